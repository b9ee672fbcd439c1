//! Events go in, effects are carried out.

use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::AtomicU32;
use std::sync::{Arc, Mutex, MutexGuard, Weak};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use tokio::sync::{OwnedMutexGuard, Semaphore, mpsc, watch};
use tokio::time::{Instant, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::CoordinatorOptions;
use super::keeper::{Chore, keep};
use super::layers::SeenFirst;
use super::scenes::SceneRecord;
use super::viewed::Viewed;
use crate::farm::EVENTS;
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::{JobRequest, JobStatus};
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::check::CheckShare;
use crate::farm::rules::terms::{ErrorPoint, PauseReason, Terms};
use crate::farm::rules::{Answer, Effects, Event, Notice, Rules, RulesOptions};
use crate::farm::store::Store;
use crate::farm::store::jobs::Snapshots;
use crate::farm::store::journal::JournalRow;
use crate::farm::wire::lease::JobDescription;

/// How often time passes for the rules.
const TICK: Duration = Duration::from_millis(200);
/// How long a user's request waits for those before it.
const TURN_PATIENCE: Duration = Duration::from_secs(15);
/// Ids of workers and leases that a coordinator may use before those of the next run begin: 2⁴⁰.
const EPOCH_SHIFT: u32 = 40;

/// Time since start, and what it is called outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    started: Instant,
    started_unix: Duration,
}

impl Clock {
    fn start() -> Self {
        let started_unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { started: Instant::now(), started_unix }
    }

    /// Time since start.
    pub(super) fn now(&self) -> Duration {
        self.started.elapsed()
    }

    /// Milliseconds since 1970, now.
    pub(super) fn unix_milliseconds(&self) -> i64 {
        self.unix(self.now()).as_millis() as i64
    }

    /// Time since 1970 at `now`.
    pub(super) fn unix(&self, now: Duration) -> Duration {
        self.started_unix + now
    }
}

/// What all clones of a handle share.
pub(in crate::farm) struct Shared {
    pub(in crate::farm) options: CoordinatorOptions,
    pub(super) clock: Clock,
    pub(super) store: Store,
    pub(super) chores: mpsc::UnboundedSender<Chore>,
    pub(super) viewed: Viewed,
    state: Mutex<State>,
    pub(super) seen_first: SeenFirst,
    pub(super) uploads: Arc<Semaphore>,
    /// Whoever adds or deletes scenes, or jobs that refer to them.
    pub(super) catalogue: Turn,
    /// Rises whenever a waiting worker should ask again.
    pub(in crate::farm) work: watch::Sender<u64>,
    pub(super) stopped: CancellationToken,
    /// Uploads and results under way.
    pub(in crate::farm) busy: TaskTracker,
}

/// What the state mutex guards.
pub(in crate::farm) struct State {
    pub(in crate::farm) rules: Rules,
    pub(super) jobs: BTreeMap<JobId, Arc<JobRecord>>,
    pub(super) scenes: HashMap<String, Arc<SceneRecord>>,
    /// The largest id that any job ever had.
    pub(super) last_job: Option<JobId>,
    pub(super) is_closed: bool,
}

/// A job beside the rules.
pub(in crate::farm) struct JobRecord {
    pub(in crate::farm) id: JobId,
    pub(super) facts: Mutex<JobFacts>,
    /// Rises when part of the job is done again.
    pub(in crate::farm) generation: AtomicU32,
    pub(in crate::farm) merging: Mutex<Option<Merging>>,
    pub(super) status: watch::Sender<JobStatus>,
    /// Whoever does something to the job for a user.
    pub(super) users: Turn,
}

/// What is done one after the other.
#[derive(Debug, Default)]
pub(super) struct Turn(Arc<tokio::sync::Mutex<()>>);

/// A job that is there, while no other user does something to it.
pub(super) struct JobInTurn {
    pub(super) job: Arc<JobRecord>,
    _turn: OwnedMutexGuard<()>,
}

