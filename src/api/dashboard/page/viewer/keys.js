// The keys of the page: one table, which the help shows, too. They are those of the viewer `tev` where it has them.

import { make } from '../elements/dom.js';
import { openNote } from '../elements/dialogs.js';

// Key as the browser names it, how it is written, what it does, and the name of the action with its argument.
export const KEYS = [
  ['e', 'E', 'brighter by half a stop', 'exposure', 0.5],
  ['E', 'Shift+E', 'darker by half a stop', 'exposure', -0.5],
  ['g', 'G', 'gamma curve, larger gamma', 'gamma', 0.1],
  ['G', 'Shift+G', 'gamma curve, smaller gamma', 'gamma', -0.1],
  ['t', 'T', 'next tone curve', 'curve'],
  ['c', 'C', 'false colors of luminance, on and off', 'falseColor'],
  ['r', 'R', 'exposure, curve and scale as at first', 'reset'],
  ['f', 'F', 'fit the picture to the window', 'fit'],
  ['a', 'A', 'actual size: a pixel of the picture on one of the screen', 'actual'],
  ['+', '+', 'closer', 'zoom', 2 ** 0.5],
  ['-', '−', 'farther', 'zoom', 2 ** -0.5],
  ['Shift+ArrowLeft', 'Shift+←', 'move to the left', 'pan', [80, 0]],
  ['Shift+ArrowRight', 'Shift+→', 'move to the right', 'pan', [-80, 0]],
  ['Shift+ArrowUp', 'Shift+↑', 'move up', 'pan', [0, 80]],
  ['Shift+ArrowDown', 'Shift+↓', 'move down', 'pan', [0, -80]],
  ['1', '1 … 9', 'color, radius, photons, error, albedo, normal, depth, denoised, its error', 'layer', 0],
  ...[1, 2, 3, 4, 5, 6, 7, 8].map(index => [String(index + 1), null, null, 'layer', index]),
  ['b', 'B', 'a region to be rendered first; again, or Enter, renders it', 'region'],
  ['Escape', 'Esc', 'take the region away', 'leaveRegion'],
  ['n', 'N', 'next job of the list', 'job', 1],
  ['p', 'P', 'previous job', 'job', -1],
  ['ArrowDown', '↓ or →', 'next job', 'job', 1],
  ['ArrowRight', null, null, 'job', 1],
  ['ArrowUp', '↑ or ←', 'previous job', 'job', -1],
  ['ArrowLeft', null, null, 'job', -1],
  ['s', 'S', 'compare side by side at a line', 'compare', 'slider'],
  ['x', 'X', 'flip between the two pictures', 'flip'],
  ['d', 'D', 'difference of the two pictures', 'compare', 'difference'],
  [',', ',', 'line to the left', 'split', -0.05],
  ['.', '.', 'line to the right', 'split', 0.05],
  ['/', '/', 'find a job', 'find'],
  ['?', '?', 'this list', 'help'],
];

const byKey = new Map(KEYS.map(row => [row[0], row]));

// `actions` has a function for each name in the table.
export function followKeys(actions) {
  document.addEventListener('keydown', event => {
    if (event.ctrlKey || event.altKey || event.metaKey || isTaken(event) || document.querySelector('dialog[open]')) return;
    const isShifted = event.shiftKey && event.key.startsWith('Arrow');
    const row = byKey.get(isShifted ? `Shift+${event.key}` : event.key === '=' ? '+' : event.key);
    if (!row) return;
    event.preventDefault();
    actions[row[3]](row[4]);
  });
}

// What is typed into a field belongs there, and so do arrows in a control that knows them.
function isTaken({ target, key }) {
  if (target.closest('input:not([type=radio], [type=checkbox], [type=range]), select, textarea')) return true;
  return key.startsWith('Arrow') && target.closest('input, [role=tablist]') !== null;
}

export function showKeys() {
  const rows = KEYS.filter(row => row[1]).map(([, key, meaning]) =>
    make('tr', {}, make('th', { scope: 'row' }, make('kbd', {}, key)), make('td', {}, meaning)),
  );
  const pointer = 'Drag moves the picture; the wheel or two fingers zoom. Close up, the pixels show their values.';
  openNote('Keys', [make('table', { className: 'keys' }, make('tbody', {}, rows)), make('p', {}, pointer)]);
}
