//! The coordinator: the [rules](super::rules) with a clock, locks and threads round it.
//!
//! Callers hold a [`CoordinatorHandle`]. One mutex guards the rules and is only held for bookkeeping. Each job has a
//! second one for its [merge state](super::merging), held by blocking threads that decode and add. Where both are
//! needed the merge state is locked first.
//!
//! | file | what |
//! |---|---|
//! | `lifetime` | how it starts, lets time pass, and stops |
//! | `shared` | events go in, effects are carried out |
//! | `scenes`, `jobs`, `control` | what users ask for, one `turn` after the other |
//! | `sequences`, `sequence_control`, `frames` | many frames of one scene: what users ask for, and how frames become jobs |
//! | [`members`], [`tokens`] | who they are, and what they may do |
//! | `results`, `workers` | what workers deliver, and how they are sent away |
//! | `keeper`, `records`, `restoring` | what is stored (its `chores`), and how it comes back |
//! | `pictures` | pictures, also of jobs that ended long ago (`viewed`), and what their pixels see first (`seen_first`, `layers`) |
//! | `denoising` | pictures with less noise |
//! | [`request`], `status`, `sequence_status` | what users say and are told |
//! | `announcing` | what webhooks are told |
//! | `feed` | all changes of all jobs, numbered |
//! | `counters`, `metrics` | what is counted and measured, for Prometheus |
//! | `options`, `limits`, `quotas` | how it runs, what it accepts, and what of one user |

mod announcing;
mod blocking;
mod chores;
mod clock;
mod control;
mod counters;
mod denoising;
mod feed;
mod frames;
mod jobs;
mod keeper;
mod layers;
mod lifetime;
mod limits;
pub(crate) mod members;
mod metrics;
mod options;
mod pictures;
mod quotas;
mod records;
pub(crate) mod request;
mod restoring;
mod results;
mod scene_record;
mod scenes;
mod seen_first;
mod sequence_control;
mod sequence_record;
mod sequence_status;
mod sequences;
mod shared;
mod status;
pub mod tokens;
mod turn;
mod viewed;
mod workers;

use std::ops::Bound;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

pub(super) use blocking::blocking;
pub use jobs::JobChanges;
pub use limits::{FaultHooks, Limits, UserLimits};
pub use options::CoordinatorOptions;
pub use pictures::LayeredPicture;
pub(super) use results::{Delivered, Delivery, Payload};
pub use scene_record::{SceneLayout, SceneSummary};
pub use scenes::SceneUpload;
pub(super) use shared::{JobRecord, Shared};

use super::access::caller::Caller;
use super::error::FarmError;
use super::ids::JobId;
use super::job::{Changes, IdempotencyKey, JobFilter, JobRequest, JobStatus, SceneChanges, StopRule, WorkerStatus};
use super::rules::Event;
use super::rules::terms::ErrorPoint;
use super::store::Store;
use super::store::journal::JournalRow;
use crate::estimate::Picture;
use crate::estimate::picture_files::Layer;
use crate::import::changes::with_changes;
use crate::scene::camera::CameraMatrices;

/// The door to a running coordinator. Cheap to clone; all clones speak to the same one.
#[derive(Clone)]
pub struct CoordinatorHandle {
    pub(super) shared: Arc<Shared>,
}

impl CoordinatorHandle {
    /// Starts a coordinator on a store: scenes and jobs that are there go on. Must be called inside a tokio runtime.
    pub async fn start(options: CoordinatorOptions, store: Store) -> Result<Self, FarmError> {
        Ok(Self { shared: Shared::start(options, store).await? })
    }

    /// What is accepted here.
    pub fn limits(&self) -> &Limits {
        &self.shared.options.limits
    }

    /// Names by which it may be called beside those that are always right.
    pub fn host_names(&self) -> &[String] {
        &self.shared.options.host_names
    }

    /// Whether browsers reach it over encrypted connections, of its own or of a proxy in front of it.
    pub fn is_encrypted(&self) -> bool {
        let options = &self.shared.options;
        let is_public = |provider: &Arc<super::login::provider::Provider>| {
            provider.options().public_address.starts_with("https://")
        };
        options.is_encrypted || options.login.as_ref().is_some_and(is_public)
    }

    /// Checks and keeps a scene: XML or JSON that stands alone, or a zip archive. The same bytes again cost nothing.
    pub async fn add_scene(&self, bytes: Vec<u8>) -> Result<SceneSummary, FarmError> {
        self.add_scene_of(bytes, &Caller::Anyone).await
    }

    /// The same for a caller, whose the scene is if it is new.
    pub async fn add_scene_of(&self, bytes: Vec<u8>, caller: &Caller) -> Result<SceneSummary, FarmError> {
        self.shared.upload_all(&bytes, caller.name().cloned()).await?.finish().await
    }

    /// Begins a caller's scene whose bytes come bit by bit.
    pub async fn begin_upload(&self, caller: &Caller) -> Result<SceneUpload, FarmError> {
        self.shared.begin_upload(caller.name().cloned()).await
    }

