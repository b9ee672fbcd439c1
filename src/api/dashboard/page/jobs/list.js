// The list of jobs. Only the rows that are seen exist as elements, so ten thousand jobs scroll as well as ten.

import { element, make, setHidden, setText } from '../elements/dom.js';
import { count } from '../elements/numbers.js';
import { store } from '../store.js';
import { fillRow, makeRow } from './row.js';
import { ORDERS, select } from './selection.js';
import { STATES } from './progress.js';
import { drawThumbnail, wantThumbnails } from './thumbnails.js';

// As in the style of `.row`.
const ROW_REM = 4.75;
// Rows that are made beyond what is seen, so that scrolling shows no gaps.
const MARGIN = 4;
// Sorting many jobs takes a while, so it is done this often at most.
const SORT_MS = 300;

const list = element('list');
const rows = new Map();
let listed = [];
let sortedAt = 0;
let timer = null;
let open = () => {};

const rowHeight = () => ROW_REM * parseFloat(getComputedStyle(document.documentElement).fontSize);

// `choose` is called with the id of the job that the user wants to see.
export function startList(choose) {
  open = choose;
  element('state-filter').append(...STATES.map(state => make('option', { value: state }, state)));
  element('order').append(...Object.entries(ORDERS).map(([value, [label]]) => make('option', { value }, label)));
  for (const id of ['text-filter', 'state-filter', 'order']) element(id).oninput = () => sort(true);
  list.addEventListener('scroll', () => requestAnimationFrame(renderRows), { passive: true });
  list.addEventListener('keydown', moveByKey);
  new ResizeObserver(renderRows).observe(list);
}

// Shows the jobs as they are now.
export function showList() {
  const wait = sortedAt + SORT_MS - performance.now();
  if (wait <= 0) return sort(false);
  timer ??= setTimeout(() => sort(false), wait);
}

function sort(isNewQuestion) {
  clearTimeout(timer);
  [timer, sortedAt] = [null, performance.now()];
  const question = { text: element('text-filter').value, state: element('state-filter').value, order: element('order').value };
  listed = select(store.jobs.values(), question);
  if (isNewQuestion) list.scrollTop = 0;
  element('list-space').style.height = `${listed.length * rowHeight()}px`;
  const all = store.jobs.size;
  setText(element('list-count'), listed.length === all ? count(all, 'job') : `${listed.length} of ${count(all, 'job')}`);
  setHidden(element('list-empty'), listed.length > 0);
  setText(element('list-empty'), all ? 'No job fits the filter.' : 'There are no jobs yet. Submit a scene to begin.');
  renderRows();
}

function renderRows() {
  const first = Math.max(Math.floor(list.scrollTop / rowHeight()) - MARGIN, 0);
  const last = Math.min(Math.ceil((list.scrollTop + list.clientHeight) / rowHeight()) + MARGIN, listed.length);
  const shown = listed.slice(first, last);
  const wanted = new Set(shown.map(job => job.id));
  for (const [id, row] of rows)
    if (!wanted.has(id)) {
      row.remove();
      rows.delete(id);
    }
  shown.forEach((job, index) => renderRow(job, first + index));
  const active = rows.get(store.chosen);
  if (active) list.setAttribute('aria-activedescendant', active.id);
  else list.removeAttribute('aria-activedescendant');
  wantThumbnails(shown, id => rows.has(id) && drawThumbnail(rows.get(id).querySelector('canvas'), id));
}

function renderRow(job, index) {
  let row = rows.get(job.id);
  if (!row) {
    row = makeRow(job.id, () => open(job.id));
    rows.set(job.id, row);
    list.append(row);
    drawThumbnail(row.querySelector('canvas'), job.id);
  }
  row.style.transform = `translateY(${index * rowHeight()}px)`;
  row.setAttribute('aria-posinset', index + 1);
  row.setAttribute('aria-setsize', listed.length);
  row.setAttribute('aria-selected', store.chosen === job.id);
  fillRow(row, job);
}

const STEPS = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8, Home: -Infinity, End: Infinity };

function moveByKey(event) {
  const step = STEPS[event.key];
  if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  event.stopPropagation();
  openNeighbour(step);
}

// Opens the job that stands so many rows further.
export function openNeighbour(step) {
  if (!listed.length) return;
  const now = listed.findIndex(job => job.id === store.chosen);
  const next = Math.min(Math.max(now < 0 ? 0 : now + step, 0), listed.length - 1);
  open(listed[next].id);
  reveal(next);
}

function reveal(index) {
  const top = index * rowHeight();
  if (top < list.scrollTop) list.scrollTop = top;
  else if (top + rowHeight() > list.scrollTop + list.clientHeight) list.scrollTop = top + rowHeight() - list.clientHeight;
}

// The newest of the jobs that are listed.
export const firstListed = () => listed[0];
