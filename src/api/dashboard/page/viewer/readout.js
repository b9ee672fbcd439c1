// Tells the pixel under the pointer, or in the middle of the view while no pointer is there, and how large pixels are shown.

import { element, setText } from '../elements/dom.js';
import { short } from '../elements/numbers.js';
import { channelLetter } from './layers.js';

const DIGITS = 7;
// Two pictures' values stand beside each other.
const SHORT_DIGITS = 5;
const HALF_DIGITS = 4;

export function showReadout({ view, ratio, pixel, sources, inset }) {
  setText(element('zoom'), sources.length ? `${short(100 * view.zoom, 3)} %` : '');
  const at = { x: Math.floor(pixel.x), y: Math.floor(pixel.y) };
  // What lies over the picture is what is seen.
  const ofInset = inset?.source.valueAt({ x: at.x - inset.x, y: at.y - inset.y });
  const found = ofInset ? [ofInset] : sources.map(source => source.valueAt(at)).filter(Boolean);
  const names = found.length > 1 ? ['A ', 'B '] : [''];
  const values = found.map((value, index) => names[index] + valueText(value, found.length > 1 ? SHORT_DIGITS : DIGITS));
  setText(element('readout'), found.length ? [`${at.x}, ${at.y}`, ...values, blockText(found[0]), ofInset ? 'of the region' : ''].filter(Boolean).join('   ') : '');
  element('picture').style.cursor = view.zoom > 8 * ratio ? 'crosshair' : 'grab';
}

const valueText = ({ values, channels, format }, digits) =>
  channels.map((channel, index) => `${channelLetter(channel)} ${short(values[index], format === 'half' ? HALF_DIGITS : digits)}`).join(' ');

// Coarse values are means, and 16-bit floats have three digits.
function blockText({ level, format }) {
  if (level > 0) return `mean of ${2 ** level} × ${2 ** level} pixels`;
  return format === 'half' ? '(16-bit)' : '';
}
