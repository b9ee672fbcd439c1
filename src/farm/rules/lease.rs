//! Leases: who may deliver what, and until when.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Duration;

use super::plan::PlannedShard;
use crate::farm::ids::{Fencing, JobId, LeaseId, WorkerId};

/// Closed leases that are remembered, so that a repeated result is told from a fenced one.
const CLOSED_KEPT: usize = 1 << 16;

/// Work for a job's scene rather than for its picture, done when somebody wants to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Errand {
    /// What the pixels see first.
    FirstSurfaces,
    /// How much of each pixel objects and materials cover.
    Mattes,
}

/// What a lease is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// Trials of several methods on a small picture, all by one worker: what they measure is only comparable on one machine.
    Choice,
    /// The job's first radii and cost.
    Pilot,
    /// The shard with this index in the job's plan.
    Shard(u64, PlannedShard),
    /// The same shard once more, to compare its bits.
    Check(u64, PlannedShard),
    /// Work for the job's scene.
    Errand(Errand),
}

/// The place of a piece of work in its job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WorkIndex {
    /// See [`Work::Choice`].
    Choice,
    /// See [`Work::Pilot`].
    Pilot,
    /// See [`Work::Shard`].
    Shard(u64),
    /// See [`Work::Check`].
    Check(u64),
    /// See [`Work::Errand`].
    Errand(Errand),
}

impl fmt::Display for WorkIndex {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Choice => out.write_str("trials"),
            Self::Pilot => out.write_str("pilot"),
            Self::Shard(index) => write!(out, "shard {index}"),
            Self::Check(index) => write!(out, "check of shard {index}"),
            Self::Errand(Errand::FirstSurfaces) => out.write_str("first surfaces"),
            Self::Errand(Errand::Mattes) => out.write_str("mattes"),
        }
    }
}

impl Work {
    /// Its place in the job.
    pub fn index(&self) -> WorkIndex {
        match self {
            Self::Choice => WorkIndex::Choice,
            Self::Pilot => WorkIndex::Pilot,
            Self::Shard(index, _) => WorkIndex::Shard(*index),
            Self::Check(index, _) => WorkIndex::Check(*index),
            Self::Errand(errand) => WorkIndex::Errand(*errand),
        }
    }

    /// Passes of the shard; `None` for work that is none.
    pub fn passes(&self) -> Option<u32> {
        match self {
            Self::Shard(_, planned) | Self::Check(_, planned) => Some(planned.shard.passes),
            Self::Choice | Self::Pilot | Self::Errand(_) => None,
        }
    }
}

/// A promise: this worker may deliver this work until the deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lease {
    /// Unique in a coordinator.
    pub id: LeaseId,
    /// The job.
    pub job: JobId,
    /// The worker.
    pub worker: WorkerId,
    /// What to do.
    pub work: Work,
    /// Rises every time the same work is leased.
    pub fencing: Fencing,
    /// When it was given.
    pub issued: Duration,
    /// When it expires unless a heartbeat comes.
    pub deadline: Duration,
}

/// Why a lease ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// Its result was taken.
    Delivered,
    /// Another lease's result for the same work was taken.
    Superseded,
    /// It expired, was given back or refused: the work belongs to others now.
    Fenced,
    /// The job ended without it.
    JobEnded,
}

/// A lease's place among those of the same work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct ByWork {
    job: JobId,
    work: WorkIndex,
    lease: LeaseId,
}

/// A lease's place among those of the same worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct ByWorker {
    worker: WorkerId,
    lease: LeaseId,
}

const FIRST: LeaseId = LeaseId::new(0);
const LAST: LeaseId = LeaseId::new(u64::MAX);

/// All leases, active ones in full.
#[derive(Debug, Default)]
pub struct LeaseTable {
    active: BTreeMap<LeaseId, Lease>,
    by_work: BTreeSet<ByWork>,
    by_worker: BTreeSet<ByWorker>,
    closed: BTreeMap<LeaseId, Closed>,
    next_id: LeaseId,
}

impl LeaseTable {
    /// An empty table whose ids start at `first_id`.
    pub fn new(first_id: u64) -> Self {
        Self { next_id: LeaseId::new(first_id), ..Self::default() }
    }

    /// Adds a lease under a new id; the given id is ignored.
    pub fn issue(&mut self, lease: Lease) -> Lease {
        let lease = Lease { id: self.next_id, ..lease };
        self.next_id = self.next_id.next();
        self.active.insert(lease.id, lease);
        self.by_work.insert(ByWork { job: lease.job, work: lease.work.index(), lease: lease.id });
        self.by_worker.insert(ByWorker { worker: lease.worker, lease: lease.id });
        lease
    }

    /// The lease, while it is active.
    pub fn get(&self, id: LeaseId) -> Option<&Lease> {
        self.active.get(&id)
    }

    /// Why a lease ended; `None` while it is active or when it is unknown or long forgotten.
    pub fn closed(&self, id: LeaseId) -> Option<Closed> {
        self.closed.get(&id).copied()
    }

    /// Ends a lease.
    pub fn close(&mut self, id: LeaseId, reason: Closed) -> Option<Lease> {
        let lease = self.active.remove(&id)?;
        self.by_work.remove(&ByWork { job: lease.job, work: lease.work.index(), lease: id });
        self.by_worker.remove(&ByWorker { worker: lease.worker, lease: id });
        self.closed.insert(id, reason);
        if self.closed.len() > CLOSED_KEPT {
            self.closed.pop_first();
        }
        Some(lease)
    }

    /// Moves the deadline.
    pub fn extend(&mut self, id: LeaseId, deadline: Duration) {
        if let Some(lease) = self.active.get_mut(&id) {
            lease.deadline = deadline;
        }
    }

    /// Moves every deadline by `time`, because nobody could be heard meanwhile.
    pub fn postpone(&mut self, time: Duration) {
        self.active.values_mut().for_each(|lease| lease.deadline += time);
    }

    /// Every active lease, oldest first.
    pub fn active(&self) -> impl Iterator<Item = &Lease> {
        self.active.values()
    }

    /// Active leases of one job in the order of its work.
    pub fn of_job(&self, job: JobId) -> impl Iterator<Item = &Lease> {
        let first = ByWork { job, work: WorkIndex::Choice, lease: FIRST };
        let last = ByWork { job, work: WorkIndex::Errand(Errand::Mattes), lease: LAST };
        self.by_work.range(first..=last).map(|place| &self.active[&place.lease])
    }

    /// Active leases of one piece of work.
    pub fn of_work(&self, job: JobId, work: WorkIndex) -> impl Iterator<Item = &Lease> {
        let (first, last) = (ByWork { job, work, lease: FIRST }, ByWork { job, work, lease: LAST });
        self.by_work.range(first..=last).map(|place| &self.active[&place.lease])
    }

    /// Active leases of one worker, oldest first.
    pub fn of_worker(&self, worker: WorkerId) -> impl Iterator<Item = &Lease> {
        let (first, last) = (ByWorker { worker, lease: FIRST }, ByWorker { worker, lease: LAST });
        self.by_worker.range(first..=last).map(|place| &self.active[&place.lease])
    }
}
