// One row of the list of jobs.

import { make, setText } from '../elements/dom.js';
import { errorText, nameOf, reached, share, timeLeft } from './progress.js';

export const THUMBNAIL = { width: 84, height: 56 };

export function makeRow(id, open) {
  const picture = make('canvas', { className: 'thumbnail', ...THUMBNAIL, 'aria-hidden': 'true' });
  const parts = ['name', 'about', 'reached', 'state', 'left'].map(part => make('span', { className: part }));
  const bar = make('span', { className: 'bar', 'aria-hidden': 'true' }, make('span'));
  return make('div', { className: 'row', id: `job-${id}`, role: 'option', onclick: open }, picture, parts, bar);
}

export function fillRow(row, job) {
  const set = (part, text) => setText(row.querySelector(`.${part}`), text);
  set('name', nameOf(job));
  set('about', [job.method, job.owner, ...job.tags.map(tag => `#${tag}`)].filter(Boolean).join(' · '));
  set('reached', reachedShortly(job));
  set('state', job.state);
  set('left', timeLeft(job));
  row.dataset.state = job.state;
  row.title = `${nameOf(job)}, job ${job.id}: ${reached(job)}`;
  row.querySelector('.bar > span').style.width = `${(100 * share(job)).toFixed(1)}%`;
}

// What of the stop rule counts most fits in a row.
function reachedShortly(job) {
  if (job.stop.error) return errorText(job);
  return reached({ ...job, estimated_error: undefined });
}
