// The mode "light paths": people say where light comes from, and see what that does to the noise. While its panel is open, clicks on the picture
// make paths, which are drawn over it.

import { element, make, setHidden, setText } from '../elements/dom.js';
import { problemNote } from '../elements/problem_note.js';
import { middlePixel, onClick, onDrawn, redraw } from '../viewer/viewer.js';
import { drawPaths } from './draw_paths.js';
import { extended, fromParameter, movedPoint, startedAt, startedAtPlace, withCone, withoutPoint, writtenPlace } from './light_paths.js';
import { lightName, showPathList } from './path_list.js';
import { inPicture } from './projection.js';
import { showRender, startRender } from './render_paths.js';
import { layoutOf, placeAt } from './scene_layout.js';

// How near to a lamp's mark a click takes the lamp, pixels of the screen.
const LAMP_REACH = 12;

// The job whose picture is clicked, `null` while the panel is closed; what is known of its scene; and the paths.
const state = { job: null, layout: null, paths: [], chosen: 0, refused: null };
// Paths by scene: whoever looks at another job of the same scene keeps them.
const kept = new Map();
let listed = null;
// Places are looked up one after the other, so that points stand in the order of the clicks.
let lookups = Promise.resolve();

// `compare(id, other)` shows a job beside another.
export function startPaths({ compare }) {
  element('path-start').onclick = () => startAt(state.layout?.lights[element('path-light').value]);
  element('path-add').onclick = () => addPlace(middlePixel());
  startRender(state, { refuse, compare });
  onClick((pixel, perPixel) => state.job && clicked(pixel, perPixel));
  onDrawn(frame => state.job && drawPaths(frame, { ...state, size: state.job }));
}

// Opens the mode for a job, or closes it without one.
export async function showPaths(job) {
  const isOther = job?.id !== state.job?.id;
  element('stage').classList.toggle('picks', Boolean(job));
  state.job = job;
  if (!job) return isOther && redraw();
  if (isOther) await openFor(job);
  show();
}

async function openFor(job) {
  const ofJob = job.parameters.user_paths ?? [];
  Object.assign(state, { layout: null, paths: kept.get(job.scene) ?? fromParameter(ofJob), chosen: 0, refused: null });
  try {
    const layout = await layoutOf(job);
    if (state.job?.id !== job.id) return;
    state.layout = layout;
    say(layout.world_to_ndc ? '' : 'This camera bends straight lines, so paths cannot be drawn; they can be made all the same.');
  } catch (problem) {
    say([problem.message, problem.remedy].filter(Boolean).join('; '));
  }
}

const say = text => setText(element('paths-note'), text);

function show() {
  listLights();
  showPathList(state, { choose, remove, move, removePoint, cone });
  showRender(state);
  redraw();
}

function listLights() {
  const { layout } = state;
  if (listed === layout) return;
  listed = layout;
  const options = (layout?.lights ?? []).map((light, index) => make('option', { value: index }, `${index + 1}: ${lightName(light)}`));
  element('path-light').replaceChildren(...(options.length ? options : [make('option', { value: '' }, 'no lamp with a place')]));
  element('path-start').disabled = !options.length;
  const leftOut = layout?.lights_left_out ?? 0;
  setText(element('path-light-note'), leftOut ? `${leftOut} further lamps of less power are not listed.` : '');
}

// The paths are others than those that were refused.
function change(paths, chosen = state.chosen) {
  Object.assign(state, { paths, chosen: Math.max(Math.min(chosen, paths.length - 1), 0), refused: null });
  kept.set(state.job.scene, paths);
  element('paths-problem').replaceChildren();
  show();
}

const replaced = (index, path) => state.paths.map((other, at) => (at === index ? path : other));
const choose = index => change(state.paths, index);
const remove = index => change(state.paths.filter((_, other) => other !== index));
const move = (index, point, at) => change(replaced(index, movedPoint(state.paths[index], point, at)), index);
const cone = (index, segment, degrees) => change(replaced(index, withCone(state.paths[index], segment, degrees)), index);

function removePoint(index, point) {
  const path = withoutPoint(state.paths[index], point);
  if (path) change(replaced(index, path), index);
  else remove(index);
}

function startAt(light) {
  if (!light) return;
  change([...state.paths, startedAt(light)], state.paths.length);
  say(`Path ${state.paths.length} starts at ${lightName(light)}. Click the surface that its light reaches.`);
}

// A click beside a lamp's mark starts a path there, any other one adds a point to the path that is chosen. A path that only has its lamp wants a
// surface: marks of lamps behind walls are everywhere.
function clicked(pixel, perPixel) {
  const isJustStarted = state.paths[state.chosen]?.points.length === 1;
  const lamp = isJustStarted ? null : lampAt(pixel, LAMP_REACH / perPixel);
  if (lamp) startAt(lamp);
  else addPlace(pixel);
}

function lampAt({ x, y }, reach) {
  const { layout, job } = state;
  const matrix = layout?.world_to_ndc;
  if (!matrix) return null;
  const place = light => inPicture(matrix, job, light.points[0]);
  const isNear = at => at && Math.hypot(at.x - x, at.y - y) <= reach;
  return layout.lights.find(light => isNear(place(light))) ?? null;
}

// Adds what a pixel shows to the path that is chosen now.
function addPlace(pixel) {
  const { job, chosen } = state;
  lookups = lookups.then(() => lookUp(job, chosen, pixel));
}

async function lookUp(job, chosen, { x, y }) {
  const pixel = { x: Math.floor(x), y: Math.floor(y) };
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= job.width || pixel.y >= job.height) return;
  say('A worker looks where that is …');
  try {
    const at = await placeAt(job, pixel);
    const path = state.paths[chosen];
    // Another job may be shown by now, or the path may be gone.
    if (state.job?.id !== job.id || (!path && state.paths.length)) return;
    if (path) change(replaced(chosen, extended(path, at)));
    else change([startedAtPlace(at)]);
    say(`Point ${state.paths[chosen].points.length} of path ${chosen + 1} is at ${writtenPlace(at)} m.`);
  } catch (problem) {
    say([problem.message, problem.remedy].filter(Boolean).join(' '));
  }
}

// Shows why the coordinator refused the paths: beside the segment where that is known.
function refuse(problem, refused) {
  state.refused = refused;
  if (refused) state.chosen = refused.path;
  element('paths-problem').replaceChildren(...(problem && !refused ? [problemNote(problem)] : []));
  setHidden(element('paths-problem'), !problem || Boolean(refused));
  show();
}
