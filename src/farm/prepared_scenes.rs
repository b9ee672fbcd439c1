//! The prepared scenes of this process. Coordinator and workers that live in one process share them: a scene is prepared once and is in
//! memory once.

use std::collections::VecDeque;
use std::future::Future;
use std::sync::{Arc, Mutex};

use tokio::sync::OnceCell;

use super::job::SceneChanges;
use super::locks::lock;
use crate::import::{UNNAMED, load_changed_bytes};
use crate::scene::Scene;
use crate::scene::error::SceneError;

type Place = Arc<OnceCell<Arc<Scene>>>;

struct Entry {
    hash: String,
    place: Place,
}

/// The scenes used last, by the hash of their bytes. Clones share them.
#[derive(Clone)]
pub struct PreparedScenes {
    entries: Arc<Mutex<VecDeque<Entry>>>,
    capacity: usize,
}

impl PreparedScenes {
    /// Keeps at most `capacity` scenes; of 0, none outlives those who use it.
    pub fn new(capacity: usize) -> Self {
        Self { entries: Arc::default(), capacity }
    }

    /// The scene with this hash. Whoever asks first prepares it, others wait for it.
    pub async fn get_or_prepare<E>(
        &self,
        hash: &str,
        prepare: impl Future<Output = Result<Arc<Scene>, E>>,
    ) -> Result<Arc<Scene>, E> {
        self.place(hash).get_or_try_init(|| prepare).await.cloned()
    }

    fn place(&self, hash: &str) -> Place {
        let mut entries = lock(&self.entries);
        let known = entries.iter().position(|entry| entry.hash == hash).and_then(|index| entries.remove(index));
        let entry = known.unwrap_or_else(|| Entry { hash: hash.to_owned(), place: Place::default() });
        let place = entry.place.clone();
        entries.push_back(entry);
        while entries.len() > self.capacity {
            entries.pop_front();
        }
        place
    }
}

/// From the bytes of a whole scene to one that can be rendered. Coordinator and workers read scenes alike.
pub fn prepare_scene(bytes: &[u8]) -> Result<Scene, SceneError> {
    prepare_changed_scene(bytes, &SceneChanges::default())
}

/// The same with changes of the scene.
pub(super) fn prepare_changed_scene(bytes: &[u8], changes: &SceneChanges) -> Result<Scene, SceneError> {
    Scene::prepare(&load_changed_bytes(UNNAMED, bytes, changes)?)
}
