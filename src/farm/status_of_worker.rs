//! How a worker is doing, as users are told.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a worker is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WorkerState {
    /// Waits for work.
    Idle,
    /// Holds leases.
    Working,
    /// Gets no further work, and leaves when it has done what it holds.
    Draining,
    /// Gets no work for now; `set_aside` says why.
    SetAside,
    /// Was not heard of for longer than a lease lives; it may be dead.
    Silent,
}

impl WorkerState {
    /// All states.
    pub const ALL: [Self; 5] = [Self::Idle, Self::Working, Self::Draining, Self::SetAside, Self::Silent];

    /// Its name in JSON and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Working => "working",
            Self::Draining => "draining",
            Self::SetAside => "set_aside",
            Self::Silent => "silent",
        }
    }
}

/// One worker as the coordinator sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WorkerStatus {
    /// The worker's id.
    pub id: String,
    /// The name it gave itself.
    pub name: String,
    /// What it is doing.
    pub state: WorkerState,
    /// Its rendering threads.
    pub threads: u32,
    /// Shards it delivered that were merged.
    pub shards_done: u64,
    /// Leases it holds.
    pub leases: u32,
    /// Seconds since it was last heard of.
    pub idle_seconds: f64,
    /// Why no work is given to it for now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub set_aside: Option<String>,
    /// What went wrong with its work last; it stays until the worker leaves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_error: Option<LastError>,
}

/// Work that a worker could not do, or whose result was no good.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct LastError {
    /// The job's id.
    pub job: String,
    /// What was traced, as `shard 12`.
    pub work: String,
    /// What was wrong.
    pub problem: String,
    /// When, seconds since 1970.
    pub time: u64,
}
