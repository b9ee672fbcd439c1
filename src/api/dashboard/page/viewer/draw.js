// Draws the viewer's canvas: the tiles of one picture or of two, the line between them, and the numbers of large pixels.

import { TILE, levelFor, toPicture, toScreen } from './geometry.js';
import { channelLetter } from './layers.js';
import { painted } from './tile_painter.js';
import { short } from '../elements/numbers.js';

// Pixels of this many CSS pixels have room for their numbers.
export const NUMBERS_FROM = 52;
const CHANNEL_COLORS = { R: '#ff9a8f', G: '#9be08a', B: '#9fc4ff', X: '#ff9a8f', Y: '#f2f2f2', Z: '#9fc4ff' };

// `frame` has: `context`, `screen`, `ratio` (device pixels of a CSS pixel), `view`, `layer`, `scale`, `sources` (one or two),
// `inset` (a `source` with a `view` of its own, or null) and `comparison`.
export function drawFrame(frame) {
  const {
    context,
    screen,
    sources: [first, second],
    comparison,
  } = frame;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, screen.width, screen.height);
  if (!first) return;
  if (!second) drawPicture(frame, first);
  else if (comparison.mode === 'difference') drawPicture(frame, first, second);
  else if (comparison.mode === 'flip') drawPicture(frame, comparison.showsOther ? second : first);
  else drawSplit(frame);
  drawNumbers(frame, second && comparison.mode === 'flip' && comparison.showsOther ? second : first);
  if (frame.inset) drawInset(frame, frame.inset);
}

// Another job's picture over a part of the first one, with a border of one pixel of the screen.
function drawInset(frame, { source, view }) {
  if (!source.overview) return;
  const own = { ...frame, view };
  drawPicture(own, source);
  drawNumbers(own, source);
  const { context, screen, ratio } = frame;
  const [from, to] = [toScreen(view, screen, { x: 0, y: 0 }), toScreen(view, screen, { x: source.size.width, y: source.size.height })];
  outlineRectangle(context, from, to, ratio);
}

// A rectangle that is seen on any picture, at whole pixels of the screen.
export function outlineRectangle(context, from, to, ratio) {
  const [left, top, right, bottom] = [from.x, from.y, to.x, to.y].map(Math.round);
  context.lineWidth = ratio;
  for (const [color, outside] of [
    ['rgb(0 0 0 / 75%)', 1.5 * ratio],
    ['#ffffff', ratio / 2],
  ]) {
    context.strokeStyle = color;
    context.strokeRect(left - outside, top - outside, right - left + 2 * outside, bottom - top + 2 * outside);
  }
}

function drawSplit(frame) {
  const {
    context,
    screen,
    ratio,
    sources: [first, second],
    comparison,
  } = frame;
  const line = Math.round(screen.width * comparison.split);
  const half = (source, left, width) => {
    context.save();
    context.beginPath();
    context.rect(left, 0, width, screen.height);
    context.clip();
    drawPicture(frame, source);
    context.restore();
  };
  half(first, 0, line);
  half(second, line, screen.width - line);
  context.fillStyle = '#ffffff';
  context.fillRect(line - ratio / 2, 0, ratio, screen.height);
}

function drawPicture(frame, source, other) {
  const { context, screen, view, layer, scale } = frame;
  const [left, top] = Object.values(toScreen(view, screen, { x: 0, y: 0 }));
  const { width, height } = source.size;
  context.save();
  context.beginPath();
  // Blocks at the edges reach beyond the picture.
  context.rect(left, top, width * view.zoom, height * view.zoom);
  context.clip();
  const finest = levelFor(view, source.size, false);
  for (const tile of source.drawable(finest)) {
    const partner = other?.same(tile);
    if (other && !partner) continue;
    const side = 2 ** tile.level * view.zoom;
    // Enlarged pixels are squares; what is only coarse for now, or made smaller, is smooth.
    context.imageSmoothingEnabled = tile.level > 0 || side < 1;
    context.imageSmoothingQuality = 'high';
    const canvas = painted(tile, layer, scale, partner);
    context.drawImage(canvas, left + tile.x * TILE * side, top + tile.y * TILE * side, tile.width * side, tile.height * side);
  }
  context.restore();
}

function drawNumbers(frame, source) {
  const { context, screen, view, ratio } = frame;
  if (view.zoom < NUMBERS_FROM * ratio) return;
  const [first, last] = [toPicture(view, screen, { x: 0, y: 0 }), toPicture(view, screen, { x: screen.width, y: screen.height })];
  const size = Math.min(view.zoom / 5, 15 * ratio);
  context.font = `${size}px ui-monospace, monospace`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  for (let y = Math.floor(first.y); y < last.y; y++) {
    for (let x = Math.floor(first.x); x < last.x; x++) {
      const found = source.valueAt({ x, y });
      if (found?.level === 0) drawPixelNumbers(context, found, toScreen(view, screen, { x: x + 0.5, y: y + 0.5 }), size);
    }
  }
}

function drawPixelNumbers(context, { values, channels }, { x, y }, size) {
  context.lineWidth = size / 5;
  context.strokeStyle = 'rgb(0 0 0 / 75%)';
  values.forEach((value, index) => {
    const at = y + (index - (values.length - 1) / 2) * size * 1.3;
    context.strokeText(short(value, 4), x, at);
    context.fillStyle = CHANNEL_COLORS[channelLetter(channels[index])];
    context.fillText(short(value, 4), x, at);
  });
}
