//! What a worker keeps between shards: prepared scenes, renderers, radius fields. The least recently used goes first.

use std::sync::{Arc, Mutex};

use prost::Message;

use super::client::{CallError, Client};
use super::pool::RenderPool;
use super::session::TRANSFER_TIMEOUT;
use crate::estimate::RadiusField;
use crate::farm::coordinator::{lock, prepare_scene};
use crate::farm::rules::plan::PlannedShard;
use crate::farm::wire::lease::JobDescription;
use crate::farm::wire::{messages, radius};
use crate::render::Renderer;
use crate::scene::Scene;

const SCENES: usize = 2;
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

/// The caches of one session. Jobs' ids are only unique while the coordinator runs, so they end with it.
pub(super) struct Cache {
    scenes: Mutex<Recent<String, Arc<Scene>>>,
    renderers: Mutex<Recent<String, Arc<Renderer>>>,
    fields: Mutex<Recent<(String, u32, u32), Arc<RadiusField>>>,
}

impl Cache {
    /// Empty caches.
    pub(super) fn new() -> Self {
        Self {
            scenes: Mutex::new(Recent::new(SCENES)),
            renderers: Mutex::new(Recent::new(RENDERERS)),
            fields: Mutex::new(Recent::new(FIELDS)),
        }
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
        let (method, seed) = (job.method.clone(), job.seed);
        let made = pool.run(move || Renderer::new(scene, &method, seed).map_err(|problem| problem.to_string())).await;
        let renderer = Arc::new(made.and_then(|made| made).map_err(PrepareError::Unusable)?);
        lock(&self.renderers).insert(job.id.clone(), renderer.clone());
        Ok(renderer)
    }

    async fn scene(&self, client: &Client, pool: &RenderPool, hash: &str) -> Result<Arc<Scene>, PrepareError> {
        if let Some(scene) = lock(&self.scenes).get(&hash.to_owned()) {
            return Ok(scene);
        }
        let bytes = client.get(&format!("scenes/{hash}"), TRANSFER_TIMEOUT).await?;
        let expected = hash.to_owned();
        let prepare = move || {
            if blake3::hash(&bytes).to_hex().as_str() != expected {
                return Err(format!("scene {expected} was damaged on its way"));
            }
            prepare_scene(&bytes).map_err(|problem| problem.to_string())
        };
        let scene = pool.run(prepare).await.and_then(|scene| scene).map_err(PrepareError::Unusable)?;
        let scene = Arc::new(scene);
        lock(&self.scenes).insert(hash.to_owned(), scene.clone());
        Ok(scene)
    }

    /// The radius field with which `planned` is traced. Methods that gather nothing need none, and none is fetched.
    pub(super) async fn field(
        &self,
        client: &Client,
        job: &JobDescription,
        planned: &PlannedShard,
    ) -> Result<Arc<RadiusField>, PrepareError> {
        let unusable = |problem: crate::method::MethodError| PrepareError::Unusable(problem.to_string());
        if !crate::method::declaration(&job.method).map_err(unusable)?.has_radii() {
            return Ok(Arc::new(RadiusField::none()));
        }
        let key = (job.id.clone(), planned.field_epoch, planned.region);
        if let Some(field) = lock(&self.fields).get(&key) {
            return Ok(field);
        }
        let path = format!("jobs/{}/radius/{}/{}", key.0, key.1, key.2);
        let bytes = client.get(&path, TRANSFER_TIMEOUT).await?;
        let message = messages::RadiusField::decode(bytes).map_err(|e| PrepareError::Unusable(e.to_string()))?;
        let pixels = planned.shard.region.pixel_count(job.width);
        let field = radius::decode(&message, pixels).map_err(|e| PrepareError::Unusable(e.to_string()))?;
        let field = Arc::new(field);
        lock(&self.fields).insert(key, field.clone());
        Ok(field)
    }
}
