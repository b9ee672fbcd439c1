//! Who traces what: a state machine without clock, locks, tasks or I/O.
//!
//! Events come in as method calls with the time since start; answers and [`Schedule::take_changed`] go out. The
//! [coordinator](crate::farm::coordinator) is the adapter round it. So thousands of fault schedules run in a test in seconds.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use super::lease::{Closed, Lease, LeaseTable, Work};
use super::plan::Plan;
use super::progress::{JobProgress, MergedTotals};
use super::roster::Roster;
use crate::farm::job::{JobState, StopRule};

/// A worker is forgotten after being silent for this many lease durations.
const SILENT_LEASES: u32 = 4;
/// A shard is overdue after this many times its typical duration …
const OVERDUE_FACTOR: u32 = 2;
/// … but not before.
const OVERDUE_LEAST: Duration = Duration::from_millis(500);
/// One lease being traced, one prefetched, one on its way back.
const LEASES_PER_WORKER: usize = 3;

/// What a worker that asks for work is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseAnswer {
    /// Do this.
    Granted(Lease),
    /// There is nothing to do now.
    Nothing,
    /// The coordinator is shutting down.
    Drain,
    /// Register first.
    UnknownWorker,
}

/// What a heartbeat brings back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeartbeatAnswer {
    /// Leases of no use any more.
    pub cancelled: Vec<u64>,
    /// The coordinator is shutting down.
    pub drain: bool,
}

/// What became of leased work, as judged by the adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// A result that fits the work.
    Accepted,
    /// A result that does not.
    Refused(String),
    /// The worker's own error message.
    Failed(String),
}

/// What is to be done with a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultAnswer {
    /// Merge it when its turn comes; it will not be asked for again.
    Take(Lease),
    /// It is there already: nothing to do.
    AlreadyMerged,
    /// The lease is not the worker's any more.
    Fenced,
    /// The failure is noted and the work leased to others.
    Noted,
}

/// The state machine.
#[derive(Debug)]
pub struct Schedule {
    lease_duration: Duration,
    jobs: BTreeMap<u64, JobProgress>,
    rotation: VecDeque<u64>,
    roster: Roster,
    leases: LeaseTable,
    changed: BTreeSet<u64>,
    draining: bool,
}

impl Schedule {
    /// A schedule without jobs. Ids of workers and leases start at `first_id`, so that those of an earlier coordinator
    /// are not mistaken for its own.
    pub fn new(lease_duration: Duration, first_id: u64) -> Self {
        Self {
            lease_duration,
            jobs: BTreeMap::new(),
            rotation: VecDeque::new(),
            roster: Roster::new(first_id),
            leases: LeaseTable::new(first_id),
            changed: BTreeSet::new(),
            draining: false,
        }
    }

    /// Queues a job under a number not used before.
    pub fn add_job(&mut self, number: u64, stop: StopRule, notices: Vec<String>) {
        self.jobs.insert(number, JobProgress::new(stop, notices));
        self.rotation.push_back(number);
        self.changed.insert(number);
    }

    /// How a job is doing.
    pub fn job(&self, number: u64) -> Option<&JobProgress> {
        self.jobs.get(&number)
    }

    /// The workers.
    pub fn roster(&self) -> &Roster {
        &self.roster
    }

    /// The leases.
    pub fn leases(&self) -> &LeaseTable {
        &self.leases
    }

    /// Jobs that changed since the last call.
    pub fn take_changed(&mut self) -> BTreeSet<u64> {
        std::mem::take(&mut self.changed)
    }

    /// From now on nothing is leased.
    pub fn drain(&mut self) {
        self.draining = true;
    }

    /// A worker joins; answers its id.
    pub fn register(&mut self, now: Duration, name: &str, threads: u32) -> u64 {
        self.roster.register(now, name, threads)
    }

    /// A worker asks for work.
    pub fn lease(&mut self, now: Duration, worker: u64) -> LeaseAnswer {
        self.expire(now);
        let Some(record) = self.roster.hear(worker, now) else { return LeaseAnswer::UnknownWorker };
        if self.draining {
            return LeaseAnswer::Drain;
        }
        let held = self.leases.of_worker(worker).count();
        if record.set_aside(now).is_some() || held >= LEASES_PER_WORKER {
            return LeaseAnswer::Nothing;
        }
        match self.fresh_work(now, worker, held).or_else(|| self.overdue_work(now, held)) {
            Some((job, work)) => LeaseAnswer::Granted(self.grant(now, worker, job, work)),
            None => LeaseAnswer::Nothing,
        }
    }

