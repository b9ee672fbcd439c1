// The workers: what each does, how fast, and why one gets no work.

import { element, make, setText } from '../elements/dom.js';
import { count, duration } from '../elements/numbers.js';

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
  if (JSON.stringify(rows) === shown) return;
  shown = JSON.stringify(rows);
  const cell = (text, index) =>
    make(index ? 'td' : 'th', { className: index >= 2 && index <= 5 ? 'number' : '', scope: index ? undefined : 'row' }, text);
  element('workers-rows').replaceChildren(...rows.map(row => make('tr', {}, row.map(cell))));
  [...element('workers-rows').rows].forEach((row, index) => {
    row.dataset.state = workers[index].state;
  });
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
  ];
}
