//! What the pixels of some scenes see first, as workers saw it.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use tokio::sync::watch;

use crate::farm::locks::lock;
use crate::render::first_surface::FirstSurface;

/// Scenes whose first surfaces are kept.
const KEPT: usize = 4;

/// What the pixels of some scenes see first.
#[derive(Default)]
pub(super) struct SeenFirst {
    scenes: Mutex<VecDeque<Seen>>,
    /// Rises with every scene that arrives.
    pub(super) arrived: watch::Sender<u64>,
}

struct Seen {
    scene: String,
    pixels: Arc<[FirstSurface]>,
}

impl SeenFirst {
    /// Keeps what a worker saw.
    pub(super) fn insert(&self, scene: &str, pixels: Vec<FirstSurface>) {
        let mut scenes = lock(&self.scenes);
        scenes.retain(|seen| seen.scene != scene);
        scenes.push_back(Seen { scene: scene.to_owned(), pixels: pixels.into() });
        if scenes.len() > KEPT {
            scenes.pop_front();
        }
        drop(scenes);
        self.arrived.send_modify(|version| *version += 1);
    }

    /// What a worker saw of a scene.
    pub(super) fn get(&self, scene: &str) -> Option<Arc<[FirstSurface]>> {
        lock(&self.scenes).iter().find(|seen| seen.scene == scene).map(|seen| seen.pixels.clone())
    }
}
