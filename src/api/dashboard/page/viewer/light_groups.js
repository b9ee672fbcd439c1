// The light groups of a picture: how bright and in which color the light of each is shown. The picture is their sum, so that this needs no new passes.

import { element, make, setHidden, setText } from '../elements/dom.js';
import { changeLook } from './look.js';

export const LIGHT_GROUPS = 'light_groups';
const PREFIX = 'light_group.';
const MOST_BRIGHTNESS = 4;
const AS_RENDERED = { brightness: 1, color: '#ffffff' };

// What was chosen, by the group's name: jobs of one scene have the same groups.
const chosen = new Map();
// Rises with every choice.
let version = 0;
let shown = '';
let remix = () => {};

export const keepsGroups = job => Boolean(job?.light_groups?.length);
export const mixVersion = () => version;

// `remixed` is called when groups are to be shown in another way.
export function startLightGroups(remixed) {
  remix = remixed;
  element('light-groups-reset').onclick = () => {
    chosen.clear();
    shown = '';
    tell();
  };
}

function tell() {
  version++;
  remix();
  changeLook({});
}

function choose(name, changes) {
  chosen.set(name, { ...AS_RENDERED, ...chosen.get(name), ...changes });
  tell();
}

// The values of a picture, of those of its groups beside each other; `channels` names them.
export function mixed(values, channels) {
  const names = channels.filter((_, index) => index % 3 === 0).map(channel => channel.slice(PREFIX.length, channel.lastIndexOf('.')));
  const factors = Float32Array.from(names.flatMap(factorsOf));
  const result = new Float32Array(values.length / names.length);
  for (let at = 0, out = 0; out < result.length; out += 3) {
    for (let channel = 0; channel < factors.length; channel++, at++) result[out + (channel % 3)] += factors[channel] * values[at];
  }
  return result;
}

// What the channels of a group are multiplied with.
function factorsOf(name) {
  const { brightness, color } = chosen.get(name) ?? AS_RENDERED;
  return [1, 3, 5].map(at => brightness * linear(parseInt(color.slice(at, at + 2), 16) / 255));
}

// The inverse of the sRGB curve.
const linear = value => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);

export function showLightGroups(job, layer) {
  setHidden(element('light-groups'), layer !== LIGHT_GROUPS);
  if (layer !== LIGHT_GROUPS) return;
  const names = job.light_groups;
  if (shown !== names.join()) {
    shown = names.join();
    element('light-group-list').replaceChildren(...names.map(controlsOf));
  }
  names.forEach((name, index) => setText(element(`light-group-${index}-value`), String((chosen.get(name) ?? AS_RENDERED).brightness)));
}

function controlsOf(name, index) {
  const id = `light-group-${index}`;
  const { brightness, color } = chosen.get(name) ?? AS_RENDERED;
  const range = { id, type: 'range', min: 0, max: MOST_BRIGHTNESS, step: 0.05, value: brightness };
  const slider = make('input', { ...range, oninput: event => choose(name, { brightness: event.target.valueAsNumber }) });
  const label = `Color of ${name}`;
  const picker = make('input', { type: 'color', value: color, 'aria-label': label, title: label, oninput: event => choose(name, { color: event.target.value }) });
  const value = make('output', { id: `${id}-value`, for: id });
  return make('div', { className: 'control' }, make('label', { for: id }, name), slider, make('span', {}, value, ' ', picker));
}
