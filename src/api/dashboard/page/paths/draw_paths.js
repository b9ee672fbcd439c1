// Draws paths of light and lamps over the picture.

import { toScreen } from '../viewer/geometry.js';
import { coneInPicture, inPicture, lineInPicture } from './projection.js';

// On any picture; a dark edge sets them off from a bright one.
const COLORS = { chosen: '#ffd166', other: '#9fc4ff', refused: '#ff5c49', lamp: '#ffffff', edge: 'rgb(0 0 0 / 75%)' };
const LAMP_SIDE = 5;

// `paths` with `chosen`, the index of one, and `refused`, where the coordinator refused one, or null; `lights` that can be clicked.
export function drawPaths({ context, screen, ratio, view }, { layout, size, paths, chosen, refused }) {
  const matrix = layout?.world_to_ndc;
  if (!matrix) return;
  const scene = { context, ratio, matrix, size, place: at => toScreen(view, screen, at) };
  context.save();
  context.lineJoin = 'round';
  for (const light of layout.lights) drawLamp(scene, light);
  paths.forEach((path, index) => drawPath(scene, path, index === chosen ? 'chosen' : 'other', refused?.path === index ? refused.point : null));
  context.restore();
}

function drawLamp(scene, light) {
  const at = inPicture(scene.matrix, scene.size, light.points[0]);
  if (!at) return;
  const { x, y } = scene.place(at);
  const side = LAMP_SIDE * scene.ratio;
  const corners = [
    { x, y: y - side },
    { x: x + side, y },
    { x, y: y + side },
    { x: x - side, y },
  ];
  outline(scene, corners, COLORS.lamp, 1, true);
}

function drawPath(scene, { points, cones }, kind, refusedPoint) {
  points.slice(1).forEach(({ at }, segment) => {
    const color = refusedPoint === segment + 1 ? COLORS.refused : COLORS[kind];
    const line = lineInPicture(scene.matrix, scene.size, points[segment].at, at);
    if (line) outline(scene, line.map(scene.place), color, 2.5, false);
    const cone = coneInPicture(scene.matrix, scene.size, points[segment].at, at, cones[segment]);
    if (cone.length) outline(scene, cone.map(scene.place), color, 1, true);
  });
  points.forEach(({ at }, index) => {
    const seen = inPicture(scene.matrix, scene.size, at);
    if (seen) drawPoint(scene, scene.place(seen), String(index + 1), refusedPoint === index ? COLORS.refused : COLORS[kind]);
  });
}

function drawPoint({ context, ratio }, { x, y }, text, color) {
  context.beginPath();
  context.arc(x, y, 8 * ratio, 0, 2 * Math.PI);
  context.fillStyle = color;
  context.fill();
  context.lineWidth = ratio;
  context.strokeStyle = COLORS.edge;
  context.stroke();
  context.fillStyle = '#000000';
  context.font = `${11 * ratio}px system-ui, sans-serif`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.fillText(text, x, y);
}

function outline({ context, ratio }, places, color, width, isClosed) {
  context.beginPath();
  places.forEach(({ x, y }, index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (isClosed) context.closePath();
  for (const [style, thickness] of [
    [COLORS.edge, width + 2],
    [color, width],
  ]) {
    context.strokeStyle = style;
    context.lineWidth = thickness * ratio;
    context.stroke();
  }
}
