//! What the pixels of some scenes see first, as workers saw it.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use tokio::sync::watch;

use crate::farm::locks::lock;

/// Scenes of which it is kept.
const KEPT: usize = 4;

/// What the pixels of some scenes see first: `T` of each scene.
pub(super) struct SeenFirst<T: ?Sized> {
    scenes: Mutex<VecDeque<(String, Arc<T>)>>,
    /// Rises with every scene that arrives.
    pub(super) arrived: watch::Sender<u64>,
}

impl<T: ?Sized> Default for SeenFirst<T> {
    fn default() -> Self {
        Self { scenes: Mutex::default(), arrived: watch::Sender::default() }
    }
}

impl<T: ?Sized> SeenFirst<T> {
    /// Keeps what a worker saw.
    pub(super) fn insert(&self, scene: &str, seen: Arc<T>) {
        let mut scenes = lock(&self.scenes);
        scenes.retain(|(known, _)| known != scene);
        scenes.push_back((scene.to_owned(), seen));
        if scenes.len() > KEPT {
            scenes.pop_front();
        }
        drop(scenes);
        self.arrived.send_modify(|version| *version += 1);
    }

    /// What a worker saw of a scene.
    pub(super) fn get(&self, scene: &str) -> Option<Arc<T>> {
        lock(&self.scenes).iter().find(|(known, _)| known == scene).map(|(_, seen)| seen.clone())
    }
}
