//! The workers, and how far each can be trusted for now.

use std::collections::BTreeMap;
use std::time::Duration;

use super::lease::WorkIndex;
use crate::farm::ids::{JobId, WorkerId};

/// Failures in a row after which a worker is set aside.
const FAILURES_BEFORE_PAUSE: u32 = 3;
/// The first pause; it doubles every time.
const FIRST_PAUSE: Duration = Duration::from_secs(5);
/// Doublings after which pauses stay the same (5 s · 2⁶ ≈ 5 min).
const PAUSE_DOUBLINGS: u32 = 6;
/// How long a worker is set aside that returned wrong bits.
pub(crate) const WRONG_BITS_PAUSE: Duration = Duration::from_secs(3600);

/// For how long no work is given, and why.
#[derive(Clone, Debug, PartialEq)]
struct Pause {
    until: Duration,
    reason: String,
}

/// Failures in a row, and the pauses that came of them.
#[derive(Clone, Debug, Default, PartialEq)]
struct Trust {
    failures_in_row: u32,
    pauses: u32,
    pause: Option<Pause>,
}

impl Trust {
    fn set_aside(&self, now: Duration) -> Option<&str> {
        self.pause.as_ref().filter(|pause| now < pause.until).map(|pause| pause.reason.as_str())
    }

    /// Answers the pause if this failure begins one.
    fn failed(&mut self, now: Duration, problem: &str) -> Option<Duration> {
        self.failures_in_row += 1;
        if self.failures_in_row < FAILURES_BEFORE_PAUSE {
            return None;
        }
        let length = FIRST_PAUSE * (1 << self.pauses.min(PAUSE_DOUBLINGS));
        let reason = format!("{} results in a row failed; the last: {problem}", self.failures_in_row);
        self.pause = Some(Pause { until: now + length, reason });
        self.pauses += 1;
        // The first failure after a pause begins the next one.
        self.failures_in_row = FAILURES_BEFORE_PAUSE - 1;
        Some(length)
    }
}

/// Work that a worker could not do, or whose result was no good.
#[derive(Clone, Debug, PartialEq)]
pub struct LastError {
    /// The job.
    pub job: JobId,
    /// What was traced.
    pub work: WorkIndex,
    /// What was wrong.
    pub problem: String,
    /// When; time since start.
    pub at: Duration,
}

/// What the rules know of a worker.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkerRecord {
    /// The name it gave itself.
    pub name: String,
    /// Its rendering threads.
    pub threads: u32,
    /// When it was last heard of.
    pub last_heard: Duration,
    /// Results of its that were taken.
    pub shards_done: u64,
    /// Whether its silence was logged.
    pub is_silent: bool,
    /// Whether it gets no further work and leaves when it has done what it holds.
    pub is_draining: bool,
    /// What went wrong last.
    pub last_error: Option<LastError>,
    /// The job of the last shard that it was given.
    pub last_job: Option<JobId>,
    farm: Trust,
    jobs: BTreeMap<JobId, Trust>,
}

impl WorkerRecord {
    /// Why it gets no work at all at `now`.
    pub fn set_aside(&self, now: Duration) -> Option<&str> {
        self.farm.set_aside(now)
    }

    /// Whether it gets no work of `job` at `now`.
    pub fn is_set_aside_for(&self, job: JobId, now: Duration) -> bool {
        self.jobs.get(&job).is_some_and(|trust| trust.set_aside(now).is_some())
    }

    /// Whether it was heard of within `silence` and may take work of `job` at `now`.
    fn takes(&self, job: JobId, now: Duration, silence: Duration) -> bool {
        self.takes_any(now, silence) && !self.is_set_aside_for(job, now)
    }

    /// The same of work of any job.
    fn takes_any(&self, now: Duration, silence: Duration) -> bool {
        now.saturating_sub(self.last_heard) < silence && !self.is_draining && self.set_aside(now).is_none()
    }

    /// A result was taken: it is trusted again.
    pub fn succeeded(&mut self, job: JobId) {
        self.shards_done += 1;
        self.farm = Trust::default();
        self.jobs.remove(&job);
    }

    /// A result was refused. Answers the pause if this begins one.
    pub fn refused(&mut self, now: Duration, problem: &str) -> Option<Duration> {
        self.farm.failed(now, problem)
    }

    /// The worker reported that it cannot do some work of `job`. Answers the pause for that job if this begins one.
    pub fn failed(&mut self, job: JobId, now: Duration, problem: &str) -> Option<Duration> {
        self.jobs.entry(job).or_default().failed(now, problem)
    }
}

