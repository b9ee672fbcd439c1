// What the page knows. Messages of the farm and choices of the user change it; views read it and are told when it changed.

export const store = {
  jobs: new Map(),
  workers: [],
  connection: { state: 'connecting', since: Date.now() },
  // Who one is: `user` and `scope`.
  me: { scope: 'read' },
  // The id of the job that is shown.
  chosen: null,
};

const views = new Set();
let isPlanned = false;

export const subscribe = view => views.add(view);

// Tells all views at the next frame, once for all that happens until then.
export function changed() {
  if (isPlanned) return;
  isPlanned = true;
  const tell = () => {
    isPlanned = false;
    views.forEach(view => view(store));
  };
  // Frames do not come in a hidden tab, whose title and list should be right all the same when it is shown.
  if (document.hidden) setTimeout(tell, 500);
  else requestAnimationFrame(tell);
}

// Takes a message of the farm.
export function hear(message) {
  if (message.kind === 'connection') store.connection = { state: message.state, since: message.since };
  if (message.kind === 'workers') store.workers = message.workers;
  if (message.kind === 'jobs') hearJobs(message);
  changed();
}

function hearJobs({ isReset, changed, deleted }) {
  if (isReset) store.jobs.clear();
  deleted.forEach(id => store.jobs.delete(id));
  changed.forEach(job => store.jobs.set(job.id, job));
}

export function choose(id) {
  store.chosen = id;
  changed();
}

export const chosenJob = () => store.jobs.get(store.chosen);

// Whether the coordinator is there to take orders.
export const isLive = () => store.connection.state === 'live';

// Whether the user may change this job: it is their own, or they are an admin.
export function mayChange(job) {
  const { user, scope } = store.me;
  if (!isLive()) return false;
  return scope === 'admin' || (scope === 'submit' && job.owner === user);
}

export const maySubmit = () => isLive() && ['submit', 'admin'].includes(store.me.scope);
