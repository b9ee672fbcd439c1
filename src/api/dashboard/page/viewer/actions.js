// What keys and buttons do to the viewer.

import { element } from '../elements/dom.js';
import { nextCurve, resetLook } from './controls.js';
import { LAYERS } from './layers.js';
import { changeLook, look } from './look.js';
import { leaveRegion, pressRegion } from './region.js';
import { actualSize, changeComparison, changeLayer, fit, pan, viewer, zoomBy } from './viewer.js';

// The functions that the table of keys names. `openNeighbour` and `help` belong to the page.
export function viewerActions({ openNeighbour, help }) {
  element('zoom-fit').onclick = fit;
  element('zoom-actual').onclick = actualSize;
  element('zoom-in').onclick = () => zoomBy(Math.SQRT2);
  element('zoom-out').onclick = () => zoomBy(Math.SQRT1_2);
  element('full-screen').onclick = () => (document.fullscreenElement ? document.exitFullscreen() : element('stage').requestFullscreen());
  return {
    exposure: stops => changeLook({ exposure: look.exposure + stops }),
    gamma: step => changeLook({ gamma: look.gamma + step, curve: 'gamma' }),
    curve: nextCurve,
    falseColor: () => changeLook({ isFalseColor: !look.isFalseColor }),
    reset: resetLook,
    fit,
    actual: actualSize,
    zoom: zoomBy,
    pan,
    layer: index => changeLayer(LAYERS[index].name),
    job: openNeighbour,
    compare: mode => changeComparison({ mode }),
    flip: () => changeComparison({ mode: 'flip', showsOther: viewer.comparison.mode === 'flip' && !viewer.comparison.showsOther }),
    split: step => changeComparison({ mode: 'slider', split: Math.min(Math.max(viewer.comparison.split + step, 0), 1) }),
    region: pressRegion,
    leaveRegion,
    find: () => element('text-filter').focus(),
    help,
  };
}
