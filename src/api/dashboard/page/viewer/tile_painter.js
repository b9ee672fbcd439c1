// Tiles of numbers as small canvases. Each is painted once for a look and kept.

import { look, usesScale } from './look.js';
import { layerNamed } from './layers.js';
import { difference, paintColor, paintNormals, paintScale, singleChannel } from './paint.js';

// The canvas of a tile; of its difference from `other` where that is given.
export function painted(tile, layer, scale, other = null) {
  const wanted = [look.version, scale?.low, scale?.high, scale?.isLogarithmic, other?.tag].join('/');
  if (tile.paintedAs === wanted) return tile.canvas;
  tile.canvas ??= new OffscreenCanvas(tile.width, tile.height);
  const image = new ImageData(tile.width, tile.height);
  const values = other ? difference(tile.values, other.values) : tile.values;
  paintValues(values, tile.channels.length, layer, scale, new Uint32Array(image.data.buffer));
  tile.canvas.getContext('2d').putImageData(image, 0, 0);
  tile.paintedAs = wanted;
  return tile.canvas;
}

function paintValues(values, channels, layer, scale, pixels) {
  if (usesScale(layer)) paintScale(singleChannel(values, channels), scale ?? { low: 0, high: 1 }, pixels);
  else if (layerNamed(layer).kind === 'normal') paintNormals(values, pixels);
  else paintColor(values, look.table, pixels);
}
