const element = id => document.getElementById(id);
const hint = element('status').innerHTML;
let chosen = null, events = null, shown = '', following = false;

// The answer to a request, or nothing where a user has to log in first.
async function ask(address, options) {
  const answer = await fetch(address, options);
  if (answer.status === 401) { showLogin(); return null; }
  return answer.ok ? answer.json() : null;
}

function showLogin() {
  events?.close();
  chosen = null; following = false;
  element('login').hidden = false;
  element('user').hidden = element('job').hidden = true;
  element('jobs').replaceChildren();
  element('workers').textContent = element('status').textContent = '';
}

async function logIn(event) {
  event.preventDefault();
  const body = JSON.stringify({ token: element('token').value });
  const headers = { 'Content-Type': 'application/json' };
  const answer = await fetch('/v1/session', { method: 'POST', headers, body });
  element('token').value = '';
  if (!answer.ok) { element('status').textContent = (await answer.json()).detail; return; }
  element('login').hidden = true;
  element('status').innerHTML = hint;
  start();
}

async function logOut() {
  await fetch('/v1/session', { method: 'DELETE' });
  showLogin();
}

const count = (number, word) => `${number} ${word}${number === 1 ? '' : 's'}`;

async function refreshLists() {
  if (!element('login').hidden) return;
  try {
    const list = await ask('/v1/jobs');
    if (!list) return;
    const jobs = list.jobs.reverse();
    const buttons = jobs.map(job => {
      const button = document.createElement('button');
      const owner = job.owner ? `, ${job.owner}` : '';
      button.textContent = `${job.name ?? job.id}: ${job.method}, ${job.state}, ${count(job.passes_done, 'pass')}${owner}`;
      button.title = [job.id, ...job.tags].join(', ');
      button.ariaCurrent = String(chosen === job.id);
      button.onclick = () => choose(job.id);
      return button;
    });
    element('jobs').replaceChildren(...(buttons.length ? buttons : ['no jobs yet']));
    const current = jobs.find(job => job.id === chosen);
    if (chosen && !current) forget();
    // It ended, and was extended.
    if (current && !following && !hasEnded(current)) choose(chosen);
    if (!chosen && jobs.length) choose(jobs[0].id);
    const workers = (await ask('/v1/workers'))?.workers ?? [];
    element('workers').textContent = `${count(workers.length, 'worker')}, ` +
      count(workers.reduce((sum, worker) => sum + worker.threads, 0), 'thread');
  } catch { element('workers').textContent = 'the coordinator does not answer'; }
}

const hasEnded = job => ['done', 'failed', 'cancelled'].includes(job.state);

function forget() {
  events?.close();
  chosen = null; following = false;
  element('job').hidden = true;
  element('status').innerHTML = hint;
}

function choose(id) {
  if (chosen !== id) element('picture').removeAttribute('src');
  chosen = id; shown = ''; following = true;
  events?.close();
  element('job').hidden = false;
  events = new EventSource(`/v1/jobs/${id}/events`);
  events.addEventListener('status', event => show(JSON.parse(event.data)));
  refreshLists();
}

// What a job waits for, in a sentence; empty while it makes progress.
function reason(job) {
  const since = job.waiting_for_workers_since;
  if (since) return `It waits for workers since ${new Date(since * 1000).toLocaleTimeString()}.`;
  if (job.paused) return `${job.paused}.`;
  if (job.waiting_for_memory) return 'It waits for memory that other jobs hold.';
  return job.error ?? '';
}

function show(job) {
  if (job.id !== chosen) return;
  const ended = hasEnded(job);
  if (ended) { events.close(); following = false; }
  const rate = (job.photons_per_second / 1e6).toFixed(2);
  element('status').textContent = `${job.state}: ${job.passes_done} of ${job.passes_total ?? '∞'} passes, ` +
    `${rate} million photons/s, ${job.seconds.toFixed(1)} s, ${count(job.workers, 'worker')}. ${reason(job)}`;
  element('status').className = job.error ? 'error' : '';
  const share = Math.max(job.passes_done / (job.passes_total ?? Infinity), job.seconds / (job.stop.seconds ?? Infinity));
  element('progress').value = job.state === 'done' ? 1 : share;
  element('cancel').hidden = ended;
  element('cancel').onclick = () => cancel(job);
  element('exr').href = job.links.image_exr;
  const exposure = element('exposure').value;
  const wanted = `${job.links.image_png}?exposure=${exposure}`;
  if (job.passes_done && shown !== wanted + job.picture_version && (element('picture').complete || ended)) {
    shown = wanted + job.picture_version;
    element('picture').src = `${wanted}#${job.picture_version}`;
  }
  element('exposure').onchange = () => show(job);
}

async function cancel(job) {
  const answer = await fetch(job.links.cancel, { method: 'POST' });
  if (!answer.ok) element('workers').textContent = (await answer.json()).detail;
}

async function start() {
  const me = await ask('/v1/me').catch(() => null);
  element('user').hidden = !me?.user;
  element('name').textContent = me?.user ?? '';
  refreshLists();
}

element('login').onsubmit = logIn;
element('logout').onclick = logOut;
start();
setInterval(refreshLists, 3000);
