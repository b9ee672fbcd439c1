// Submitting: a scene is dropped and uploaded, a form says how it is to be rendered, and the coordinator checks it before anything is traced.

import { ask, post } from '../connection/api.js';
import { element, field, make, setHidden, setText } from '../elements/dom.js';
import { problemNote } from '../elements/problem_note.js';
import { count } from '../elements/numbers.js';
import { maySubmit } from '../store.js';
import { methodFields } from './method_fields.js';
import { FORMATS, chosenFiles, droppedFiles, packed, sceneCandidates } from './scene_files.js';
import { readStop, stopFields } from './stop_fields.js';
import { readTags } from './tags.js';
import { upload } from './upload.js';

const form = element('submit-form');
let open = () => {};

// `openJob` is called with the id of a new job.
export function startSubmit(openJob) {
  open = openJob;
  setText(element('formats'), FORMATS.filter(format => format !== 'zip').map(format => `.${format}`).join(', '));
  element('scene-file').accept = FORMATS.map(format => `.${format}`).join();
  element('scene-file').onchange = event => take(chosenFiles(event.target.files));
  element('scene-folder').onchange = event => take(chosenFiles(event.target.files));
  const drop = element('drop');
  // A file that misses the field must not replace the page.
  addEventListener('dragover', event => event.preventDefault());
  addEventListener('drop', event => event.preventDefault());
  drop.addEventListener('dragover', () => drop.classList.add('over'));
  drop.addEventListener('dragleave', () => drop.classList.remove('over'));
  drop.addEventListener('drop', async event => {
    drop.classList.remove('over');
    take(await droppedFiles(event.dataTransfer));
  });
}

async function take(files) {
  setHidden(form, true);
  if (!maySubmit()) return tell(problemNote({ message: 'You may not submit jobs here.', remedy: 'Log in with a token that has the scope "submit", or wait until the coordinator answers.' }));
  const candidates = sceneCandidates(files);
  if (files.length > 1 && candidates.length === 0) {
    return tell(problemNote({ message: `There is no scene file among the ${count(files.length, 'file')}.`, remedy: `Add one of these: ${FORMATS.join(', ')}.` }));
  }
  if (files.length > 1 && candidates.length > 1) return askWhich(files, candidates);
  if (files.length) send(files, candidates[0]);
}

function askWhich(files, candidates) {
  const select = make('select', {}, candidates.map(name => make('option', { value: name }, name)));
  tell(field('Which file is the scene?', select), make('p', { className: 'buttons' }, make('button', { type: 'button', onclick: () => send(files, select.value) }, 'Upload')));
}

const tell = (...notes) => element('upload').replaceChildren(...notes);

async function send(files, scene) {
  const bar = make('progress', { max: 1, value: 0, 'aria-label': 'Upload' });
  const text = make('p', {}, 'The files are packed …');
  tell(text, bar);
  try {
    const blob = await packed(files, scene, (index, name) => { setText(text, `${name} is packed …`); bar.value = index / files.length; });
    setText(text, `${(blob.size / 1e6).toFixed(1)} MB are uploaded …`);
    const known = await upload(blob, share => {
      bar.value = share;
      if (share === 1) setText(text, 'The coordinator checks the scene …');
    });
    const name = scene ?? files[0].file.name;
    tell(make('p', {}, `${name}: ${known.width} × ${known.height} pixels, ${count(files.length, 'file')}.`), ...noticeList(known.notices));
    await showForm(known, name);
  } catch (problem) {
    const alone = files.length === 1 && !files[0].name.endsWith('.zip');
    const hint = alone ? make('p', { className: 'quiet' }, 'A scene that refers to other files is uploaded with them: choose its folder, or a zip archive.') : null;
    tell(...[problemNote(problem), hint].filter(Boolean));
  }
}

const noticeList = notices => (notices.length ? [make('ul', { className: 'notices' }, notices.map(text => make('li', {}, text)))] : []);

