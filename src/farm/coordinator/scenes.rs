//! Scenes: checked once, kept as the bytes that came.

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use bytes::Bytes;
use tokio::sync::OwnedSemaphorePermit;

use super::blocking::blocking;
use super::quotas::OwnUpload;
use super::scene_record::{SceneLayout, SceneRecord, SceneSummary};
use super::shared::{JobRecord, Shared};
use crate::farm::access::user::UserName;
use crate::farm::changed_scene::ChangedScene;
use crate::farm::error::FarmError;
use crate::farm::job::SceneChanges;
use crate::farm::prepared_scenes::prepare_changed_scene;
use crate::farm::rules::Event;
use crate::farm::store::blobs::Uploaded;
use crate::farm::store::scenes::SceneRow;
use crate::farm::store::{BlobName, StoreError, Upload};
use crate::farm::wire::lease::JobDescription;
use crate::method::{self, CheckedMethod, SceneTraits};
use crate::scene::Scene;
use crate::scene::light::groups::OTHERS;

impl Shared {
    pub(super) fn scene(&self, hash: &str) -> Result<Arc<SceneRecord>, FarmError> {
        self.lock().scenes.get(hash).cloned().ok_or_else(|| FarmError::UnknownScene(hash.to_owned()))
    }

    pub(super) fn scenes(&self) -> Vec<SceneSummary> {
        let mut scenes: Vec<SceneSummary> = self.lock().scenes.values().map(|scene| scene.summary.clone()).collect();
        scenes.sort_by(|a, b| a.hash.cmp(&b.hash));
        scenes
    }

    pub(super) async fn scene_bytes(&self, hash: &str) -> Result<Bytes, FarmError> {
        self.scene(hash)?;
        let bytes = self.store.blobs().get(&BlobName::of_scene(hash)).await;
        if let Err(problem) = &bytes
            && problem.is_for_good()
        {
            self.fail_jobs_of(hash, problem);
        }
        Ok(bytes?)
    }

    /// No worker will ever have the scene.
    fn fail_jobs_of(&self, hash: &str, problem: &StoreError) {
        let is_of_scene = |job: &Arc<JobRecord>| {
            let own = job.description().scene;
            own == hash || self.scene(&own).is_ok_and(|scene| scene.base.as_deref() == Some(hash))
        };
        for job in self.live_jobs().into_iter().filter(is_of_scene) {
            self.apply(Event::JobFailed { job: job.id, problem: format!("its scene is lost: {problem}") });
        }
    }

    /// Makes place for an upload; at most so many at a time.
    pub(super) async fn begin_upload(self: &Arc<Self>, owner: Option<UserName>) -> Result<SceneUpload, FarmError> {
        let slot = self.upload_slot(owner.as_ref())?;
        let upload = self.store.blobs().begin_scene().await?;
        Ok(SceneUpload { shared: self.clone(), upload, owner, _slot: slot })
    }

    /// The place of one scene that is taken in for `owner`, until it is dropped.
    pub(super) fn upload_slot(self: &Arc<Self>, owner: Option<&UserName>) -> Result<UploadSlot, FarmError> {
        let limits = &self.options.limits;
        let Ok(place) = self.uploads.clone().try_acquire_owned() else {
            let problem = format!("{} scenes are being uploaded already", limits.uploads);
            return Err(FarmError::Busy { problem, retry_after: limits.retry_after() });
        };
        Ok(UploadSlot { _place: place, _own: self.take_upload_of(owner)? })
    }

    /// Uploads a scene whose bytes are all there.
    pub(super) async fn upload_all(
        self: &Arc<Self>,
        bytes: &[u8],
        owner: Option<UserName>,
    ) -> Result<SceneUpload, FarmError> {
        let mut upload = self.begin_upload(owner).await?;
        match upload.write(bytes).await {
            Ok(()) => Ok(upload),
            Err(problem) => {
                upload.abort().await?;
                Err(problem)
            }
        }
    }

