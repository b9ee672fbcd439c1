// The charts of a job: its error from the coordinator's history, speed and workers as they were while the page was open.

import { ask } from '../connection/api.js';
import { element, make } from '../elements/dom.js';
import { hasEnded } from '../jobs/progress.js';
import { lineChart } from './line_chart.js';
import { recorded } from './recorder.js';

const REFRESH_MS = 4000;

let history = { id: null, version: null, at: 0, points: [] };

export async function showCharts(job) {
  await refresh(job);
  const panel = element('panel-charts');
  // Another job may have been chosen meanwhile.
  if (panel.hidden || history.id !== job.id) return;
  const { points } = history;
  const error = lineChart({
    label: 'Error over time',
    isLogarithmic: true,
    goal: job.stop.error,
    lines: [
      { className: 'bound', points: points.map(({ seconds, bound }) => [seconds, bound]) },
      { className: 'estimate', points: points.map(({ seconds, relmse }) => [seconds, relmse]) },
    ],
  });
  const noted = recorded(job.id);
  const speed = lineChart({
    label: 'Speed over time',
    lines: [{ className: 'estimate', points: noted.map(({ seconds, speed }) => [seconds, speed ?? NaN]) }],
  });
  const workers = lineChart({
    label: 'Workers over time',
    lines: [{ className: 'estimate', points: noted.map(point => [point.seconds, point.workers]) }],
  });
  const what = job.photons_emitted ? 'Photons' : 'Samples';
  panel.replaceChildren(
    figure('Error (relMSE): estimate, and the bound that it is below with 95 % confidence', error, points.length ? '' : 'Nothing is estimated yet.'),
    figure(`${what} a second`, speed, noted.length > 1 ? '' : 'Noted while this page is open and the job runs.'),
    figure('Workers', workers, noted.length ? '' : 'Noted while this page is open and the job runs.'),
    make('p', { className: 'quiet' }, 'The coordinator keeps the error over time. Speed and workers are noted by this page while it is open.'),
  );
}

const figure = (title, chart, note) =>
  make('figure', {}, make('figcaption', {}, title), chart, note ? make('p', { className: 'quiet' }, note) : null);

async function refresh(job) {
  const isOther = history.id !== job.id;
  const isOld = history.version !== job.picture_version && (hasEnded(job) || performance.now() - history.at > REFRESH_MS);
  if (!isOther && !isOld) return;
  const points = isOther ? [] : history.points;
  history = { id: job.id, version: job.picture_version, at: performance.now(), points };
  const answer = await ask(`/v1/jobs/${job.id}/history`).catch(() => null);
  if (answer && history.id === job.id) history.points = answer.points;
}
