//! Leases: who may deliver what, and until when.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::plan::PlannedShard;

/// Closed leases that are remembered, so that a repeated result is told from a fenced one.
const CLOSED_KEPT: usize = 1 << 16;

/// What a lease is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// The job's first radii and cost.
    Pilot,
    /// The shard with this index in the job's plan.
    Shard(u64, PlannedShard),
}

/// The place of a piece of work in its job: the pilot (`None`) comes before every shard (`Some(index)`).
pub type WorkIndex = Option<u64>;

impl Work {
    /// Its place in the job.
    pub fn index(&self) -> WorkIndex {
        match self {
            Self::Pilot => None,
            Self::Shard(index, _) => Some(*index),
        }
    }

    /// What it costs relative to other work of the job: passes, or 1 for the pilot.
    pub fn passes(&self) -> u32 {
        match self {
            Self::Pilot => 1,
            Self::Shard(_, planned) => planned.shard.passes,
        }
    }
}

/// A promise: this worker may deliver this work until the deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lease {
    /// Unique in a coordinator.
    pub id: u64,
    /// The job.
    pub job: u64,
    /// The worker.
    pub worker: u64,
    /// What to do.
    pub work: Work,
    /// Rises every time the same work is leased.
    pub fencing: u64,
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

/// All leases, active ones in full.
#[derive(Debug, Default)]
pub struct LeaseTable {
    active: BTreeMap<u64, Lease>,
    by_work: BTreeSet<(u64, WorkIndex, u64)>,
    closed: BTreeMap<u64, Closed>,
    next_id: u64,
}

impl LeaseTable {
    /// An empty table whose ids start at `first_id`.
    pub fn new(first_id: u64) -> Self {
        Self { next_id: first_id, ..Self::default() }
    }

    /// Adds a lease under a new id; the given id is ignored.
    pub fn issue(&mut self, lease: Lease) -> Lease {
        let lease = Lease { id: self.next_id, ..lease };
        self.next_id += 1;
        self.active.insert(lease.id, lease);
        self.by_work.insert((lease.job, lease.work.index(), lease.id));
        lease
    }

    /// The lease, while it is active.
    pub fn get(&self, id: u64) -> Option<&Lease> {
        self.active.get(&id)
    }

    /// Why a lease ended; `None` while it is active or when it is unknown or long forgotten.
    pub fn closed(&self, id: u64) -> Option<Closed> {
        self.closed.get(&id).copied()
    }

    /// Ends a lease.
    pub fn close(&mut self, id: u64, reason: Closed) -> Option<Lease> {
        let lease = self.active.remove(&id)?;
        self.by_work.remove(&(lease.job, lease.work.index(), id));
        self.closed.insert(id, reason);
        if self.closed.len() > CLOSED_KEPT {
            self.closed.pop_first();
        }
        Some(lease)
    }

    /// Moves the deadline.
    pub fn extend(&mut self, id: u64, deadline: Duration) {
        if let Some(lease) = self.active.get_mut(&id) {
            lease.deadline = deadline;
        }
    }

    /// Every active lease, oldest first.
    pub fn active(&self) -> impl Iterator<Item = &Lease> {
        self.active.values()
    }

    /// Active leases of one job in the order of its work.
    pub fn of_job(&self, job: u64) -> impl Iterator<Item = &Lease> {
        self.by_work.range((job, None, 0)..=(job, Some(u64::MAX), u64::MAX)).map(|(_, _, id)| &self.active[id])
    }

    /// Active leases of one piece of work.
    pub fn of_work(&self, job: u64, work: WorkIndex) -> impl Iterator<Item = &Lease> {
        self.by_work.range((job, work, 0)..=(job, work, u64::MAX)).map(|(_, _, id)| &self.active[id])
    }

    /// Active leases of one worker.
    pub fn of_worker(&self, worker: u64) -> impl Iterator<Item = &Lease> {
        self.active.values().filter(move |lease| lease.worker == worker)
    }
}
