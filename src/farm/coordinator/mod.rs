//! The coordinator: the [schedule](crate::farm::rules::schedule) with a clock, locks and threads round it.
//!
//! Callers hold a [`CoordinatorHandle`]. One mutex guards the schedule and is only held for bookkeeping. Each job has a
//! second one for its [merge state](crate::farm::merging), held by blocking threads that decode and add. Where both are
//! needed the merge state is locked first.

mod layers;
pub mod request;
mod status;

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

use crate::farm::error::FarmError;
use crate::farm::job::{JobRequest, JobStatus, StopRule, WorkerStatus};
use crate::farm::merging::Merging;
use layers::SeenFirst;

use crate::estimate::Picture;
use crate::farm::rules::progress::ErrorAtTime;
use crate::farm::rules::schedule::Schedule;
use crate::farm::wire::lease::JobDescription;
use crate::method::SceneTraits;
use crate::render::first_surface::FirstSurface;
use crate::scene::error::SceneError;
use crate::scene::{Integrator, Scene};

/// How often time passes for the schedule.
const TICK: Duration = Duration::from_millis(200);

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

/// The door to a running coordinator. Cheap to clone; all clones speak to the same one.
#[derive(Clone)]
pub struct CoordinatorHandle {
    pub(super) shared: Arc<Shared>,
}

/// What all clones of a handle share.
pub(super) struct Shared {
    pub(super) options: CoordinatorOptions,
    started: Instant,
    state: Mutex<State>,
    /// Rises whenever a waiting worker should ask again.
    pub(super) work: watch::Sender<u64>,
    stopped: CancellationToken,
    /// Uploads and results under way.
    pub(super) busy: tokio_util::task::TaskTracker,
}

/// What the state mutex guards.
pub(super) struct State {
    pub(super) schedule: Schedule,
    pub(super) jobs: BTreeMap<u64, Arc<JobRecord>>,
    scenes: HashMap<String, Arc<SceneRecord>>,
    is_closed: bool,
}

struct SceneRecord {
    summary: SceneSummary,
    traits: SceneTraits,
    integrator: Option<Integrator>,
    bytes: Arc<[u8]>,
    seen_first: SeenFirst,
}

/// A job beside its schedule.
pub(super) struct JobRecord {
    pub(super) number: u64,
    pub(super) description: JobDescription,
    pub(super) stop: StopRule,
    pub(super) merging: Mutex<Option<Merging>>,
    status: watch::Sender<JobStatus>,
}

/// Locks, also after a panic elsewhere: what a mutex here guards is consistent between statements.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `work` on a thread that may block.
pub(super) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, FarmError> + Send + 'static,
) -> Result<T, FarmError> {
    match tokio::task::spawn_blocking(work).await {
        Ok(result) => result,
        Err(problem) => {
            tracing::error!(%problem, "the coordinator's own work failed");
            Err(FarmError::Internal(problem.to_string()))
        }
    }
}

