// Sequences: how far each is, frame by frame, and what can be done with all of its frames at once.

import { ask, post } from '../connection/api.js';
import { confirm } from '../elements/dialogs.js';
import { element, make, replaceChildren, setHidden, setText } from '../elements/dom.js';
import { count, date, duration } from '../elements/numbers.js';
import { changed, isLive, mayChange, store } from '../store.js';
import { nameOf } from '../jobs/progress.js';
import { frameCells } from './frame_cells.js';

// Jobs are told as they change; how many frames are still to come is asked for.
const LOOK_MS = 2000;

let sequences = null;
let timer = null;
let shown = '';

const isGoing = sequence => ['running', 'paused'].includes(sequence.state);

// Name, label, when it is shown, and what it does.
const ACTIONS = [
  ['pause', 'Pause', ({ state }) => state === 'running', sequence => control(sequence, 'pause')],
  ['resume', 'Resume', ({ state, error }) => state === 'paused' || (state === 'failed' && Boolean(error)), sequence => control(sequence, 'resume')],
  ['cancel', 'Cancel …', isGoing, askToCancel],
  ['delete', 'Delete …', () => true, askToDelete],
];

// Shows them, and asks for news for as long as they are seen.
export function showSequences(jobs) {
  if (!timer) look();
  if (!sequences) return;
  const frames = Map.groupBy([...jobs.values()].filter(job => job.frame), job => job.frame.sequence);
  const cards = sequences.toReversed().map(sequence => ({ sequence, cells: frameCells(sequence, frames.get(sequence.id) ?? []) }));
  const wanted = JSON.stringify([cards, isLive()]);
  if (wanted === shown) return;
  shown = wanted;
  setHidden(element('no-sequences'), cards.length > 0);
  replaceChildren(element('sequences'), cards.map(card));
}

export function leaveSequences() {
  clearTimeout(timer);
  timer = null;
}

async function look() {
  timer = setTimeout(look, LOOK_MS);
  if (document.hidden) return;
  try {
    ({ sequences } = await ask('/v1/sequences'));
    changed();
  } catch {
    // The banner tells that the coordinator is away.
  }
}

async function control(sequence, what) {
  await post(`/v1/sequences/${sequence.id}/${what}`);
  await news();
}

async function news() {
  leaveSequences();
  await look();
}

function card({ sequence, cells }) {
  const { id, state, error, waiting, owner, tags, progress } = sequence;
  const facts = [id, owner, ...tags.map(tag => `#${tag}`), date(sequence.submitted * 1000)].filter(Boolean).join(' · ');
  return make(
    'article',
    { className: 'sequence', 'data-state': state, 'aria-labelledby': `${id}-name` },
    make('h3', { id: `${id}-name` }, nameOf(sequence)),
    make('span', { className: 'state' }, state),
    make('p', { className: 'quiet' }, facts),
    make('p', { className: 'buttons' }, ACTIONS.map(action(sequence))),
    make('progress', { max: 1, value: progress, 'aria-label': `Progress of ${nameOf(sequence)}` }),
    make('p', {}, reached(sequence)),
    error || waiting ? make('p', { className: error ? 'reason failed' : 'reason' }, error ?? `It waits: ${waiting}.`) : null,
    make('ol', { className: 'frames', 'aria-label': 'Frames' }, cells.map(cell)),
  );
}

function reached({ frames_done: done, frames_failed: failed, frames_total: total, progress, seconds_left: left }) {
  const parts = [`${done} of ${count(total, 'frame')}`, failed && `${failed} failed`, `${Math.floor(100 * progress)} %`, left && `${duration(left)} left`];
  return parts.filter(Boolean).join(', ');
}

function cell({ number, state, job }) {
  const label = `Frame ${number}: ${state}`;
  const properties = { id: `frame-${job}`, href: `#/jobs/${job}`, title: label, 'aria-label': label, 'data-state': state };
  return make('li', {}, job ? make('a', properties, number) : make('span', { title: label }, number));
}

const action =
  sequence =>
  ([name, label, isShown, act]) => {
    if (!isShown(sequence)) return null;
    const title = mayChange(sequence) ? '' : isLive() ? 'Your role does not allow this.' : 'The coordinator does not answer.';
    const perform = async () => {
      setText(element('sequences-problem'), '');
      try {
        await act(sequence);
      } catch (problem) {
        setText(element('sequences-problem'), [problem.message, problem.remedy].filter(Boolean).join('; '));
      }
    };
    // Pause and resume take each other's place, and keep the focus.
    const place = name === 'resume' ? 'pause' : name;
    const properties = { type: 'button', id: `${place}-${sequence.id}`, disabled: !mayChange(sequence), title, onclick: perform };
    return make('button', { ...properties, 'aria-label': `${label} ${nameOf(sequence)}` }, label);
  };

function askToCancel(sequence) {
  const text = `Frames of ${sequence.id} that are being rendered stop and keep their pictures so far; no further frame begins.`;
  confirm(`Cancel ${nameOf(sequence)}?`, text, 'Cancel the sequence', () => control(sequence, 'cancel'));
}

function askToDelete(sequence) {
  const text = `All ${sequence.frames_total} frames of ${sequence.id} and their pictures are deleted for good${isGoing(sequence) ? '; it is cancelled first' : ''}.`;
  const dialog = confirm(`Delete ${nameOf(sequence)}?`, text, 'Delete the sequence', async () => {
    await ask(`/v1/sequences/${sequence.id}`, { method: 'DELETE' });
    await news();
  });
  // The button that had the focus is gone with its sequence.
  dialog.addEventListener('close', () => !sequences.some(({ id }) => id === sequence.id) && element('sequences-title').focus());
}