/// All registered workers.
#[derive(Debug, Default)]
pub struct Roster {
    workers: BTreeMap<WorkerId, WorkerRecord>,
    /// Trust in workers that are gone, by name: one that was set aside does not get away by registering anew.
    former: BTreeMap<String, Trust>,
    next_id: WorkerId,
}

impl Roster {
    /// An empty roster whose ids start at `first_id`.
    pub fn new(first_id: u64) -> Self {
        Self { next_id: WorkerId::new(first_id), ..Self::default() }
    }

    /// Adds a worker; answers its id.
    pub fn join(&mut self, now: Duration, name: &str, threads: u32) -> WorkerId {
        let id = self.next_id;
        self.next_id = id.next();
        let record = WorkerRecord {
            name: name.to_owned(),
            threads,
            last_heard: now,
            shards_done: 0,
            is_silent: false,
            is_draining: false,
            last_error: None,
            last_job: None,
            farm: self.former.remove(name).unwrap_or_default(),
            jobs: BTreeMap::new(),
        };
        self.workers.insert(id, record);
        id
    }

    /// The worker, with `now` recorded as the last time it was heard of.
    pub fn record_contact(&mut self, id: WorkerId, now: Duration) -> Option<&mut WorkerRecord> {
        let worker = self.workers.get_mut(&id)?;
        worker.last_heard = worker.last_heard.max(now);
        worker.is_silent = false;
        Some(worker)
    }

    /// The worker.
    pub fn get(&self, id: WorkerId) -> Option<&WorkerRecord> {
        self.workers.get(&id)
    }

    /// The worker.
    pub fn get_mut(&mut self, id: WorkerId) -> Option<&mut WorkerRecord> {
        self.workers.get_mut(&id)
    }

    /// The worker's name.
    pub fn name(&self, id: WorkerId) -> String {
        self.workers.get(&id).map_or_else(|| format!("number {id}"), |worker| worker.name.clone())
    }

    /// Forgets a worker.
    pub fn remove(&mut self, now: Duration, id: WorkerId) -> Option<WorkerRecord> {
        let worker = self.workers.remove(&id)?;
        self.former.retain(|_, trust| trust.set_aside(now).is_some());
        if worker.set_aside(now).is_some() {
            self.former.insert(worker.name.clone(), worker.farm.clone());
        }
        Some(worker)
    }

    /// The workers of this name returned other bits than two others, also those that are gone; answers who of them is there.
    pub fn distrust(&mut self, now: Duration, name: &str, reason: &str) -> Vec<WorkerId> {
        let pause = Some(Pause { until: now + WRONG_BITS_PAUSE, reason: reason.to_owned() });
        self.former.insert(name.to_owned(), Trust { pause: pause.clone(), ..Trust::default() });
        let found = self.workers.iter_mut().filter(|(_, worker)| worker.name == name);
        found.map(|(id, worker)| (worker.farm.pause.clone_from(&pause), *id).1).collect()
    }

    /// All workers with their ids.
    pub fn iter(&self) -> impl Iterator<Item = (WorkerId, &WorkerRecord)> {
        self.workers.iter().map(|(id, worker)| (*id, worker))
    }

    /// The names of workers that were heard of within `silence` and may take work of `job` at `now`.
    pub fn takers(&self, job: JobId, now: Duration, silence: Duration) -> Vec<&str> {
        let takers = self.workers.values().filter(|worker| worker.takes(job, now, silence));
        takers.map(|worker| worker.name.as_str()).collect()
    }

    /// Whether a worker other than `id` is one of [`Self::takers`].
    pub fn has_other(&self, id: WorkerId, job: JobId, now: Duration, silence: Duration) -> bool {
        self.iter().any(|(other, worker)| other != id && worker.takes(job, now, silence))
    }

    /// Workers not heard of for `silence`.
    pub fn silent(&self, now: Duration, silence: Duration) -> Vec<WorkerId> {
        let is_silent = |worker: &WorkerRecord| now.saturating_sub(worker.last_heard) >= silence;
        self.workers.iter().filter(|(_, worker)| is_silent(worker)).map(|(id, _)| *id).collect()
    }

    /// Whether nobody was heard of for `silence` who may take work.
    pub fn is_deserted(&self, now: Duration, silence: Duration) -> bool {
        !self.workers.values().any(|worker| worker.takes_any(now, silence))
    }

    /// Counts `time` in which nobody could be heard as if it had not passed.
    pub fn postpone(&mut self, time: Duration) {
        self.workers.values_mut().for_each(|worker| worker.last_heard += time);
    }

    /// A job is forgotten: so is who failed at it.
    pub fn forget_job(&mut self, job: JobId) {
        self.workers.values_mut().for_each(|worker| drop(worker.jobs.remove(&job)));
    }

    /// How many workers are registered.
    pub fn count(&self) -> usize {
        self.workers.len()
    }
}
