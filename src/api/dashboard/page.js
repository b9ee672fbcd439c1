const element = id => document.getElementById(id);
const hint = element('status').innerHTML;
const jobs = new Map();
let chosen = null, events = null, shown = '', listing = false;

// The answer to a request, or nothing where a user has to log in first.
async function ask(address, options) {
  const answer = await fetch(address, options);
  if (answer.status === 401) { showLogin(); return null; }
  return answer.ok ? answer.json() : null;
}

function showLogin() {
  events?.close();
  chosen = null;
  jobs.clear();
  element('login').hidden = false;
  element('user').hidden = element('job').hidden = true;
  element('jobs').replaceChildren();
  element('workers').textContent = element('status').textContent = '';
  showProvider();
}

// Where people may log in with an account that they have elsewhere.
async function showProvider() {
  const { provider } = await (await fetch('/v1/session')).json();
  element('provider').hidden = !provider;
  if (provider) element('provider').querySelector('span').textContent = new URL(provider).host;
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

const count = (number, word) => `${number} ${word}${number === 1 ? '' : /s$/.test(word) ? 'es' : 's'}`;

// One stream tells of all jobs. The browser opens it again when it breaks, and then hears what it missed.
function follow() {
  events?.close();
  jobs.clear();
  events = new EventSource('/v1/events');
  events.addEventListener('reset', () => jobs.clear());
  events.addEventListener('deleted', event => { jobs.delete(JSON.parse(event.data).id); list(); });
  events.addEventListener('status', event => {
    const job = JSON.parse(event.data);
    jobs.set(job.id, job);
    list();
    show(job);
  });
  // A stream that is refused is not opened again: somebody has to log in, or the coordinator is away.
  events.onerror = () => {
    element('workers').textContent = 'the coordinator does not answer';
    if (events.readyState === EventSource.CLOSED) setTimeout(start, 2000);
  };
}

// The newest job is the first.
function list() {
  if (listing) return;
  listing = true;
  requestAnimationFrame(() => {
    listing = false;
    const newest = [...jobs.values()].sort((a, b) => a.id < b.id ? 1 : -1);
    const buttons = newest.map(job => {
      const button = document.createElement('button');
      const owner = job.owner ? `, ${job.owner}` : '';
      button.textContent = `${job.name ?? job.id}: ${job.method}, ${job.state}, ${count(job.passes_done, 'pass')}${owner}`;
      button.title = [job.id, ...job.tags].join(', ');
      button.ariaCurrent = String(chosen === job.id);
      button.onclick = () => choose(job.id);
      return button;
    });
    element('jobs').replaceChildren(...(buttons.length ? buttons : ['no jobs yet']));
    if (chosen && !jobs.has(chosen)) forget();
    if (!chosen && newest.length) choose(newest[0].id);
  });
}

async function refreshWorkers() {
  if (!element('login').hidden) return;
  const workers = (await ask('/v1/workers').catch(() => null))?.workers;
  if (!workers) return;
  element('workers').textContent = `${count(workers.length, 'worker')}, ` +
    count(workers.reduce((sum, worker) => sum + worker.threads, 0), 'thread');
}

const hasEnded = job => ['done', 'failed', 'cancelled'].includes(job.state);

function forget() {
  chosen = null;
  element('job').hidden = true;
  element('status').innerHTML = hint;
}

function choose(id) {
  if (chosen !== id) element('picture').removeAttribute('src');
  chosen = id; shown = '';
  element('job').hidden = false;
  show(jobs.get(id));
  list();
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
  const samples = job.width * job.height * job.passes_done / Math.max(job.seconds, 1e-9);
  const rate = job.photons_emitted ? `${(job.photons_per_second / 1e6).toFixed(2)} million photons/s`
    : `${(samples / 1e6).toFixed(2)} million samples/s`;
  const accepted = (job.acceptance ?? []).map((of) =>
    ` ${(100 * of.accepted / Math.max(of.proposed, 1)).toFixed(0)} % of ${of.proposal.replaceAll('_', ' ')} accepted.`);
  element('status').textContent = `${job.state}: ${job.passes_done} of ${job.passes_total ?? '∞'} passes, ` +
    `${rate}, ${job.seconds.toFixed(1)} s, ${count(job.workers, 'worker')}.${accepted.join('')} ${reason(job)}`;
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
  if (!element('login').hidden) return;
  follow();
  refreshWorkers();
}

element('login').onsubmit = logIn;
element('logout').onclick = logOut;
start();
setInterval(refreshWorkers, 3000);
