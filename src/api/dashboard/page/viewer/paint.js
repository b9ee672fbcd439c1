// Float values as pixels of a screen. Pure functions on typed arrays: the inner loops of the viewer.

import { NO_VALUE_STEP, OPAQUE, PALETTE, shareOf } from './palette.js';
import { entryOf } from './tone.js';

// Rec. 709.
export const luminance = (red, green, blue) => 0.2126 * red + 0.7152 * green + 0.0722 * blue;

// Three channels by a tone table.
export function paintColor(values, table, pixels) {
  const bits = new Uint32Array(values.buffer, values.byteOffset, values.length);
  for (let pixel = 0, at = 0; pixel < pixels.length; pixel++, at += 3) {
    const [red, green, blue] = [table[entryOf(bits[at])], table[entryOf(bits[at + 1])], table[entryOf(bits[at + 2])]];
    pixels[pixel] = OPAQUE | (blue << 16) | (green << 8) | red;
  }
}

// Unit vectors: -1 is black, 1 is full.
export function paintNormals(values, pixels) {
  const byte = value => Math.round(255 * Math.min(Math.max((value + 1) / 2, 0), 1));
  for (let pixel = 0, at = 0; pixel < pixels.length; pixel++, at += 3) {
    pixels[pixel] = OPAQUE | (byte(values[at + 2]) << 16) | (byte(values[at + 1]) << 8) | byte(values[at]);
  }
}

// One value a pixel in false colors.
export function paintScale(values, scale, pixels) {
  const { low, high, isLogarithmic } = scale;
  const factor = 255 / (isLogarithmic ? Math.log(high / low) : high - low);
  for (let pixel = 0; pixel < pixels.length; pixel++) {
    const value = values[pixel];
    const share = isLogarithmic ? (value > 0 ? Math.log(value / low) : NaN) : value - low;
    const step = Math.round(share * factor);
    pixels[pixel] = PALETTE[step >= 0 && step <= 255 ? step : Number.isFinite(shareOf(value, scale)) ? (step < 0 ? 0 : 255) : NO_VALUE_STEP];
  }
}

// The luminance of colors; other layers as they are.
export function singleChannel(values, channels) {
  if (channels === 1) return values;
  const single = new Float32Array(values.length / channels);
  for (let pixel = 0, at = 0; pixel < single.length; pixel++, at += channels) {
    single[pixel] = luminance(values[at], values[at + 1], values[at + 2]);
  }
  return single;
}

// How far two pictures are from each other, channel by channel.
export function difference(values, other) {
  const result = new Float32Array(values.length);
  for (let index = 0; index < result.length; index++) result[index] = Math.abs(values[index] - other[index]);
  return result;
}
