// The workers: what each does, how fast, why one gets no work, and what went wrong with it last. Admins send them away.

import { post } from '../connection/api.js';
import { confirm } from '../elements/dialogs.js';
import { element, make, replaceChildren, setText } from '../elements/dom.js';
import { count, date, duration } from '../elements/numbers.js';
import { isLive, store } from '../store.js';

// Speeds are means over about this long.
const WINDOW_MS = 60000;

// Shards that each worker had done, by time.
const notes = new Map();
let shown = '';

export function summary(workers) {
  const threads = workers.reduce((sum, worker) => sum + worker.threads, 0);
  return `${count(workers.length, 'worker')}, ${count(threads, 'thread')}`;
}

// Notes how many shards are done, for the speeds.
export function noteWorkers(workers) {
  const now = performance.now();
  for (const { id, shards_done: done } of workers) {
    const list = (notes.get(id) ?? []).filter(note => now - note.at < WINDOW_MS);
    notes.set(id, [...list, { at: now, done }]);
  }
}

function perMinute(id) {
  const list = notes.get(id) ?? [];
  const [first, last] = [list[0], list.at(-1)];
  return list.length > 1 ? ((last.done - first.done) / (last.at - first.at)) * 60000 : null;
}

export function showWorkers(workers) {
  const states = Object.entries(Object.groupBy(workers, worker => worker.state)).map(([state, list]) => `${list.length} ${state.replace('_', ' ')}`);
  const none = 'No worker is connected. Start one with: photonfarm worker --coordinator ADDRESS';
  setText(element('workers-summary'), workers.length ? `${summary(workers)}: ${states.join(', ')}.` : none);
  const rows = workers.map(rowOf);
  const wanted = JSON.stringify([rows, mayDrain()]);
  if (wanted === shown) return;
  shown = wanted;
  const cell = (text, index) =>
    make(index ? 'td' : 'th', { className: index >= 2 && index <= 5 ? 'number' : '', scope: index ? undefined : 'row' }, text);
  const row = (cells, index) => make('tr', { 'data-state': workers[index].state }, cells.map(cell), make('td', {}, drainButton(workers[index])));
  replaceChildren(element('workers-rows'), rows.map(row));
}

function rowOf(worker) {
  const rate = perMinute(worker.id);
  return [
    worker.name,
    worker.state.replace('_', ' '),
    String(worker.threads),
    String(worker.leases),
    worker.shards_done.toLocaleString('en'),
    rate === null ? '–' : rate.toFixed(0),
    `${duration(worker.idle_seconds)} ago`,
    worker.set_aside ?? '',
    errorText(worker.last_error),
  ];
}

const errorText = error => (error ? `${date(error.time * 1000)}, ${error.work} of job ${error.job}: ${error.problem}` : '');

const mayDrain = () => isLive() && store.me.scope === 'admin';

function drainButton({ id, name, state }) {
  const label = state === 'draining' ? 'Leaves soon' : 'Send away …';
  const isAllowed = mayDrain() && state !== 'draining';
  const title = isAllowed || state === 'draining' ? '' : isLive() ? 'Only admins send workers away.' : 'The coordinator does not answer.';
  const text = 'It gets no further work, delivers what it holds and leaves; photonfarm worker ends. Start it again to have it back.';
  const ask = () => confirm(`Send ${name} away?`, text, 'Send away', () => post(`/v1/workers/${id}/drain`));
  return make('button', { type: 'button', id: `drain-${id}`, disabled: !isAllowed, title, onclick: ask, 'aria-label': `${label}: ${name}` }, label);
}
