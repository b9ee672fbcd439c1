// What can be done with a job. What cannot be undone is asked for first, and what is not allowed now is disabled with a reason.

import { ask, expect, post, send } from '../connection/api.js';
import { confirm, openForm } from '../elements/dialogs.js';
import { element, field, make, setText } from '../elements/dom.js';
import { isLive, mayChange, maySubmit, store } from '../store.js';
import { look } from '../viewer/look.js';
import { methodFields } from '../submit/method_fields.js';
import { readStop, stopFields } from '../submit/stop_fields.js';
import { readTags } from '../submit/tags.js';
import { hasEnded, nameOf } from './progress.js';

const isWaiting = job => ['queued', 'choosing', 'running'].includes(job.state);

// Name, label, when it is shown, who may do it, and what it does.
const ACTIONS = [
  ['pause', 'Pause', isWaiting, mayChange, job => post(`/v1/jobs/${job.id}/pause`)],
  ['resume', 'Resume', job => job.state === 'paused', mayChange, job => post(`/v1/jobs/${job.id}/resume`)],
  ['extend', 'Extend …', hasEnded, mayChange, openExtend],
  ['clone', 'Clone …', () => true, maySubmit, openClone],
  ['edit', 'Edit …', () => true, mayChange, openEdit],
  ['cancel', 'Cancel …', job => !hasEnded(job), mayChange, openCancel],
  ['delete', 'Delete …', () => true, mayChange, openDelete],
];

let open = () => {};

// `openJob` is called with the id of a job that was made.
export function startActions(openJob) {
  open = openJob;
  const button = ([name, label, , , act]) => make('button', { type: 'button', id: `action-${name}`, onclick: () => perform(act) }, label);
  const link = (id, text, title) => make('a', { id, className: 'button', title }, text);
  element('job-actions').append(
    ...ACTIONS.map(button),
    make('p', { id: 'action-problem', role: 'alert' }),
    link('link-exr', 'EXR', 'Save the picture as 32-bit float EXR'),
    link('link-png', 'PNG', 'Save the picture as 8-bit sRGB PNG with this exposure'),
  );
}

export function showActions(job) {
  for (const [name, , isShown, isAllowed] of ACTIONS) {
    const button = element(`action-${name}`);
    button.hidden = !isShown(job);
    button.disabled = !isAllowed(job);
    button.title = !button.disabled ? '' : isLive() ? 'Your role does not allow this.' : 'The coordinator does not answer.';
  }
  for (const [id, address] of [
    ['link-exr', job.links.image_exr],
    ['link-png', `${job.links.image_png}?exposure=${look.exposure}`],
  ]) {
    const link = element(id);
    link.hidden = !job.passes_done;
    link.href = address;
    link.download = `${nameOf(job).replaceAll(/[^\w.-]+/g, '_')}.${id.slice(5)}`;
  }
}

async function perform(act) {
  setText(element('action-problem'), '');
  const job = store.jobs.get(store.chosen);
  try {
    if (job) await act(job);
  } catch (problem) {
    setText(element('action-problem'), [problem.message, problem.remedy].filter(Boolean).join('; '));
  }
}

function openCancel(job) {
  const text = `The job stops after ${job.passes_done} passes and keeps its picture. It can be extended later.`;
  confirm(`Cancel ${nameOf(job)}?`, text, 'Cancel the job', () => post(`/v1/jobs/${job.id}/cancel`));
}

function openDelete(job) {
  const text = `The job and its pictures are deleted for good${hasEnded(job) ? '' : '; it is cancelled first'}.`;
  confirm(`Delete ${nameOf(job)}?`, text, 'Delete the job', () => ask(`/v1/jobs/${job.id}`, { method: 'DELETE' }));
}

function openExtend(job) {
  const fields = stopFields({ ...job.stop, passes: job.stop.passes ? 2 * job.passes_done : undefined });
  const text = 'The job goes on from its stored state to the bits of the longer job. Give an end that is later than the last.';
  openForm(`Extend ${nameOf(job)}`, [make('p', {}, text), fields], 'Extend', () => post(`/v1/jobs/${job.id}/extend`, readStop(fields)));
}

async function openClone(job) {
  const name = make('input', { name: 'name', value: job.name ?? '', maxLength: 200 });
  const seed = make('input', { name: 'seed', type: 'number', min: 0, step: 1, value: job.seed });
  const method = await methodFields(job.method, {});
  const stop = stopFields(job.stop);
  const text = 'Another job of the same scene. Parameters that are left out are as in this job, or as by default for another method.';
  const contents = [make('p', {}, text), field('Name', name), method.fields, stop, field('Seed', seed)];
  openForm(`Clone ${nameOf(job)}`, contents, 'Submit', async () => {
    const request = { ...method.read(), stop: readStop(stop), seed: seed.valueAsNumber || 0, name: name.value };
    open((await post(`/v1/jobs/${job.id}/clone`, request)).id);
  });
}

// The version that the user saw goes along, so that what somebody else changed meanwhile is not lost.
async function openEdit(job) {
  const answer = await expect(await send(`/v1/jobs/${job.id}`));
  const version = answer.headers.get('etag');
  const seen = await answer.json();
  const name = make('input', { name: 'name', value: seen.name ?? '', maxLength: 200 });
  const tags = make('input', { name: 'tags', value: seen.tags.join(', ') });
  const priority = make('input', { name: 'priority', type: 'number', min: 1, max: 1000, required: true, value: seen.priority });
  const contents = [
    field('Name', name),
    field('Tags', tags, 'Words to find it by, separated by commas.'),
    field('Priority', priority, '1 to 1000: a job of 200 gets twice the work done that one of 100 gets.'),
  ];
  openForm(`Edit ${nameOf(seen)}`, contents, 'Save', () =>
    ask(`/v1/jobs/${job.id}`, {
      method: 'PATCH',
      headers: { 'If-Match': version },
      body: { name: name.value, tags: readTags(tags.value), priority: priority.valueAsNumber },
    }),
  );
}
