// The histogram of the whole picture, as far as its coarse values tell it.

import { element, setText } from '../elements/dom.js';
import { short } from '../elements/numbers.js';
import { layerNamed } from './layers.js';
import { look } from './look.js';
import { histogram, summary } from './statistics.js';

const BINS = 128;
// Values are spread over powers of 2, at most this many below the largest.
const MOST_OCTAVES = 20;
const COLORS = ['#e5484d', '#30a46c', '#3e8bff'];

const canvas = element('histogram');
let drawnAs = '';

export function showHistogram(source, layer) {
  const overview = source?.overview;
  const wanted = [overview?.tag, canvas.clientWidth, look.version, devicePixelRatio].join('/');
  if (!canvas.clientWidth || wanted === drawnAs) return;
  drawnAs = wanted;
  Object.assign(canvas, { width: canvas.clientWidth * devicePixelRatio, height: canvas.clientHeight * devicePixelRatio });
  const level = overview?.level ?? 0;
  setText(element('histogram-note'), level ? `of means over ${2 ** level} × ${2 ** level} pixels` : '');
  if (!overview) return setText(element('histogram-summary'), '');
  const facts = summary(overview.values);
  const { unit } = layerNamed(layer);
  const more = facts.notFinite ? `, ${facts.notFinite} not finite` : '';
  setText(element('histogram-summary'), `least ${short(facts.least)}, mean ${short(facts.mean)}, largest ${short(facts.largest)} ${unit}${more}`);
  draw(overview, facts, layer);
}

function draw({ values, channels }, { largest }, layer) {
  const context = canvas.getContext('2d');
  const to = Math.ceil(Math.log2(Math.max(largest, 1e-30))) || 1;
  const from = lowest(values, to);
  const counts = histogram(values, channels.length, { from, to, bins: BINS });
  const most = Math.max(...counts.flatMap(list => [...list]), 1);
  const { width, height } = canvas;
  context.globalAlpha = channels.length > 1 ? 0.55 : 0.9;
  counts.forEach((list, channel) => {
    context.fillStyle = channels.length > 1 ? COLORS[channel] : '#8a8f98';
    list.forEach((number, bin) => {
      // The square root lets rare values be seen, too.
      const size = height * Math.sqrt(number / most);
      context.fillRect((bin * width) / BINS, height - size, Math.ceil(width / BINS), size);
    });
  });
  if (layerNamed(layer).kind === 'color') drawWhite(context, ((-look.exposure - from) / (to - from)) * width);
}

function lowest(values, to) {
  let least = Infinity;
  for (const value of values) if (value > 0 && value < least) least = value;
  return Math.max(Math.min(Math.floor(Math.log2(least)), to - 1), to - MOST_OCTAVES);
}

// The value that is white on the screen.
function drawWhite(context, x) {
  context.globalAlpha = 1;
  context.fillStyle = getComputedStyle(canvas).color;
  context.fillRect(x, 0, devicePixelRatio, canvas.height);
}
