// Submitting: a scene is dropped or chosen and uploaded, and then a form says how it is to be rendered.

import { element, field, make, setText } from '../elements/dom.js';
import { noticeList } from '../elements/lists.js';
import { count } from '../elements/numbers.js';
import { problemNote } from '../elements/problem_note.js';
import { maySubmit } from '../store.js';
import { hideForm, showForm } from './form.js';
import { FORMATS, chosenFiles, droppedFiles, packed, sceneCandidates } from './scene_files.js';
import { upload } from './upload.js';

let open = () => {};

// `openMade` is called with a new job or sequence.
export function startSubmit(openMade) {
  open = openMade;
  const endings = FORMATS.map(format => `.${format}`);
  setText(element('formats'), endings.filter(ending => ending !== '.zip').join(', '));
  element('scene-file').accept = endings.join();
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

const tell = (...notes) => element('upload').replaceChildren(...notes);

const refuse = (message, remedy) => tell(problemNote({ message, remedy }));

function take(files) {
  hideForm();
  if (!files.length) return refuse('No file came.', 'Choose a file, or drop one here.');
  if (!maySubmit()) return refuse('You may not submit jobs here now.', 'Log in with a token of the scope "submit", or wait for the coordinator.');
  const candidates = sceneCandidates(files);
  if (files.length > 1 && !candidates.length) {
    return refuse(`There is no scene file among the ${count(files.length, 'file')}.`, `Add one of these: ${FORMATS.join(', ')}.`);
  }
  if (files.length > 1 && candidates.length > 1) return askWhich(files, candidates);
  return send(files, candidates[0]);
}

function askWhich(files, candidates) {
  const options = candidates.map(name => make('option', { value: name }, name));
  const select = make('select', {}, options);
  const button = make('button', { type: 'button', onclick: () => send(files, select.value) }, 'Upload');
  tell(field('Which file is the scene?', select), make('p', { className: 'buttons' }, button));
}

async function send(files, scene) {
  const name = scene ?? files[0].file.name;
  try {
    const known = await uploaded(files, scene);
    const told = `${name}: ${known.width} × ${known.height} pixels, ${count(files.length, 'file')}.`;
    tell(make('p', {}, told), noticeList(known.notices));
    await showForm(known, name, made => {
      tell();
      open(made);
    });
  } catch (problem) {
    const isAlone = files.length === 1 && !name.endsWith('.zip');
    const hint = 'A scene that refers to other files is uploaded with them: choose its folder, or a zip archive.';
    tell(problemNote(problem), make('p', { className: 'quiet', hidden: !isAlone }, hint));
  }
}

// Packs and uploads the files, tells how far that is, and answers what the coordinator knows of the scene.
async function uploaded(files, scene) {
  const bar = make('progress', { max: 1, value: 0, 'aria-label': 'Upload' });
  const text = make('p', {}, 'The files are packed …');
  tell(text, bar);
  const blob = await packed(files, scene, (index, name) => {
    setText(text, `${name} is packed …`);
    bar.value = index / files.length;
  });
  setText(text, `${(blob.size / 1e6).toFixed(1)} MB are uploaded …`);
  return upload(blob, share => {
    bar.value = share;
    if (share === 1) setText(text, 'The coordinator checks the scene …');
  });
}
