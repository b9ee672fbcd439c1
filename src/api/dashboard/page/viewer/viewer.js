// The viewer: it holds which picture is shown and how, and draws it whenever one of them changed.

import { element, setHidden, setText } from '../elements/dom.js';
import { hasEnded, reason } from '../jobs/progress.js';
import { showComparison } from './comparison.js';
import { showControls } from './controls.js';
import { drawFrame } from './draw.js';
import { fitted, levelFor, moved, tilesSeen, toPicture, unscaled, zoomedAt } from './geometry.js';
import { LIGHT_GROUPS, keepsGroups, startLightGroups } from './light_groups.js';
import { showHistogram } from './histogram_view.js';
import { currentScale, onLook, usesScale } from './look.js';
import { PictureSource } from './picture_source.js';
import { followPointer } from './pointer.js';
import { showReadout } from './readout.js';

const canvas = element('picture');
const context = canvas.getContext('2d');
// From this zoom on, in CSS pixels, values are read as they are.
const EXACT_FROM = 8;

export const viewer = {
  job: null,
  other: null,
  layer: 'color',
  // `null` fits the picture to the window.
  view: null,
  sources: [],
  // Another job's picture over a part of this one: `{ source, job, x, y }`, with the pixel at which it begins.
  inset: null,
  comparison: { mode: 'slider', split: 0.5, showsOther: false },
  pointer: null,
};

let isPlanned = false;
// What else wants to know of clicks and rectangles, and draws over the picture.
let clicked = () => {};
let selection = { isSelecting: () => false };
const drawnOver = [];

export function startViewer() {
  onLook(redraw);
  startLightGroups(() => viewer.sources.forEach(source => source.remix()));
  new ResizeObserver(redraw).observe(element('stage'));
  document.addEventListener('visibilitychange', redraw);
  followPointer(canvas, {
    move: ({ x, y }) => change(moved(currentView(), size(), { x: x * ratio(), y: y * ratio() })),
    zoom: (at, factor) => change(zoomedAt(currentView(), screen(), { x: at.x * ratio(), y: at.y * ratio() }, factor)),
    point: at => {
      viewer.pointer = at;
      redraw();
    },
    click: at => clicked(pixelAt(at), currentView().zoom / ratio()),
    isSelecting: () => selection.isSelecting(),
    select: (from, to, isDone) => selection.select(pixelAt(from), pixelAt(to), isDone),
    split: share => changeComparison({ split: Math.min(Math.max(share, 0), 1) }),
    lineAt: () => (isSplit() ? viewer.comparison.split * canvas.clientWidth : null),
  });
}

// `listener` is called with every click on the picture: its place in pixels of the picture, and how many CSS pixels of the screen one is.
export const onClick = listener => {
  clicked = listener;
};

// While `isSelecting()`, dragging does not move the picture but calls `select(from, to, isDone)` with places in pixels of the picture.
export const onSelect = listener => {
  selection = listener;
};

// `draw` is called with every frame that is drawn, to draw over it.
export const onDrawn = draw => drawnOver.push(draw);

// Shows a job, and beside it the one it is compared with. Another job's picture is never left there: its source goes with it.
export function showPicture(job, other) {
  if (viewer.layer === LIGHT_GROUPS && !keepsGroups(job)) viewer.layer = 'color';
  const fits = other && job && other.width === job.width && other.height === job.height;
  const shown = [job, fits ? other : null].map((wanted, index) => sourceFor(viewer.sources[index], wanted));
  viewer.sources.filter(source => !shown.includes(source)).forEach(source => source?.close());
  const isOtherSize = job && viewer.job && (job.width !== viewer.job.width || job.height !== viewer.job.height);
  if (!job || isOtherSize) viewer.view = null;
  Object.assign(viewer, { job, other: fits ? other : null, sources: shown.filter(Boolean) });
  redraw();
}

// Lays a job's picture over that which is shown, from a pixel of it on; without a job there is none.
export function showInset(job, { x, y } = {}) {
  const source = sourceFor(viewer.inset?.source, job);
  if (viewer.inset && viewer.inset.source !== source) viewer.inset.source.close();
  viewer.inset = job && { source, job, x, y };
  redraw();
}

function sourceFor(source, job) {
  if (!job) return null;
  // A job without light groups is compared as it is.
  const layer = viewer.layer === LIGHT_GROUPS && !keepsGroups(job) ? 'color' : viewer.layer;
  const isSame = source?.id === job.id && source.layer === layer && source.size.width === job.width && source.size.height === job.height;
  return isSame ? source : new PictureSource(job, layer, redraw);
}

export function changeLayer(layer) {
  viewer.layer = layer;
  showPicture(viewer.job, viewer.other);
  if (viewer.inset) showInset(viewer.inset.job, viewer.inset);
}

