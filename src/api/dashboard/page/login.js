// Who one is, and logging in and out: by a token, or with an account at a provider.

import { ask, post } from './connection/api.js';
import { element, setHidden, setText } from './elements/dom.js';
import { problemNote } from './elements/problem_note.js';
import { changed, store } from './store.js';

// `again` opens the stream of the farm anew.
export function startLogin(again) {
  element('login').onsubmit = async event => {
    event.preventDefault();
    const token = element('token').value;
    element('token').value = '';
    try {
      await post('/v1/session', { token });
      element('login-problem').replaceChildren();
      again();
    } catch (problem) {
      element('login-problem').replaceChildren(problemNote(problem));
    }
  };
  element('log-out').onclick = async () => {
    await ask('/v1/session', { method: 'DELETE' }).catch(() => null);
    again();
  };
}

// Asks who one is; a page that nobody logged in to may do nothing.
export async function learnWhoIAm() {
  store.me = await ask('/v1/me').catch(() => ({ scope: 'read' }));
  setHidden(element('user'), !store.me.user);
  setText(element('user-name'), `${store.me.user ?? ''} (${store.me.scope})`);
  changed();
}

// Where people may log in with an account that they have elsewhere.
export async function showProvider() {
  const { provider } = await ask('/v1/session').catch(() => ({}));
  setHidden(element('provider'), !provider);
  if (provider) setText(element('provider').querySelector('span'), new URL(provider).host);
}
