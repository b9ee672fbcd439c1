//! What the keeper is asked to store.

use tokio::sync::oneshot;

use crate::farm::ids::{JobId, SequenceId};
use crate::farm::job::JobState;
use crate::farm::rules::Rollback;
use crate::farm::store::journal::JournalRow;

/// Something to be stored.
pub(super) enum Chore {
    /// A job's record.
    Record(JobId),
    /// A job was refused after all: no record of it stays.
    Refused(JobId),
    /// The final state of a job that has ended.
    Finish(JobId),
    /// A job goes back to what can be trusted.
    RollBack(Rollback),
    /// A sequence's record.
    Sequence(SequenceId),
    /// No record of a sequence stays.
    ForgetSequence(SequenceId),
    /// Lines of the journal.
    Journal(Vec<JournalRow>),
    /// What webhooks are told of a job.
    Announce {
        /// The job.
        job: JobId,
        /// The state that it is in now.
        state: JobState,
    },
    /// A worker was there.
    Worker {
        /// Its name.
        name: String,
        /// Its threads.
        threads: u32,
    },
    /// Snapshots of all jobs, because the coordinator stops.
    SnapshotAll,
    /// Answers when everything before is stored.
    Barrier(oneshot::Sender<()>),
}
