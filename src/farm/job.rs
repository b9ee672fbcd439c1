//! What a user asks for and what they are told: requests, states, status.

use std::num::NonZeroU16;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::access::user::UserName;
use super::cut::Cut;
use super::ids::{JobId, SequenceId};
pub use super::measured::{Acceptance, EstimatedError};
pub use super::status_of_worker::{LastError, WorkerState, WorkerStatus};
pub use crate::import::changes::Changes as SceneChanges;

/// When a job is done: by passes, by seconds, by its error, or by whichever comes first. All empty: the method's `passes`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StopRule {
    /// Passes to merge, 1 to 2³¹.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes: Option<u32>,
    /// Wall-clock seconds after the first lease, above 0. After how many passes that is depends on the machines; their bits do not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// relMSE above 0: the job is done when its own estimate says with 95 % confidence that the picture's is smaller. It is
    /// looked at after shards that do not depend on the workers, so the picture does not either.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Whether `error` may end a job whose method never finds some of the light, of which its estimate cannot tell; else it is refused.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub accepts_missing_light: bool,
}

impl StopRule {
    /// Whether nothing is said.
    pub const fn is_empty(&self) -> bool {
        self.passes.is_none() && self.seconds.is_none() && self.error.is_none()
    }
}

/// A job's share of the farm, 1 to 1000 and 100 by default: beside each other, one of 200 gets twice the work done that one of 100 gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "u16", into = "u16")]
#[schema(value_type = u16, minimum = 1, maximum = 1000)]
pub struct Priority(NonZeroU16);

impl Priority {
    /// What a job has when nothing is said.
    pub const DEFAULT: Self = match NonZeroU16::new(100) {
        Some(priority) => Self(priority),
        None => unreachable!(),
    };
    /// The largest.
    pub const MOST: u16 = 1000;

    /// The number.
    pub const fn get(self) -> u16 {
        self.0.get()
    }
}

impl Default for Priority {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A number that is not a priority.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("priority is {0}; give 1 to {most}", most = Priority::MOST)]
pub struct BadPriority(u16);

impl TryFrom<u16> for Priority {
    type Error = BadPriority;

    fn try_from(number: u16) -> Result<Self, BadPriority> {
        NonZeroU16::new(number).filter(|number| number.get() <= Self::MOST).map(Self).ok_or(BadPriority(number))
    }
}

impl From<Priority> for u16 {
    fn from(priority: Priority) -> Self {
        priority.get()
    }
}

/// A job to be made: a scene that was uploaded before, and how to render it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JobRequest {
    /// Hash of an uploaded scene, 64 hexadecimal digits.
    pub scene: String,
    /// Method; the scene's own integrator when it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Method parameters that override the scene's.
    #[serde(default)]
    #[schema(value_type = Object)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// When to stop.
    #[serde(default)]
    pub stop: StopRule,
    /// How finely it is cut.
    #[serde(default, skip_serializing_if = "Cut::is_empty")]
    pub cut: Cut,
    /// Seed of all random numbers; 0 by default.
    #[serde(default)]
    pub seed: u64,
    /// What people call it; at most 200 bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Words to find it by; at most 20 of at most 100 bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
    /// Its share of the farm.
    #[serde(default)]
    pub priority: Priority,
    /// Whether the light of each light group of its scene is kept apart.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub light_groups: bool,
    /// Which frame of which sequence it is, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<FrameOfSequence>,
}

impl JobRequest {
    /// The scene's own integrator, and everything else as it is by default.
    pub fn of_scene(scene: impl Into<String>) -> Self {
        Self {
            scene: scene.into(),
            method: None,
            parameters: serde_json::Map::new(),
            stop: StopRule::default(),
            cut: Cut::default(),
            seed: 0,
            name: None,
            tags: Vec::new(),
            priority: Priority::DEFAULT,
            light_groups: false,
            frame: None,
        }
    }
}

/// Which frame of which sequence a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameOfSequence {
    /// The sequence.
    #[schema(value_type = String)]
    pub sequence: SequenceId,
    /// The frame's number.
    pub number: u32,
}

/// What a job is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waits for a worker.
    Queued,
    /// A worker tries methods, because the method is `auto`.
    Choosing,
    /// Shards are being traced.
    Running,
    /// Nothing is traced until it is resumed; `paused` says why.
    Paused,
    /// The stop rule is met.
    Done,
    /// Cannot go on; `error` says why.
    Failed,
    /// Stopped by a user; the picture is kept.
    Cancelled,
}

impl JobState {
    /// All states.
    pub const ALL: [Self; 7] =
        [Self::Queued, Self::Choosing, Self::Running, Self::Paused, Self::Done, Self::Failed, Self::Cancelled];

    /// Its name in JSON, tables and the store.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Choosing => "choosing",
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Whether the job stays as it is, unless it is extended.
    pub const fn is_final(self) -> bool {
        matches!(self, Self::Done | Self::Failed | Self::Cancelled)
    }
}

/// By what a program knows a request that it sends again, because no answer came: 1 to 200 visible ASCII characters.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct IdempotencyKey(String);

