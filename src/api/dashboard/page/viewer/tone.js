// From light to bytes. Pure functions.
//
// A tone table holds the byte of every float, found by the float's upper 18 bits: sign, exponent and 9 bits of the fraction, which is a tenth of
// what a byte can tell apart. So a pixel costs a look-up however the curve is made.

const DROPPED_BITS = 14;
const ENTRIES = 1 << (32 - DROPPED_BITS);

const clamp = value => Math.min(Math.max(value, 0), 1);

// As IEC 61966-2-1 has it.
export const encodeSrgb = value => (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);

export const CURVES = {
  srgb: { label: 'sRGB', of: value => encodeSrgb(clamp(value)) },
  gamma: { label: 'gamma', of: (value, gamma) => clamp(value) ** (1 / gamma) },
  linear: { label: 'linear', of: clamp },
  // Narkowicz 2015, "ACES Filmic Tone Mapping Curve".
  filmic: { label: 'filmic', of: value => encodeSrgb(clamp((value * (2.51 * value + 0.03)) / (value * (2.43 * value + 0.59) + 0.14))) },
};

export function toneTable({ curve, exposure, gamma }) {
  const { of } = CURVES[curve];
  const factor = 2 ** exposure;
  return tableOf(value => 255 * of(Math.min(value * factor, 1e6), gamma));
}

// The table of a function from values to bytes. What is negative or no number has byte 0.
export function tableOf(byte) {
  const bits = new Uint32Array(1);
  const value = new Float32Array(bits.buffer);
  const table = new Uint8ClampedArray(ENTRIES);
  for (let entry = 0; entry < ENTRIES; entry++) {
    // The middle of all floats that share the entry.
    bits[0] = (entry << DROPPED_BITS) | (1 << (DROPPED_BITS - 1));
    table[entry] = byte(Number.isNaN(value[0]) ? 0 : Math.max(value[0], 0));
  }
  table[0] = byte(0);
  // Infinity itself, not the middle of what follows it.
  table[0x7f800000 >>> DROPPED_BITS] = byte(Infinity);
  return table;
}

// Where to look for the byte of a float whose bits are given.
export const entryOf = bits => bits >>> DROPPED_BITS;
