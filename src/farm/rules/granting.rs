//! Which work a worker gets.
//!
//! **Fair shares.** Every grant adds its nominal cost over the job's priority to what the job was served; among the jobs with work for
//! a worker the one that was served least is next, the oldest of equals. A job that comes or comes back begins at what the others
//! were served, a little credit aside, so it neither waits for them nor makes them wait. So any shard that can be issued is issued after a bounded
//! number of grants, whatever else runs.
//!
//! **Memory.** A job's state exists from its pilot on. A job whose state does not fit beside the running ones' waits, and so do jobs
//! after it: the large one's turn comes. Tallies that came before their turn take memory, too: while those of all jobs take more than they may, a
//! job that has more than its share of them gets its next shard only once everything before that is merged.
//!
//! **Staying.** A worker keeps the scenes, fields and renderers of a few jobs. Where more jobs run, it stays with the job of its last shard until
//! that one is two shards ahead of the job whose turn it is.
//!
//! **Prefetching.** A worker asks for its next shard while it traces one. Where all that is left of the running jobs are a few last
//! shards, these are kept for workers that hold nothing.

use std::time::Duration;

use super::job::{Job, LEASE_COST, UNKNOWN_COST};
use super::lease::{Errand, Lease, Work, WorkIndex};
use super::plan::Plan;
use super::{Answer, Rules};
use crate::farm::ids::{Fencing, JobId, LeaseId, WorkerId};
use crate::farm::job::Priority;

/// One lease being traced, one prefetched, one on its way back.
const LEASES_PER_WORKER: usize = 3;
/// A shard is overdue after this many times its typical duration, for a worker that holds nothing …
const OVERDUE_FOR_IDLE: u32 = 2;
/// … for one that has other work …
const OVERDUE_FOR_BUSY: u32 = 6;
/// … but not before.
const OVERDUE_LEAST: Duration = Duration::from_millis(500);
/// What a job that could not take its share may catch up at most, nominal microseconds at the default priority.
const CREDIT: u64 = 1_000_000;
/// Jobs that a worker's caches hold: where no more run, nothing is won by staying with one.
const CACHED_JOBS: usize = 2;
/// Shards that the job with which a worker stays may be ahead.
const SHARDS_AHEAD: u64 = 2;
/// Passes that a pilot takes as long as.
const PILOT_PASSES: u64 = 3;

/// Memory for jobs that have not begun, given in the order of their arrival: whoever comes later must not take what an earlier one waits for.
struct Admission {
    /// Bytes; `None` for any number.
    free: Option<u64>,
}

impl Admission {
    /// Whether a job may begin, or has begun. Must be asked for all jobs before, too.
    fn admits(&mut self, job: &Job) -> bool {
        if job.is_admitted || job.terms.chooses_method {
            return true;
        }
        let fits = self.free.is_none_or(|free| job.terms.memory <= free);
        self.free = self.free.map(|free| if fits { free - job.terms.memory } else { 0 });
        fits
    }
}

/// Who asks for work, and what that depends on.
#[derive(Clone, Copy)]
struct Asker {
    worker: WorkerId,
    /// Leases that the worker holds.
    held: usize,
    /// The job to stay with.
    stays_with: Option<JobId>,
    /// Bytes of tallies that one job may have early: all that is left, or its share of what all may have.
    early_share: u64,
}

/// Work that a worker may be given.
struct Candidate {
    job: JobId,
    work: Work,
    served: u64,
    /// What the job was served, or less for a job to stay with: the smallest is next.
    rank: u64,
    /// One of the last shards of its job.
    is_scarce: bool,
}

