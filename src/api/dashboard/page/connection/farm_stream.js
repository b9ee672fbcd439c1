// What the coordinator tells of the farm: one stream of events for all jobs, and a look at the workers every few seconds. It says so when the
// coordinator does not answer, and tries again until it does.

// Changes are collected for this long, so that a burst of events becomes one message.
const COLLECT_MS = 100;
const RETRY_MS = 2000;
const WORKERS_MS = 3000;
const PATIENCE_MS = 8000;

export class FarmStream {
  // `tell` is called with every message: `jobs`, `workers` or `connection`.
  constructor(tell) {
    this.tell = tell;
    this.jobs = new Map();
    this.workers = [];
    this.connection = { state: 'connecting', since: Date.now() };
    this.forget();
    setInterval(() => this.askWorkers(), WORKERS_MS);
  }

  // All that is known, for a page that comes later.
  messages() {
    const jobs = { kind: 'jobs', isReset: true, changed: [...this.jobs.values()], deleted: [] };
    return [{ kind: 'connection', ...this.connection }, jobs, { kind: 'workers', workers: this.workers }];
  }

  // Opens the stream anew and forgets what was known as soon as it answers.
  open() {
    this.source?.close();
    clearTimeout(this.retry);
    const source = new EventSource('/v1/events');
    this.source = source;
    let isFirst = true;
    source.onopen = () => {
      if (isFirst) this.reset();
      isFirst = false;
      this.say('live');
      this.askWorkers();
    };
    source.addEventListener('reset', () => this.reset());
    source.addEventListener('status', event => this.change(JSON.parse(event.data)));
    source.addEventListener('deleted', event => this.delete(JSON.parse(event.data).id));
    source.onerror = () => this.lookWhy(source);
  }

  // The browser opens a broken stream again and hears what it missed; one that was refused it does not.
  async lookWhy(source) {
    const status = await fetch('/v1/me', { signal: AbortSignal.timeout(PATIENCE_MS) }).then(
      answer => answer.status,
      () => 0,
    );
    if (source !== this.source) return;
    if (status === 401) {
      source.close();
      this.reset();
      this.say('login');
      return;
    }
    if (status !== 200) this.say('away');
    if (source.readyState === EventSource.CLOSED) {
      this.retry = setTimeout(() => this.open(), RETRY_MS);
    }
  }

  async askWorkers() {
    if (!this.source || this.connection.state === 'login' || this.isAsking) return;
    this.isAsking = true;
    const answer = await fetch('/v1/workers', { signal: AbortSignal.timeout(PATIENCE_MS) }).catch(() => null);
    this.isAsking = false;
    if (answer?.ok) {
      this.workers = (await answer.json()).workers;
      this.tell({ kind: 'workers', workers: this.workers });
      // The network may have been away without the stream noticing it.
      if (this.connection.state === 'away' && this.source.readyState === EventSource.OPEN) this.open();
    } else if (answer?.status === 401) {
      this.lookWhy(this.source);
    } else {
      this.say('away');
    }
  }

  say(state) {
    if (state === this.connection.state) return;
    this.connection = { state, since: Date.now() };
    this.tell({ kind: 'connection', ...this.connection });
  }

  reset() {
    this.jobs.clear();
    this.forget();
    this.pending.isReset = true;
    this.collect();
  }

  change(job) {
    this.jobs.set(job.id, job);
    this.pending.changed.set(job.id, job);
    this.pending.deleted.delete(job.id);
    this.collect();
  }

  delete(id) {
    this.jobs.delete(id);
    this.pending.changed.delete(id);
    this.pending.deleted.add(id);
    this.collect();
  }

  forget() {
    this.pending = { isReset: false, changed: new Map(), deleted: new Set() };
  }

  collect() {
    this.timer ??= setTimeout(() => {
      const { isReset, changed, deleted } = this.pending;
      this.timer = null;
      this.forget();
      this.tell({ kind: 'jobs', isReset, changed: [...changed.values()], deleted: [...deleted] });
    }, COLLECT_MS);
  }
}
