// Which jobs are listed, and in which order. Pure functions.

import { hasEnded, nameOf, share } from './progress.js';

const GROUPS = { all: () => true, live: job => !hasEnded(job), ended: hasEnded };

// Every word has to stand in the id, name, method, owner, sequence or a tag.
function hasWords(job, words) {
  const text = [job.id, job.name, job.method, job.owner, job.frame?.sequence, ...job.tags].join('\n').toLowerCase();
  return words.every(word => text.includes(word));
}

const byText = text => (one, other) => text(one).localeCompare(text(other), 'en', { numeric: true });
const error = job => job.estimated_error?.bound ?? Infinity;
const left = job => (hasEnded(job) ? Infinity : (job.seconds_left ?? 1e300));

// Later jobs have larger ids.
const newest = (one, other) => (one.id < other.id ? 1 : -1);

export const ORDERS = {
  newest: ['newest first', newest],
  oldest: ['oldest first', (one, other) => newest(other, one)],
  name: ['name', byText(nameOf)],
  owner: ['owner', byText(job => job.owner ?? '')],
  method: ['method', byText(job => job.method)],
  state: ['state', byText(job => job.state)],
  priority: ['priority', (one, other) => other.priority - one.priority],
  progress: ['progress', (one, other) => share(other) - share(one)],
  error: ['smallest error', (one, other) => compare(error(one), error(other))],
  left: ['soonest done', (one, other) => compare(left(one), left(other))],
};

// Infinity less Infinity is no order.
const compare = (one, other) => (one < other ? -1 : one > other ? 1 : 0);

// `state` is the name of a group or of a state.
export function select(jobs, { text, state, order }) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = GROUPS[state] ?? (job => job.state === state);
  const compareJobs = ORDERS[order][1];
  return [...jobs].filter(job => fits(job) && hasWords(job, words)).sort((one, other) => compareJobs(one, other) || newest(one, other));
}
