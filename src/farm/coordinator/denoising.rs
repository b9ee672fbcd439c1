//! Pictures with less noise. To make one takes long, so it is made once for each state of a job's picture, by one thread pool at a time, and kept for a while.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use super::blocking::blocking;
use crate::estimate::denoise::{Denoised, Features, Twins, denoise};
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::JobStatus;
use crate::farm::locks::lock;
use crate::render::first_surface::FirstSurface;

/// Pictures that are kept.
const KEPT: usize = 4;

/// Pictures that somebody asked for lately.
#[derive(Default)]
pub(super) struct Denoising {
    kept: Mutex<VecDeque<Kept>>,
    /// Whoever makes one holds it, so that many who ask at once wait for one.
    turn: tokio::sync::Mutex<()>,
}

struct Kept {
    state: PictureState,
    denoised: Arc<Denoised>,
}

/// Which picture of which job is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PictureState {
    job: JobId,
    version: u64,
    passes: u32,
}

impl PictureState {
    pub(super) fn new(job: JobId, status: &JobStatus) -> Self {
        Self { job, version: status.picture_version, passes: status.passes_done }
    }
}

impl Denoising {
    /// The picture of a state, if it was made lately.
    pub(super) fn get(&self, state: PictureState) -> Option<Arc<Denoised>> {
        lock(&self.kept).iter().find(|kept| kept.state == state).map(|kept| kept.denoised.clone())
    }

    /// The picture of a state, which is made of its twins and what their pixels see first where it is not there.
    pub(super) async fn make(
        &self,
        state: PictureState,
        twins: Twins,
        seen: Arc<[FirstSurface]>,
    ) -> Result<Arc<Denoised>, FarmError> {
        let _turn = self.turn.lock().await;
        if let Some(found) = self.get(state) {
            return Ok(found);
        }
        let denoised = Arc::new(blocking(move || Ok(denoise(&twins, &features_of(&seen))?)).await?);
        let mut kept = lock(&self.kept);
        kept.push_back(Kept { state, denoised: denoised.clone() });
        if kept.len() > KEPT {
            kept.pop_front();
        }
        Ok(denoised)
    }
}

/// What pixels see first, as planes.
fn features_of(seen: &[FirstSurface]) -> Features {
    let axes = |value: fn(&FirstSurface) -> [f32; 3]| {
        [0, 1, 2].map(|axis| seen.iter().map(|pixel| value(pixel)[axis]).collect())
    };
    Features {
        albedo: axes(|pixel| pixel.albedo.to_array()),
        normal: axes(|pixel| pixel.normal.to_array()),
        position: axes(|pixel| pixel.position.to_array()),
    }
}