impl Rules {
    /// A worker asks for work.
    pub(super) fn grant(&mut self, now: Duration, worker: WorkerId) -> Answer {
        if !self.record_contact(now, worker) {
            return Answer::UnknownWorker;
        }
        if self.is_draining {
            return Answer::Draining;
        }
        let held = self.leases.of_worker(worker).count();
        let record = self.roster.get(worker);
        if record.is_some_and(|record| record.is_draining) {
            return if held == 0 { Answer::Leave } else { Answer::NoWork };
        }
        let is_set_aside = record.is_some_and(|record| record.set_aside(now).is_some());
        if is_set_aside || held >= LEASES_PER_WORKER {
            return Answer::NoWork;
        }
        if let Some((job, errand)) = self.next_errand() {
            return self.issue(now, worker, job, Work::Errand(errand), Fencing::default());
        }
        let asker = self.asker(worker, held);
        let Some((turn, Candidate { job, work, served, .. })) = self.choose(now, asker) else { return Answer::NoWork };
        self.served = self.served.max(turn);
        let Some(granted) = self.jobs.get_mut(&job) else { return Answer::NoWork };
        granted.served = served.saturating_add(share(granted.cost(&work), granted.terms.priority));
        let fencing = granted.issue(&work, now);
        if let Some(record) = self.roster.get_mut(worker) {
            record.last_job = Some(job);
        }
        self.issue(now, worker, job, work, fencing)
    }

    fn issue(&mut self, now: Duration, worker: WorkerId, job: JobId, work: Work, fencing: Fencing) -> Answer {
        self.pending.changed.insert(job);
        let deadline = now + self.options.lease_duration;
        let lease = Lease { id: LeaseId::default(), job, worker, work, fencing, issued: now, deadline };
        Answer::Granted(self.leases.issue(lease))
    }

    /// The oldest job's errand that nobody runs.
    fn next_errand(&self) -> Option<(JobId, Errand)> {
        let is_free =
            |(job, errand): &(JobId, Errand)| self.leases.of_work(*job, WorkIndex::Errand(*errand)).next().is_none();
        self.errands.keys().copied().find(is_free)
    }

    fn asker(&self, worker: WorkerId, held: usize) -> Asker {
        let mut running = self.jobs.values().filter(|job| job.takes_workers());
        let last_job = self.roster.get(worker).and_then(|record| record.last_job);
        let stays_with = last_job.filter(|_| running.nth(CACHED_JOBS).is_some());
        let early = self.jobs.values().map(|job| job.totals.early_bytes).fold(0, u64::saturating_add);
        let budget = self.options.early_budget;
        // Nobody's early tallies hold up the jobs of others.
        let live = self.jobs.values().filter(|job| !job.has_ended()).count().max(1) as u64;
        Asker { worker, held, stays_with, early_share: if early < budget { u64::MAX } else { budget / live } }
    }

    /// The work of the job whose turn it is, or of the one to stay with; before it, what the job whose turn it is was served.
    fn choose(&self, now: Duration, asker: Asker) -> Option<(u64, Candidate)> {
        let mut admission = self.admission();
        let mut best: Option<Candidate> = None;
        let (mut all_scarce, mut turn) = (true, u64::MAX);
        for (id, job) in self.jobs.iter().filter(|(_, job)| job.takes_workers()) {
            if !admission.admits(job) {
                continue;
            }
            let Some(candidate) = self.candidate(now, asker, *id, job) else { continue };
            all_scarce &= candidate.is_scarce;
            turn = turn.min(candidate.served);
            if best.as_ref().is_none_or(|best| candidate.rank < best.rank) {
                best = Some(candidate);
            }
        }
        best.filter(|_| asker.held == 0 || !all_scarce).map(|best| (turn, best))
    }

    /// What is left beside the jobs that run. All is free when nothing runs: a job that needs more than all would else wait for ever.
    fn admission(&self) -> Admission {
        let mut running = self.jobs.values().filter(|job| job.is_admitted && !job.has_ended()).peekable();
        if running.peek().is_none() {
            return Admission { free: None };
        }
        let used = running.map(|job| job.terms.memory).fold(0, u64::saturating_add);
        Admission { free: Some(self.options.memory_budget.saturating_sub(used)) }
    }

