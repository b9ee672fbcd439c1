// What a picture's values are like as a whole. Pure functions.

// Values that may lie outside of an automatic scale, at each end.
const OUTSIDE = 0.005;
// From this ratio of largest to smallest value on, equal ratios are to look alike.
const LOGARITHMIC_FROM = 30;
// What pixels hold in which nothing is seen.
export const NOTHING_SEEN = 1e10;

// A scale that covers all but a few values; `null` where there is none.
export function scaleOf(values) {
  const known = values.filter(value => Number.isFinite(value) && Math.abs(value) < NOTHING_SEEN);
  if (!known.length) return null;
  const positive = known.filter(value => value > 0);
  // Zeros, where no light is, have no place on a logarithmic scale, and yet most others may need one.
  if (positive.length > known.length / 2 && known.every(value => value >= 0)) {
    const [low, high] = innerRange(positive);
    if (high / low > LOGARITHMIC_FROM) return { low, high, isLogarithmic: true };
  }
  const [low, high] = innerRange(known);
  if (low === high) return { low: low - Math.abs(low || 1) / 2, high: high + Math.abs(high || 1) / 2, isLogarithmic: false };
  return { low, high, isLogarithmic: false };
}

// The least and the largest value, a few left out.
function innerRange(values) {
  const sorted = values.slice().sort();
  const skipped = Math.floor(OUTSIDE * (sorted.length - 1));
  return [sorted[skipped], sorted[sorted.length - 1 - skipped]];
}

// Counts of values in equal steps of log2 from `from` to `to`, one list for each channel. What is not above 0 or lies outside is not counted.
export function histogram(values, channels, { from, to, bins }) {
  const counts = Array.from({ length: channels }, () => new Uint32Array(bins));
  for (let index = 0; index < values.length; index++) {
    const bin = Math.floor(((Math.log2(values[index]) - from) / (to - from)) * bins);
    if (bin >= 0 && bin < bins) counts[index % channels][bin]++;
  }
  return counts;
}

// The least, the mean and the largest of what is finite.
export function summary(values) {
  let [least, largest, sum, number] = [Infinity, -Infinity, 0, 0];
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    least = Math.min(least, value);
    largest = Math.max(largest, value);
    sum += value;
    number++;
  }
  return { least, largest, mean: sum / number, notFinite: values.length - number };
}

// How far a picture is from a reference, as `photonfarm compare` measures it: RMSE over pixels and channels, and relMSE, the mean of
// error² / (Y² + 10⁻³·m²), with Y the channel mean of a reference pixel and m the reference's mean.
export function errors(values, reference, channels) {
  let [sum, squares] = [0, 0];
  for (let index = 0; index < values.length; index++) {
    sum += reference[index];
    squares += (values[index] - reference[index]) ** 2;
  }
  const floor = 1e-3 * (sum / values.length) ** 2;
  let relative = 0;
  for (let at = 0; at < values.length; at += channels) {
    let [gray, error] = [0, 0];
    for (let channel = 0; channel < channels; channel++) {
      gray += reference[at + channel] / channels;
      error += (values[at + channel] - reference[at + channel]) ** 2;
    }
    relative += error / channels / (gray ** 2 + floor);
  }
  return { rmse: Math.sqrt(squares / values.length), relmse: relative / (values.length / channels) };
}
