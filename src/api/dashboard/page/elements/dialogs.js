// Questions to the user, in <dialog> elements: they hold the focus, close with Escape and give the focus back.

import { make } from './dom.js';
import { problemNote } from './problem_note.js';

// Asks for a confirmation before `act` is done. What `act` fails with is told in the dialog, which stays open.
export const confirm = (title, text, action, act) => openForm(title, [make('p', {}, text)], action, act, 'danger');

// Shows a form of `contents`; `act` is done when it is sent.
export function openForm(title, contents, action, act, kind = 'primary') {
  const problem = make('div');
  const send = make('button', { type: 'submit', className: kind }, action);
  const cancel = make('button', { type: 'button', onclick: () => dialog.close() }, 'Back');
  const form = make(
    'form',
    { method: 'dialog' },
    make('h2', { id: 'dialog-title' }, title),
    contents,
    problem,
    make('p', { className: 'buttons' }, cancel, send),
  );
  const dialog = make('dialog', { 'aria-labelledby': 'dialog-title' }, form);
  form.onsubmit = async event => {
    event.preventDefault();
    send.disabled = true;
    try {
      await act();
      dialog.close();
    } catch (error) {
      problem.replaceChildren(problemNote(error));
    }
    send.disabled = false;
  };
  show(dialog);
  return dialog;
}

// Shows something to read.
export function openNote(title, contents) {
  const close = make('button', { type: 'submit', className: 'primary' }, 'Close');
  const form = make('form', { method: 'dialog' }, make('h2', { id: 'dialog-title' }, title), contents, make('p', { className: 'buttons' }, close));
  show(make('dialog', { className: 'wide', 'aria-labelledby': 'dialog-title' }, form));
}

function show(dialog) {
  dialog.onclose = () => dialog.remove();
  document.body.append(dialog);
  dialog.showModal();
}
