// Facts and sentences as tables and lists.

import { make } from './dom.js';

// Rows of a name and a value each.
export function factsTable(rows, caption) {
  const row = ([name, value]) => make('tr', {}, make('th', { scope: 'row' }, name), make('td', {}, value));
  const body = make('tbody', {}, rows.map(row));
  return make('table', { className: 'facts' }, caption && make('caption', {}, caption), body);
}

export function noticeList(notices) {
  const items = notices.map(text => make('li', {}, text));
  return make('ul', { className: 'notices', hidden: !items.length }, items);
}
