// Numbers, counts and times as people read them. Pure functions.

const PLURALS = { pass: 'passes' };

export const count = (number, word) => `${number.toLocaleString('en')} ${number === 1 ? word : (PLURALS[word] ?? `${word}s`)}`;

// Two parts at most: "45 s", "3 min 20 s", "2 h 5 min", "3 d 4 h".
export function duration(seconds) {
  if (seconds < 10) return `${Math.max(seconds, 0).toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return twoParts(whole, 60, 'min', 1, 's');
  if (whole < 86400) return twoParts(whole, 3600, 'h', 60, 'min');
  return twoParts(whole, 86400, 'd', 3600, 'h');
}

function twoParts(seconds, large, largeUnit, small, smallUnit) {
  const rest = Math.floor((seconds % large) / small);
  return `${Math.floor(seconds / large)} ${largeUnit}${rest ? ` ${rest} ${smallUnit}` : ''}`;
}

// Three digits that count, without needless zeros: 0.0123, 1.5e-7, 12300.
export function short(value, digits = 3) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? 'NaN' : value > 0 ? '∞' : '−∞';
  return String(Number(value.toPrecision(digits)));
}

// A rate with its unit: "1.25 million photons/s".
export function rate(perSecond, what) {
  if (perSecond >= 1e6) return `${(perSecond / 1e6).toFixed(2)} million ${what}/s`;
  return `${Math.round(perSecond).toLocaleString('en')} ${what}/s`;
}

// Swedish dates are those of ISO 8601, which nobody takes for another day.
const ISO = 'sv-SE';
export const time = milliseconds => new Date(milliseconds).toLocaleTimeString(ISO);
export const date = milliseconds => new Date(milliseconds).toLocaleString(ISO);
