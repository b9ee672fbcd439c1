//! What happens to a farm, and what follows from it. Events are values: they can be logged, replayed, simulated and authorised.

use std::collections::BTreeSet;
use std::fmt;
use std::time::Duration;

use super::check::Digest;
use super::lease::{Errand, Lease, WorkIndex};
use super::plan::Plan;
use super::terms::{MergedTotals, PauseReason, Restored, Terms};
use crate::farm::ids::{Fencing, JobId, LeaseId, WorkerId};
use crate::farm::job::{JobState, Priority};

/// One thing that happens. [`Rules::apply`](super::Rules::apply) says what follows.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A job was accepted and stored.
    JobAdded {
        /// Its id, not used before.
        job: JobId,
        /// What was agreed.
        terms: Terms,
    },
    /// A stored job goes on: after a restart, because it was extended, or because part of it has to be done again.
    JobRestored {
        /// Its id.
        job: JobId,
        /// What was agreed.
        terms: Terms,
        /// How far it had come.
        restored: Box<Restored>,
    },
    /// The trials of a job whose method was `auto` are over; the adapter has stored the choice.
    MethodChosen {
        /// The job.
        job: JobId,
        /// Its terms with the method chosen.
        terms: Terms,
        /// Why, one sentence each.
        reasons: Vec<String>,
    },
    /// The pilot's result was turned into a plan.
    PilotDone {
        /// The job.
        job: JobId,
        /// How it is cut.
        plan: Plan,
    },
    /// Shards were merged, in order.
    Merged {
        /// The job.
        job: JobId,
        /// How far it has come.
        totals: MergedTotals,
    },
    /// A job cannot go on.
    JobFailed {
        /// The job.
        job: JobId,
        /// Why.
        problem: String,
    },
    /// A user stops a job for good. An ended job stays as it is.
    JobCancelled {
        /// The job.
        job: JobId,
    },
    /// A job stops for a while: nothing new is leased; what is being traced is still merged.
    JobPaused {
        /// The job.
        job: JobId,
        /// Why.
        reason: PauseReason,
    },
    /// A paused job goes on.
    JobResumed {
        /// The job.
        job: JobId,
    },
    /// A job gets another share of the farm.
    PriorityChanged {
        /// The job.
        job: JobId,
        /// Its new share.
        priority: Priority,
    },
    /// The adapter has stored an ended job, or its user deleted it: nothing more needs to be known of it.
    JobForgotten {
        /// The job.
        job: JobId,
    },
    /// A user deleted an ended job: nobody waits for anything of it.
    JobErased {
        /// The job.
        job: JobId,
    },
    /// Somebody wants to know something of a job's scene.
    ErrandWanted {
        /// A job with that scene, running or not.
        job: JobId,
        /// What is to be found out.
        errand: Errand,
    },
    /// A worker joins.
    WorkerJoined {
        /// The name it gave itself.
        name: String,
        /// Its rendering threads.
        threads: u32,
    },
    /// A worker asks for work.
    LeaseWanted {
        /// The worker.
        worker: WorkerId,
    },
    /// A worker says that it still works on `leases`.
    HeartbeatCame {
        /// The worker.
        worker: WorkerId,
        /// What it holds.
        leases: Vec<LeaseId>,
    },
    /// A worker gives leases back.
    LeasesReleased {
        /// The worker.
        worker: WorkerId,
        /// What it gives back.
        leases: Vec<LeaseId>,
    },
    /// A worker is to get no further work, and to leave when it has done what it holds.
    WorkerDrained {
        /// The worker.
        worker: WorkerId,
    },
    /// A worker leaves for good.
    WorkerLeft {
        /// The worker.
        worker: WorkerId,
    },
    /// A worker delivers. After [`Answer::Take`] the adapter reports with `PilotDone`, `Merged`, `MethodChosen` or `JobFailed`.
    ResultCame {
        /// The worker.
        worker: WorkerId,
        /// Its lease.
        lease: LeaseId,
        /// The lease's fencing number.
        fencing: Fencing,
        /// What it delivers, as the adapter judges it.
        outcome: Outcome,
    },
    /// Time passes: leases expire, seconds run out, silent workers are forgotten.
    TimePassed,
    /// From now on nothing is leased.
    DrainBegan,
}

/// Result of leased work, as the adapter judges it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// A result that fits the work. The digest is needed for shards that are [checked](super::Rules::wants_digest).
    Accepted(Option<Digest>),
    /// A result that does not.
    Refused(String),
    /// The worker's own error message.
    Failed(String),
}

/// What the one who brought an event is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The event has happened.
    Done,
    /// There is no such job, or it has ended and was forgotten.
    UnknownJob,
    /// The job's state does not allow it.
    NotPossible(JobState),
    /// The worker's id.
    Joined(WorkerId),
    /// Do this.
    Granted(Lease),
    /// There is nothing to do now.
    NoWork,
    /// The coordinator is shutting down.
    Draining,
    /// There will be nothing to do any more: leave.
    Leave,
    /// Register first.
    UnknownWorker,
    /// The heartbeat was received.
    Alive {
        /// Leases of no use any more.
        cancelled: Vec<LeaseId>,
    },
    /// Merge the result when its turn comes; it will not be asked for again.
    Take(Lease),
    /// The result was compared with another worker's; there is nothing to merge.
    Compared,
    /// It is there already: nothing to do.
    AlreadyMerged,
    /// The lease is not the worker's any more.
    Fenced,
    /// The failure is recorded and the work leased to others.
    Recorded,
}

