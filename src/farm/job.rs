//! What a user asks for and what they are told: requests, states, status.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// When a job is done: by passes, by seconds, by its error, or by whichever comes first. All empty: the method's `passes`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StopRule {
    /// Passes to merge, 1 to 2³¹.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes: Option<u32>,
    /// Wall-clock seconds after the first lease, above 0. The picture then depends on the machines' speed, but a job that
    /// stopped after n passes has the bits of a job asked for n passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// relMSE above 0: the job is done when its own estimate says with 95 % confidence that the picture's is smaller. It is
    /// looked at after shards that do not depend on the workers, so the picture does not either.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
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
    /// Seed of all random numbers; 0 by default.
    #[serde(default)]
    pub seed: u64,
}

/// What a job is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waits for a worker.
    Queued,
    /// Shards are being traced.
    Running,
    /// The stop rule is met.
    Done,
    /// Cannot go on; `error` says why.
    Failed,
    /// Stopped by a user; the picture is kept.
    Cancelled,
}

/// How far a job's picture is from the truth, as its own passes tell it, without a reference. Errors are
/// relMSE = mean((L − truth)²/(Y² + 10⁻³·m²)), with Y the mean of the truth's channels in a pixel and m that of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct EstimatedError {
    /// Passes merged when it was estimated.
    pub passes: u32,
    /// The estimate: noise and bias together.
    pub relmse: f64,
    /// Its part by noise.
    pub noise: f64,
    /// Its part by the bias of density estimates; 0 for methods without them, and not known for `photon_map`.
    pub bias: f64,
    /// relMSE is below this with the confidence beside it.
    pub bound: f64,
    /// Share of pictures whose bound holds.
    pub confidence: f64,
}

/// How a job is doing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobStatus {
    /// The job's id.
    pub id: String,
    /// What it is doing.
    pub state: JobState,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Hash of its scene.
    pub scene: String,
    /// Its method.
    pub method: String,
    /// All parameters of the method, defaults written out.
    #[schema(value_type = Object)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// Its stop rule.
    pub stop: StopRule,
    /// Its seed.
    pub seed: u64,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Passes merged into the picture.
    pub passes_done: u32,
    /// Passes at which it stops; empty when only seconds count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub passes_total: Option<u32>,
    /// Photons emitted in merged passes.
    pub photons_emitted: u64,
    /// Photons emitted per second, over the whole run.
    pub photons_per_second: f64,
    /// Wall-clock seconds since the first lease.
    pub seconds: f64,
    /// Estimated seconds left; empty while nothing is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds_left: Option<f64>,
    /// Workers that hold one of its shards now.
    pub workers: u32,
    /// Contributions dropped because they were not finite.
    pub non_finite: u64,
    /// How far the picture is from the truth; empty while too few shards are merged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimated_error: Option<EstimatedError>,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
    /// Rises with every change of the picture; the ETag of its images.
    pub picture_version: u64,
}

/// One worker as the coordinator sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WorkerStatus {
    /// The worker's id.
    pub id: String,
    /// The name it gave itself.
    pub name: String,
    /// Its rendering threads.
    pub threads: u32,
    /// Shards it delivered that were merged.
    pub shards_done: u64,
    /// Leases it holds.
    pub leases: u32,
    /// Seconds since it was last heard of.
    pub idle_seconds: f64,
    /// Why no work is given to it for now.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set_aside: Option<String>,
}
