// The controls of the look: they show it and change it.

import { element, make, setHidden, setText } from '../elements/dom.js';
import { short } from '../elements/numbers.js';
import { LAYERS, layerNamed } from './layers.js';
import { LIGHT_GROUPS, keepsGroups, showLightGroups } from './light_groups.js';
import { DEFAULT_LOOK, changeLook, chooseScale, isScaleChosen, look, usesScale } from './look.js';
import { PALETTE } from './palette.js';
import { CURVES } from './tone.js';

// Layers that have a key.
const DIGITS = 9;

let shownScale = null;
let shownLayer = 'color';

// `changeLayer` is called with a layer's name.
export function startControls(changeLayer) {
  const layer = ({ name, label }, index) =>
    make(
      'label',
      { title: index < DIGITS ? `${label} (${index + 1})` : label },
      make('input', { type: 'radio', name: 'layer', value: name, onchange: () => changeLayer(name) }),
      label,
    );
  element('layers').append(make('div', { className: 'segments' }, LAYERS.map(layer)));
  element('curve').append(...Object.entries(CURVES).map(([value, { label }]) => make('option', { value }, label)));
  element('exposure').oninput = event => changeLook({ exposure: event.target.valueAsNumber });
  element('gamma').oninput = event => changeLook({ gamma: event.target.valueAsNumber, curve: 'gamma' });
  element('curve').onchange = event => changeLook({ curve: event.target.value });
  element('false-color').onchange = event => changeLook({ isFalseColor: event.target.checked });
  element('reset-look').onclick = () => resetLook();
  element('scale-auto').onclick = () => chooseScale(shownLayer, null);
  for (const id of ['scale-low', 'scale-high', 'scale-log']) element(id).onchange = readScale;
  drawColorBar();
}

export function resetLook() {
  chooseScale(shownLayer, null);
  changeLook(DEFAULT_LOOK);
}

export function nextCurve() {
  const names = Object.keys(CURVES);
  changeLook({ curve: names[(names.indexOf(look.curve) + 1) % names.length] });
}

function readScale() {
  const [low, high] = ['scale-low', 'scale-high'].map(id => Number(element(id).value.replace(',', '.')));
  const isLogarithmic = element('scale-log').checked;
  const problem = !(low < high) ? 'Give two numbers, the smaller one first.' : isLogarithmic && low <= 0 ? 'A logarithmic scale begins above 0.' : '';
  setText(element('scale-problem'), problem);
  setHidden(element('scale-problem'), !problem);
  if (!problem) chooseScale(shownLayer, { low, high, isLogarithmic });
}

export function showControls({ layer, job }, scale) {
  shownLayer = layer;
  setHidden(element('layers').querySelector(`[value=${LIGHT_GROUPS}]`).closest('label'), !keepsGroups(job));
  showLightGroups(job, layer);
  element('layers').querySelector(`[value=${layer}]`).checked = true;
  set('exposure', look.exposure);
  setText(element('exposure-value'), `${look.exposure > 0 ? '+' : ''}${look.exposure}`);
  set('gamma', look.gamma);
  setText(element('gamma-value'), String(look.gamma));
  set('curve', look.curve);
  element('false-color').checked = look.isFalseColor;
  showOnlyUseful(layer);
  setHidden(element('scale-auto'), !isScaleChosen(layer));
  if (scale && scale !== shownScale) showScale(scale);
}

// What would change nothing is not there.
function showOnlyUseful(layer) {
  const isColor = layerNamed(layer).kind === 'color';
  const hasTone = isColor && !look.isFalseColor;
  setHidden(element('exposure').closest('.control'), !hasTone);
  setHidden(element('curve').closest('.control'), !hasTone);
  setHidden(element('gamma').closest('.control'), !hasTone || look.curve !== 'gamma');
  setHidden(element('false-color').closest('p'), !isColor);
  setHidden(element('scale'), !usesScale(layer));
}

function showScale(scale) {
  shownScale = scale;
  set('scale-low', short(scale.low));
  set('scale-high', short(scale.high));
  element('scale-log').checked = scale.isLogarithmic;
}

// A control in which the user types keeps what is typed.
function set(id, value) {
  const control = element(id);
  if (document.activeElement !== control && control.value !== String(value)) control.value = value;
}

function drawColorBar() {
  const image = new ImageData(256, 1);
  new Uint32Array(image.data.buffer).set(PALETTE.subarray(0, 256));
  element('color-bar').getContext('2d').putImageData(image, 0, 0);
}
