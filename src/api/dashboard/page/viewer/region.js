// A region that is rendered first: people drag a rectangle, a job of its own renders that part with more of the farm than the others get, and its
// picture lies over the one that is shown until that one has as many passes.

import { ask, post } from '../connection/api.js';
import { element, setHidden, setText } from '../elements/dom.js';
import { hasEnded, nameOf } from '../jobs/progress.js';
import { chosenJob, maySubmit, store } from '../store.js';
import { outlineRectangle } from './draw.js';
import { toScreen } from './geometry.js';
import { middlePart, onDrawn, onSelect, redraw, showInset } from './viewer.js';

// How much more than the job itself a region gets, and the most that there is.
const HURRY = 10;
const MOST_PRIORITY = 1000;
// Of the view's sides, before a rectangle is dragged.
const FIRST_SHARE = 0.5;

// What is chosen: `{ job, rectangle }` with the job's id; the rectangle is `null` until one is dragged.
let choosing = null;
// Regions by the job that they belong to: `{ id, x, y }`, the job that renders it and the pixel at which it begins.
const regions = new Map();

export function startRegion() {
  element('region').onclick = pressRegion;
  element('region-leave').onclick = leaveRegion;
  onSelect({ isSelecting: () => choosing !== null, select });
  onDrawn(drawChosen);
}

// Shows what there is of a region of the job that is shown, and ends it where nobody needs it any more.
export function showRegion() {
  const job = chosenJob();
  if (choosing && (choosing.job !== job?.id || hasEnded(job))) choosing = null;
  dropUnneeded();
  const region = job && regions.get(job.id);
  const own = region && store.jobs.get(region.id);
  showInset(own && own.passes_done > job.passes_done ? own : null, region);
  const canBegin = job && !hasEnded(job) && maySubmit();
  element('region').disabled = !canBegin;
  element('region').title = job && hasEnded(job) ? 'The job has ended: no part of it is early any more.' : 'A part of the picture that is rendered first (B)';
  element('stage').classList.toggle('selects', choosing !== null);
  setText(element('region'), choosing ? 'Render this region' : 'Region first');
  setHidden(element('region-leave'), !choosing && !region);
  setText(element('region-note'), choosing ? 'Drag a rectangle, or move the picture under this one.' : own ? `Region: pass ${own.passes_done.toLocaleString('en')}` : '');
}

// The first press begins to choose a rectangle, the second one renders it.
export function pressRegion() {
  if (element('region').disabled) return;
  if (choosing) return render(choosing);
  choosing = { job: chosenJob().id, rectangle: null };
  setText(element('region-problem'), '');
  element('region').focus();
  showRegion();
}

// Stops choosing; else takes the region of the job that is shown away.
export function leaveRegion() {
  setText(element('region-problem'), '');
  if (choosing) choosing = null;
  else if (regions.has(store.chosen)) end(store.chosen);
  showRegion();
}

// Pixels that a rectangle touches, within the picture; `null` where it touches none.
export function touchedPixels([one, other], { width, height }) {
  const range = (from, to, end) => [Math.max(Math.floor(Math.min(from, to)), 0), Math.min(Math.ceil(Math.max(from, to)), end)];
  const [left, right] = range(one.x, other.x, width);
  const [top, bottom] = range(one.y, other.y, height);
  return left < right && top < bottom ? { x: left, y: top, width: right - left, height: bottom - top } : null;
}

function chosenPixels({ job, rectangle }) {
  const whole = store.jobs.get(job);
  return whole ? touchedPixels(rectangle ?? middlePart(FIRST_SHARE), whole) : null;
}

function select(from, to, isDone) {
  // The job may end in the middle of a drag.
  if (!choosing) return;
  choosing.rectangle = [from, to];
  redraw();
  if (isDone) render(choosing);
}

async function render(chosen) {
  const pixels = chosenPixels(chosen);
  choosing = null;
  showRegion();
  try {
    if (!pixels) throw new Error('The rectangle lies beside the picture.');
    await submit(store.jobs.get(chosen.job), pixels);
  } catch (problem) {
    setText(element('region-problem'), [problem.message, problem.remedy].filter(Boolean).join('; '));
  }
  showRegion();
}

// The same job with a part of the picture. Changes of a scene count from the first pixel of the film, of which the job may show a part itself.
async function submit(job, { x, y, width, height }) {
  const { first_pixel: first } = await ask(`/v1/jobs/${job.id}/layout`);
  const { scene, method, parameters, stop } = job;
  const made = await post('/v1/jobs', {
    scene,
    method,
    parameters,
    stop,
    scene_changes: { crop: { x: x + first[0], y: y + first[1], width, height } },
    priority: Math.min(job.priority * HURRY, MOST_PRIORITY),
    name: `${nameOf(job)}, region ${x},${y} ${width}×${height}`.slice(0, 150),
  });
  if (regions.has(job.id)) end(job.id);
  regions.set(job.id, { id: made.id, x, y });
}

// A region has done its work when its job is gone, or the whole picture has ended or is as far as a region that has ended.
function dropUnneeded() {
  for (const [id, region] of regions) {
    const [whole, own] = [store.jobs.get(id), store.jobs.get(region.id)];
    // The farm tells of a new job a moment later than the answer does.
    if (own) region.isKnown = true;
    const isGone = !whole || (region.isKnown && !own);
    if (isGone || hasEnded(whole) || (own && hasEnded(own) && whole.passes_done >= own.passes_done)) end(id);
  }
}

function end(id) {
  const { id: own } = regions.get(id);
  regions.delete(id);
  const job = store.jobs.get(own);
  if (job && hasEnded(job)) return;
  post(`/v1/jobs/${own}/cancel`).catch(problem => setText(element('region-problem'), problem.message));
}

function drawChosen({ context, screen, ratio, view }) {
  const pixels = choosing && chosenPixels(choosing);
  if (!pixels) return;
  const [from, to] = [pixels, { x: pixels.x + pixels.width, y: pixels.y + pixels.height }].map(corner => toScreen(view, screen, corner));
  outlineRectangle(context, from, to, ratio);
}