/// A text that is no such key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an idempotency key is 1 to {LONGEST_KEY} visible ASCII characters")]
pub struct BadIdempotencyKey;

const LONGEST_KEY: usize = 200;

impl FromStr for IdempotencyKey {
    type Err = BadIdempotencyKey;

    fn from_str(text: &str) -> Result<Self, BadIdempotencyKey> {
        let is_key = (1..=LONGEST_KEY).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_graphic());
        if is_key { Ok(Self(text.to_owned())) } else { Err(BadIdempotencyKey) }
    }
}

/// With which key a job was submitted, and what was asked for then.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Idempotency {
    /// The key.
    pub key: IdempotencyKey,
    /// BLAKE3 of the request as JSON.
    pub request: String,
}

/// What changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// The number of the newest change.
    pub newest: u64,
    /// Whether everything that was known before is to be forgotten.
    pub is_reset: bool,
    /// Jobs that changed, each as it is now.
    pub jobs: Vec<JobStatus>,
    /// Jobs that were deleted.
    pub deleted: Vec<JobId>,
}

/// Which jobs are meant. What is `None` leaves all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JobFilter {
    /// Those in this state.
    pub state: Option<JobState>,
    /// Those with this tag.
    pub tag: Option<String>,
    /// Those with this name.
    pub name: Option<String>,
    /// Those of this user.
    pub owner: Option<UserName>,
    /// The frames of this sequence.
    pub sequence: Option<SequenceId>,
    /// Those that were submitted after this one.
    pub after: Option<JobId>,
}

impl JobFilter {
    /// Whether a job is among them, its id left aside.
    pub fn fits(&self, job: &JobStatus) -> bool {
        self.state.is_none_or(|state| state == job.state)
            && self.tag.as_ref().is_none_or(|tag| job.tags.contains(tag))
            && self.name.as_ref().is_none_or(|name| job.name.as_ref() == Some(name))
            && self.owner.as_ref().is_none_or(|owner| job.owner.as_ref() == Some(owner))
            && self.sequence.is_none_or(|sequence| job.frame.is_some_and(|frame| frame.sequence == sequence))
    }
}

/// How a job is doing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobStatus {
    /// The job's id.
    pub id: String,
    /// What it is doing.
    pub state: JobState,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Why it pauses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paused: Option<String>,
    /// Since when no worker is there that could trace it, seconds since 1970.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waiting_for_workers_since: Option<u64>,
    /// Whether it cannot begin because other jobs, also paused ones, hold the coordinator's memory.
    #[serde(default)]
    #[schema(required = true)]
    pub waiting_for_memory: bool,
    /// Who submitted it, where there are users.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub owner: Option<UserName>,
    /// What people call it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Which frame of which sequence it is, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<FrameOfSequence>,
    /// Words to find it by.
    #[serde(default)]
    #[schema(required = true)]
    pub tags: Vec<String>,
    /// Its share of the farm.
    #[serde(default)]
    #[schema(required = true)]
    pub priority: Priority,
    /// When it was submitted, seconds since 1970.
    #[serde(default)]
    #[schema(required = true)]
    pub submitted: u64,
    /// Hash of its scene.
    pub scene: String,
    /// Its method.
    pub method: String,
    /// All parameters of the method, defaults written out.
    #[schema(value_type = Object)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// Its stop rule.
    pub stop: StopRule,
    /// How finely it is cut, as far as that was asked for.
    #[serde(default, skip_serializing_if = "Cut::is_empty")]
    pub cut: Cut,
    /// Its seed.
    pub seed: u64,
    /// The light groups that it keeps apart, as layers of its picture; empty unless that was asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light_groups: Vec<String>,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Passes merged into the picture.
    pub passes_done: u32,
    /// Passes at which it stops; empty when only seconds count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes_total: Option<u32>,
    /// Photons emitted in merged passes.
    pub photons_emitted: u64,
    /// Photons emitted per second, over the whole run.
    pub photons_per_second: f64,
    /// Wall-clock seconds since the first lease.
    pub seconds: f64,
    /// Estimated seconds left; empty while nothing is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds_left: Option<f64>,
    /// Workers that hold one of its shards now.
    pub workers: u32,
    /// Contributions dropped because they were not finite.
    pub non_finite: u64,
    /// How often chains accepted what was proposed to them, by kind of proposal; empty for methods without chains.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub acceptance: Vec<Acceptance>,
    /// Shards that a second worker traced to the same bits.
    #[serde(default)]
    #[schema(required = true)]
    pub shards_verified: u64,
    /// Shards for which two workers returned different bits.
    #[serde(default)]
    #[schema(required = true)]
    pub shards_mismatched: u64,
    /// Shards that were to be traced twice, but no second worker was there.
    #[serde(default)]
    #[schema(required = true)]
    pub shards_unchecked: u64,
    /// How far the picture is from the truth; empty while too few shards are merged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimated_error: Option<EstimatedError>,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
    /// Rises with every change of the picture; the ETag of its images.
    pub picture_version: u64,
}