    /// What is known of an uploaded scene.
    pub fn scene(&self, hash: &str) -> Result<SceneSummary, FarmError> {
        self.shared.scene(hash).map(|scene| scene.summary.clone())
    }

    /// The camera of an uploaded scene, where it stands somewhere.
    pub fn camera(&self, hash: &str) -> Result<Option<CameraMatrices>, FarmError> {
        self.shared.scene(hash).map(|scene| scene.camera)
    }

    /// Where the camera and the lights of an uploaded scene stand.
    ///
    /// # Errors
    /// [`FarmError::Busy`] while too many scenes are taken in: what has to be prepared counts as one of them.
    pub async fn layout(&self, hash: &str, caller: &Caller) -> Result<SceneLayout, FarmError> {
        self.shared.layout(hash, caller.name()).await
    }

    /// All uploaded scenes, by hash.
    pub fn scenes(&self) -> Vec<SceneSummary> {
        self.shared.scenes()
    }

    /// Deletes a scene that no job refers to.
    pub async fn delete_scene(&self, hash: &str) -> Result<(), FarmError> {
        self.shared.delete_scene(hash).await
    }

    /// The bytes of an uploaded scene, as they came.
    pub async fn scene_bytes(&self, hash: &str) -> Result<Bytes, FarmError> {
        self.shared.scene_bytes(hash).await
    }

    /// The bytes of an uploaded scene as `changes` make it: the changes, and which scene it is.
    pub async fn changed_scene(&self, hash: &str, changes: SceneChanges) -> Result<Vec<u8>, FarmError> {
        self.shared.changed_scene(hash, changes).await
    }

    /// A whole scene's bytes with `changes` packed beside it.
    ///
    /// # Errors
    /// When the bytes are no scene.
    pub async fn changed(&self, bytes: Bytes, changes: SceneChanges, caller: &Caller) -> Result<Vec<u8>, FarmError> {
        // An archive takes much more memory than its bytes while it is unpacked.
        let slot = self.shared.upload_slot(caller.name())?;
        blocking(move || {
            let _slot = slot;
            Ok(with_changes(&bytes, &changes)?)
        })
        .await
    }

    /// Checks a request and queues the job; answers its id. Nothing is traced before the answer.
    pub async fn submit(&self, request: JobRequest) -> Result<JobId, FarmError> {
        self.submit_of(request, &Caller::Anyone, None).await
    }

    /// The same for a caller, whose the job is. Who submits the same again with the same `key` gets the job that there is.
    pub async fn submit_of(
        &self,
        request: JobRequest,
        caller: &Caller,
        key: Option<IdempotencyKey>,
    ) -> Result<JobId, FarmError> {
        self.shared.submit(request, caller.name().cloned(), key).await
    }

    /// A job's error as it was estimated from time to time.
    pub fn error_history(&self, id: JobId) -> Result<Vec<ErrorPoint>, FarmError> {
        let job = self.shared.job(id)?;
        let state = self.shared.lock();
        Ok(state.rules.job(id).map_or_else(|| job.history(), |progress| progress.history.clone()))
    }

    /// All jobs, oldest first.
    pub fn jobs(&self) -> Vec<JobStatus> {
        self.find_jobs(&JobFilter::default(), usize::MAX)
    }

    /// The first `limit` of the jobs that are meant, oldest first.
    pub fn find_jobs(&self, filter: &JobFilter, limit: usize) -> Vec<JobStatus> {
        let state = self.shared.lock();
        let after = filter.after.map_or(Bound::Unbounded, Bound::Excluded);
        let jobs = state.jobs.range((after, Bound::Unbounded));
        let statuses = jobs.map(|(_, job)| state.status(job, &self.shared.clock));
        statuses.filter(|job| filter.fits(job)).take(limit).collect()
    }

    /// How a job is doing now.
    pub fn job(&self, id: JobId) -> Result<JobStatus, FarmError> {
        let job = self.shared.job(id)?;
        Ok(self.shared.lock().status(&job, &self.shared.clock))
    }

    /// A job's status as it changes. The last value stays readable after the job has ended.
    pub fn watch(&self, id: JobId) -> Result<watch::Receiver<JobStatus>, FarmError> {
        Ok(self.shared.job(id)?.watch())
    }

    /// What changed after change number `seen`; everything when that is too long ago to know.
    pub fn changes(&self, seen: u64) -> Changes {
        self.shared.changes(seen)
    }

    /// The number of the newest change as it rises. It starts anew with the coordinator, which its [run](Self::run) tells.
    pub fn watch_changes(&self) -> watch::Receiver<u64> {
        self.shared.feed.watch()
    }

    /// Which run of the coordinator this is: milliseconds since 1970 when it started.
    pub fn run(&self) -> u64 {
        self.shared.clock.unix(Duration::ZERO).as_millis() as u64
    }

