// Two pictures of the same size: which one is compared, how both are shown, and how far they are from each other.

import { expect, send } from '../connection/api.js';
import { element, make, setHidden, setText } from '../elements/dom.js';
import { factsTable } from '../elements/lists.js';
import { problemNote } from '../elements/problem_note.js';
import { count, short } from '../elements/numbers.js';
import { nameOf } from '../jobs/progress.js';
import { layerNamed } from './layers.js';
import { mixVersion } from './light_groups.js';
import { errors } from './statistics.js';

// More are found by their names in the list of jobs, not in a menu.
const MOST_LISTED = 200;
const MODES = { slider: 'Line', flip: 'Flip', difference: 'Difference' };

let actions = {};
// Errors over every pixel, once they were asked for, and of which pictures.
let measured = null;
let found = null;
let shown = '';

// `compareWith(id)` and `change(comparison)` do what the controls ask for; `current()` answers the viewer.
export function startComparison(given) {
  actions = given;
  const mode = ([value, label]) =>
    make('label', {}, make('input', { type: 'radio', name: 'mode', value, onchange: () => actions.change({ mode: value }) }), label);
  element('comparison-modes').append(make('div', { className: 'segments' }, Object.entries(MODES).map(mode)));
  element('other').onchange = event => actions.compareWith(event.target.value || null);
  element('split').oninput = event => actions.change({ split: event.target.valueAsNumber });
  element('flip').onclick = () => actions.change({ showsOther: !actions.current().comparison.showsOther });
  element('measure').onclick = measure;
}

// Jobs that can be compared with this one: those of its scene first, then the newest.
export function listOthers(jobs, job, chosen) {
  const fits = other => other.id !== job.id && other.width === job.width && other.height === job.height && other.passes_done > 0;
  const others = [...jobs].filter(fits).sort((one, other) => (other.scene === job.scene) - (one.scene === job.scene) || (one.id < other.id ? 1 : -1));
  const options = others.slice(0, MOST_LISTED).map(other => [other.id, `${nameOf(other)} (${other.method}, ${other.passes_done} passes)`]);
  const select = element('other');
  const wanted = JSON.stringify(options);
  // A menu that is open must not change under the pointer.
  if (select.dataset.options !== wanted && document.activeElement !== select) {
    select.replaceChildren(
      make('option', { value: '' }, options.length ? 'nothing' : 'no other job fits'),
      ...options.map(([value, text]) => make('option', { value }, text)),
    );
    select.dataset.options = wanted;
  }
  if (select.value !== (chosen ?? '')) select.value = chosen ?? '';
}

export function showComparison({ sources, comparison, layer, job, other }) {
  setHidden(element('comparison'), sources.length < 2);
  if (sources.length < 2) return;
  element('comparison-modes').querySelector(`[value=${comparison.mode}]`).checked = true;
  setHidden(element('split-control'), comparison.mode !== 'slider');
  setHidden(element('flip-control'), comparison.mode !== 'flip');
  element('split').value = comparison.split;
  setText(element('flip'), `Shown: ${nameOf(comparison.showsOther ? other : job)}. Flip`);
  showErrors(sources, layer, [job, other]);
}

function showErrors(sources, layer, jobs) {
  const [one, other] = sources.map(source => source.overview);
  if (!one || !other) return;
  const key = [one.tag, other.tag, one.mix, other.mix].join();
  if (found?.key !== key) found = { key, ...errors(one.values, other.values, one.channels.length) };
  const isMeasured = measured?.mix === mixVersion() && measured.sources.every((source, index) => source === sources[index]);
  const { rmse, relmse } = isMeasured ? measured : found;
  const side = 2 ** one.level;
  setHidden(element('measure'), side === 1);
  setText(element('errors-note'), `The other job is the reference. ${isMeasured ? measured.of : pixelsOf(side)}`);
  const rows = [['RMSE', `${short(rmse)} ${layerNamed(layer).unit}`], ['relMSE', short(relmse)], ...noiseRows(jobs)];
  const text = JSON.stringify(rows);
  if (text === shown) return;
  shown = text;
  element('errors').replaceChildren(factsTable(rows, 'Error against the other job'));
}

// What each job's own passes tell of its noise, as relMSE.
const noiseRows = jobs =>
  jobs.map(job => {
    const error = job.estimated_error;
    return [`Noise of ${nameOf(job)}`, error ? `${short(error.noise)} after ${count(error.passes, 'pass')}` : 'not known yet'];
  });

const pixelsOf = side => (side > 1 ? `Of means over ${side} × ${side} pixels, which are less noisy than pixels.` : 'Of every pixel.');

// Fetches both pictures whole: what an overview tells is less than the error of pixels.
async function measure() {
  const { sources } = actions.current();
  element('measure').disabled = true;
  try {
    const whole = async source => {
      const answer = await expect(await send(`/v1/jobs/${source.id}/pixels?layer=${source.layer}`, { cache: 'no-store' }));
      const channels = answer.headers.get('photonfarm-channels').split(',');
      const passes = answer.headers.get('photonfarm-passes');
      return { ...source.shown({ values: new Float32Array(await answer.arrayBuffer()), channels }), passes };
    };
    const pictures = [await whole(sources[0]), await whole(sources[1])];
    const of = `Of every pixel, at passes ${pictures.map(picture => picture.passes).join(' and ')}.`;
    const found = errors(pictures[0].values, pictures[1].values, pictures[0].channels.length);
    measured = { sources: [...sources], of, mix: mixVersion(), ...found };
    actions.change({});
  } catch (problem) {
    element('errors-note').replaceChildren(problemNote(problem));
  }
  element('measure').disabled = false;
}
