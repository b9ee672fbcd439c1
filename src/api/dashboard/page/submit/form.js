// The form for a job of a scene that is uploaded. The coordinator checks it before anything is traced.

import { ask, post } from '../connection/api.js';
import { element, field, make, setHidden } from '../elements/dom.js';
import { factsTable, noticeList } from '../elements/lists.js';
import { count } from '../elements/numbers.js';
import { problemNote } from '../elements/problem_note.js';
import { methodFields } from './method_fields.js';
import { readSequence, sequenceFields } from './sequence_fields.js';
import { readStop, stopFields } from './stop_fields.js';
import { readTags } from './tags.js';

const form = element('submit-form');

export const hideForm = () => setHidden(form, true);

// `done` is called with the job or the sequence once it is submitted.
export async function showForm(scene, fileName, done) {
  const method = await methodFields('', { ofScene: `as the scene says (${scene.integrator ?? 'sppm'})` });
  const [stop, sequence] = [stopFields(), sequenceFields()];
  const answer = make('div', { id: 'check-answer', 'aria-live': 'polite' });
  const check = make('button', { type: 'button', id: 'check' }, 'Check');
  const submit = make('button', { className: 'primary', id: 'submit' }, 'Submit');
  const buttons = make('p', { className: 'buttons' }, check, submit);
  form.replaceChildren(labelFields(fileName), method.fields, stop, sceneFields(scene), sequence, ...lightGroupsField(scene), answer, buttons);
  const request = () => readForm(scene, method, stop);
  check.onclick = () =>
    form.reportValidity() &&
    run(answer, check, async () => {
      const frames = readSequence(sequence, request())?.frames;
      return checked(await post('/v1/jobs/validate', request()), frames);
    });
  form.onsubmit = event => {
    event.preventDefault();
    run(answer, submit, async () => {
      const job = request();
      done(await send(readSequence(sequence, job) ?? job));
      hideForm();
      return [];
    });
  };
  form.oninput = forgetKey;
  forgetKey();
  setHidden(form, false);
  form.elements.name.focus();
}

const number = (name, byDefault, further = {}) => make('input', { name, type: 'number', min: 1, step: 1, placeholder: byDefault, ...further });
const text = (name, value = '') => make('input', { name, type: 'text', value, autocomplete: 'off' });

function labelFields(fileName) {
  const [name] = fileName.split('/').pop().split('.');
  return make(
    'div',
    { className: 'columns' },
    field('Name', text('name', name)),
    field('Tags', text('tags'), 'Words to find it by, separated by commas.'),
    field('Priority', number('priority', 100, { max: 1000 }), '200 gets twice the work done that 100 gets.'),
  );
}

function sceneFields(scene) {
  const fields = [
    field('Width', number('width', scene.width), 'One alone keeps the proportions.'),
    field('Height', number('height', scene.height)),
    field('Camera', text('camera'), 'Its name, or its index from 0.'),
    field('Seed', number('seed', 0, { min: 0 })),
  ];
  return make('fieldset', {}, make('legend', {}, 'What is changed of the scene'), make('div', { className: 'columns' }, fields));
}

// Where lights of the scene name groups, a job may keep them apart.
function lightGroupsField({ light_groups: groups }) {
  if (!groups?.length) return [];
  const box = make('input', { name: 'light_groups', type: 'checkbox' });
  const cost = `${groups.join(', ')}: each becomes a layer, and a pass costs as much as ${count(groups.length, 'pass')}.`;
  return [make('p', { className: 'field' }, make('label', {}, box, ' Keep light groups apart'), make('small', {}, cost))];
}

// The job as the fields say; what is empty is left out.
function readForm(scene, method, stop) {
  const value = name => form.elements[name].value.trim() || undefined;
  const numberOf = name => (value(name) === undefined ? undefined : Number(value(name)));
  const changes = { width: numberOf('width'), height: numberOf('height'), camera: value('camera') };
  const isChanged = Object.values(changes).some(change => change !== undefined);
  // JSON leaves out what is undefined.
  return {
    scene: scene.hash,
    ...method.read(),
    stop: readStop(stop),
    name: value('name'),
    tags: readTags(value('tags') ?? ''),
    priority: numberOf('priority'),
    seed: numberOf('seed'),
    light_groups: form.elements.light_groups?.checked || undefined,
    scene_changes: isChanged ? changes : undefined,
  };
}

const forgetKey = () => delete form.dataset.key;

// The same key again makes no second job or sequence, should the answer get lost.
function send(request) {
  form.dataset.key ??= `page-${Date.now()}-${Math.random().toString(36).slice(2)}`;
  const address = request.frames ? '/v1/sequences' : '/v1/jobs';
  return ask(address, { method: 'POST', body: request, headers: { 'Idempotency-Key': form.dataset.key } });
}

// What would become of the job, and of which frames.
function checked({ method, parameters, stop, width, height, notices }, frames) {
  const list = values =>
    Object.entries(values)
      .map(([name, value]) => `${name.replaceAll('_', ' ')} ${value}`)
      .join(', ');
  const rows = [
    ['method', method],
    ...(frames ? [['frames', `${frames.first} to ${frames.last}; what each shows is checked when it is submitted`]] : []),
    ['size', `${width} × ${height}`],
    ['stop', list(stop) || "at the method's passes"],
    ['parameters', list(parameters)],
  ];
  return [make('p', { className: 'good' }, 'The job can be rendered.'), factsTable(rows), noticeList(notices)];
}

// Shows what `act` answers, or why it failed.
async function run(answer, button, act) {
  button.disabled = true;
  try {
    answer.replaceChildren(...(await act()));
  } catch (problem) {
    answer.replaceChildren(problemNote(problem));
  }
  button.disabled = false;
}
