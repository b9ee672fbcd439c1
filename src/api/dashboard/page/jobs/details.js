// All that the coordinator knows of a job, as a table.

import { element, make } from '../elements/dom.js';
import { date, duration, short } from '../elements/numbers.js';
import { acceptance, speed } from './progress.js';

let shown = '';

export function showDetails(job) {
  const rows = [...general(job), ...Object.entries(job.parameters).map(([name, value]) => [name, String(value), 'parameter'])];
  const text = JSON.stringify(rows);
  if (text === shown) return;
  shown = text;
  const row = ([name, value, kind]) => make('tr', { className: kind ?? '' }, make('th', { scope: 'row' }, name), make('td', {}, value));
  const table = (caption, list) => make('table', { className: 'facts' }, make('caption', {}, caption), make('tbody', {}, list.map(row)));
  element('panel-details').replaceChildren(table('The job', rows.filter(([, , kind]) => !kind)), table(`Parameters of ${job.method}`, rows.filter(([, , kind]) => kind)));
}

function general(job) {
  const error = job.estimated_error;
  const checks = `${job.shards_verified} equal, ${job.shards_mismatched} different, ${job.shards_unchecked} without a second worker`;
  return [
    ['id', job.id],
    ['submitted', date(job.submitted * 1000)],
    ['owner', job.owner],
    ['tags', job.tags.join(', ')],
    ['priority', job.priority],
    ['size', `${job.width} × ${job.height}`],
    ['scene', job.scene.slice(0, 16)],
    ['seed', job.seed],
    ['stop', stopText(job.stop)],
    ['photons', job.photons_emitted && job.photons_emitted.toLocaleString('en')],
    ['speed', speed(job)],
    ['running for', duration(job.seconds)],
    ['relMSE', error && `${short(error.relmse)}: noise ${short(error.noise)}, bias ${short(error.bias)}`],
    ['bound', error && `${short(error.bound)} at ${100 * error.confidence} % confidence, after ${error.passes} passes`],
    ['chains', acceptance(job).join(' ')],
    ['checked shards', checks],
    ['not finite', job.non_finite && `${job.non_finite} contributions were dropped`],
  ].filter(([, value]) => value !== undefined && value !== '' && value !== 0);
}

function stopText({ passes, seconds, error, accepts_missing_light: acceptsMissing }) {
  const parts = [passes && `${passes} passes`, seconds && duration(seconds), error && `error below ${short(error)}`, acceptsMissing && 'accepts missing light'];
  return parts.filter(Boolean).join(', ');
}
