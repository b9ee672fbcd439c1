//! How finely a job is cut.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How finely a job is cut into shards. What is not given follows the cost of the picture. The cut is part of what decides a picture's bits, so it
/// is kept with the job and never follows the number of workers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Cut {
    /// Passes of a full-grown shard, 1 to 1024; by default as many as cost one core about a second, and never more than cost it ten minutes. More
    /// of them send fewer tallies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes_per_shard: Option<u32>,
    /// Shards of a region between two refreshes of the radii, an even number from 2 to 4096; 16 by default. More of them let more workers
    /// trace one picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shards_per_epoch: Option<u32>,
}

impl Cut {
    /// The most passes of a shard.
    pub const MOST_PASSES: u32 = 1024;
    /// The most shards of an epoch.
    pub const MOST_SHARDS: u32 = 4096;

    /// Whether nothing is said.
    pub const fn is_empty(&self) -> bool {
        self.passes_per_shard.is_none() && self.shards_per_epoch.is_none()
    }
}