    /// Work that nobody holds, of the job whose turn it is.
    fn fresh_work(&self, now: Duration, worker: u64, held: usize) -> Option<(u64, Work)> {
        let others = self.roster.has_other(worker, now);
        self.rotation.iter().find_map(|number| {
            let job = &self.jobs[number];
            let work = job.next_work(worker, others)?;
            // The last shards are left to idle workers instead of being prefetched by busy ones.
            let is_scarce = job.unissued() <= self.roster.count() as u64;
            (held == 0 || !is_scarce).then_some((*number, work))
        })
    }

    /// Work that another worker holds for too long; whoever delivers first wins.
    fn overdue_work(&self, now: Duration, held: usize) -> Option<(u64, Work)> {
        if held > 0 {
            return None;
        }
        let is_overdue = |job: &JobProgress, lease: &Lease| {
            let typical = job.typical_duration(&lease.work);
            let limit = typical.map(|typical| (typical * OVERDUE_FACTOR).max(OVERDUE_LEAST));
            limit.is_some_and(|limit| now.saturating_sub(lease.issued) > limit)
        };
        self.rotation.iter().find_map(|number| {
            let overdue = self.leases.of_job(*number).find(|lease| {
                is_overdue(&self.jobs[number], lease) && self.leases.of_work(*number, lease.work.index()).count() == 1
            })?;
            Some((*number, overdue.work))
        })
    }

    fn grant(&mut self, now: Duration, worker: u64, number: u64, work: Work) -> Lease {
        self.rotation.retain(|other| *other != number);
        self.rotation.push_back(number);
        self.changed.insert(number);
        let fencing = self.jobs.get_mut(&number).map_or(0, |job| job.issue(&work, now));
        let deadline = now + self.lease_duration;
        self.leases.issue(Lease { id: 0, job: number, worker, work, fencing, issued: now, deadline })
    }

    /// A worker says that it still works on `leases`. `None`: register first.
    pub fn heartbeat(&mut self, now: Duration, worker: u64, leases: &[u64]) -> Option<HeartbeatAnswer> {
        self.roster.hear(worker, now)?;
        let is_mine = |schedule: &Self, id| schedule.leases.get(id).is_some_and(|lease| lease.worker == worker);
        let (kept, cancelled): (Vec<u64>, Vec<u64>) = leases.iter().partition(|id| is_mine(self, **id));
        for id in kept {
            self.leases.extend(id, now + self.lease_duration);
        }
        self.expire(now);
        Some(HeartbeatAnswer { cancelled, drain: self.draining })
    }

    /// A worker gives leases back.
    pub fn release(&mut self, now: Duration, worker: u64, leases: &[u64]) {
        self.roster.hear(worker, now);
        for id in leases {
            if self.leases.get(*id).is_some_and(|lease| lease.worker == worker) {
                self.fence(*id);
            }
        }
    }

    /// A worker leaves; its leases go to others.
    pub fn worker_gone(&mut self, worker: u64) {
        let held: Vec<u64> = self.leases.of_worker(worker).map(|lease| lease.id).collect();
        for id in held {
            self.fence(id);
        }
        self.roster.remove(worker);
    }

    /// A worker delivers. After [`ResultAnswer::Take`] the adapter reports with [`pilot_done`](Self::pilot_done) or
    /// [`merged`](Self::merged), or ends the job with [`fail`](Self::fail).
    pub fn result(&mut self, now: Duration, worker: u64, id: u64, fencing: u64, outcome: &Outcome) -> ResultAnswer {
        self.roster.hear(worker, now);
        let lease = match self.leases.get(id) {
            Some(lease) if lease.worker == worker && lease.fencing == fencing => *lease,
            Some(_) => return ResultAnswer::Fenced,
            None => {
                return match self.leases.closed(id) {
                    Some(Closed::Delivered | Closed::Superseded) => ResultAnswer::AlreadyMerged,
                    Some(Closed::Fenced | Closed::JobEnded) | None => ResultAnswer::Fenced,
                };
            }
        };
        match outcome {
            Outcome::Accepted => self.take(now, lease),
            Outcome::Refused(problem) => self.note_failure(now, lease, problem, false),
            Outcome::Failed(problem) => self.note_failure(now, lease, problem, true),
        }
    }

