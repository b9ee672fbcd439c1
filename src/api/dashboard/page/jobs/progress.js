// How far a job is, in numbers and words. Pure functions of its status.

import { count, duration, rate, short, time } from '../elements/numbers.js';

export const STATES = ['queued', 'choosing', 'running', 'paused', 'done', 'failed', 'cancelled'];

export const hasEnded = job => ['done', 'failed', 'cancelled'].includes(job.state);

export const nameOf = job => job.name ?? job.id;

// The share that is done of whichever part of the stop rule is nearest, 0 to 1.
export function share(job) {
  if (job.state === 'done') return 1;
  const parts = [job.passes_total ? job.passes_done / job.passes_total : 0, job.stop.seconds ? job.seconds / job.stop.seconds : 0, errorShare(job)];
  return Math.min(Math.max(...parts), 1);
}

// On a logarithmic scale from 1, the relMSE of a black picture, to the goal.
export function errorShare(job) {
  const { estimated_error: found, stop } = job;
  if (!stop.error || !found || !(found.bound > 0)) return 0;
  return Math.min(Math.max(Math.log(found.bound) / Math.log(Math.min(stop.error, 0.999)), 0), 1);
}

// "12 of 64 passes, relMSE below 0.02 of 0.01, 4 s of 60 s": what is reached beside what is to be.
export function reached(job) {
  const { stop, passes_total: total } = job;
  const passes = total ? `${job.passes_done.toLocaleString('en')} of ${count(total, 'pass')}` : count(job.passes_done, 'pass');
  const seconds = stop.seconds ? `${duration(job.seconds)} of ${duration(stop.seconds)}` : duration(job.seconds);
  return [passes, errorText(job), seconds].filter(Boolean).join(', ');
}

// The job's own bound of its error, against the goal where there is one.
export function errorText(job) {
  const bound = job.estimated_error?.bound;
  const { error: goal } = job.stop;
  if (bound === undefined) return goal ? `error not known yet, goal ${short(goal)}` : '';
  return goal ? `error below ${short(bound)}, goal ${short(goal)}` : `error below ${short(bound)}`;
}

export function timeLeft(job) {
  if (hasEnded(job) || job.seconds_left === undefined || job.state === 'paused') return '';
  return `${duration(job.seconds_left)} left`;
}

// Photons where there are any, else camera samples.
export function samplesPerSecond(job) {
  return job.photons_emitted ? job.photons_per_second : (job.width * job.height * job.passes_done) / Math.max(job.seconds, 1e-9);
}

export const speed = job => rate(samplesPerSecond(job), job.photons_emitted ? 'photons' : 'samples');

// What a job waits for or died of, in a sentence; empty while it makes progress.
export function reason(job) {
  if (job.error) return job.error;
  if (job.paused) return `${job.paused}.`;
  if (job.waiting_for_workers_since) {
    return `It waits for workers since ${time(job.waiting_for_workers_since * 1000)}.`;
  }
  return job.waiting_for_memory ? 'It waits for memory that other jobs hold.' : '';
}

// How often Markov chains took what was proposed to them, a sentence for each kind.
export function acceptance(job) {
  const sentence = ({ proposal, proposed, accepted }) =>
    `${((100 * accepted) / Math.max(proposed, 1)).toFixed(0)} % of ${proposal.replaceAll('_', ' ')} accepted.`;
  return (job.acceptance ?? []).map(sentence);
}
