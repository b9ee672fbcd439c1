//! Passes on this machine's threads. The one door through which farm workers reach the methods.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::estimate::{RadiusField, Shard, Tally};
use crate::method::{CheckedMethod, MethodError};
use crate::scene::Scene;

/// The caller asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// What the pilot finds out before the first pass; a worker runs it like a shard.
#[derive(Clone, Debug, PartialEq)]
pub struct Pilot {
    /// First gather radius² per pixel of the whole picture, m².
    pub radius_squared: Vec<f32>,
    /// What one pass of the whole picture costs, in nominal microseconds of one core: counted rays, photons and gathers
    /// times fixed constants, never measured time.
    pub cost_per_pass: u64,
}

/// A job ready to be traced on this machine: prepared scene, checked method, seed. Every function is pure.
pub struct Renderer {}

impl Renderer {
    /// Prepares `method` for `scene`.
    pub fn new(scene: Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Self, MethodError> {
        let _ = (scene, method, seed);
        todo!("lands with the methods")
    }

    /// Finds first radii and costs, on the calling rayon pool.
    pub fn pilot(&self, cancel: &AtomicBool) -> Result<Pilot, Cancelled> {
        let _ = cancel;
        todo!("lands with the methods")
    }

    /// Traces a shard with the radii of `field` (one per pixel of the shard's region), on the calling rayon pool.
    pub fn trace(&self, shard: Shard, field: &RadiusField, cancel: &AtomicBool) -> Result<Tally, Cancelled> {
        let _ = (shard, field, cancel);
        todo!("lands with the methods")
    }
}
