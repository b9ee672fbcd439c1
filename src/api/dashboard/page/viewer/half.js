// 16-bit floats (IEEE 754 binary16) as numbers, by a table of all of them. Pure functions.

const VALUES = Float32Array.from({ length: 1 << 16 }, (_, bits) => valueOf(bits));

function valueOf(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? (1024 + fraction) * 2 ** (exponent - 25) : fraction * 2 ** -24);
}

export function decodeHalf(bits) {
  const values = new Float32Array(bits.length);
  for (let index = 0; index < bits.length; index++) values[index] = VALUES[bits[index]];
  return values;
}