impl CoordinatorHandle {
    /// Starts a coordinator without scenes, jobs and workers. Must be called inside a tokio runtime.
    pub fn start(options: CoordinatorOptions) -> Self {
        // Ids that rise from one run to the next: a worker of an earlier run is not taken for one of this.
        let first_id = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_micros() as u64);
        let state = State {
            schedule: Schedule::new(options.lease_duration, first_id),
            jobs: BTreeMap::new(),
            scenes: HashMap::new(),
            is_closed: false,
        };
        let shared = Shared {
            options,
            started: Instant::now(),
            state: Mutex::new(state),
            work: watch::Sender::new(0),
            stopped: CancellationToken::new(),
            busy: tokio_util::task::TaskTracker::new(),
        };
        let shared = Arc::new(shared);
        tokio::spawn(keep_time(Arc::downgrade(&shared), shared.stopped.clone()));
        Self { shared }
    }

    /// Checks and keeps a scene: XML or JSON that stands alone, or a zip archive. The same bytes again cost nothing.
    pub async fn add_scene(&self, bytes: Vec<u8>) -> Result<SceneSummary, FarmError> {
        let (found, limit) = (bytes.len() as u64, self.shared.options.max_scene_bytes);
        if found > limit {
            return Err(FarmError::TooLarge { what: "the scene's size in bytes", found, limit });
        }
        let shared = self.shared.clone();
        blocking(move || shared.add_scene(bytes)).await
    }

    /// What is known of an uploaded scene.
    pub fn scene(&self, hash: &str) -> Result<SceneSummary, FarmError> {
        self.shared.scene(hash).map(|scene| scene.summary.clone())
    }

    /// The bytes of an uploaded scene, as they came.
    pub fn scene_bytes(&self, hash: &str) -> Result<Arc<[u8]>, FarmError> {
        self.shared.scene(hash).map(|scene| scene.bytes.clone())
    }

    /// Checks a request and queues the job; answers its id.
    pub async fn submit(&self, request: JobRequest) -> Result<String, FarmError> {
        let shared = self.shared.clone();
        if !request::asks_for_auto(&request) {
            return shared.submit(&request, None);
        }
        blocking(move || shared.submit_after_trials(request)).await
    }

    /// A job's error as it was estimated from time to time.
    pub fn error_history(&self, id: &str) -> Result<Vec<ErrorAtTime>, FarmError> {
        let job = self.shared.job(id)?;
        let state = self.shared.lock();
        Ok(state.schedule.job(job.number).map(|progress| progress.history.clone()).unwrap_or_default())
    }

    /// All jobs, oldest first.
    pub fn jobs(&self) -> Vec<JobStatus> {
        let state = self.shared.lock();
        state.jobs.values().map(|job| state.status(job, self.shared.now())).collect()
    }

    /// How a job is doing now.
    pub fn job(&self, id: &str) -> Result<JobStatus, FarmError> {
        let job = self.shared.job(id)?;
        Ok(self.shared.lock().status(&job, self.shared.now()))
    }

    /// A job's status as it changes. The last value stays readable after the job has ended.
    pub fn watch(&self, id: &str) -> Result<watch::Receiver<JobStatus>, FarmError> {
        Ok(self.shared.job(id)?.status.subscribe())
    }

    /// The picture as merged so far, and the status that belongs to it.
    pub async fn picture(&self, id: &str) -> Result<(Picture, JobStatus), FarmError> {
        let (picture, _, status) = self.picture_with_layers(id, &[]).await?;
        Ok((picture, status))
    }

    /// Stops a job and keeps its picture. A job that has ended already stays as it is.
    pub fn cancel(&self, id: &str) -> Result<JobStatus, FarmError> {
        let job = self.shared.job(id)?;
        self.shared.change(|schedule, now| schedule.cancel(now, job.number));
        self.job(id)
    }

    /// All workers that are registered, in the order in which they came.
    pub fn workers(&self) -> Vec<WorkerStatus> {
        let (state, now) = (self.shared.lock(), self.shared.now());
        state.workers(now)
    }

    /// Takes no new jobs and gives no new leases; shards that are being traced may finish.
    pub fn drain(&self) {
        self.shared.lock().is_closed = true;
        self.shared.change(|schedule, _| schedule.drain());
    }

    /// Drains and returns when every tally that arrived has been merged. Waiting requests are answered.
    pub async fn shutdown(&self) {
        self.drain();
        self.shared.busy.close();
        self.shared.busy.wait().await;
        self.shared.stopped.cancel();
    }
}

