// Tells of a problem: what is wrong, where it stands, and what to do about it.

import { make } from './dom.js';

export function problemNote(problem) {
  const place = problem.place && make('p', {}, 'Place: ', make('code', {}, problem.place));
  const remedy = problem.remedy && make('p', { className: 'remedy' }, `Remedy: ${problem.remedy}`);
  return make('div', { className: 'problem', role: 'alert' }, make('p', {}, sentence(problem.message)), place, remedy);
}

const sentence = text => text.charAt(0).toUpperCase() + text.slice(1);