/// What follows from an event.
#[derive(Clone, Debug, PartialEq)]
pub struct Effects {
    /// For the one who brought it.
    pub answer: Answer,
    /// Jobs whose status changed.
    pub changed: BTreeSet<JobId>,
    /// Jobs that ended by this event.
    pub ended: Vec<JobId>,
    /// Jobs of which part must be done again. Nothing of them is leased or taken until [`Event::JobRestored`].
    pub rollbacks: Vec<Rollback>,
    /// For logs and journals.
    pub notices: Vec<Notice>,
    /// Whether a worker that waits for work should ask again.
    pub work_appeared: bool,
}

/// What a job merged from some shard on is not to be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rollback {
    /// The job.
    pub job: JobId,
    /// Only states with at most so many merged shards can be kept; `None` when the pilot is in doubt, too.
    pub keep: Option<u64>,
}

/// Something that people who run a farm want to read in its log.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// A worker registered.
    Joined {
        /// The worker.
        worker: WorkerId,
        /// Its name.
        name: String,
        /// Its rendering threads.
        threads: u32,
    },
    /// A worker said that it leaves.
    Left {
        /// The worker.
        worker: WorkerId,
        /// Its name.
        name: String,
    },
    /// A worker has not been heard of for a lease duration.
    Silent {
        /// The worker.
        worker: WorkerId,
        /// Its name.
        name: String,
        /// Leases of its that expired.
        leases: usize,
    },
    /// A worker was silent for so long that it has to register anew.
    Forgotten {
        /// The worker.
        worker: WorkerId,
        /// Its name.
        name: String,
    },
    /// A worker gets no work for a while.
    SetAside {
        /// Its name.
        name: String,
        /// Of this job, or of any.
        job: Option<JobId>,
        /// For so long.
        pause: Duration,
        /// Why.
        reason: String,
    },
    /// A result was no good.
    BadResult {
        /// The worker's name.
        name: String,
        /// The job.
        job: JobId,
        /// What was traced.
        work: WorkIndex,
        /// What was wrong.
        problem: String,
    },
    /// Two workers returned different bits for the same shard.
    Mismatch {
        /// The job.
        job: JobId,
        /// The shard.
        shard: u64,
    },
    /// Two workers returned different bits for the same shard, and no third one came to decide.
    Disputed {
        /// The job.
        job: JobId,
        /// The shard.
        shard: u64,
    },
    /// A job is in another state than before.
    State {
        /// The job.
        job: JobId,
        /// The new state.
        state: JobState,
        /// Why, where there is something to say.
        reason: Option<String>,
    },
}

impl Notice {
    /// The job that it is about.
    pub fn job(&self) -> Option<JobId> {
        match self {
            Self::BadResult { job, .. }
            | Self::Mismatch { job, .. }
            | Self::Disputed { job, .. }
            | Self::State { job, .. } => Some(*job),
            Self::SetAside { job, .. } => *job,
            Self::Joined { .. } | Self::Left { .. } | Self::Silent { .. } | Self::Forgotten { .. } => None,
        }
    }

    /// The name of the worker that it is about.
    pub fn worker(&self) -> Option<&str> {
        match self {
            Self::Joined { name, .. }
            | Self::Left { name, .. }
            | Self::Silent { name, .. }
            | Self::Forgotten { name, .. }
            | Self::SetAside { name, .. }
            | Self::BadResult { name, .. } => Some(name),
            Self::Mismatch { .. } | Self::Disputed { .. } | Self::State { .. } => None,
        }
    }
}

impl fmt::Display for Notice {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joined { name, threads, .. } => {
                let plural = if *threads == 1 { "" } else { "s" };
                write!(out, "worker {name} joined with {threads} thread{plural}")
            }
            Self::Left { name, .. } => write!(out, "worker {name} left"),
            Self::Silent { name, leases, .. } => write!(out, "worker {name} is silent; {leases} of its leases expired"),
            Self::Forgotten { name, .. } => write!(out, "worker {name} is given up as lost"),
            Self::SetAside { name, job, pause, reason, .. } => {
                write!(out, "worker {name} gets no work ")?;
                job.map_or(Ok(()), |job| write!(out, "of job {job} "))?;
                write!(out, "for {} s: {reason}", pause.as_secs())
            }
            Self::BadResult { name, job, work, problem } => {
                write!(out, "job {job}, {work}: worker {name}'s result is no good: {problem}")
            }
            Self::Mismatch { job, shard } => {
                write!(out, "job {job}, shard {shard}: two workers returned different bits; a third will decide")
            }
            Self::Disputed { job, shard } => {
                write!(out, "job {job}, shard {shard}: no third worker came to decide whose bits are right")
            }
            Self::State { job, state, reason } => {
                write!(out, "job {job} is {}", state.name())?;
                reason.as_ref().map_or(Ok(()), |reason| write!(out, ": {reason}"))
            }
        }
    }
}
