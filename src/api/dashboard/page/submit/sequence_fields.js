// Fields for a sequence: which frames, the camera's path, how many frames at once. Empty, one picture is wanted.

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
      field('Frames', frames, 'First and last, as 1-48: what moves in the scene does so from the first to the last.'),
      field('Camera path', input('camera_path', { type: 'text' }), 'Names or indices of cameras, separated by commas.'),
      field('Frames at once', input('at_once', { type: 'number', min: 1, max: 100, step: 1, placeholder: 2 })),
    ),
  );
}

// The sequence around a job, if frames are given; what is empty is left out.
export function readSequence(fields, job) {
  const value = name => fields.querySelector(`[name=${name}]`).value.trim();
  if (!value('frames')) return null;
  const [first, last] = value('frames').split('-').map(Number);
  const path = value('camera_path').split(',').map(camera => camera.trim()).filter(Boolean);
  return {
    job,
    frames: { first, last, camera_path: path },
    at_once: value('at_once') ? Number(value('at_once')) : undefined,
  };
}
