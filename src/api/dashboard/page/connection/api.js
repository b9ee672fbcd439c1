// Requests to the coordinator. Every failure becomes a Problem: what is wrong, where, and what to do about it.

export class Problem extends Error {
  constructor({ title = 'problem', detail = '', remedy, place, status = 0, type = '' }) {
    super(detail || title);
    Object.assign(this, { title, remedy, place, status, kind: type.split(':').pop() });
  }
}

const AWAY = { title: 'no answer', detail: 'The coordinator does not answer.', remedy: 'Try again when it is back.' };

// Sends a request and answers the Response, whatever its status; fails only when there is none.
export async function send(address, options) {
  try {
    return await fetch(address, options);
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Problem(AWAY);
  }
}

// Fails unless the answer is good.
export async function expect(answer) {
  if (answer.ok) return answer;
  const problem = await answer.json().catch(() => ({}));
  throw new Problem({ detail: `The coordinator answers ${answer.status}.`, ...problem, status: answer.status });
}

// Asks for JSON; `body` is sent as JSON where it is given.
export async function ask(address, { method = 'GET', body, headers = {} } = {}) {
  const json = body === undefined ? {} : { body: JSON.stringify(body) };
  if (body !== undefined) headers = { 'Content-Type': 'application/json', ...headers };
  const answer = await expect(await send(address, { method, headers, ...json }));
  return answer.status === 204 ? null : answer.json();
}

export const post = (address, body) => ask(address, { method: 'POST', body });
