// The coordinator's page. Messages of the farm go into the store, the store tells the views, and what the user does goes to the coordinator, which
// tells the farm. The address says which view is open and which job is shown.

import { followFarm } from './page/connection/follow_farm.js';
import { record } from './page/charts/recorder.js';
import { showCharts } from './page/charts/charts.js';
import { element, setHidden, setText } from './page/elements/dom.js';
import { startTabs } from './page/elements/tabs.js';
import { time } from './page/elements/numbers.js';
import { showActions, startActions } from './page/jobs/actions.js';
import { showDetails } from './page/jobs/details.js';
import { showHead } from './page/jobs/job_head.js';
import { showJournal } from './page/jobs/journal.js';
import { firstListed, openNeighbour, showList, startList } from './page/jobs/list.js';
import { learnWhoIAm, showProvider, startLogin } from './page/login.js';
import { showPaths, startPaths } from './page/paths/paths_panel.js';
import { choose, chosenJob, hear, store, subscribe } from './page/store.js';
import { leaveSequences, showSequences } from './page/sequences/sequences.js';
import { startSubmit } from './page/submit/submit.js';
import { changeComparison, changeLayer, showPicture, startViewer, viewer } from './page/viewer/viewer.js';
import { listOthers, startComparison } from './page/viewer/comparison.js';
import { startControls } from './page/viewer/controls.js';
import { viewerActions } from './page/viewer/actions.js';
import { followKeys, showKeys } from './page/viewer/keys.js';
import { showRegion, startRegion } from './page/viewer/region.js';
import { noteWorkers, showWorkers, summary } from './page/workers/workers.js';

const VIEWS = ['jobs', 'sequences', 'submit', 'workers'];
// From this width on there is room for a job beside the list, so one is shown.
const WIDE = matchMedia('(min-width: 900px)');

let route = { view: 'jobs', job: null };
let other = null;
// What the next job is to be compared with.
let nextOther = null;
let panel = 'panel-look';
let journal = '';

// "#/jobs/ID", "#/sequences", "#/submit", "#/workers".
function readRoute() {
  const [view, job] = location.hash.replace(/^#\/?/, '').split('/');
  const before = route.view;
  route = { view: VIEWS.includes(view) ? view : 'jobs', job: view === 'jobs' && job ? job : null };
  if (route.job !== store.chosen) [other, nextOther] = [nextOther, null];
  choose(route.job);
  if (route.view !== before) element('main').focus({ preventScroll: true });
  if (route.view === 'workers') showJournal(element('farm-journal'));
}

const openJob = id => {
  location.hash = `#/jobs/${id}`;
};

// Shows what was submitted: a job, or among others a sequence.
function openMade({ id, frames }) {
  if (frames) location.hash = '#/sequences';
  else openJob(id);
}

// What is told of a job that is shown under another's id would be wrong, so all of it follows from the store at once.
function show() {
  const { connection, jobs, workers } = store;
  const isOut = connection.state === 'login';
  setHidden(element('login-view'), !isOut);
  for (const view of VIEWS) {
    setHidden(element(`${view}-view`), isOut || route.view !== view);
    const link = document.querySelector(`nav [href="#/${view}"]`);
    if (route.view === view && !isOut) link.setAttribute('aria-current', 'page');
    else link.removeAttribute('aria-current');
  }
  showConnection(connection);
  setText(element('farm'), isOut || connection.state === 'connecting' ? '' : summary(workers));
  if (route.view === 'workers') showWorkers(workers);
  if (route.view === 'jobs') showJobs(jobs);
  if (route.view === 'sequences' && !isOut) showSequences(jobs);
  else leaveSequences();
}

function showConnection({ state, since }) {
  const isAway = state === 'away';
  document.body.classList.toggle('away', isAway);
  setHidden(element('away'), !isAway);
  setText(element('away'), isAway ? `The coordinator does not answer since ${time(since)}. What you see is how it was then.` : '');
}

function showJobs(jobs) {
  showList();
  const job = chosenJob();
  document.body.classList.toggle('has-job', Boolean(job));
  if (!job && !route.job && WIDE.matches && firstListed()) location.replace(`#/jobs/${firstListed().id}`);
  setHidden(element('job'), !job);
  setHidden(element('no-job'), Boolean(job));
  const isGone = route.job && store.connection.state === 'live';
  setText(element('gone'), isGone ? `There is no job ${route.job} here, or not any more. ` : '');
  showPicture(job ?? null, jobs.get(other));
  showPaths(panel === 'panel-paths' && job ? job : null);
  showRegion();
  document.title = job ? `${job.name ?? job.id}: ${job.state} – photonfarm` : 'photonfarm';
  if (!job) return;
  showHead(job);
  showActions(job);
  showPanel(job);
}

function showPanel(job) {
  if (panel === 'panel-compare') listOthers(store.jobs.values(), job, viewer.other?.id);
  if (panel === 'panel-charts') showCharts(job);
  if (panel === 'panel-details') showDetails(job);
  // Lines are written when the state changes.
  const wanted = `${job.id} ${job.state}`;
  if (panel === 'panel-journal' && journal !== wanted) {
    journal = wanted;
    showJournal(element('panel-journal'), job.id);
  }
}

function hearFarm(message) {
  if (message.kind === 'connection' && message.state === 'login') showProvider();
  if (message.kind === 'connection' && message.state === 'live') learnWhoIAm();
  if (message.kind === 'jobs') record(message.changed);
  if (message.kind === 'workers') noteWorkers(message.workers);
  hear(message);
}

function compareWith(id) {
  other = id;
  show();
}

// Shows a job and its difference from another.
function openComparison(job, beside) {
  nextOther = beside;
  changeComparison({ mode: 'difference' });
  element('tab-compare').click();
  if (job === store.chosen) compareWith(beside);
  else openJob(job);
}

async function start() {
  startList(openJob);
  startActions(openJob);
  startSubmit(openMade);
  startViewer();
  startControls(changeLayer);
  startComparison({ compareWith, change: changeComparison, current: () => viewer });
  startRegion();
  startPaths({ compare: openComparison });
  startTabs(element('panel-tabs'), shown => {
    [panel, journal] = [shown, ''];
    show();
  });
  followKeys(viewerActions({ openNeighbour, help: showKeys }));
  element('show-keys').onclick = showKeys;
  subscribe(show);
  addEventListener('hashchange', readRoute);
  readRoute();
  const build = await fetch('/version')
    .then(answer => answer.json())
    .then(
      version => version.build,
      () => '',
    );
  startLogin(followFarm(build, hearFarm));
}

start();
