// Fields for a stop rule: passes, seconds, error, whichever comes first.

import { field, make } from '../elements/dom.js';

export function stopFields(stop = {}) {
  const number = (name, value, attributes) => make('input', { name, type: 'number', value: value ?? '', ...attributes });
  const missing = make('input', { type: 'checkbox', name: 'accepts_missing_light', checked: stop.accepts_missing_light ?? false });
  return make(
    'fieldset',
    { className: 'stop' },
    make('legend', {}, 'Stop at whichever comes first'),
    make(
      'div',
      { className: 'columns' },
      field('Passes', number('passes', stop.passes, { min: 1, step: 1 })),
      field('Seconds', number('seconds', stop.seconds, { min: 0, step: 'any' })),
      field('Error (relMSE)', number('error', stop.error, { min: 0, step: 'any' }), 'For example 0.01.'),
    ),
    make('p', {}, make('label', {}, missing, ' The error may end the job although the method misses some of the light')),
  );
}

// What the fields say; empty ones say nothing.
export function readStop(fields) {
  const stop = {};
  for (const name of ['passes', 'seconds', 'error']) {
    const { valueAsNumber } = fields.querySelector(`[name=${name}]`);
    if (!Number.isNaN(valueAsNumber)) stop[name] = valueAsNumber;
  }
  if (fields.querySelector('[name=accepts_missing_light]').checked) stop.accepts_missing_light = true;
  return stop;
}
