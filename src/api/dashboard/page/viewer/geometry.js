// Where a picture lies on the screen. Pure functions.
//
// A view is the point of the picture in the middle of the screen, `center`, in the picture's pixels, and `zoom`, pixels of the screen for each of
// them. Screens are measured in device pixels, so a zoom of 1 shows every pixel as it is.

export const MOST_ZOOM = 256;
const LEAST_ZOOM = 1 / 64;

export const TILE = 256;

export function fitted(size, screen) {
  const zoom = Math.min(screen.width / size.width, screen.height / size.height);
  return { center: { x: size.width / 2, y: size.height / 2 }, zoom: Math.min(zoom, MOST_ZOOM) };
}

export const unscaled = view => ({ ...view, zoom: 1 });

export const toPicture = (view, screen, { x, y }) => ({
  x: view.center.x + (x - screen.width / 2) / view.zoom,
  y: view.center.y + (y - screen.height / 2) / view.zoom,
});

export const toScreen = (view, screen, { x, y }) => ({
  x: (x - view.center.x) * view.zoom + screen.width / 2,
  y: (y - view.center.y) * view.zoom + screen.height / 2,
});

// Zooms by a factor while the point under `at` stays where it is.
export function zoomedAt(view, screen, at, factor) {
  const zoom = Math.min(Math.max(view.zoom * factor, LEAST_ZOOM), MOST_ZOOM);
  const fixed = toPicture(view, screen, at);
  const center = {
    x: fixed.x - (at.x - screen.width / 2) / zoom,
    y: fixed.y - (at.y - screen.height / 2) / zoom,
  };
  return { center, zoom };
}

// Moves the picture by a distance on the screen. Its middle never leaves the picture, so it is not lost.
export function moved(view, size, { x, y }) {
  const within = (value, end) => Math.min(Math.max(value, 0), end);
  return { ...view, center: { x: within(view.center.x - x / view.zoom, size.width), y: within(view.center.y - y / view.zoom, size.height) } };
}

export const coarsestLevel = size => Math.ceil(Math.log2(Math.max(size.width, size.height)));

// The level whose pixels are nearest to those of the screen: not larger for a still picture, and where that saves much, a little larger for one that
// changes all the time.
export function levelFor(view, size, isChanging) {
  const exact = Math.log2(1 / view.zoom);
  return Math.min(Math.max(isChanging ? Math.round(exact) : Math.floor(exact), 0), coarsestLevel(size));
}

export const atLevel = (size, level) => ({ width: Math.ceil(size.width / 2 ** level), height: Math.ceil(size.height / 2 ** level) });

// The tiles of a level that are seen, those in the middle first.
export function tilesSeen(view, screen, size, level) {
  const side = TILE * 2 ** level;
  const [first, last] = [toPicture(view, screen, { x: 0, y: 0 }), toPicture(view, screen, { x: screen.width, y: screen.height })];
  const range = (from, to, end) => [Math.max(Math.floor(from / side), 0), Math.min(Math.ceil(to / side), Math.ceil(end / side))];
  const [left, right] = range(first.x, last.x, size.width);
  const [top, bottom] = range(first.y, last.y, size.height);
  const tiles = [];
  for (let y = top; y < bottom; y++) for (let x = left; x < right; x++) tiles.push({ level, x, y });
  const distance = ({ x, y }) => Math.hypot((x + 0.5) * side - view.center.x, (y + 0.5) * side - view.center.y);
  return tiles.sort((one, other) => distance(one) - distance(other));
}