    /// What would become of a request; nothing is kept or traced. `scene` are the bytes of one that was not uploaded.
    pub async fn validate(&self, request: JobRequest, scene: Option<Vec<u8>>) -> Result<JobStatus, FarmError> {
        self.shared.validate(request, scene).await
    }

    /// The picture as merged so far, the layers asked for, and the status that belongs to all of them.
    ///
    /// # Errors
    /// Layers of first surfaces need a worker that looks; without one they are [`FarmError::NotYet`]. So do denoised ones, and before both twins
    /// have a pass everywhere they are [`FarmError::CannotDenoise`].
    pub async fn picture_with_layers(&self, id: JobId, wanted: &[Layer]) -> Result<LayeredPicture, FarmError> {
        self.shared.picture_with_layers(id, wanted).await
    }

    /// The picture as merged so far, and the status that belongs to it.
    pub async fn picture(&self, id: JobId) -> Result<(Picture, JobStatus), FarmError> {
        let LayeredPicture { picture, status, .. } = self.picture_with_layers(id, &[]).await?;
        Ok((picture, status))
    }

    /// The denoised picture of what is merged so far, its relMSE as its two halves tell, and the status that belongs to it.
    ///
    /// # Errors
    /// As for the layers of it.
    pub async fn denoised_picture(&self, id: JobId) -> Result<(Picture, f64, JobStatus), FarmError> {
        let (denoised, status) = self.shared.denoised_picture(id).await?;
        Ok((denoised.picture.clone(), denoised.relmse, status))
    }

    /// Stops a job and keeps its picture. What the answer says is what stays. A job that has ended already stays as it is.
    pub async fn cancel(&self, id: JobId) -> Result<JobStatus, FarmError> {
        self.shared.control(id, Event::JobCancelled { job: id }).await
    }

    /// Stops issuing work of a job; what is being traced is still merged.
    pub async fn pause(&self, id: JobId) -> Result<JobStatus, FarmError> {
        let reason = super::rules::terms::PauseReason::User;
        self.shared.control(id, Event::JobPaused { job: id, reason }).await
    }

    /// Lets a paused job go on.
    pub async fn resume(&self, id: JobId) -> Result<JobStatus, FarmError> {
        self.shared.control(id, Event::JobResumed { job: id }).await
    }

    /// Changes name, tags or priority of a job, if it is as the user means it, `is_meant`.
    pub async fn change(
        &self,
        id: JobId,
        changes: JobChanges,
        is_meant: impl FnOnce(&JobStatus) -> bool,
    ) -> Result<JobStatus, FarmError> {
        self.shared.change_job(id, changes, is_meant).await
    }

    /// Lets an ended job go on to a later end, from its stored state to the bits of the longer job.
    pub async fn extend(&self, id: JobId, stop: StopRule) -> Result<JobStatus, FarmError> {
        self.shared.extend(id, stop).await
    }

    /// Deletes a job and its pictures; one that runs is cancelled first.
    pub async fn delete(&self, id: JobId) -> Result<(), FarmError> {
        self.shared.delete_job(id).await
    }

    /// What was asked for when the job was submitted.
    pub fn request(&self, id: JobId) -> Result<JobRequest, FarmError> {
        Ok(self.shared.job(id)?.request())
    }

    /// What happened, oldest first: at most `limit` lines after line `after`, of one job or of all.
    pub async fn journal(&self, after: i64, job: Option<JobId>, limit: u16) -> Result<Vec<JournalRow>, FarmError> {
        Ok(self.shared.store.journal(after, job, i64::from(limit)).await?)
    }

    /// Returns when everything that happened so far is stored.
    ///
    /// # Errors
    /// Nothing is stored any more.
    pub async fn stored(&self) -> Result<(), FarmError> {
        self.shared.stored().await
    }

    /// All workers that are registered, in the order in which they came.
    pub fn workers(&self) -> Vec<WorkerStatus> {
        self.shared.lock().workers(&self.shared.clock, self.shared.options.lease_duration)
    }

    /// Gives a worker no further work; it leaves when it has done what it holds. Answers how it is doing.
    pub fn drain_worker(&self, caller: &Caller, id: &str) -> Result<WorkerStatus, FarmError> {
        self.shared.drain_worker(caller, id)
    }

    /// Takes no new jobs and gives no new leases; shards that are being traced may finish.
    pub fn drain(&self) {
        self.shared.lock().is_closed = true;
        self.shared.apply(Event::DrainBegan);
    }

    /// Whether it stops, and takes no new jobs.
    pub fn is_closed(&self) -> bool {
        self.shared.lock().is_closed
    }

    /// Cancelled when another coordinator leads, and this one has to stop.
    pub fn deposed(&self) -> CancellationToken {
        self.shared.deposed.clone()
    }

    /// Leases that workers hold.
    pub fn leases(&self) -> usize {
        self.shared.lock().rules.leases().active().count()
    }

    /// Drains and returns when every tally that arrived has been merged. Waiting requests are answered.
    pub async fn shutdown(&self) {
        self.drain();
        self.shared.stop().await;
    }
}