    /// Checks an uploaded scene and keeps it, or leaves nothing of it.
    async fn add_uploaded(&self, uploaded: Uploaded, owner: Option<UserName>) -> Result<SceneSummary, FarmError> {
        let hash = uploaded.hash.clone();
        if let Ok(known) = self.scene(&hash) {
            known.uploaded.store(self.clock.unix_milliseconds(), Ordering::Relaxed);
            uploaded.discard().await?;
            return Ok(known.summary.clone());
        }
        let record = match self.check_scene(&uploaded, owner.clone()).await {
            Ok(record) => record,
            Err(problem) => {
                uploaded.discard().await?;
                return Err(problem);
            }
        };
        let _turn = match self.catalogue.take().await {
            Ok(turn) => turn,
            Err(problem) => {
                uploaded.discard().await?;
                return Err(problem);
            }
        };
        // Somebody may have uploaded the same, or as much as they may, while this was checked.
        if let Ok(known) = self.scene(&hash) {
            uploaded.discard().await?;
            return Ok(known.summary.clone());
        }
        let is_allowed = self.check_user_scenes(owner.as_ref(), uploaded.bytes);
        // Somebody may have deleted the scene that this one changes.
        if let Err(problem) =
            is_allowed.and_then(|()| record.base.as_deref().map_or(Ok(()), |base| self.scene(base).map(drop)))
        {
            uploaded.discard().await?;
            return Err(problem);
        }
        uploaded.keep().await?;
        let row = SceneRow {
            hash: hash.clone(),
            bytes: uploaded.bytes as i64,
            created: self.clock.unix_milliseconds(),
            // Plain data with string keys always has a JSON form.
            record: serde_json::to_string(&record).unwrap_or_default(),
        };
        self.store.insert_scene(&row).await?;
        let summary = record.summary.clone();
        tracing::info!(scene = hash, width = summary.width, height = summary.height, "scene added");
        self.lock().scenes.insert(hash, Arc::new(record));
        Ok(summary)
    }

    /// Prepares a scene, so that nobody else in this process has to, and says what it is.
    async fn check_scene(&self, uploaded: &Uploaded, owner: Option<UserName>) -> Result<SceneRecord, FarmError> {
        let hash = uploaded.hash.clone();
        let bytes = uploaded.read().await?;
        let base = self.changes_of(&hash, &bytes)?.map(|changed| changed.base);
        let scene = self.prepared(&hash, async { Ok(bytes) }).await?;
        let (found, limit) = (u64::from(scene.width) * u64::from(scene.height), self.options.limits.pixels);
        if found > limit {
            return Err(FarmError::TooLarge { what: "the picture's size in pixels", found, limit });
        }
        let summary = SceneSummary {
            hash,
            width: scene.width,
            height: scene.height,
            bytes: uploaded.bytes,
            owner,
            integrator: scene.integrator.as_ref().map(|integrator| integrator.name.clone()),
            light_groups: light_groups_of(&scene),
            notices: scene.notices.clone(),
        };
        let (integrator, traits) = (scene.integrator.clone(), SceneTraits::of(&scene));
        let uploaded = AtomicI64::new(self.clock.unix_milliseconds());
        let camera = scene.camera.matrices(&scene.film);
        Ok(SceneRecord { summary, base, integrator, traits, camera, uploaded })
    }

    /// Whether a scene can take parameters of the job's method that name places in it; its `bytes` are asked for only then.
    pub(super) async fn check_places(
        &self,
        job: &JobDescription,
        bytes: impl Future<Output = Result<Bytes, FarmError>>,
    ) -> Result<(), FarmError> {
        let Some(method) = job.method.clone().filter(CheckedMethod::names_places) else { return Ok(()) };
        let scene = self.prepared(&job.scene, bytes).await?;
        blocking(move || Ok(method::check_in_scene(&method, &scene)?)).await
    }

