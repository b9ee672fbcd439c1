// Pointers on the picture: drag to move, wheel and two fingers to zoom, clicks, and the line between two pictures that are compared.

const WHEEL_SPEED = 0.0016;
// How near to the line a pointer takes hold of it, CSS pixels.
const LINE_REACH = 12;
// A pointer that went no farther while it was down did not drag, CSS pixels.
const STILL = 4;

// `actions` has: `move(distance)`, `zoom(at, factor)`, `point(at or null)`, `click(at)`, `split(share)`, and `lineAt()`, which answers the line's x
// or null; `isSelecting()`, and while it is so, `select(from, to, isDone)`. All in CSS pixels of the canvas.
export function followPointer(canvas, actions) {
  const pointers = new Map();
  let holdsLine = false;
  // Where a pointer went down that may become a click.
  let pressed = null;
  // Where a pointer went down that drags a rectangle.
  let corner = null;
  const place = event => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  canvas.addEventListener(
    'wheel',
    event => {
      event.preventDefault();
      // Lines are told by a mouse wheel in some browsers.
      const distance = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : 1) * (event.ctrlKey ? 6 : 1);
      actions.zoom(place(event), Math.exp(-distance * WHEEL_SPEED));
    },
    { passive: false },
  );
  canvas.addEventListener('pointerdown', event => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    pressed = pointers.size === 1 && event.button === 0 ? place(event) : null;
    corner = pressed && actions.isSelecting() ? pressed : null;
    const line = actions.lineAt();
    holdsLine = !corner && pointers.size === 1 && line !== null && Math.abs(place(event).x - line) < LINE_REACH;
  });
  canvas.addEventListener('pointermove', event => {
    const at = place(event);
    actions.point(at);
    const before = pointers.get(event.pointerId);
    if (!before) return;
    if (pressed && Math.hypot(at.x - pressed.x, at.y - pressed.y) > STILL) pressed = null;
    if (corner) actions.select(corner, at, false);
    else if (holdsLine) actions.split(at.x / canvas.clientWidth);
    else if (pointers.size === 1) actions.move({ x: at.x - before.x, y: at.y - before.y });
    else pinch(pointers, event.pointerId, at, actions);
    pointers.set(event.pointerId, at);
  });
  const release = event => pointers.delete(event.pointerId);
  canvas.addEventListener('pointerup', event => {
    release(event);
    // Who did not drag has selected nothing.
    if (corner && !pressed) actions.select(corner, place(event), true);
    if (pressed && !corner && !holdsLine) actions.click(pressed);
    [pressed, corner] = [null, null];
  });
  canvas.addEventListener('pointercancel', event => {
    release(event);
    [pressed, corner] = [null, null];
  });
  canvas.addEventListener('pointerleave', () => actions.point(null));
}

// The point between two fingers stays under them.
function pinch(pointers, moving, at, actions) {
  const [still] = [...pointers].filter(([id]) => id !== moving).map(([, place]) => place);
  const before = pointers.get(moving);
  const distance = (one, other) => Math.max(Math.hypot(one.x - other.x, one.y - other.y), 1);
  const middle = { x: (still.x + at.x) / 2, y: (still.y + at.y) / 2 };
  actions.move({ x: (at.x - before.x) / 2, y: (at.y - before.y) / 2 });
  actions.zoom(middle, distance(still, at) / distance(still, before));
}
