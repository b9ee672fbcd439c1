//! What is known of a sequence, and how it is stored.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};
use tokio::time::Instant;

use super::turn::Turn;
use crate::farm::access::user::UserName;
use crate::farm::ids::{JobId, SequenceId};
use crate::farm::job::Idempotency;
use crate::farm::locks::lock;
use crate::farm::sequence::{Frame, SequenceRequest};
use crate::farm::store::StoreError;
use crate::farm::store::sequences::SequenceRow;

/// A sequence.
pub(super) struct SequenceRecord {
    pub(super) id: SequenceId,
    pub(super) facts: Mutex<SequenceFacts>,
    /// Whoever does something to it: a user, or what makes its frames.
    pub(super) turn: Turn,
    /// Held by whoever submits it until its first frame is checked.
    pub(super) checking: Turn,
    /// Whether somebody makes frames of it now.
    pub(super) is_being_made: AtomicBool,
}

/// What a user did to a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Halt {
    /// It goes on when it is resumed.
    Paused,
    /// It does not go on.
    Cancelled,
    /// It is on its way out.
    Deleted,
}

/// What was asked for, and how far it is.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SequenceFacts {
    pub(super) request: SequenceRequest,
    /// What the first and the last frame of the whole sequence show.
    pub(super) moments: Option<[f64; 2]>,
    /// Who submitted it, where there are users.
    pub(super) owner: Option<UserName>,
    /// Milliseconds since 1970.
    pub(super) submitted: i64,
    /// How many frames became jobs, the first ones.
    pub(super) made: u32,
    pub(super) halt: Option<Halt>,
    /// Why the next frame cannot become a job.
    pub(super) problem: Option<String>,
    /// The key with which it was submitted.
    pub(super) idempotency: Option<Idempotency>,
    /// The jobs of its frames, by number, as their own records tell; those that were deleted are missing.
    #[serde(skip)]
    pub(super) jobs: BTreeMap<u32, JobId>,
    /// Those of them that had not ended when they were looked at last.
    #[serde(skip)]
    pub(super) live: Vec<JobId>,
    /// Whether its first frame is being checked: it may still be refused.
    #[serde(default)]
    pub(super) is_new: bool,
    /// Why no further frame becomes a job for now.
    #[serde(skip)]
    pub(super) waiting: Option<String>,
    /// When that is tried again.
    #[serde(skip)]
    pub(super) retry_at: Option<Instant>,
}

impl SequenceFacts {
    /// Those of a sequence whose first frame is to be checked.
    pub(super) fn new(
        request: SequenceRequest,
        moments: Option<[f64; 2]>,
        owner: Option<UserName>,
        idempotency: Option<Idempotency>,
    ) -> Self {
        Self {
            request,
            moments,
            owner,
            submitted: 0,
            made: 0,
            halt: None,
            problem: None,
            idempotency,
            is_new: true,
            waiting: None,
            retry_at: None,
            jobs: BTreeMap::new(),
            live: Vec::new(),
        }
    }

    /// Whether users know of it: one whose first frame is being checked may still be refused.
    pub(super) fn is_there(&self) -> bool {
        !self.is_new && self.halt != Some(Halt::Deleted)
    }

    /// The next frame that is no job yet.
    pub(super) fn next(&self) -> Option<Frame> {
        let frames = &self.request.frames;
        (self.made < frames.count()).then(|| frames.frame(frames.first + self.made, self.moments))
    }

    /// Whether frames are to be made still, now or when it is resumed.
    pub(super) fn goes_on(&self) -> bool {
        matches!(self.halt, None | Some(Halt::Paused)) && self.next().is_some()
    }

    /// A frame became a job.
    pub(super) fn add(&mut self, frame: u32, job: JobId) {
        self.jobs.insert(frame, job);
        self.live.push(job);
        self.made = self.made.max(frame - self.request.frames.first + 1);
    }
}

impl SequenceRecord {
    pub(super) fn new(id: SequenceId, facts: SequenceFacts) -> Self {
        let (turn, checking) = (Turn::default(), Turn::default());
        Self { id, facts: Mutex::new(facts), turn, checking, is_being_made: AtomicBool::new(false) }
    }

    /// As it is now, to be stored.
    pub(super) fn row(&self) -> SequenceRow {
        let facts = lock(&self.facts);
        // Plain data with string keys always has a JSON form.
        let record = serde_json::to_string(&*facts).unwrap_or_default();
        SequenceRow { id: self.id, created: facts.submitted, record }
    }

    /// A stored one.
    pub(super) fn read(row: &SequenceRow) -> Result<Self, StoreError> {
        let bad = |problem: serde_json::Error| StoreError::BadRecord {
            what: format!("sequence {}", row.id),
            problem: problem.to_string(),
        };
        Ok(Self::new(row.id, serde_json::from_str(&row.record).map_err(bad)?))
    }
}
