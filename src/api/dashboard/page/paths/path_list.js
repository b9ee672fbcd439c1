// The paths as a list: each with its points and cones as fields, so that all of it can be read and changed by keys alone.

import { element, make, replaceChildren } from '../elements/dom.js';
import { readPlace, writtenPlace } from './light_paths.js';

let shown = '';

// `state` has `paths`, `chosen` and `refused`; `actions` are called as the user changes them.
export function showPathList(state, actions) {
  const wanted = JSON.stringify([state.paths, state.chosen, state.refused]);
  if (wanted === shown) return;
  shown = wanted;
  replaceChildren(
    element('paths'),
    state.paths.map((path, index) => pathItem(path, index, state, actions)),
  );
}

function pathItem(path, index, { chosen, refused }, actions) {
  const choose = make(
    'button',
    { type: 'button', id: `path-${index}-choose`, 'aria-pressed': String(index === chosen), onclick: () => actions.choose(index) },
    `Path ${index + 1}`,
  );
  const remove = removal(`path-${index}-remove`, `Remove path ${index + 1}`, () => actions.remove(index));
  const refusedPoint = refused?.path === index ? refused : null;
  const rows = path.points.map((_, point) => pointItem(path, index, point, refusedPoint, actions));
  return make('li', { className: index === chosen ? 'chosen' : '' }, make('div', { className: 'path-head' }, choose, remove), make('ol', {}, rows));
}

function pointItem(path, index, point, refused, actions) {
  const name = `Path ${index + 1}, point ${point + 1}`;
  const { at, light } = path.points[point];
  const id = `path-${index}-${point}`;
  const place = make('input', { id: `${id}-place`, value: writtenPlace(at), 'aria-label': `${name}: x, y and z, m`, spellcheck: false });
  place.title = at.join(', ');
  place.onchange = () => {
    const read = readPlace(place.value);
    place.setCustomValidity(read ? '' : 'Give three numbers.');
    if (read) actions.move(index, point, read);
    else place.reportValidity();
  };
  const what = point ? coneField(path, index, point, actions) : make('span', { className: 'quiet' }, light ? light.name || light.kind : 'lamp');
  const why = refused?.point === point ? make('p', { className: 'problem', role: 'alert' }, `Refused: ${refused.why}`) : null;
  const remove = removal(`${id}-remove`, `Remove point ${point + 1} of path ${index + 1}`, () => actions.removePoint(index, point));
  return make('li', {}, make('div', { className: 'path-point' }, place, what, remove), why);
}

function coneField(path, index, point, actions) {
  const cone = make('input', { type: 'number', id: `path-${index}-${point}-cone`, min: 0.1, max: 90, step: 'any', value: path.cones[point - 1] });
  cone.setAttribute('aria-label', `Path ${index + 1}, segment ${point}: half angle of its cone, °`);
  cone.onchange = () => (cone.checkValidity() && cone.value ? actions.cone(index, point - 1, cone.valueAsNumber) : cone.reportValidity());
  return make('span', { className: 'cone' }, cone, '°');
}

const removal = (id, label, onclick) => make('button', { type: 'button', id, 'aria-label': label, title: label, onclick }, '×');

export const lightName = ({ name, kind }) => (name ? `${name} (${kind})` : kind);