impl Shared {
    /// Time since start.
    pub(super) fn now(&self) -> Duration {
        self.started.elapsed()
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// Lets `event` happen to the schedule, then tells whoever watches jobs or waits for work.
    pub(super) fn change<T>(&self, event: impl FnOnce(&mut Schedule, Duration) -> T) -> T {
        let mut state = self.lock();
        let now = self.now();
        let answer = event(&mut state.schedule, now);
        let changed = state.schedule.take_changed();
        for job in changed.iter().filter_map(|number| state.jobs.get(number)) {
            job.status.send_replace(state.status(job, now));
        }
        drop(state);
        if !changed.is_empty() {
            self.work.send_modify(|version| *version += 1);
        }
        answer
    }

    fn scene(&self, hash: &str) -> Result<Arc<SceneRecord>, FarmError> {
        self.lock().scenes.get(hash).cloned().ok_or_else(|| FarmError::UnknownScene(hash.to_owned()))
    }

    /// What the pixels of an uploaded scene see first.
    pub(super) fn first_surface(&self, scene: &str) -> Result<Arc<[FirstSurface]>, FarmError> {
        let scene = self.scene(scene)?;
        scene.seen_first.of(&scene.bytes)
    }

    /// The job with this id.
    pub(super) fn job(&self, id: &str) -> Result<Arc<JobRecord>, FarmError> {
        let number = id.strip_prefix("job-").and_then(|number| number.parse().ok()).unwrap_or(0);
        let job = self.lock().jobs.get(&number).cloned();
        job.filter(|job| job.description.id == id).ok_or_else(|| FarmError::UnknownJob(id.to_owned()))
    }

    fn add_scene(&self, bytes: Vec<u8>) -> Result<SceneSummary, FarmError> {
        let hash = blake3::hash(&bytes).to_hex().to_string();
        if let Ok(known) = self.scene(&hash) {
            return Ok(known.summary.clone());
        }
        let scene = prepare_scene(&bytes)?;
        let (found, limit) = (u64::from(scene.width) * u64::from(scene.height), self.options.max_pixels);
        if found > limit {
            return Err(FarmError::TooLarge { what: "the picture's size in pixels", found, limit });
        }
        let summary = SceneSummary {
            hash: hash.clone(),
            width: scene.width,
            height: scene.height,
            integrator: scene.integrator.as_ref().map(|integrator| integrator.name.clone()),
            notices: scene.notices.clone(),
        };
        tracing::info!(scene = hash, width = summary.width, height = summary.height, "scene added");
        let record = SceneRecord {
            summary: summary.clone(),
            integrator: scene.integrator.clone(),
            traits: SceneTraits::of(&scene),
            bytes: bytes.into(),
            seen_first: SeenFirst::default(),
        };
        self.lock().scenes.insert(hash, Arc::new(record));
        Ok(summary)
    }

    fn submit_after_trials(&self, mut request: JobRequest) -> Result<String, FarmError> {
        request::check_stop(request.stop)?;
        let scene = prepare_scene(&self.scene(&request.scene)?.bytes)?;
        let found = request::choose_method(&mut request, scene)?;
        self.submit(&request, Some(found.reason()))
    }

    fn submit(&self, request: &JobRequest, reason: Option<String>) -> Result<String, FarmError> {
        let scene = self.scene(&request.scene)?;
        let (width, height) = (scene.summary.width, scene.summary.height);
        let pixels = u64::from(width) * u64::from(height);
        let resolved = request::resolve_method(request, scene.integrator.as_ref(), pixels, scene.traits)?;
        let stop = request::resolve_stop(request.stop, &resolved.method)?;
        let notices = scene.summary.notices.iter().cloned().chain(reason).chain(resolved.notices).collect();
        let mut state = self.lock();
        if state.is_closed {
            return Err(FarmError::ShuttingDown);
        }
        let number = state.jobs.len() as u64 + 1;
        let id = format!("job-{number}");
        let description = JobDescription {
            id: id.clone(),
            scene: request.scene.clone(),
            method: resolved.method,
            seed: request.seed,
            width,
            height,
        };
        tracing::info!(job = id, scene = request.scene, method = description.method.choice.name, "job queued");
        state.schedule.add_job(number, stop, notices);
        let status = watch::Sender::new(description.status(stop));
        let job = JobRecord { number, description, stop, merging: Mutex::new(None), status };
        state.jobs.insert(number, Arc::new(job));
        drop(state);
        self.change(|_, _| ());
        Ok(id)
    }
}

impl JobRecord {
    /// Reads the merge state, once something has been merged.
    pub(super) fn with_merged<T>(&self, read: impl FnOnce(&Merging) -> T) -> Result<T, FarmError> {
        let merging = lock(&self.merging);
        let merged = merging.as_ref().filter(|merging| merging.totals().shards > 0);
        merged.map(read).ok_or_else(|| FarmError::NoPictureYet(self.description.id.clone()))
    }
}

/// From the bytes of an upload to a scene that can be rendered. Coordinator and workers read scenes alike.
pub(super) fn prepare_scene(bytes: &[u8]) -> Result<Scene, SceneError> {
    let description = crate::scene::import::load_bytes("scene", bytes, &[])?;
    Scene::prepare(&description)
}

/// Lets time pass until the coordinator is stopped or dropped.
async fn keep_time(shared: std::sync::Weak<Shared>, stopped: CancellationToken) {
    let mut interval = tokio::time::interval(TICK);
    while stopped.run_until_cancelled(interval.tick()).await.is_some() {
        match shared.upgrade() {
            Some(shared) => shared.change(|schedule, now| schedule.tick(now)),
            None => return,
        }
    }
}
