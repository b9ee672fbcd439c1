// What the coordinator does not keep: speed and workers over time, noted from the events while the page is open.

import { samplesPerSecond } from '../jobs/progress.js';

const STEP_SECONDS = 1;
// When there are more, every second one goes.
const MOST = 600;

const records = new Map();

// Notes how these jobs are now. Rates are those since the note before.
export function record(jobs) {
  for (const job of jobs) {
    if (job.state !== 'running') continue;
    const points = records.get(job.id) ?? [];
    records.set(job.id, points);
    const last = points.at(-1);
    if (last && job.seconds - last.seconds < STEP_SECONDS) continue;
    const done = samplesPerSecond(job) * job.seconds;
    const speed = last ? Math.max((done - last.done) / (job.seconds - last.seconds), 0) : null;
    points.push({ seconds: job.seconds, done, speed, workers: job.workers });
    if (points.length > MOST)
      records.set(
        job.id,
        points.filter((_, index) => index % 2 === 0),
      );
  }
}

export const recorded = id => records.get(id) ?? [];
