//! Pictures with further layers. What the first surface is like follows from the scene alone: the coordinator looks
//! itself when someone asks, once a scene, and keeps what it saw. No other picture comes from the coordinator.

use std::sync::{Arc, Mutex};

use super::{CoordinatorHandle, blocking, lock, prepare_scene};
use crate::estimate::picture_files::{Layer, PictureLayer};
use crate::estimate::{Estimate, Picture};
use crate::farm::error::FarmError;
use crate::farm::job::JobStatus;
use crate::render::first_surface::{FirstSurface, first_surface_layers};

impl CoordinatorHandle {
    /// The picture as merged so far, the layers asked for, and the status that belongs to both.
    pub async fn picture_with_layers(
        &self,
        id: &str,
        wanted: &[Layer],
    ) -> Result<(Picture, Vec<PictureLayer>, JobStatus), FarmError> {
        let (shared, job, wanted) = (self.shared.clone(), self.shared.job(id)?, wanted.to_vec());
        blocking(move || {
            let (picture, mut layers, status) = job.with_merged(|merging| {
                let status = shared.lock().status(&job, shared.now());
                let layers = wanted.iter().filter_map(|layer| of_estimate(*layer, &merging.estimate));
                (merging.estimate.picture(), layers.collect::<Vec<_>>(), status)
            })?;
            if layers.len() < wanted.len() {
                let seen = shared.first_surface(&job.description.scene)?;
                layers.extend(wanted.iter().filter_map(|layer| of_first_surface(*layer, &seen)));
            }
            Ok((picture, layers, status))
        })
        .await
    }
}

/// What a scene's pixels see first, once someone has asked.
#[derive(Default)]
pub(super) struct SeenFirst(Mutex<Option<Arc<[FirstSurface]>>>);

impl SeenFirst {
    /// Looks at the scene in `bytes`, or remembers. Whoever asks meanwhile waits.
    pub(super) fn of(&self, bytes: &[u8]) -> Result<Arc<[FirstSurface]>, FarmError> {
        let mut seen = lock(&self.0);
        if let Some(seen) = &*seen {
            return Ok(seen.clone());
        }
        let found: Arc<[FirstSurface]> = first_surface_layers(&prepare_scene(bytes)?).into();
        *seen = Some(found.clone());
        Ok(found)
    }
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
