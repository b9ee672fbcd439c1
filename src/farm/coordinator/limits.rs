//! What a coordinator accepts. Every limit stands here, once.

use std::sync::Arc;
use std::time::Duration;

use crate::farm::ids::JobId;
use crate::farm::rules::plan::PASSES_LIMIT;

const GIB: u64 = 1 << 30;

/// What a coordinator accepts.
#[derive(Clone, Debug, PartialEq, serde::Serialize, utoipa::ToSchema)]
pub struct Limits {
    /// Bytes of a scene file or archive.
    pub scene_bytes: u64,
    /// Bytes of a job request, inline scene included.
    pub job_bytes: u64,
    /// Pixels of a picture.
    pub pixels: u64,
    /// Passes of a job.
    pub passes: u32,
    /// Seconds of a job.
    pub seconds: f64,
    /// Bytes of a name: a job's or a worker's.
    pub name_bytes: usize,
    /// Tags of a job.
    pub tags: usize,
    /// Bytes of a tag.
    pub tag_bytes: usize,
    /// Jobs that have not ended.
    pub live_jobs: usize,
    /// What one user may have at the same time; admins are not limited.
    pub user: UserLimits,
    /// Users.
    pub users: usize,
    /// Tokens of a user, logins of the page included, and those by which workers join.
    pub tokens: usize,
    /// Webhooks.
    pub webhooks: usize,
    /// Uploads at the same time.
    pub uploads: usize,
    /// Connections at the same time; further ones wait.
    pub connections: usize,
    /// Seconds without a request or without a byte of one after which a connection is closed.
    pub silence: u64,
    /// Threads of a worker.
    pub worker_threads: u32,
    /// Bytes of a worker's result: the tally of the largest region, or the radii of the largest picture, compressed.
    pub result_bytes: u64,
    /// Bytes of results that are received at the same time; further ones wait.
    pub result_memory: u64,
    /// Bytes of a worker's other messages.
    pub message_bytes: usize,
    /// Bytes of memory for the states of all running jobs together. Jobs that do not fit wait; a job that never will is refused.
    pub job_memory: u64,
    /// Bytes of tallies that came before their turn, of all jobs together: while there are more, a job's next shard is leased only when nothing
    /// of the job is under way.
    pub early_memory: u64,
    /// Seconds after which a refused request may be repeated.
    pub retry_after: u64,
}

/// What one user may have at the same time.
#[derive(Clone, Debug, PartialEq, serde::Serialize, utoipa::ToSchema)]
pub struct UserLimits {
    /// Jobs that have not ended.
    pub live_jobs: usize,
    /// Pixels of all pictures of such jobs together.
    pub pixels: u64,
    /// Bytes of all scenes that the user was the first to upload.
    pub scene_bytes: u64,
    /// Seconds that one job may ask for.
    pub seconds: f64,
}

impl Default for UserLimits {
    fn default() -> Self {
        Self { live_jobs: 200, pixels: 2_000_000_000, scene_bytes: 100 << 30, seconds: 30.0 * 86_400.0 }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            scene_bytes: GIB,
            job_bytes: 64 << 20,
            pixels: 100_000_000,
            passes: PASSES_LIMIT,
            seconds: 10.0 * 365.25 * 86_400.0,
            name_bytes: 200,
            tags: 20,
            tag_bytes: 100,
            live_jobs: 1000,
            user: UserLimits::default(),
            users: 10_000,
            tokens: 100,
            webhooks: 100,
            uploads: 4,
            connections: 4096,
            silence: 30,
            worker_threads: 1 << 16,
            result_bytes: GIB / 2,
            result_memory: GIB,
            message_bytes: 1 << 20,
            job_memory: total_memory().map_or(8 * GIB, |total| total / 2),
            early_memory: total_memory().map_or(2 * GIB, |total| total / 8),
            retry_after: 5,
        }
    }
}

/// Files in which a container's limit stands, of the second and the first version of Linux control groups.
const CONTAINER_LIMITS: [&str; 2] = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];

/// The memory that there is for this process, bytes: this machine's, or that of its container; `None` where the system does not say.
fn total_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let machine = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)?;
    let limit = |file: &&str| std::fs::read_to_string(file).ok()?.trim().parse::<u64>().ok();
    Some(CONTAINER_LIMITS.iter().filter_map(limit).fold(machine, u64::min))
}

/// Called with a job and the index of the shard that is about to be merged.
type BeforeMerge = Arc<dyn Fn(JobId, u64) + Send + Sync>;

/// Faults on purpose: tests set them to see what a coordinator does when something breaks inside it.
#[derive(Clone, Default)]
pub struct FaultHooks {
    /// Runs before a shard is merged, with the job's merge state locked; may panic or block.
    pub before_merge: Option<BeforeMerge>,
}

impl Limits {
    /// The pause that a refused request is told.
    pub fn retry_after(&self) -> Duration {
        Duration::from_secs(self.retry_after)
    }
}