    /// Whether a job cannot begin because others use the memory that it needs.
    pub fn waits_for_memory(&self, id: JobId) -> bool {
        // Statuses are told at every event: only for who waits are those before it counted.
        if self.jobs.get(&id).is_none_or(|job| job.is_admitted) {
            return false;
        }
        let mut admission = self.admission();
        let waiting = self.jobs.range(..=id).filter(|(_, job)| job.takes_workers());
        waiting.map(|(other, job)| (*other, admission.admits(job))).last() == Some((id, false))
    }

    fn candidate(&self, now: Duration, asker: Asker, id: JobId, job: &Job) -> Option<Candidate> {
        let Asker { worker, held, .. } = asker;
        if self.roster.get(worker).is_some_and(|record| record.is_set_aside_for(id, now)) {
            return None;
        }
        let is_held = |shard| self.leases.of_work(id, WorkIndex::Check(shard)).next().is_some();
        let name = self.roster.get(worker).map_or("", |record| &record.name);
        let check = job.checks.next_for(name, is_held).and_then(|shard| job.work(WorkIndex::Check(shard)));
        let has_others = || self.roster.has_other(worker, id, now, self.options.lease_duration);
        let fresh = || job.next_work(worker, has_others, job.totals.early_bytes < asker.early_share);
        let work = check.or_else(fresh).or_else(|| self.overdue_work(now, worker, held, id, job))?;
        let is_scarce = job.unissued() <= self.roster.count() as u64;
        let served = job.served.max(self.served.saturating_sub(CREDIT));
        let lead = if asker.stays_with == Some(id) {
            SHARDS_AHEAD.saturating_mul(share(job.cost(&work), job.terms.priority))
        } else {
            0
        };
        Some(Candidate { job: id, work, served, rank: served.saturating_sub(lead), is_scarce })
    }

    /// Work that another worker holds for too long; whoever delivers first wins.
    fn overdue_work(&self, now: Duration, worker: WorkerId, held: usize, id: JobId, job: &Job) -> Option<Work> {
        let factor = if held == 0 { OVERDUE_FOR_IDLE } else { OVERDUE_FOR_BUSY };
        let is_overdue = |lease: &&Lease| {
            let typical = job.typical_duration(&lease.work);
            let limit = typical.map(|typical| (typical * factor).max(OVERDUE_LEAST));
            limit.is_some_and(|limit| now.saturating_sub(lease.issued) > limit)
                && matches!(lease.work, Work::Shard(..))
                && lease.worker != worker
                && self.leases.of_work(id, lease.work.index()).count() == 1
        };
        self.leases.of_job(id).find(is_overdue).map(|lease| lease.work)
    }

    /// Records that a worker was heard of; answers whether it is known.
    pub(super) fn record_contact(&mut self, now: Duration, worker: WorkerId) -> bool {
        let was_silent = self.roster.get(worker).is_some_and(|record| record.is_silent);
        let is_known = self.roster.record_contact(worker, now).is_some();
        if was_silent {
            self.jobs.values_mut().for_each(|job| job.found_worker(worker));
            self.look_for_workers(now);
        }
        is_known
    }
}

impl Job {
    /// Whether workers may be given its work.
    pub(super) fn takes_workers(&self) -> bool {
        use crate::farm::job::JobState::{Choosing, Queued, Running};
        matches!(self.state, Queued | Choosing | Running) && !self.is_rolling_back
    }
}

/// What a job is served by work of this cost.
fn share(cost: u64, priority: Priority) -> u64 {
    (cost.saturating_mul(u64::from(Priority::DEFAULT.get())) / u64::from(priority.get())).max(1)
}

/// Charges a job for its pilot, now that one knows what it cost.
pub(super) fn charge_pilot(job: &mut Job, plan: &Plan) {
    let priority = job.terms.priority;
    let before = job.served.saturating_sub(share(UNKNOWN_COST, priority));
    let cost = plan.cost_per_pass.saturating_mul(PILOT_PASSES * plan.regions.len() as u64).max(LEASE_COST);
    job.served = before + share(cost, priority);
}
