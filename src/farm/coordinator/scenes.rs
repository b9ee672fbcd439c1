//! Scenes: checked once, kept as the bytes that came.

use std::sync::Arc;

use super::shared::{Shared, blocking};
use crate::farm::error::FarmError;
use crate::farm::prepared_scenes::prepare_scene;
use crate::method::SceneTraits;
use crate::scene::Integrator;

/// A scene that was uploaded, checked and prepared.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
pub struct SceneSummary {
    /// BLAKE3 of its bytes, 64 hexadecimal digits.
    pub hash: String,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Bytes of the file or archive.
    pub bytes: u64,
    /// The method that its integrator asks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integrator: Option<String>,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
}

/// What the coordinator knows of a scene.
pub(super) struct SceneRecord {
    pub(super) summary: SceneSummary,
    pub(super) traits: SceneTraits,
    pub(super) integrator: Option<Integrator>,
    bytes: Arc<[u8]>,
}

impl Shared {
    pub(super) fn scene(&self, hash: &str) -> Result<Arc<SceneRecord>, FarmError> {
        self.lock().scenes.get(hash).cloned().ok_or_else(|| FarmError::UnknownScene(hash.to_owned()))
    }

    pub(super) fn scenes(&self) -> Vec<SceneSummary> {
        let mut scenes: Vec<SceneSummary> = self.lock().scenes.values().map(|scene| scene.summary.clone()).collect();
        scenes.sort_by(|a, b| a.hash.cmp(&b.hash));
        scenes
    }

    pub(super) async fn scene_bytes(&self, hash: &str) -> Result<Arc<[u8]>, FarmError> {
        Ok(self.scene(hash)?.bytes.clone())
    }

    pub(super) async fn add_scene(&self, bytes: Vec<u8>) -> Result<SceneSummary, FarmError> {
        let limits = &self.options.limits;
        let (found, limit) = (bytes.len() as u64, limits.scene_bytes);
        if found > limit {
            return Err(FarmError::TooLarge { what: "the scene's size in bytes", found, limit });
        }
        let Ok(_slot) = self.uploads.try_acquire() else {
            let problem = format!("{} scenes are being uploaded already", limits.uploads);
            return Err(FarmError::Busy { problem, retry_after: limits.retry_after() });
        };
        let hash = blake3::hash(&bytes).to_hex().to_string();
        if let Ok(known) = self.scene(&hash) {
            return Ok(known.summary.clone());
        }
        let bytes: Arc<[u8]> = bytes.into();
        let record = self.check_scene(hash, bytes).await?;
        let summary = record.summary.clone();
        tracing::info!(scene = summary.hash, width = summary.width, height = summary.height, "scene added");
        self.lock().scenes.insert(summary.hash.clone(), Arc::new(record));
        Ok(summary)
    }

    /// Prepares a scene, so that nobody else in this process has to, and says what it is.
    async fn check_scene(&self, hash: String, bytes: Arc<[u8]>) -> Result<SceneRecord, FarmError> {
        let prepare = async {
            let bytes = bytes.clone();
            blocking(move || Ok(Arc::new(prepare_scene(&bytes)?))).await
        };
        let scene = self.options.scenes.get_or_prepare(&hash, prepare).await?;
        let (found, limit) = (u64::from(scene.width) * u64::from(scene.height), self.options.limits.pixels);
        if found > limit {
            return Err(FarmError::TooLarge { what: "the picture's size in pixels", found, limit });
        }
        let summary = SceneSummary {
            hash,
            width: scene.width,
            height: scene.height,
            bytes: bytes.len() as u64,
            integrator: scene.integrator.as_ref().map(|integrator| integrator.name.clone()),
            notices: scene.notices.clone(),
        };
        let (integrator, traits) = (scene.integrator.clone(), SceneTraits::of(&scene));
        Ok(SceneRecord { summary, integrator, traits, bytes })
    }

    pub(super) async fn delete_scene(&self, hash: &str) -> Result<(), FarmError> {
        let mut state = self.lock();
        if !state.scenes.contains_key(hash) {
            return Err(FarmError::UnknownScene(hash.to_owned()));
        }
        if let Some(job) = state.jobs.values().find(|job| job.description().scene == hash) {
            return Err(FarmError::Conflict {
                problem: format!("scene {hash} is the scene of job {}", job.id),
                remedy: "delete the job first".to_owned(),
            });
        }
        state.scenes.remove(hash);
        Ok(())
    }
}
