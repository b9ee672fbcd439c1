//! What a worker keeps between shards: renderers and radius fields. The least recently used goes first.

use std::sync::{Arc, Mutex};

use bytes::Bytes;
use prost::Message;

use super::client::{CallError, Client, TRANSFER_TIMEOUT};
use super::pool::RenderPool;
use crate::estimate::RadiusField;
use crate::farm::changed_scene::ChangedScene;
use crate::farm::ids::JobId;
use crate::farm::job::SceneChanges;
use crate::farm::locks::lock;
use crate::farm::prepared_scenes::{PreparedScenes, prepare_changed_scene};
use crate::farm::wire::lease::{JobDescription, ShardTerms};
use crate::farm::wire::{guides, messages, radius};
use crate::method::CheckedMethod;
use crate::render::Renderer;
use crate::scene::Scene;

const RENDERERS: usize = 3;
const FIELDS: usize = 6;

/// Work that cannot be prepared.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum PrepareError {
    /// The coordinator does not give what is needed.
    #[error(transparent)]
    Call(#[from] CallError),
    /// Scene or method cannot be used here.
    #[error("{0}")]
    Unusable(String),
}

/// The most recently used values by key.
struct Recent<K, V> {
    entries: Vec<(K, V)>,
    capacity: usize,
}

impl<K: PartialEq, V: Clone> Recent<K, V> {
    fn new(capacity: usize) -> Self {
        Self { entries: Vec::new(), capacity }
    }

    fn get(&mut self, key: &K) -> Option<V> {
        let index = self.entries.iter().position(|(known, _)| known == key)?;
        let entry = self.entries.remove(index);
        let value = entry.1.clone();
        self.entries.push(entry);
        Some(value)
    }

    fn insert(&mut self, key: K, value: V) {
        if self.entries.len() == self.capacity {
            self.entries.remove(0);
        }
        self.entries.push((key, value));
    }
}

/// Which radius field it is.
#[derive(Clone, Copy, PartialEq)]
struct FieldKey {
    job: JobId,
    generation: u32,
    epoch: u32,
    region: u32,
}

/// Which of a job's pilots: a job that is done again may have another.
#[derive(Clone, Copy, PartialEq)]
struct PilotKey {
    job: JobId,
    generation: u32,
}

/// A scene that others are with changes.
#[derive(Clone)]
struct Base {
    hash: String,
    bytes: Bytes,
}

/// The bytes of a scene, which are those that its hash names.
async fn scene_bytes(client: &Client, pool: &RenderPool, hash: &str) -> Result<Bytes, PrepareError> {
    let bytes = client.get(&format!("scenes/{hash}"), TRANSFER_TIMEOUT).await?;
    let expected = hash.to_owned();
    let check = move || if blake3::hash(&bytes).to_hex().as_str() == expected { Ok(bytes) } else { Err(expected) };
    let checked = pool.run(check).await.map_err(PrepareError::Unusable)?;
    checked.map_err(|hash| PrepareError::Unusable(format!("scene {hash} was damaged on its way")))
}

/// The caches of one session.
pub(super) struct Cache {
    scenes: PreparedScenes,
    renderers: Mutex<Recent<JobId, Arc<Renderer>>>,
    /// Renderers of passes, whose photons start as the pilot found.
    guided: Mutex<Recent<PilotKey, Arc<Renderer>>>,
    fields: Mutex<Recent<FieldKey, Arc<RadiusField>>>,
    base: Mutex<Option<Base>>,
}

impl Cache {
    /// Empty caches beside the process's scenes.
    pub(super) fn new(scenes: PreparedScenes) -> Self {
        let (renderers, guided) = (Mutex::new(Recent::new(RENDERERS)), Mutex::new(Recent::new(RENDERERS)));
        Self { scenes, renderers, guided, fields: Mutex::new(Recent::new(FIELDS)), base: Mutex::default() }
    }

    /// The job's renderer.
    pub(super) async fn renderer(
        &self,
        client: &Client,
        pool: &RenderPool,
        job: &JobDescription,
    ) -> Result<Arc<Renderer>, PrepareError> {
        if let Some(renderer) = lock(&self.renderers).get(&job.id) {
            return Ok(renderer);
        }
        let scene = self.scene(client, pool, &job.scene).await?;
        let method =
            job.method.clone().ok_or_else(|| PrepareError::Unusable("the job has no method yet".to_owned()))?;
        let (seed, keeps_groups) = (job.seed, !job.light_groups.is_empty());
        let prepare = move || {
            let renderer = Renderer::new(scene, &method, seed).map_err(|problem| problem.to_string())?;
            if keeps_groups {
                renderer.with_light_groups().map_err(|problem| problem.to_string())
            } else {
                Ok(renderer)
            }
        };
        let made = pool.run(prepare).await;
        let renderer = Arc::new(made.and_then(|made| made).map_err(PrepareError::Unusable)?);
        if job.declaration().as_ref() != Some(renderer.declaration()) {
            return Err(PrepareError::Unusable("the job's light groups are not those of its scene".to_owned()));
        }
        lock(&self.renderers).insert(job.id, renderer.clone());
        Ok(renderer)
    }

