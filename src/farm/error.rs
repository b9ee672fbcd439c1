//! What the farm answers when it cannot do what was asked.

use std::time::Duration;

use super::access::caller::Denied;
use super::access::secret::NoRandomness;
use super::ids::{JobId, SequenceId};
use super::sequence::BadFrames;
use super::store::StoreError;
use crate::estimate::denoise::DenoiseError;
use crate::method::MethodError;
use crate::scene::error::SceneError;

/// A request to the coordinator that cannot be met. None of these disturbs other jobs.
#[derive(Clone, Debug, thiserror::Error)]
pub enum FarmError {
    /// No scene with this hash was uploaded.
    #[error("there is no scene \"{0}\"")]
    UnknownScene(String),
    /// No job has this id.
    #[error("there is no job \"{0}\"")]
    UnknownJob(JobId),
    /// No sequence has this id.
    #[error("there is no sequence \"{0}\"")]
    UnknownSequence(SequenceId),
    /// The frames cannot be.
    #[error("{0}; {remedy}", remedy = .0.remedy())]
    BadFrames(#[from] BadFrames),
    /// No worker has this number.
    #[error("there is no worker \"{0}\"")]
    UnknownWorker(String),
    /// No user or token is called so.
    #[error("there is no {0}")]
    UnknownMember(String),
    /// The scene cannot be rendered.
    #[error(transparent)]
    BadScene(#[from] SceneError),
    /// The method does not exist or cannot take its parameters.
    #[error(transparent)]
    BadMethod(#[from] MethodError),
    /// Another part of the request is wrong.
    #[error("{problem}; {remedy}")]
    BadRequest {
        /// What is wrong.
        problem: String,
        /// What the user can do.
        remedy: String,
    },
    /// Nothing has been merged yet.
    #[error("job \"{0}\" has no picture yet; wait for its first shard")]
    NoPictureYet(JobId),
    /// The picture cannot be denoised, at least not yet.
    #[error(transparent)]
    CannotDenoise(#[from] DenoiseError),
    /// More than the coordinator takes.
    #[error("{what} is {found} where at most {limit} is accepted")]
    TooLarge {
        /// What is too large, with its unit.
        what: &'static str,
        /// How large it is.
        found: u64,
        /// How large it may be.
        limit: u64,
    },
    /// More than the coordinator takes at the same time.
    #[error("{problem}; try again later")]
    Busy {
        /// What there is too much of.
        problem: String,
        /// When to try again.
        retry_after: Duration,
    },
    /// Something that will be there later.
    #[error("{problem}; ask again")]
    NotYet {
        /// What is missing.
        problem: String,
        /// When to ask again.
        retry_after: Duration,
    },
    /// The job or scene is in a state that does not allow it.
    #[error("{problem}; {remedy}")]
    Conflict {
        /// What the state is.
        problem: String,
        /// What the user can do.
        remedy: String,
    },
    /// The job is not any more what the user means to change.
    #[error("job {0} was changed since; get it again, and then change it")]
    ChangedSince(JobId),
    /// What was asked for cannot be stored or read now.
    #[error("{problem}; try again when the store works")]
    Store {
        /// What the store says.
        problem: String,
    },
    /// Something that was stored is gone.
    #[error("{problem}; it was lost or changed behind the coordinator's back")]
    Lost {
        /// What the store says.
        problem: String,
    },
    /// Whoever asks may not.
    #[error("{0}; {remedy}", remedy = .0.remedy())]
    Denied(#[from] Denied),
    /// The coordinator is stopping and takes no new work.
    #[error("the coordinator is shutting down; try again when it is back")]
    ShuttingDown,
    /// A fault of the coordinator itself; its log says more.
    #[error("internal fault: {0}")]
    Internal(String),
}

impl From<NoRandomness> for FarmError {
    fn from(error: NoRandomness) -> Self {
        Self::Internal(error.to_string())
    }
}

impl From<StoreError> for FarmError {
    fn from(error: StoreError) -> Self {
        let problem = error.to_string();
        if error.is_for_good() { Self::Lost { problem } } else { Self::Store { problem } }
    }
}
