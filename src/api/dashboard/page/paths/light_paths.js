// Paths of light as people make them: from a lamp to surfaces. Pure functions; none changes what it is given.
//
// A path has `points`, each with its place `at`, m, and of the first the `light` that it was chosen from, if any; and `cones`, the half angle around
// each segment, °.

import { distance } from './projection.js';

// As the coordinator takes it where nothing is said.
export const USUAL_CONE = 5;

export const startedAt = light => ({ points: [{ at: light.points[0], light }], cones: [] });

export const startedAtPlace = at => ({ points: [{ at }], cones: [] });

// A path with a further point at its end. A lamp that has several places shines from the one that is nearest.
export const extended = ({ points, cones }, at) => aimed({ points: [...points, { at }], cones: [...cones, cones.at(-1) ?? USUAL_CONE] });

export function movedPoint({ points, cones }, index, at) {
  return aimed({ points: points.map((point, other) => (other === index ? { at } : point)), cones });
}

// A path without a point, or `null` when none is left. The segments on both sides of it become one.
export function withoutPoint({ points, cones }, index) {
  if (points.length === 1) return null;
  const merged = Math.max(index - 1, 0);
  const kept = points.filter((_, other) => other !== index);
  return aimed({ points: kept, cones: cones.filter((_, segment) => segment !== merged) });
}

export const withCone = ({ points, cones }, segment, degrees) => ({
  points,
  cones: cones.map((cone, other) => (other === segment ? degrees : cone)),
});

function aimed(path) {
  const [{ light }, next] = path.points;
  if (!light || !next) return path;
  const nearest = light.points.reduce((best, at) => (distance(at, next.at) < distance(best, next.at) ? at : best));
  return { ...path, points: [{ at: nearest, light }, ...path.points.slice(1)] };
}

// What the parameter `user_paths` takes, and back.
export const asParameter = paths => paths.map(({ points, cones }) => ({ points: points.map(({ at }) => at), cones }));

export const fromParameter = list =>
  list.map(({ points, cones = [] }) => ({
    points: points.map(at => ({ at })),
    cones: points.slice(1).map((_, segment) => cones[segment] ?? cones[0] ?? USUAL_CONE),
  }));

// Which path the coordinator refuses, counted from 0, at which point of it, and why; `null` where a problem is about something else.
export function refusal(message, paths) {
  const found = message.match(/path (\d+) of user_paths: (.*)$/s);
  if (!found) return null;
  const path = Number(found[1]) - 1;
  const segment = found[2].match(/^segment (\d+)/);
  const point = segment ? Number(segment[1]) : found[2].startsWith('it starts') ? 0 : (paths[path]?.points.length ?? 1) - 1;
  return { path, point, why: found[2] };
}

// Three numbers, in any usual way to separate them; `null` where that is something else.
export function readPlace(text) {
  const numbers = text
    .trim()
    .split(/[\s,;]+/)
    .map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) ? numbers : null;
}

export const writtenPlace = at => at.map(value => String(Number(value.toPrecision(4)))).join(', ');
