// From the world to the picture. Pure functions.
//
// A camera's matrix goes by rows, for row vectors: (x, y, z, 1) is multiplied from the left, and divided by the fourth number of the product. What
// stands behind the camera has none above 0 there, so lines are cut before they are divided.

// How near to the camera a line is cut, as a share of the way to its other end.
const NEAREST = 1e-4;

const STEPS = 32;
// Cones that are wider reach past everything.
const WIDEST_CONE = 80;

// A point before the division.
const multiplied = (matrix, [x, y, z]) =>
  [0, 1, 3].map(column => x * matrix[column] + y * matrix[4 + column] + z * matrix[8 + column] + matrix[12 + column]);

const divided = ([x, y, w], { width, height }) => ({ x: (x / w) * width, y: (y / w) * height });

// Where a point of the world lies in a picture of that size, in pixels; `null` behind the camera.
export function inPicture(matrix, size, point) {
  const product = multiplied(matrix, point);
  return product[2] > 0 ? divided(product, size) : null;
}

// The part of a line that is before the camera, as two places in the picture; `null` where there is none.
export function lineInPicture(matrix, size, from, to) {
  const ends = [from, to].map(point => multiplied(matrix, point));
  const least = NEAREST * Math.max(ends[0][2], ends[1][2]);
  if (least <= 0) return null;
  const cut = (end, other) => {
    if (end[2] >= least) return end;
    const share = (least - end[2]) / (other[2] - end[2]);
    return end.map((value, index) => value + share * (other[index] - value));
  };
  return [divided(cut(ends[0], ends[1]), size), divided(cut(ends[1], ends[0]), size)];
}

// The circle in which a cone around a segment ends, as places in the picture; empty where it is too wide or partly behind the camera.
export function coneInPicture(matrix, size, from, to, degrees) {
  const axis = minus(to, from);
  const length = Math.hypot(...axis);
  if (degrees > WIDEST_CONE || !length) return [];
  const radius = length * Math.tan((degrees * Math.PI) / 180);
  const [one, other] = across(axis.map(value => value / length));
  const places = Array.from({ length: STEPS }, (_, step) => {
    const [cosine, sine] = [Math.cos((2 * Math.PI * step) / STEPS), Math.sin((2 * Math.PI * step) / STEPS)];
    return inPicture(
      matrix,
      size,
      to.map((value, index) => value + radius * (cosine * one[index] + sine * other[index])),
    );
  });
  return places.every(Boolean) ? places : [];
}

export const minus = (one, other) => one.map((value, index) => value - other[index]);

export const distance = (one, other) => Math.hypot(...minus(one, other));

const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

// Two unit vectors across a unit vector and each other.
function across(axis) {
  const start = Math.abs(axis[0]) < 0.5 ? [1, 0, 0] : [0, 1, 0];
  const one = cross(axis, start);
  const length = Math.hypot(...one);
  const unit = one.map(value => value / length);
  return [unit, cross(axis, unit)];
}