    fn take(&mut self, now: Duration, lease: Lease) -> ResultAnswer {
        self.leases.close(lease.id, Closed::Delivered);
        let others: Vec<u64> = self.leases.of_work(lease.job, lease.work.index()).map(|other| other.id).collect();
        for other in others {
            self.leases.close(other, Closed::Superseded);
        }
        if let Some(worker) = self.roster.get_mut(lease.worker) {
            worker.succeeded();
        }
        if let Some(job) = self.jobs.get_mut(&lease.job) {
            job.arrive(&lease.work, now.saturating_sub(lease.issued));
        }
        self.changed.insert(lease.job);
        ResultAnswer::Take(lease)
    }

    fn note_failure(&mut self, now: Duration, lease: Lease, problem: &str, ends_job: bool) -> ResultAnswer {
        tracing::warn!(job = lease.job, worker = lease.worker, problem, "a worker's result is no good");
        if let Some(pause) = self.roster.get_mut(lease.worker).and_then(|worker| worker.failed(now, problem)) {
            tracing::warn!(worker = lease.worker, seconds = pause.as_secs(), "worker is set aside");
        }
        if let Some(job) = self.jobs.get_mut(&lease.job).filter(|_| ends_job) {
            job.fail_work(lease.work.index(), lease.worker, problem, now);
        }
        self.fence(lease.id);
        self.settle(lease.job);
        ResultAnswer::Noted
    }

    /// The pilot's result was turned into a plan.
    pub fn pilot_done(&mut self, now: Duration, number: u64, plan: Plan) {
        if let Some(job) = self.jobs.get_mut(&number).filter(|job| !job.has_ended()) {
            job.pilot_done(plan, now);
            self.changed.insert(number);
        }
    }

    /// Shards were merged, in order; `totals` tells how far.
    pub fn merged(&mut self, now: Duration, number: u64, totals: MergedTotals) {
        if let Some(job) = self.jobs.get_mut(&number) {
            job.merged(totals, now);
        }
        self.settle(number);
    }

    /// Ends a job because it cannot go on.
    pub fn fail(&mut self, now: Duration, number: u64, problem: &str) {
        if let Some(job) = self.jobs.get_mut(&number).filter(|job| !job.has_ended()) {
            job.error = Some(problem.to_owned());
            job.end(JobState::Failed, now);
        }
        self.settle(number);
    }

    /// Ends a job because its user says so. An ended job stays as it is.
    pub fn cancel(&mut self, now: Duration, number: u64) {
        if let Some(job) = self.jobs.get_mut(&number).filter(|job| !job.has_ended()) {
            job.end(JobState::Cancelled, now);
        }
        self.settle(number);
    }

    /// Time passes: leases expire, seconds run out, silent workers are forgotten.
    pub fn tick(&mut self, now: Duration) {
        self.expire(now);
        for number in self.rotation.clone() {
            let Some(job) = self.jobs.get_mut(&number) else { continue };
            if job.seconds_run_out(now) {
                job.stop_by_seconds(now);
                self.settle(number);
            }
        }
        for worker in self.roster.silent(now, self.lease_duration * SILENT_LEASES) {
            tracing::info!(worker, "a silent worker is forgotten");
            self.worker_gone(worker);
        }
    }

    fn expire(&mut self, now: Duration) {
        let expired: Vec<Lease> = self.leases.active().filter(|lease| lease.deadline <= now).copied().collect();
        for lease in expired {
            tracing::info!(job = lease.job, lease = lease.id, worker = lease.worker, "a lease expired");
            self.fence(lease.id);
        }
    }

    /// Ends a lease whose work goes to someone else, unless a second lease of the same work lives.
    fn fence(&mut self, id: u64) {
        let Some(lease) = self.leases.close(id, Closed::Fenced) else { return };
        let is_held = self.leases.of_work(lease.job, lease.work.index()).next().is_some();
        if let Some(job) = self.jobs.get_mut(&lease.job).filter(|_| !is_held) {
            job.give_back(lease.work.index());
        }
        self.changed.insert(lease.job);
    }

    /// Ends leases of no use any more, after a job has changed its end or ended.
    fn settle(&mut self, number: u64) {
        self.changed.insert(number);
        let Some(job) = self.jobs.get(&number) else { return };
        let (ended, limit) = (job.has_ended(), job.limit());
        let has_plan = job.plan.is_some();
        let is_useless = |lease: &&Lease| ended || (has_plan && lease.work.index().is_some_and(|index| index >= limit));
        let useless: Vec<u64> = self.leases.of_job(number).filter(is_useless).map(|lease| lease.id).collect();
        for id in useless {
            self.leases.close(id, Closed::JobEnded);
        }
        if ended {
            self.rotation.retain(|other| *other != number);
        }
    }
}
