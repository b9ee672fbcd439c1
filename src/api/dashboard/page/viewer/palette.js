// False colors. Pure functions.
//
// From dark violet over blue and green to light yellow, a helix in Oklab [Ottosson 2020, "A perceptual color space for image processing"], as the
// maps of `photonfarm map` have it: lightness rises evenly, so equal steps look equally different, to color-blind people by lightness alone.

import { encodeSrgb } from './tone.js';

const LIGHTNESS = [0.22, 0.94];
const HUE_DEGREES = [318, 105];
const CHROMA = 0.1;
// Grey says that there is no value.
const NO_VALUE = [128, 128, 128];

export const OPAQUE = 0xff000000;
export const pixelOf = ([red, green, blue]) => (OPAQUE | (blue << 16) | (green << 8) | red) >>> 0;

export function colorAt(share) {
  const between = ([from, to]) => from + share * (to - from);
  const hue = (between(HUE_DEGREES) * Math.PI) / 180;
  return fromOklab([between(LIGHTNESS), CHROMA * Math.cos(hue), CHROMA * Math.sin(hue)]);
}

function fromOklab([lightness, a, b]) {
  const cone = (fromA, fromB) => (lightness + fromA * a + fromB * b) ** 3;
  const long = cone(0.3963377774, 0.2158037573);
  const medium = cone(-0.1055613458, -0.0638541728);
  const short = cone(-0.0894841775, -1.291485548);
  const linear = [
    4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
    -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
    -0.0041960863 * long - 0.7034186147 * medium + 1.707614701 * short,
  ];
  return linear.map(value => Math.round(255 * encodeSrgb(Math.min(Math.max(value, 0), 1))));
}

// 256 colors as pixels, and the one of no value behind them.
export const PALETTE = Uint32Array.from({ length: 257 }, (_, step) => pixelOf(step < 256 ? colorAt(step / 255) : NO_VALUE));
export const NO_VALUE_STEP = 256;

// Where a value lies from 0 to 1 on a scale from `low` to `high`; NaN where it has no place.
export function shareOf(value, { low, high, isLogarithmic }) {
  if (isLogarithmic) return value > 0 ? Math.log(value / low) / Math.log(high / low) : NaN;
  return (value - low) / (high - low);
}

export function stepOf(value, scale) {
  const share = shareOf(value, scale);
  return Number.isFinite(share) ? Math.round(255 * Math.min(Math.max(share, 0), 1)) : NO_VALUE_STEP;
}
