// Fields for a method and those of its parameters that are not to be as by default.

import { ask } from '../connection/api.js';
import { field, make, setText } from '../elements/dom.js';

const AUTO = { name: 'auto', summary: 'the method that short trials find to be the soonest; notices say why', cannot_sample: '', parameters: [] };

// Answers the element and a function that reads it. `scenes` names the choice of no method at all, where there is one.
export async function methodFields(chosen, { ofScene }) {
  const methods = [...(await ask('/v1/methods')).methods, AUTO];
  const option = ({ name }) => make('option', { value: name }, name);
  const select = make('select', { name: 'method' }, ofScene && make('option', { value: '' }, ofScene), methods.map(option));
  const summary = make('small');
  const rows = make('div', { className: 'parameters' });
  const add = make('button', { type: 'button' }, 'Set a parameter');
  const current = () => methods.find(({ name }) => name === select.value);
  const showMethod = () => {
    const method = current();
    setText(
      summary,
      method ? [`${method.summary}.`, method.cannot_sample && `Cannot sample: ${method.cannot_sample}.`].filter(Boolean).join(' ') : '',
    );
    rows.replaceChildren();
    add.hidden = !method?.parameters.length;
  };
  select.value = chosen ?? '';
  select.onchange = showMethod;
  add.onclick = () => {
    const row = parameterRow(current().parameters);
    rows.append(row);
    row.querySelector('select').focus();
  };
  showMethod();
  const fields = make('div', {}, field('Method', select), summary, rows, make('p', {}, add));
  return { fields, read: () => ({ ...(select.value && { method: select.value }), parameters: readRows(rows) }) };
}

function parameterRow(parameters) {
  const name = make(
    'select',
    { name: 'parameter', 'aria-label': 'Parameter' },
    parameters.map(parameter => make('option', { value: parameter.name }, parameter.name)),
  );
  const value = make('input', { name: 'value', 'aria-label': 'Value', required: true, autocomplete: 'off' });
  const help = make('small');
  const remove = make('button', { type: 'button', 'aria-label': 'Remove this parameter', onclick: () => row.remove() }, '×');
  const row = make('div', { className: 'parameter' }, name, value, remove, help);
  const show = () => {
    const { meaning, range, default: byDefault } = parameters.find(parameter => parameter.name === name.value);
    setText(help, `${meaning} (${range}), else ${byDefault}`);
  };
  name.onchange = show;
  show();
  return row;
}

function readRows(rows) {
  const parameters = {};
  for (const row of rows.children) parameters[row.querySelector('select').value] = readValue(row.querySelector('input').value);
  return parameters;
}

// Numbers and truth values as JSON has them, everything else as text.
export function readValue(text) {
  const trimmed = text.trim();
  if (trimmed === 'true' || trimmed === 'false') return trimmed === 'true';
  return trimmed !== '' && Number.isFinite(Number(trimmed)) ? Number(trimmed) : trimmed;
}