impl Turn {
    /// Waits for its turn.
    ///
    /// # Errors
    /// Those before do not end, for example because the store does not answer them.
    pub(super) async fn take(&self) -> Result<OwnedMutexGuard<()>, FarmError> {
        let late = |_| FarmError::Store { problem: "others wait for the store already".to_owned() };
        timeout(TURN_PATIENCE, self.0.clone().lock_owned()).await.map_err(late)
    }

    /// The turn, if nobody has it.
    pub(super) fn take_now(&self) -> Option<OwnedMutexGuard<()>> {
        self.0.clone().try_lock_owned().ok()
    }
}

/// What was asked for, and what was made of it.
#[derive(Clone, Debug)]
pub(super) struct JobFacts {
    pub(super) request: JobRequest,
    pub(super) description: JobDescription,
    pub(super) terms: Terms,
    /// Seconds since 1970.
    pub(super) submitted: u64,
    /// How its error fell, until it ended or was stored.
    pub(super) history: Vec<ErrorPoint>,
    /// Stored states.
    pub(super) snapshots: Snapshots,
    /// For how long it ran, until it ended or was stored.
    pub(super) ran: Duration,
    /// When it ended, milliseconds since 1970.
    pub(super) ended: Option<i64>,
    /// Why it paused when it was stored.
    pub(super) pause: Option<PauseReason>,
}

/// Runs `work` on a thread that may block.
pub(in crate::farm) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, FarmError> + Send + 'static,
) -> Result<T, FarmError> {
    match tokio::task::spawn_blocking(work).await {
        Ok(result) => result,
        Err(problem) => {
            tracing::error!(%problem, "the coordinator's own work failed");
            Err(FarmError::Internal(problem.to_string()))
        }
    }
}

impl JobRecord {
    pub(super) fn new(id: JobId, facts: JobFacts, status: JobStatus) -> Self {
        Self {
            id,
            facts: Mutex::new(facts),
            generation: AtomicU32::new(0),
            merging: Mutex::new(None),
            status: watch::Sender::new(status),
            users: Turn::default(),
        }
    }

    /// What workers need to know.
    pub(in crate::farm) fn description(&self) -> JobDescription {
        lock(&self.facts).description.clone()
    }

    /// What was asked for.
    pub(super) fn request(&self) -> JobRequest {
        lock(&self.facts).request.clone()
    }

    /// How the error fell until the job ended.
    pub(super) fn history(&self) -> Vec<ErrorPoint> {
        lock(&self.facts).history.clone()
    }

    pub(super) fn watch(&self) -> watch::Receiver<JobStatus> {
        self.status.subscribe()
    }
}

impl Shared {
    pub(super) async fn start(options: CoordinatorOptions, store: Store) -> Result<Arc<Self>, FarmError> {
        let clock = Clock::start();
        let rules = RulesOptions {
            lease_duration: options.lease_duration,
            memory_budget: options.limits.job_memory,
            check_share: CheckShare::new(options.check_share),
            // Ids that rise from one run to the next: a worker of an earlier run is not taken for one of this.
            first_id: (store.epoch() << EPOCH_SHIFT).max(clock.unix(Duration::ZERO).as_micros() as u64),
        };
        let state = State {
            rules: Rules::new(rules),
            jobs: BTreeMap::new(),
            scenes: HashMap::new(),
            last_job: store.last_job().await?,
            is_closed: false,
        };
        let (chores, waiting) = mpsc::unbounded_channel();
        let shared = Self {
            uploads: Arc::new(Semaphore::new(options.limits.uploads)),
            catalogue: Turn::default(),
            options,
            clock,
            store,
            chores,
            viewed: Viewed::default(),
            state: Mutex::new(state),
            seen_first: SeenFirst::default(),
            work: watch::Sender::new(0),
            stopped: CancellationToken::new(),
            busy: TaskTracker::new(),
        };
        let shared = Arc::new(shared);
        shared.take_over_scenes().await?;
        let rows = shared.store.job_rows().await?;
        shared.take_over(rows).await?;
        tokio::spawn(keep(Arc::downgrade(&shared), waiting));
        tokio::spawn(keep_time(Arc::downgrade(&shared), shared.stopped.clone()));
        Ok(shared)
    }

