//! The coordinator as its callers see it: scenes in, jobs in, status and pictures out.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;

use super::error::FarmError;
use super::job::{JobRequest, JobStatus, WorkerStatus};
use crate::estimate::Picture;

/// What a coordinator may be told.
#[derive(Clone, Debug)]
pub struct CoordinatorOptions {
    /// How long a lease lives without a heartbeat.
    pub lease_duration: Duration,
    /// Pixels a picture may have.
    pub max_pixels: u64,
    /// Bytes a scene file or archive may have.
    pub max_scene_bytes: u64,
}

impl Default for CoordinatorOptions {
    fn default() -> Self {
        Self { lease_duration: Duration::from_secs(15), max_pixels: 100_000_000, max_scene_bytes: 2 << 30 }
    }
}

/// A scene that was uploaded, checked and prepared.
#[derive(Clone, Debug, PartialEq, serde::Serialize, utoipa::ToSchema)]
pub struct SceneSummary {
    /// BLAKE3 of its bytes, 64 hexadecimal digits.
    pub hash: String,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// The method that its integrator asks for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integrator: Option<String>,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
}

/// Per-pixel facts beside the picture, row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Gather radius, m.
    pub radius: Vec<f32>,
    /// N, accumulated photons.
    pub photons: Vec<f32>,
}

/// The door to a running coordinator. Cheap to clone; all clones speak to the same one.
#[derive(Clone)]
pub struct CoordinatorHandle {}

impl CoordinatorHandle {
    /// Starts a coordinator without scenes, jobs and workers. Must be called inside a tokio runtime.
    pub fn start(options: CoordinatorOptions) -> Self {
        let _ = options;
        todo!("lands with the coordinator")
    }

    /// Checks and keeps a scene: XML or JSON that stands alone, or a zip archive. The same bytes again cost nothing.
    pub async fn add_scene(&self, bytes: Vec<u8>) -> Result<SceneSummary, FarmError> {
        let _ = bytes;
        todo!("lands with the coordinator")
    }

    /// What is known of an uploaded scene.
    pub fn scene(&self, hash: &str) -> Result<SceneSummary, FarmError> {
        let _ = hash;
        todo!("lands with the coordinator")
    }

    /// The bytes of an uploaded scene, as they came.
    pub fn scene_bytes(&self, hash: &str) -> Result<Arc<[u8]>, FarmError> {
        let _ = hash;
        todo!("lands with the coordinator")
    }

    /// Checks a request and queues the job; answers its id.
    pub async fn submit(&self, request: JobRequest) -> Result<String, FarmError> {
        let _ = request;
        todo!("lands with the coordinator")
    }

    /// All jobs, oldest first.
    pub fn jobs(&self) -> Vec<JobStatus> {
        todo!("lands with the coordinator")
    }

    /// How a job is doing now.
    pub fn job(&self, id: &str) -> Result<JobStatus, FarmError> {
        let _ = id;
        todo!("lands with the coordinator")
    }

    /// A job's status as it changes. The last value stays readable after the job has ended.
    pub fn watch(&self, id: &str) -> Result<watch::Receiver<JobStatus>, FarmError> {
        let _ = id;
        todo!("lands with the coordinator")
    }

    /// The picture as merged so far, and the status that belongs to it.
    pub async fn picture(&self, id: &str) -> Result<(Picture, JobStatus), FarmError> {
        let _ = id;
        todo!("lands with the coordinator")
    }

    /// Radius and photon count per pixel as merged so far.
    pub async fn layers(&self, id: &str) -> Result<Layers, FarmError> {
        let _ = id;
        todo!("lands with the coordinator")
    }

    /// Stops a job and keeps its picture. A job that has ended already stays as it is.
    pub fn cancel(&self, id: &str) -> Result<JobStatus, FarmError> {
        let _ = id;
        todo!("lands with the coordinator")
    }

    /// All workers that are registered, by name.
    pub fn workers(&self) -> Vec<WorkerStatus> {
        todo!("lands with the coordinator")
    }

    /// Takes no new jobs and gives no new leases; shards that are being traced may finish.
    pub fn drain(&self) {
        todo!("lands with the coordinator")
    }

    /// Drains and returns when every tally that arrived has been merged. Waiting requests are answered.
    pub async fn shutdown(&self) {
        todo!("lands with the coordinator")
    }
}