    /// Where the camera and the lights of a scene stand.
    pub(super) async fn layout(
        self: &Arc<Self>,
        hash: &str,
        owner: Option<&UserName>,
    ) -> Result<SceneLayout, FarmError> {
        let slot = self.upload_slot(owner)?;
        let scene = self.prepared(hash, self.scene_bytes(hash)).await?;
        blocking(move || {
            let _slot = slot;
            let camera = scene.camera.matrices(&scene.film);
            let lights = scene.lights.whereabouts(&scene.geometry);
            Ok(SceneLayout { first_pixel: scene.film.offset, camera, lights })
        })
        .await
    }

    /// A scene that can be traced; its `bytes` are asked for where this process has not prepared it lately.
    async fn prepared(
        &self,
        hash: &str,
        bytes: impl Future<Output = Result<Bytes, FarmError>>,
    ) -> Result<Arc<Scene>, FarmError> {
        let prepare = async {
            let bytes = bytes.await?;
            let (bytes, changes) = match self.changes_of(hash, &bytes)? {
                Some(ChangedScene { base, changes }) => (self.scene_bytes(&base).await?, changes),
                None => (bytes, SceneChanges::default()),
            };
            blocking(move || Ok(Arc::new(prepare_changed_scene(&bytes, &changes)?))).await
        };
        self.options.scenes.get_or_prepare(hash, prepare).await
    }

    /// The bytes of the scene with this hash, or of the one that it changes.
    pub(super) async fn whole_scene_bytes(&self, hash: &str) -> Result<Bytes, FarmError> {
        let bytes = self.scene_bytes(hash).await?;
        match self.changes_of(hash, &bytes)? {
            Some(changed) => self.scene_bytes(&changed.base).await,
            None => Ok(bytes),
        }
    }

    /// Which scene with which changes these bytes are, if they are no whole scene.
    fn changes_of(&self, hash: &str, bytes: &[u8]) -> Result<Option<ChangedScene>, FarmError> {
        let refused = |problem: String| FarmError::BadRequest {
            problem: format!("scene {hash} is no scene: {problem}"),
            remedy: "upload a scene of one of the formats, and give its changes with a job".to_owned(),
        };
        let changed = ChangedScene::decode(bytes).map_err(|problem| refused(problem.to_string()))?;
        let Some(changed) = changed else { return Ok(None) };
        match self.scene(&changed.base) {
            Ok(base) if base.base.is_none() => Ok(Some(changed)),
            _ => Err(refused("what it changes is not here, or a changed scene itself".to_owned())),
        }
    }

    /// The bytes of the scene with this hash as `changes` make it.
    pub(super) async fn changed_scene(&self, hash: &str, changes: SceneChanges) -> Result<Vec<u8>, FarmError> {
        let whole = ChangedScene { base: hash.to_owned(), changes: SceneChanges::default() };
        let known = match self.scene(hash)?.base {
            Some(_) => self.changes_of(hash, &self.scene_bytes(hash).await?)?.unwrap_or(whole),
            None => whole,
        };
        Ok(ChangedScene { base: known.base, changes: changes.over(known.changes) }.encode())
    }

    /// Takes the scenes of the store over.
    pub(super) async fn take_over_scenes(&self) -> Result<(), FarmError> {
        for row in self.store.scene_rows().await? {
            let bad = |problem: serde_json::Error| StoreError::BadRecord {
                what: format!("scene {}", row.hash),
                problem: problem.to_string(),
            };
            let record: SceneRecord = serde_json::from_str(&row.record).map_err(bad)?;
            record.uploaded.store(row.created, Ordering::Relaxed);
            self.lock().scenes.insert(row.hash, Arc::new(record));
        }
        Ok(())
    }

