// Renders a job with paths as hints, and the same without where there is none yet, so that both can be compared.

import { ask, post } from '../connection/api.js';
import { element, make, setHidden, setText } from '../elements/dom.js';
import { nameOf } from '../jobs/progress.js';
import { maySubmit, store } from '../store.js';
import { asParameter, refusal } from './light_paths.js';

// The jobs that were submitted last: `withPaths` and `without`, by their ids.
let made = null;
let paths = null;
let actions = {};

// `given.refuse(problem, refusal)` tells why the coordinator refused the paths; `given.compare(id, other)` shows two jobs beside each other.
export function startRender(state, given) {
  [paths, actions] = [state, given];
  element('paths-check').onclick = () => attempt(check, 'All paths can be taken.');
  element('paths-render').onclick = () => attempt(render, '');
  element('paths-compare').onclick = () => actions.compare(made.withPaths, made.without);
  element('paths-method').onchange = () => showRender(state);
}

export function showRender({ job, paths: list }) {
  listMethods(job);
  const isReady = list.length > 0 && list.every(({ points }) => points.length > 1);
  element('paths-render').disabled = !isReady || !maySubmit();
  element('paths-check').disabled = !isReady || !maySubmit();
  setText(element('paths-twin'), twinOf(job) ? '' : 'The same job without paths is rendered, too, to be compared with.');
  showMade();
}

// What came of it; with the pictures of both they can be compared.
function showMade() {
  const jobs = made && [made.withPaths, made.without].map(id => store.jobs.get(id));
  setHidden(element('paths-made'), !made);
  if (!made) return;
  const state = job => (job ? `${nameOf(job)}: ${job.state}, ${job.passes_done} passes` : 'deleted');
  setText(element('paths-made-text'), `With the paths: ${state(jobs[0])}. Without: ${state(jobs[1])}.`);
  element('paths-compare').disabled = !jobs.every(job => job?.passes_done > 0);
}

let methods = null;

// The methods that take paths, of which the job's own is chosen first.
async function listMethods(job) {
  if (methods) return;
  methods = ask('/v1/methods').catch(() => null);
  const answer = await methods;
  if (!answer) {
    methods = null;
    return;
  }
  const takers = answer.methods.filter(({ parameters }) => parameters.some(({ name }) => name === 'user_paths')).map(({ name }) => name);
  element('paths-method').replaceChildren(...takers.map(name => make('option', { value: name }, name)));
  if (takers.includes(job.method)) element('paths-method').value = job.method;
}

const method = () => element('paths-method').value;

// The job itself where it is one by the same method without paths.
const twinOf = job => (job.method === method() && !job.parameters.user_paths?.length ? job.id : null);

async function attempt(act, done) {
  setText(element('paths-note'), '');
  try {
    actions.refuse(null, null);
    await act(paths.job, asParameter(paths.paths));
    setText(element('paths-note'), done);
  } catch (problem) {
    actions.refuse(problem, refusal(problem.message, paths.paths));
  }
}

// The job's other parameters, where they are those of this method.
const parameters = (job, list) => ({ ...(job.method === method() ? job.parameters : {}), user_paths: list });

const check = ({ scene, stop, ...job }, list) => post('/v1/jobs/validate', { scene, method: method(), parameters: parameters(job, list), stop });

async function render(job, list) {
  const clone = (name, user_paths) =>
    post(`/v1/jobs/${job.id}/clone`, { method: method(), parameters: { user_paths }, name: `${nameOf(job)}, ${name}`.slice(0, 150) });
  const withPaths = await clone(`${method()} with ${list.length === 1 ? '1 path' : `${list.length} paths`}`, list);
  const without = twinOf(job) ?? (await clone(`${method()} without paths`, [])).id;
  made = { withPaths: withPaths.id, without };
}
