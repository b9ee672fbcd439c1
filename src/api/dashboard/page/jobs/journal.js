// What happened, as the coordinator wrote it down: to one job, or on the whole farm.

import { ask } from '../connection/api.js';
import { make } from '../elements/dom.js';
import { problemNote } from '../elements/problem_note.js';
import { date } from '../elements/numbers.js';

// Lines of the coordinator's answer at most.
const LINES = 1000;

// Shows the lines of a job, or of all where none is given, the newest first.
export async function showJournal(target, job) {
  try {
    const lines = await read(job);
    const row = line => make('tr', {}, make('th', { scope: 'row' }, make('time', {}, date(line.time))), make('td', {}, line.text));
    const note = lines.length ? null : make('p', { className: 'quiet' }, 'Nothing is written down yet.');
    target.replaceChildren(...[note, make('table', { className: 'journal' }, make('tbody', {}, lines.reverse().map(row)))].filter(Boolean));
  } catch (problem) {
    target.replaceChildren(problemNote(problem));
  }
}

// The last lines: the journal is read from its beginning, in parts.
async function read(job) {
  let lines = [];
  for (;;) {
    const query = new URLSearchParams({ after: lines.at(-1)?.sequence ?? 0, ...(job && { job }) });
    const part = (await ask(`/v1/journal?${query}`)).lines;
    lines = [...lines, ...part].slice(-LINES);
    if (part.length < LINES) return lines;
  }
}
