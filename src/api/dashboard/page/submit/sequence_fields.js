// Fields for a sequence: which frames, the camera's path, how many frames at once. Empty, one picture is wanted.

import { Problem } from '../connection/api.js';
import { field, make } from '../elements/dom.js';

export function sequenceFields() {
  const input = (name, attributes) => make('input', { name, autocomplete: 'off', ...attributes });
  const frames = input('frames', { type: 'text', placeholder: 'one picture', pattern: '\\s*\\d+\\s*-\\s*\\d+\\s*', title: 'First and last frame, as 1-48' });
  return make(
    'fieldset',
    {},
    make('legend', {}, 'A sequence'),
    make(
      'div',
      { className: 'columns' },
      field('Frames', frames, 'For example 1-48. Motion starts at the first frame and ends at the last.'),
      field('Camera path', input('camera_path', { type: 'text' }), 'Names or indices of cameras, separated by commas.'),
      field('Frames at once', input('at_once', { type: 'number', min: 1, max: 100, step: 1, placeholder: 2 })),
    ),
  );
}

// The sequence around a job, if frames are given; what is empty is left out.
export function readSequence(fields, job) {
  const value = name => fields.querySelector(`[name=${name}]`).value.trim();
  const path = value('camera_path').split(',').map(camera => camera.trim()).filter(Boolean);
  if (!value('frames')) {
    if (!path.length && !value('at_once')) return null;
    throw new Problem({ detail: 'a camera path and frames at once are of a sequence, and no frames are given', remedy: 'give frames, as 1-48' });
  }
  const [first, last] = value('frames').split('-').map(Number);
  if (first > last) throw new Problem({ detail: `the last frame, ${last}, is before the first one, ${first}`, remedy: 'give the first one first' });
  return {
    job,
    frames: { first, last, camera_path: path },
    at_once: value('at_once') ? Number(value('at_once')) : undefined,
  };
}
