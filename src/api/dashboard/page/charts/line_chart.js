// A chart of lines as SVG. Pure: the answer depends on the arguments alone.

import { makeSvg } from '../elements/dom.js';
import { duration, short } from '../elements/numbers.js';

const WIDTH = 320;
const HEIGHT = 170;
const MARGIN = { left: 48, right: 10, top: 10, bottom: 22 };

// `lines` is a list of `{ name, className, points: [[seconds, value], …] }`; `goal` draws a dashed line.
export function lineChart({ label, lines, isLogarithmic, goal }) {
  const points = lines.flatMap(line => line.points).filter(([, value]) => Number.isFinite(value) && (!isLogarithmic || value > 0));
  const end = Math.max(...points.map(([seconds]) => seconds), 1);
  const [low, high] = valueRange(points.map(([, value]) => value).concat(goal ?? []), isLogarithmic);
  const position = isLogarithmic ? Math.log : value => value;
  const x = seconds => MARGIN.left + (seconds / end) * (WIDTH - MARGIN.left - MARGIN.right);
  const y = value =>
    HEIGHT - MARGIN.bottom - ((position(value) - position(low)) / (position(high) - position(low))) * (HEIGHT - MARGIN.top - MARGIN.bottom);
  const children = [
    ...valueTicks(low, high, isLogarithmic).flatMap(value => horizontal(y(value), short(value))),
    ...[0, 0.5, 1].map(share => text(x(share * end), HEIGHT - 6, duration(share * end), ['start', 'middle', 'end'][share * 2])),
    ...lines.map(line => path(line, x, y, isLogarithmic)),
  ];
  if (goal) children.push(makeSvg('line', { class: 'goal', x1: MARGIN.left, x2: WIDTH - MARGIN.right, y1: y(goal), y2: y(goal) }));
  return makeSvg('svg', { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: 'img', 'aria-label': label, class: 'chart' }, children);
}

function path({ className, points }, x, y, isLogarithmic) {
  const drawn = points.filter(([, value]) => Number.isFinite(value) && (!isLogarithmic || value > 0));
  const steps = drawn.map(([seconds, value], index) => `${index ? 'L' : 'M'}${x(seconds).toFixed(1)} ${y(value).toFixed(1)}`);
  return makeSvg('path', { class: className, d: steps.join('') });
}

// Round values around all that is drawn. Linear axes begin at 0.
function valueRange(values, isLogarithmic) {
  if (!values.length) return [isLogarithmic ? 0.1 : 0, 1];
  const [least, most] = [Math.min(...values), Math.max(...values)];
  if (isLogarithmic) return [10 ** Math.floor(Math.log10(least)), 10 ** Math.ceil(Math.log10(most) + 1e-9)];
  return [0, roundUp(most) || 1];
}

function roundUp(value) {
  const unit = 10 ** Math.floor(Math.log10(value || 1));
  return (Math.ceil((value / unit) * 2) / 2) * unit;
}

function valueTicks(low, high, isLogarithmic) {
  if (!isLogarithmic) return high > 1 ? [0, high / 2, high] : [0, high];
  const [from, to] = [Math.round(Math.log10(low)), Math.round(Math.log10(high))];
  const step = Math.ceil((to - from) / 4);
  return Array.from({ length: Math.floor((to - from) / step) + 1 }, (_, index) => 10 ** (from + index * step));
}

const horizontal = (y, label) => [
  makeSvg('line', { class: 'grid', x1: MARGIN.left, x2: WIDTH - MARGIN.right, y1: y, y2: y }),
  text(MARGIN.left - 5, y + 3.5, label, 'end'),
];

const text = (x, y, label, anchor) => makeSvg('text', { x, y, 'text-anchor': anchor }, label);