async function showForm(scene, fileName) {
  const number = (name, value, attributes = {}) => make('input', { name, type: 'number', min: 1, step: 1, placeholder: value, ...attributes });
  const text = (name, value = '') => make('input', { name, type: 'text', value, autocomplete: 'off' });
  const method = await methodFields('', { ofScene: `as the scene says (${scene.integrator ?? 'sppm'})` });
  const stop = stopFields();
  const answer = make('div', { id: 'check-answer', 'aria-live': 'polite' });
  const check = make('button', { type: 'button', id: 'check' }, 'Check');
  form.replaceChildren(
    make('div', { className: 'columns' }, field('Name', text('name', fileName.replace(/\.\w+$/, '').split('/').pop())),
      field('Tags', text('tags'), 'Words to find it by, separated by commas.'), field('Priority', number('priority', 100, { max: 1000 }))),
    method.fields, stop,
    make('fieldset', {}, make('legend', {}, 'What is changed of the scene'), make('div', { className: 'columns' },
      field('Width', number('width', scene.width), 'One alone keeps the proportions.'), field('Height', number('height', scene.height)),
      field('Camera', text('camera'), 'Its name, or its index from 0.'), field('Seed', number('seed', 0, { min: 0 })))),
    answer, make('p', { className: 'buttons' }, check, make('button', { className: 'primary', id: 'submit' }, 'Submit')));
  const request = () => readForm(scene, method, stop);
  check.onclick = () => form.reportValidity() && run(answer, check, async () => checked(await post('/v1/jobs/validate', request())));
  form.onsubmit = event => {
    event.preventDefault();
    // The same key again makes no second job, should the answer get lost.
    form.dataset.key ??= `page-${Date.now()}-${Math.random().toString(36).slice(2)}`;
    run(answer, element('submit'), async () => {
      const job = await ask('/v1/jobs', { method: 'POST', body: request(), headers: { 'Idempotency-Key': form.dataset.key } });
      setHidden(form, true);
      tell();
      open(job.id);
    });
  };
  form.oninput = () => { delete form.dataset.key; };
  delete form.dataset.key;
  setHidden(form, false);
  form.elements.name.focus();
}

function readForm(scene, method, stop) {
  const value = name => form.elements[name].value.trim();
  const number = name => (value(name) === '' ? undefined : Number(value(name)));
  const changes = Object.fromEntries([['width', number('width')], ['height', number('height')], ['camera', value('camera') || undefined]].filter(([, wanted]) => wanted !== undefined));
  return {
    scene: scene.hash, ...method.read(), stop: readStop(stop), tags: readTags(value('tags')),
    ...(value('name') && { name: value('name') }), ...(number('priority') && { priority: number('priority') }), ...(number('seed') !== undefined && { seed: number('seed') }),
    ...(Object.keys(changes).length && { scene_changes: changes }),
  };
}

// What would become of the job.
function checked({ method, parameters, stop, width, height, notices }) {
  const rules = Object.entries(stop).map(([name, value]) => `${name.replaceAll('_', ' ')} ${value}`).join(', ');
  const set = Object.entries(parameters).map(([name, value]) => `${name} ${value}`).join(', ');
  const rows = [['method', method], ['size', `${width} × ${height}`], ['stop', rules || "at the method's passes"], ['parameters', set]];
  const table = make('table', { className: 'facts' }, make('tbody', {}, rows.map(([name, value]) => make('tr', {}, make('th', { scope: 'row' }, name), make('td', {}, value)))));
  return [make('p', { className: 'good' }, 'The job can be rendered.'), table, ...noticeList(notices)];
}

async function run(answer, button, act) {
  button.disabled = true;
  try {
    answer.replaceChildren(...(await act() ?? []));
  } catch (problem) {
    answer.replaceChildren(problemNote(problem));
  }
  button.disabled = false;
}
