//! Events go in, effects are carried out.

use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicU32, AtomicU64};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use tokio::sync::{OwnedMutexGuard, Semaphore, mpsc, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::chores::Chore;
use super::clock::Clock;
use super::counters::{Counters, is_result};
use super::denoising::Denoising;
use super::feed::Feed;
use super::options::CoordinatorOptions;
use super::scene_record::SceneRecord;
use super::seen_first::SeenFirst;
use super::sequence_record::SequenceRecord;
use super::turn::Turn;
use super::viewed::Viewed;
use crate::estimate::picture_files::Mattes;
use crate::farm::access::caller::Caller;
use crate::farm::access::register::Register;
use crate::farm::access::secret::NoRandomness;
use crate::farm::access::user::UserName;
use crate::farm::access::worker_secret::WorkerSecrets;
use crate::farm::error::FarmError;
use crate::farm::events::EVENTS;
use crate::farm::ids::{JobId, SequenceId};
use crate::farm::job::{Idempotency, JobRequest, JobStatus};
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::terms::{ErrorPoint, PauseReason, Terms};
use crate::farm::rules::{Answer, Effects, Event, Notice, Rules};
use crate::farm::store::Store;
use crate::farm::store::jobs::Snapshots;
use crate::farm::store::journal::JournalRow;
use crate::farm::webhooks::webhook::Webhook;
use crate::farm::wire::lease::JobDescription;
use crate::render::first_surface::FirstSurface;

/// What all clones of a handle share.
pub(in crate::farm) struct Shared {
    pub(in crate::farm) options: CoordinatorOptions,
    pub(super) clock: Clock,
    pub(super) store: Store,
    pub(super) chores: mpsc::UnboundedSender<Chore>,
    pub(super) viewed: Viewed,
    state: Mutex<State>,
    pub(super) register: Mutex<Register>,
    pub(super) webhooks: Mutex<Vec<Webhook>>,
    pub(super) counters: Counters,
    pub(super) feed: Feed,
    pub(in crate::farm) worker_secrets: WorkerSecrets,
    pub(super) surfaces_seen: SeenFirst<[FirstSurface]>,
    pub(super) mattes_seen: SeenFirst<Mattes>,
    pub(super) denoising: Denoising,
    pub(super) uploads: Arc<Semaphore>,
    /// How many of them are whose.
    pub(super) uploading: Mutex<BTreeMap<UserName, usize>>,
    /// Whoever adds or deletes scenes, or jobs that refer to them.
    pub(super) catalogue: Turn,
    pub(super) sequences: Mutex<BTreeMap<SequenceId, Arc<SequenceRecord>>>,
    /// Whoever submits one.
    pub(super) sequencing: Turn,
    /// Whoever changes users or tokens.
    pub(super) members: Turn,
    /// Rises whenever a waiting worker should ask again.
    pub(in crate::farm) work: watch::Sender<u64>,
    pub(super) stopped: CancellationToken,
    /// Cancelled when another coordinator leads.
    pub(super) deposed: CancellationToken,
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
    status: watch::Sender<JobStatus>,
    /// The number of its last change.
    pub(super) changed: AtomicU64,
    /// Whoever does something to the job for a user.
    pub(super) users: Turn,
}

/// A job that is there, while no other user does something to it.
pub(super) struct JobInTurn {
    pub(super) job: Arc<JobRecord>,
    _turn: OwnedMutexGuard<()>,
}

/// What was asked for, and what was made of it.
#[derive(Clone, Debug)]
pub(super) struct JobFacts {
    pub(super) request: JobRequest,
    pub(super) description: JobDescription,
    pub(super) terms: Terms,
    /// Who submitted it, where there are users.
    pub(super) owner: Option<UserName>,
    /// Seconds since 1970.
    pub(super) submitted: u64,
    /// How its error fell, until it ended or was stored.
    pub(super) history: Vec<ErrorPoint>,
    /// The key with which it was submitted.
    pub(super) idempotency: Option<Idempotency>,
    /// When the last of them was written, or when it began to run; time since start.
    pub(super) last_snapshot: Option<Duration>,
    /// Stored states.
    pub(super) snapshots: Snapshots,
    /// For how long it ran, until it ended or was stored.
    pub(super) ran: Duration,
    /// When it ended, milliseconds since 1970.
    pub(super) ended: Option<i64>,
    /// Why it paused when it was stored.
    pub(super) pause: Option<PauseReason>,
}

impl JobFacts {
    /// Those of a job that was submitted at `unix`, the time since 1970, and has not begun.
    pub(super) fn new(request: JobRequest, description: JobDescription, terms: Terms, unix: Duration) -> Self {
        Self {
            request,
            description,
            terms,
            owner: None,
            idempotency: None,
            submitted: unix.as_secs(),
            history: Vec::new(),
            last_snapshot: None,
            snapshots: Snapshots::default(),
            ran: Duration::ZERO,
            ended: None,
            pause: None,
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
            changed: AtomicU64::new(0),
            users: Turn::default(),
        }
    }

    /// What workers need to know.
    pub(in crate::farm) fn description(&self) -> JobDescription {
        lock(&self.facts).description.clone()
    }

    /// Who submitted it, where there are users.
    pub(super) fn owner(&self) -> Option<UserName> {
        lock(&self.facts).owner.clone()
    }

    /// What was asked for.
    pub(super) fn request(&self) -> JobRequest {
        lock(&self.facts).request.clone()
    }

    /// How the error fell until the job ended.
    pub(super) fn history(&self) -> Vec<ErrorPoint> {
        lock(&self.facts).history.clone()
    }

    /// Its status as it was told last.
    pub(super) fn last_status(&self) -> JobStatus {
        self.status.borrow().clone()
    }

    pub(super) fn watch(&self) -> watch::Receiver<JobStatus> {
        self.status.subscribe()
    }
}

impl Shared {
    /// Nothing but the rules of a farm without jobs.
    pub(super) fn new(
        options: CoordinatorOptions,
        store: Store,
        clock: Clock,
        rules: Rules,
        last_job: Option<JobId>,
        chores: mpsc::UnboundedSender<Chore>,
    ) -> Result<Self, NoRandomness> {
        let state = State { rules, jobs: BTreeMap::new(), scenes: HashMap::new(), last_job, is_closed: false };
        Ok(Self {
            register: Mutex::default(),
            webhooks: Mutex::default(),
            counters: Counters::new(),
            feed: Feed::new(),
            worker_secrets: WorkerSecrets::new()?,
            members: Turn::default(),
            uploads: Arc::new(Semaphore::new(options.limits.uploads)),
            uploading: Mutex::default(),
            catalogue: Turn::default(),
            sequences: Mutex::default(),
            sequencing: Turn::default(),
            options,
            clock,
            store,
            chores,
            viewed: Viewed::default(),
            state: Mutex::new(state),
            surfaces_seen: SeenFirst::default(),
            mattes_seen: SeenFirst::default(),
            denoising: Denoising::default(),
            work: watch::Sender::new(0),
            stopped: CancellationToken::new(),
            deposed: CancellationToken::new(),
            busy: TaskTracker::new(),
        })
    }

    pub(in crate::farm) fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// Lets `event` happen, carries out what follows, and answers the one who brought it.
    pub(in crate::farm) fn apply(&self, event: Event) -> Answer {
        let is_result = is_result(&event);
        let mut state = self.lock();
        let now = self.clock.now();
        let Effects { answer, changed, ended, rollbacks, notices, work_appeared } = state.rules.apply(now, event);
        for job in changed.iter().filter_map(|id| state.jobs.get(id)) {
            self.publish(job, state.status(job, &self.clock));
        }
        for id in &ended {
            self.forget_ended(&mut state, *id);
        }
        drop(state);
        self.counters.count(is_result, &answer, &notices);
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

    /// Tells whoever watches how a job is doing.
    pub(super) fn publish(&self, job: &JobRecord, status: JobStatus) {
        job.status.send_replace(status);
        self.feed.number(&job.changed);
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

    /// Records what somebody did to users and tokens.
    pub(super) fn record_deed(&self, caller: &Caller, deed: &str) {
        self.record_deed_of(caller.shown(), deed);
    }

    /// The same of somebody who is no user.
    pub(super) fn record_deed_of(&self, who: &str, deed: &str) {
        let text = format!("{deed} by {who}");
        tracing::info!(target: EVENTS, "{text}");
        let time = self.clock.unix_milliseconds();
        self.leave_to_keeper(Chore::Journal(vec![JournalRow { sequence: 0, time, job: None, worker: None, text }]));
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
            if let Notice::State { job, state, .. } = notice
                && !lock(&self.webhooks).is_empty()
            {
                self.leave_to_keeper(Chore::Announce { job: *job, state: *state });
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

    /// Another coordinator leads: nothing that this one says counts any more.
    pub(super) fn depose(&self) {
        if !self.deposed.is_cancelled() {
            tracing::error!(target: EVENTS, "another coordinator leads; this one stops");
            self.lock().is_closed = true;
            self.deposed.cancel();
        }
    }

    /// Hands something to the keeper.
    pub(super) fn leave_to_keeper(&self, chore: Chore) {
        // Without a keeper the coordinator is ending.
        let _ = self.chores.send(chore);
    }
}
