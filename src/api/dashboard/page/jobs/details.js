// All that the coordinator knows of a job, as a table.

import { element } from '../elements/dom.js';
import { factsTable } from '../elements/lists.js';
import { date, duration, short } from '../elements/numbers.js';
import { acceptance, speed } from './progress.js';

let shown = '';

export function showDetails(job) {
  const parameters = Object.entries(job.parameters).map(([name, value]) => [name, typeof value === 'object' ? JSON.stringify(value) : String(value)]);
  const tables = [
    [general(job), 'The job'],
    [parameters, `Parameters of ${job.method}`],
  ];
  const text = JSON.stringify(tables);
  if (text === shown) return;
  shown = text;
  element('panel-details').replaceChildren(...tables.map(([rows, caption]) => factsTable(rows, caption)));
}

function general(job) {
  const error = job.estimated_error;
  const checks = `${job.shards_verified} equal, ${job.shards_mismatched} different, ${job.shards_unchecked} without a second worker`;
  return [
    ['id', job.id],
    ['submitted', date(job.submitted * 1000)],
    ['owner', job.owner],
    ['tags', job.tags.join(', ')],
    ['frame', job.frame && `${job.frame.number} of ${job.frame.sequence}`],
    ['priority', job.priority],
    ['size', `${job.width} × ${job.height}`],
    ['scene', job.scene.slice(0, 16)],
    ['seed', job.seed],
    ['light groups', job.light_groups?.join(', ')],
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
  const parts = [
    passes && `${passes} passes`,
    seconds && duration(seconds),
    error && `error below ${short(error)}`,
    acceptsMissing && 'accepts missing light',
  ];
  return parts.filter(Boolean).join(', ');
}