export function changeComparison(changes) {
  Object.assign(viewer.comparison, changes);
  redraw();
}

function change(view) {
  if (!viewer.job) return;
  viewer.view = view;
  redraw();
}

export const fit = () => change(null);
export const actualSize = () => change(unscaled(currentView()));
export const zoomBy = factor => change(zoomedAt(currentView(), screen(), { x: screen().width / 2, y: screen().height / 2 }, factor));
export const pan = ([x, y]) => change(moved(currentView(), size(), { x: x * ratio(), y: y * ratio() }));

const ratio = () => devicePixelRatio;
const size = () => viewer.sources[0]?.size ?? { width: 1, height: 1 };
const screen = () => ({ width: canvas.width, height: canvas.height });
const currentView = () => viewer.view ?? fitted(size(), screen());
const isSplit = () => viewer.sources.length > 1 && viewer.comparison.mode === 'slider';

const pixelAt = ({ x, y }) => toPicture(currentView(), screen(), { x: x * ratio(), y: y * ratio() });

// What is seen of the picture around the middle of the view, as a share of the view's sides: two corners in pixels of the picture.
export function middlePart(share) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const corner = side => pixelAt({ x: (width * (1 + side * share)) / 2, y: (height * (1 + side * share)) / 2 });
  return [corner(-1), corner(1)];
}

// The place in the middle of the view, in pixels of the picture.
export const middlePixel = () => pixelAt({ x: canvas.clientWidth / 2, y: canvas.clientHeight / 2 });

export function redraw() {
  if (isPlanned) return;
  isPlanned = true;
  requestAnimationFrame(() => {
    isPlanned = false;
    draw();
  });
}

function draw() {
  const { clientWidth, clientHeight } = canvas;
  if (!clientWidth || !clientHeight) return;
  const [width, height] = [Math.round(clientWidth * ratio()), Math.round(clientHeight * ratio())];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const { sources, layer, comparison, job, other } = viewer;
  const view = currentView();
  sources.forEach((source, index) => wantTiles(source, view, [job, other][index]));
  const isDifference = comparison.mode === 'difference' && sources.length > 1;
  const [overview, otherOverview] = sources.map(source => source.overview);
  const canScale = usesScale(layer) && overview && (!isDifference || otherOverview);
  const scale = canScale ? currentScale(layer, overview, isDifference ? otherOverview : null) : null;
  const pixel = viewer.pointer ? pixelAt(viewer.pointer) : middlePixel();
  const frame = { context, screen: screen(), ratio: ratio(), view, layer, scale, sources, inset: insetIn(view), comparison, pixel };
  drawFrame(frame);
  if (sources.length) drawnOver.forEach(drawOver => drawOver(frame));
  showNote();
  showReadout(frame);
  showControls(viewer, scale);
  showHistogram(sources[0], layer);
  showComparison(viewer);
}

// The inset with the view in which it lies at its place; two pictures that are compared have none.
function insetIn(view) {
  const { inset, sources } = viewer;
  if (!inset || sources.length !== 1) return null;
  const own = { center: { x: view.center.x - inset.x, y: view.center.y - inset.y }, zoom: view.zoom };
  wantTiles(inset.source, own, inset.job);
  return { ...inset, view: own };
}

function wantTiles(source, view, job) {
  const level = levelFor(view, source.size, !hasEnded(job));
  const format = view.zoom >= EXACT_FROM * ratio() ? 'float' : 'half';
  const isCoarseEnough = level > source.coarse.level || (level === source.coarse.level && source.coarse.format === 'float');
  const seen = isCoarseEnough ? [] : tilesSeen(view, screen(), source.size, level).map(tile => ({ ...tile, format }));
  // Before the first pass there is nothing to ask for.
  source.want(seen, job.passes_done ? job.picture_version : 0);
}

// Why there is no picture, or nothing new.
function showNote() {
  const {
    job,
    sources: [source],
  } = viewer;
  let text = '';
  if (job && !source?.overview) {
    if (!job.passes_done && hasEnded(job)) text = 'There is no picture: the job ended before its first pass.';
    else if (!job.passes_done) text = `No pass is merged yet. ${reason(job)}`;
    else text = source?.problem || 'The picture comes …';
  } else if (source?.problem) {
    text = source.problem;
  }
  setText(element('picture-note'), text);
  setHidden(element('picture-note'), !text);
  const passes = source?.overview?.passes;
  setText(element('picture-passes'), passes === undefined ? '' : `as of pass ${passes.toLocaleString('en')}`);
  canvas.setAttribute('aria-label', job ? `The picture of job ${job.name ?? job.id} so far, layer ${viewer.layer}` : 'No picture');
}