    pub(super) async fn delete_scene(&self, hash: &str) -> Result<(), FarmError> {
        let _turn = self.catalogue.take().await?;
        if let Some(sequence) = self.sequences_to_make().into_iter().find(|sequence| sequence.scene == hash) {
            return Err(FarmError::Conflict {
                problem: format!("scene {hash} is the scene of sequence {}, of which frames are missing", sequence.id),
                remedy: "delete the sequence first".to_owned(),
            });
        }
        {
            let state = self.lock();
            if !state.scenes.contains_key(hash) {
                return Err(FarmError::UnknownScene(hash.to_owned()));
            }
            if let Some(job) = state.jobs.values().find(|job| job.description().scene == hash) {
                return Err(FarmError::Conflict {
                    problem: format!("scene {hash} is the scene of job {}", job.id),
                    remedy: "delete the job first".to_owned(),
                });
            }
            if let Some((changed, _)) = state.scenes.iter().find(|(_, scene)| scene.base.as_deref() == Some(hash)) {
                return Err(FarmError::Conflict {
                    problem: format!("scene {changed} is scene {hash} with changes"),
                    remedy: "delete that first".to_owned(),
                });
            }
        }
        Ok(self.erase_scene(hash).await?)
    }

    /// Nothing of a scene stays. Who calls has the catalogue's turn.
    async fn erase_scene(&self, hash: &str) -> Result<(), StoreError> {
        self.store.delete_scene(hash).await?;
        self.lock().scenes.remove(hash);
        self.store.blobs().delete(&BlobName::of_scene(hash)).await
    }

    /// Deletes the scenes that nobody uploaded since `before`, milliseconds since 1970, and that no job refers to.
    pub(super) async fn delete_old_scenes(&self, before: i64) -> Result<(), StoreError> {
        let Some(_turn) = self.catalogue.take_now() else { return Ok(()) };
        let of_sequences = self.sequences_to_make().into_iter().map(|sequence| sequence.scene);
        let old: Vec<String> = {
            let state = self.lock();
            let of_jobs = state.jobs.values().map(|job| job.description().scene);
            // These go the next time.
            let of_changed = state.scenes.values().filter_map(|scene| scene.base.clone());
            let used: HashSet<String> = of_jobs.chain(of_changed).chain(of_sequences).collect();
            let is_old = |scene: &SceneRecord| scene.uploaded.load(Ordering::Relaxed) < before;
            let old = state.scenes.iter().filter(|(hash, scene)| !used.contains(*hash) && is_old(scene));
            old.map(|(hash, _)| hash.clone()).collect()
        };
        for hash in old {
            self.erase_scene(&hash).await?;
        }
        Ok(())
    }
}

/// The light groups that lights of a scene name, and where there are any also that of the other lights.
fn light_groups_of(scene: &Scene) -> Vec<String> {
    let names = scene.lights.groups().names();
    if names == [OTHERS] { Vec::new() } else { names.to_vec() }
}

/// The place of one scene that is taken in.
pub(super) struct UploadSlot {
    _place: OwnedSemaphorePermit,
    _own: Option<OwnUpload>,
}

/// A scene on its way: written to the store and hashed as it comes.
pub struct SceneUpload {
    shared: Arc<Shared>,
    upload: Upload,
    owner: Option<UserName>,
    _slot: UploadSlot,
}

impl SceneUpload {
    /// Takes the next bytes.
    ///
    /// # Errors
    /// More than a scene may have.
    pub async fn write(&mut self, bytes: &[u8]) -> Result<(), FarmError> {
        let (found, limit) = (self.upload.bytes() + bytes.len() as u64, self.shared.options.limits.scene_bytes);
        if found > limit {
            return Err(FarmError::TooLarge { what: "the scene's size in bytes", found, limit });
        }
        Ok(self.upload.write(bytes).await?)
    }

    /// All bytes came: checks the scene and keeps it.
    pub async fn finish(self) -> Result<SceneSummary, FarmError> {
        let uploaded = self.upload.finish().await?;
        self.shared.add_uploaded(uploaded, self.owner).await
    }

    /// All bytes came: checks the scene, and keeps nothing of it.
    pub(super) async fn check(self) -> Result<Arc<SceneRecord>, FarmError> {
        let uploaded = self.upload.finish().await?;
        let checked = self.shared.check_scene(&uploaded, self.owner).await;
        uploaded.discard().await?;
        checked.map(Arc::new)
    }

    /// Nothing of it stays.
    pub async fn abort(self) -> Result<(), FarmError> {
        Ok(self.upload.abort().await?)
    }
}
