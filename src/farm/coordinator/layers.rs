//! Pictures with further layers. What the first surface is like follows from the scene alone: a worker looks when someone asks, once a
//! scene, and the coordinator keeps what it saw.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::sync::watch;
use tokio::time::timeout;

use super::CoordinatorHandle;
use super::shared::{JobRecord, Shared};
use crate::estimate::picture_files::{Layer, PictureLayer};
use crate::estimate::{Estimate, Picture};
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::JobStatus;
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::Event;
use crate::render::first_surface::FirstSurface;

/// Scenes whose first surfaces are kept.
const KEPT: usize = 4;
/// How long a request waits for a worker to look.
const PATIENCE: Duration = Duration::from_secs(20);

impl CoordinatorHandle {
    /// The picture as merged so far, the layers asked for, and the status that belongs to all of them.
    ///
    /// # Errors
    /// Layers of first surfaces need a worker that looks; without one they are [`FarmError::NotYet`].
    pub async fn picture_with_layers(
        &self,
        id: JobId,
        wanted: &[Layer],
    ) -> Result<(Picture, Vec<PictureLayer>, JobStatus), FarmError> {
        let (shared, job) = (self.shared.clone(), self.shared.job(id)?);
        let seen = if wanted.iter().any(|layer| is_of_first_surface(*layer)) {
            Some(shared.first_surfaces(&job).await?)
        } else {
            None
        };
        let (wanted, record) = (wanted.to_vec(), job.clone());
        let read = move |merging: &Merging| {
            let status = shared.lock().status(&record, &shared.clock);
            let seen = seen.as_deref().unwrap_or_default();
            let layer =
                |layer: &Layer| of_estimate(*layer, &merging.estimate).or_else(|| of_first_surface(*layer, seen));
            (merging.estimate.picture(), wanted.iter().filter_map(layer).collect(), status)
        };
        self.shared.with_merged(&job, read).await
    }
}

/// What the pixels of some scenes see first.
#[derive(Default)]
pub(super) struct SeenFirst {
    scenes: Mutex<VecDeque<Seen>>,
    arrived: watch::Sender<u64>,
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

    fn get(&self, scene: &str) -> Option<Arc<[FirstSurface]>> {
        lock(&self.scenes).iter().find(|seen| seen.scene == scene).map(|seen| seen.pixels.clone())
    }
}

impl Shared {
    /// What the pixels of a job's scene see first. Lets a worker look if nobody has yet.
    async fn first_surfaces(&self, job: &JobRecord) -> Result<Arc<[FirstSurface]>, FarmError> {
        let scene = job.description().scene;
        let mut arrived = self.seen_first.arrived.subscribe();
        if let Some(seen) = self.seen_first.get(&scene) {
            return Ok(seen);
        }
        self.apply(Event::FirstSurfacesWanted { job: job.id });
        let look = async {
            loop {
                arrived.mark_unchanged();
                if let Some(seen) = self.seen_first.get(&scene) {
                    return Some(seen);
                }
                if !self.lock().rules.has_errand(job.id) {
                    return None;
                }
                arrived.changed().await.ok()?;
            }
        };
        timeout(PATIENCE, look).await.ok().flatten().ok_or_else(|| FarmError::NotYet {
            problem: format!("no worker has looked at the first surfaces of job {} yet", job.id),
            retry_after: self.options.limits.retry_after(),
        })
    }
}

fn is_of_first_surface(layer: Layer) -> bool {
    matches!(layer, Layer::Albedo | Layer::Normal | Layer::Depth)
}

/// A layer that the estimate holds.
fn of_estimate(layer: Layer, estimate: &Estimate) -> Option<PictureLayer> {
    let pixels = (0..estimate.pixel_count()).map(|pixel| estimate.pixel(pixel));
    let values = match layer {
        Layer::Radius => pixels.map(|pixel| pixel.radius_squared.sqrt() as f32).collect(),
        Layer::Photons => pixels.map(|pixel| pixel.photons as f32).collect(),
        // Nothing is known before each twin has a pass.
        Layer::Error => estimate.standard_error().unwrap_or_else(|| vec![f32::NAN; estimate.pixel_count()]),
        Layer::Albedo | Layer::Normal | Layer::Depth => return None,
    };
    Some(PictureLayer { layer, channels: vec![values] })
}

/// A layer that follows from the scene.
fn of_first_surface(layer: Layer, seen: &[FirstSurface]) -> Option<PictureLayer> {
    let axes = |value: fn(&FirstSurface) -> [f32; 3]| {
        (0..3).map(|axis| seen.iter().map(|pixel| value(pixel)[axis]).collect()).collect()
    };
    let channels = match layer {
        Layer::Albedo => axes(|pixel| pixel.albedo.to_array()),
        Layer::Normal => axes(|pixel| pixel.normal.to_array()),
        Layer::Depth => vec![seen.iter().map(|pixel| pixel.depth).collect()],
        Layer::Radius | Layer::Photons | Layer::Error => return None,
    };
    Some(PictureLayer { layer, channels })
}
