// The head of the job that is shown: what it is called, how far it is, what it waits for, and its notices.

import { element, make, setHidden, setText } from '../elements/dom.js';
import { acceptance, hasEnded, nameOf, reached, reason, share, speed, timeLeft } from './progress.js';
import { count } from '../elements/numbers.js';

let announced = '';
let notices = '';

export function showHead(job) {
  setText(element('job-name'), nameOf(job));
  setText(element('job-state'), job.state);
  element('job-state').dataset.state = job.state;
  setText(element('job-facts'), [job.method, job.owner, ...job.tags.map(tag => `#${tag}`)].filter(Boolean).join(' · '));
  element('job-bar').value = share(job);
  setHidden(element('job-bar'), hasEnded(job));
  setText(
    element('job-reached'),
    `${[`${reached(job)}. ${speed(job)}${hasEnded(job) ? '' : `, ${count(job.workers, 'worker')}`}.`, ...acceptance(job)].join(' ')}`,
  );
  setText(element('job-left'), timeLeft(job));
  setText(element('job-reason'), reason(job));
  setHidden(element('job-reason'), !reason(job));
  element('job-reason').classList.toggle('failed', job.state === 'failed');
  showNotices(job.notices);
  announce(job);
}

function showNotices(list) {
  if (notices === JSON.stringify(list)) return;
  notices = JSON.stringify(list);
  element('job-notices').replaceChildren(...list.map(text => make('li', {}, text)));
  setHidden(element('job-notices'), !list.length);
}

// Tells people who do not see the page when a job's state changes, and not with every pass.
function announce(job) {
  const text = `${nameOf(job)}: ${job.state}. ${reason(job)}`;
  if (text === announced) return;
  announced = text;
  setText(element('announcement'), text);
}
