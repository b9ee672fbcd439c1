//! The workers, and how far each can be trusted for now.

use std::collections::BTreeMap;
use std::time::Duration;

/// Failures in a row after which a worker is set aside.
const FAILURES_BEFORE_PAUSE: u32 = 3;
/// The first pause; it doubles every time.
const FIRST_PAUSE: Duration = Duration::from_secs(5);
/// Doublings after which pauses stay the same (5 s · 2⁶ ≈ 5 min).
const PAUSE_DOUBLINGS: u32 = 6;

/// What the schedule knows of a worker.
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
    failures_in_row: u32,
    pauses: u32,
    pause: Option<(Duration, String)>,
}

impl WorkerRecord {
    /// Why it gets no work at `now`.
    pub fn set_aside(&self, now: Duration) -> Option<&str> {
        self.pause.as_ref().filter(|(until, _)| now < *until).map(|(_, reason)| reason.as_str())
    }

    /// A result was taken: it is trusted again.
    pub fn succeeded(&mut self) {
        self.shards_done += 1;
        self.failures_in_row = 0;
        self.pauses = 0;
    }

    /// A result was refused or the worker reported a failure. Answers the pause if this begins one.
    pub fn failed(&mut self, now: Duration, problem: &str) -> Option<Duration> {
        self.failures_in_row += 1;
        if self.failures_in_row < FAILURES_BEFORE_PAUSE {
            return None;
        }
        let pause = FIRST_PAUSE * (1 << self.pauses.min(PAUSE_DOUBLINGS));
        let reason = format!("{} results in a row failed; the last: {problem}", self.failures_in_row);
        self.pause = Some((now + pause, reason));
        self.pauses += 1;
        // The first failure after a pause begins the next one.
        self.failures_in_row = FAILURES_BEFORE_PAUSE - 1;
        Some(pause)
    }
}

/// All registered workers.
#[derive(Debug, Default)]
pub struct Roster {
    workers: BTreeMap<u64, WorkerRecord>,
    next_id: u64,
}

impl Roster {
    /// An empty roster whose ids start at `first_id`.
    pub fn new(first_id: u64) -> Self {
        Self { next_id: first_id, ..Self::default() }
    }

    /// Adds a worker; answers its id.
    pub fn register(&mut self, now: Duration, name: &str, threads: u32) -> u64 {
        let id = self.next_id;
        self.next_id += 1;
        let record = WorkerRecord {
            name: name.to_owned(),
            threads,
            last_heard: now,
            shards_done: 0,
            failures_in_row: 0,
            pauses: 0,
            pause: None,
        };
        self.workers.insert(id, record);
        id
    }

    /// The worker, with `now` noted as the last time it was heard of.
    pub fn hear(&mut self, id: u64, now: Duration) -> Option<&mut WorkerRecord> {
        let worker = self.workers.get_mut(&id)?;
        worker.last_heard = worker.last_heard.max(now);
        Some(worker)
    }

    /// The worker.
    pub fn get_mut(&mut self, id: u64) -> Option<&mut WorkerRecord> {
        self.workers.get_mut(&id)
    }

    /// Forgets a worker.
    pub fn remove(&mut self, id: u64) -> Option<WorkerRecord> {
        self.workers.remove(&id)
    }

    /// All workers with their ids.
    pub fn iter(&self) -> impl Iterator<Item = (u64, &WorkerRecord)> {
        self.workers.iter().map(|(id, worker)| (*id, worker))
    }

    /// Whether a worker other than `id` may take work at `now`.
    pub fn has_other(&self, id: u64, now: Duration) -> bool {
        self.workers.iter().any(|(other, worker)| *other != id && worker.set_aside(now).is_none())
    }

    /// Workers not heard of for `silence`.
    pub fn silent(&self, now: Duration, silence: Duration) -> Vec<u64> {
        let is_silent = |worker: &WorkerRecord| now.saturating_sub(worker.last_heard) >= silence;
        self.workers.iter().filter(|(_, worker)| is_silent(worker)).map(|(id, _)| *id).collect()
    }

    /// How many workers are registered.
    pub fn count(&self) -> usize {
        self.workers.len()
    }
}