    /// The renderer of a job's passes. Methods whose pilot learns nothing need no guides, and none are fetched.
    pub(super) async fn pass_renderer(
        &self,
        client: &Client,
        pool: &RenderPool,
        job: &JobDescription,
        terms: &ShardTerms,
    ) -> Result<Arc<Renderer>, PrepareError> {
        let key = PilotKey { job: job.id, generation: terms.generation };
        if let Some(renderer) = lock(&self.guided).get(&key) {
            return Ok(renderer);
        }
        let renderer = self.renderer(client, pool, job).await?;
        if !job.method.as_ref().is_some_and(CheckedMethod::may_be_guided) {
            return Ok(renderer);
        }
        let bytes = client.get(&format!("jobs/{}/guide", job.id), TRANSFER_TIMEOUT).await?;
        let message = messages::Guides::decode(bytes).map_err(|e| PrepareError::Unusable(e.to_string()))?;
        let guides = guides::decode(&message).map_err(|e| PrepareError::Unusable(e.to_string()))?;
        let guided = renderer.guided(&guides).map_err(|e| PrepareError::Unusable(e.to_string()))?;
        let guided = Arc::new(guided);
        lock(&self.guided).insert(key, guided.clone());
        Ok(guided)
    }

    /// A prepared scene.
    pub(super) async fn scene(
        &self,
        client: &Client,
        pool: &RenderPool,
        hash: &str,
    ) -> Result<Arc<Scene>, PrepareError> {
        let prepare = async {
            let bytes = scene_bytes(client, pool, hash).await?;
            let changed =
                ChangedScene::decode(&bytes).map_err(|problem| PrepareError::Unusable(problem.to_string()))?;
            let (bytes, changes) = match changed {
                Some(ChangedScene { base, changes }) => (self.base_bytes(client, pool, &base).await?, changes),
                None => (bytes, SceneChanges::default()),
            };
            let prepare = move || prepare_changed_scene(&bytes, &changes).map_err(|problem| problem.to_string());
            let scene = pool.run(prepare).await.and_then(|scene| scene).map_err(PrepareError::Unusable)?;
            Ok(Arc::new(scene))
        };
        self.scenes.get_or_prepare(hash, prepare).await
    }

    /// The bytes of a scene that others are with changes. The last one's are kept: the frames of a sequence ask for them one after the other.
    async fn base_bytes(&self, client: &Client, pool: &RenderPool, hash: &str) -> Result<Bytes, PrepareError> {
        let known = lock(&self.base).clone().filter(|known| known.hash == hash);
        if let Some(known) = known {
            return Ok(known.bytes);
        }
        let bytes = scene_bytes(client, pool, hash).await?;
        *lock(&self.base) = Some(Base { hash: hash.to_owned(), bytes: bytes.clone() });
        Ok(bytes)
    }

    /// The radius field with which a shard is traced. Methods that gather nothing need none, and none is fetched.
    pub(super) async fn field(
        &self,
        client: &Client,
        job: &JobDescription,
        terms: &ShardTerms,
    ) -> Result<Arc<RadiusField>, PrepareError> {
        let unusable = |problem: String| PrepareError::Unusable(problem);
        let declaration = job.declaration().ok_or_else(|| unusable("the job has no method yet".to_owned()))?;
        if !declaration.has_radii() {
            return Ok(Arc::new(RadiusField::none()));
        }
        let planned = &terms.planned;
        let (epoch, region) = (planned.field_epoch, planned.region);
        let key = FieldKey { job: job.id, generation: terms.generation, epoch, region };
        if let Some(field) = lock(&self.fields).get(&key) {
            return Ok(field);
        }
        let bytes = client.get(&format!("jobs/{}/radius/{epoch}/{region}", job.id), TRANSFER_TIMEOUT).await?;
        let message = messages::RadiusField::decode(bytes).map_err(|e| PrepareError::Unusable(e.to_string()))?;
        let pixels = planned.shard.region.pixel_count(job.width);
        let field = radius::decode(&message, pixels).map_err(|e| PrepareError::Unusable(e.to_string()))?;
        let field = Arc::new(field);
        lock(&self.fields).insert(key, field.clone());
        Ok(field)
    }
}
