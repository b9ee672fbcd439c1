// How the numbers of a picture are shown: exposure, curve, false colors and their scale. It changes by `changeLook` only, which tells whoever draws.

import { scaleOf } from './statistics.js';
import { difference, singleChannel } from './paint.js';
import { layerNamed } from './layers.js';
import { toneTable } from './tone.js';

export const DEFAULT_LOOK = { exposure: 0, gamma: 2.2, curve: 'srgb', isFalseColor: false };
export const MOST_EXPOSURE = 20;
const GAMMAS = [0.2, 6];

export const look = { ...DEFAULT_LOOK, table: toneTable(DEFAULT_LOOK), version: 0 };

let tell = () => {};
export const onLook = listener => {
  tell = listener;
};

export function changeLook(changes) {
  const within = (value, low, high) => Math.min(Math.max(value, low), high);
  Object.assign(look, changes);
  look.exposure = within(Math.round(look.exposure * 100) / 100, -MOST_EXPOSURE, MOST_EXPOSURE);
  look.gamma = within(Math.round(look.gamma * 100) / 100, ...GAMMAS);
  look.table = toneTable(look);
  look.version++;
  tell();
}

// Whether values are shown on a scale of false colors.
export const usesScale = layer => layerNamed(layer).kind === 'scale' || (look.isFalseColor && layerNamed(layer).kind === 'color');

// The scales that users chose, by layer; elsewhere they follow from the values.
const chosenScales = new Map();

export function chooseScale(layer, scale) {
  if (scale) chosenScales.set(layer, scale);
  else chosenScales.delete(layer);
  changeLook({});
}

export const isScaleChosen = layer => chosenScales.has(layer);

// The scale of a layer whose values, all of them coarsely, are in this tile; of the difference where another tile is given.
export function currentScale(layer, overview, other) {
  if (chosenScales.has(layer)) return chosenScales.get(layer);
  if (!overview) return null;
  // Values of the same tiles give the same scale; finding it sorts them all.
  if (overview.scaleOther !== other || !overview.scale) {
    const values = other ? difference(overview.values, other.values) : overview.values;
    overview.scale = scaleOf(singleChannel(values, overview.channels.length)) ?? { low: 0, high: 1, isLogarithmic: false };
    overview.scaleOther = other;
  }
  return overview.scale;
}
