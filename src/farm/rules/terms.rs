//! What is agreed on when a job is accepted, what is stored of it, and what it is told while it runs.

use std::fmt;
use std::time::Duration;

use super::plan::Plan;
use crate::estimate::{Acceptance, ErrorEstimate};
use crate::farm::job::{Priority, StopRule};

/// The error of a picture, and when it was estimated.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredError {
    /// Passes merged then.
    pub passes: u32,
    /// What they tell.
    pub error: ErrorEstimate,
}

/// The error of a picture as it was estimated at some time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorPoint {
    /// Seconds that the job had been running.
    pub seconds: f64,
    /// The error then.
    pub measured: MeasuredError,
}

/// What the merged shards add up to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MergedTotals {
    /// Shards merged.
    pub shards: u64,
    /// Passes merged in every region.
    pub passes: u32,
    /// Photons emitted in them.
    pub photons_emitted: u64,
    /// Contributions dropped because they were not finite.
    pub non_finite: u64,
    /// How often chains accepted what was proposed to them.
    pub acceptance: Vec<Acceptance>,
    /// The last estimate of the error.
    pub error: Option<MeasuredError>,
    /// The error is as small as the stop rule asks for: nothing more will be merged.
    pub good_enough: bool,
    /// Bytes of tallies that came before their turn and wait for it.
    pub early_bytes: u64,
}

/// What was agreed on when a job was accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// When to stop.
    pub stop: StopRule,
    /// Its share of the farm.
    pub priority: Priority,
    /// Bytes of memory that the coordinator needs for it while it runs.
    pub memory: u64,
    /// Whether trials choose its method first.
    pub chooses_method: bool,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
}

/// How far a stored job had come.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Restored {
    /// Its cut, once its pilot was done.
    pub plan: Option<Plan>,
    /// What its snapshot holds.
    pub totals: MergedTotals,
    /// The error as it was estimated from time to time.
    pub history: Vec<ErrorPoint>,
    /// For how long it had been running.
    pub ran: Duration,
    /// Why it pauses, if it does.
    pub pause: Option<PauseReason>,
}

/// Why a job pauses.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PauseReason {
    /// A user asked for it.
    User,
    /// Several workers were lost while they traced the same work.
    WorkersLost {
        /// The work in words.
        work: String,
    },
    /// The job's state cannot be stored, for example because the disk is full.
    Store {
        /// What the store says.
        problem: String,
    },
}

impl fmt::Display for PauseReason {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::User => out.write_str("paused by a user"),
            Self::WorkersLost { work } => {
                write!(out, "several workers were lost while they traced its {work}; resume the job to try again")
            }
            Self::Store { problem } => {
                write!(out, "its state cannot be stored ({problem}); it goes on when there is room")
            }
        }
    }
}
