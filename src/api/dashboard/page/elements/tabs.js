// Tabs: one panel of several is seen. The arrow keys go from tab to tab.

import { element } from './dom.js';

// `tell` is called with the id of the panel that is shown.
export function startTabs(list, tell) {
  const tabs = [...list.querySelectorAll('[role=tab]')];
  const show = shown => {
    for (const tab of tabs) {
      tab.setAttribute('aria-selected', tab === shown);
      tab.tabIndex = tab === shown ? 0 : -1;
      element(tab.getAttribute('aria-controls')).hidden = tab !== shown;
    }
    tell(shown.getAttribute('aria-controls'));
  };
  tabs.forEach(tab => {
    tab.onclick = () => show(tab);
  });
  list.addEventListener('keydown', event => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const next = tabs[(tabs.indexOf(document.activeElement) + step + tabs.length) % tabs.length];
    next.focus();
    show(next);
  });
}