    pub(in crate::farm) fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// Lets `event` happen, carries out what follows, and answers the one who brought it.
    pub(in crate::farm) fn apply(&self, event: Event) -> Answer {
        let mut state = self.lock();
        let now = self.clock.now();
        let Effects { answer, changed, ended, rollbacks, notices, work_appeared } = state.rules.apply(now, event);
        for job in changed.iter().filter_map(|id| state.jobs.get(id)) {
            job.status.send_replace(state.status(job, &self.clock));
        }
        for id in &ended {
            self.forget_ended(&mut state, *id);
        }
        drop(state);
        self.write_journal(&notices);
        for id in ended {
            self.leave_to_keeper(Chore::Finish(id));
        }
        for rollback in rollbacks {
            self.leave_to_keeper(Chore::RollBack(rollback));
        }
        if work_appeared {
            self.work.send_modify(|version| *version += 1);
        }
        answer
    }

    /// An ended job is no business of the rules any more; its last status stays.
    fn forget_ended(&self, state: &mut State, id: JobId) {
        if let Some((job, progress)) = state.jobs.get(&id).zip(state.rules.job(id)) {
            let mut facts = lock(&job.facts);
            facts.history.clone_from(&progress.history);
            facts.terms.clone_from(&progress.terms);
            facts.ran = progress.ran(self.clock.now());
            facts.pause = None;
            facts.ended = Some(self.clock.unix_milliseconds());
        }
        state.rules.apply(self.clock.now(), Event::JobForgotten { job: id });
    }

    /// What people want to read in a log.
    fn write_journal(&self, notices: &[Notice]) {
        if notices.is_empty() {
            return;
        }
        let time = self.clock.unix_milliseconds();
        let row = |notice: &Notice| {
            let text = notice.to_string();
            tracing::info!(target: EVENTS, "{text}");
            if let Notice::Joined { name, threads, .. } = notice {
                self.leave_to_keeper(Chore::Worker { name: name.clone(), threads: *threads });
            }
            let worker = notice.worker().map(str::to_owned);
            JournalRow { sequence: 0, time, job: notice.job(), worker, text }
        };
        self.leave_to_keeper(Chore::Journal(notices.iter().map(row).collect()));
    }

    /// The job with this id.
    pub(in crate::farm) fn job(&self, id: JobId) -> Result<Arc<JobRecord>, FarmError> {
        self.lock().jobs.get(&id).cloned().ok_or(FarmError::UnknownJob(id))
    }

    /// The job with this id, when its users' turn has come: it may have been deleted while one waited.
    pub(super) async fn job_in_turn(&self, id: JobId) -> Result<JobInTurn, FarmError> {
        let turn = self.job(id)?.users.take().await?;
        Ok(JobInTurn { job: self.job(id)?, _turn: turn })
    }

    /// Ends when every tally that arrived has been merged, and everything is stored.
    pub(super) async fn stop(&self) {
        self.busy.close();
        self.busy.wait().await;
        if self.store.is_durable() {
            self.leave_to_keeper(Chore::SnapshotAll);
        }
        if let Err(problem) = self.stored().await {
            tracing::error!(target: EVENTS, "{problem}");
        }
        self.stopped.cancel();
        self.store.close().await;
    }
}

/// Lets time pass until the coordinator is stopped or dropped.
async fn keep_time(shared: Weak<Shared>, stopped: CancellationToken) {
    let mut interval = tokio::time::interval(TICK);
    interval.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    while stopped.run_until_cancelled(interval.tick()).await.is_some() {
        match shared.upgrade() {
            Some(shared) => {
                shared.apply(Event::TimePassed);
                shared.viewed.expire();
            }
            None => return,
        }
    }
}
