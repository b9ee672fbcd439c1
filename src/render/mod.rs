//! Passes on this machine's threads. The one door through which farm workers reach the methods.

pub mod first_surface;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::estimate::{RadiusField, RadiusRule, Shard, Tally};
use crate::method::{self, CheckedMethod, MethodError, Pass, PreparedMethod};
use crate::scene::Scene;
use crate::transport::Counters;

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
pub struct Renderer {
    scene: Arc<Scene>,
    method: Box<dyn PreparedMethod>,
    radius_rule: RadiusRule,
    alpha: f64,
}

impl Renderer {
    /// Prepares `method` for `scene`.
    pub fn new(scene: Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Self, MethodError> {
        let (radius_rule, alpha) = (method.radius_rule, method.alpha);
        Ok(Self { method: method::prepare(scene.clone(), method, seed)?, scene, radius_rule, alpha })
    }

    /// Finds first radii and costs, on the calling rayon pool.
    pub fn pilot(&self, cancel: &AtomicBool) -> Result<Pilot, Cancelled> {
        let (radius_squared, counters) = self.method.pilot(cancel).ok_or(Cancelled)?;
        Ok(Pilot { cost_per_pass: nominal_cost(&counters, radius_squared.len()), radius_squared })
    }

    /// Traces a shard with the radii of `field` (one per pixel of the shard's region), on the calling rayon pool.
    pub fn trace(&self, shard: Shard, field: &RadiusField, cancel: &AtomicBool) -> Result<Tally, Cancelled> {
        let mut tally = Tally::zero(shard, self.scene.width);
        for index in shard.pass_indices() {
            let scale = field.scale_of_pass(self.radius_rule, self.alpha, index);
            let pass = Pass {
                index,
                region: shard.region,
                radius_squared: &field.radius_squared,
                scale,
                typical_radius_squared: field.typical_radius_squared * scale,
            };
            let counters = self.method.trace_pass(&pass, &mut tally.pixels, cancel).ok_or(Cancelled)?;
            tally.photons_emitted += counters.photons_emitted;
            tally.photons_stored += counters.photons_stored;
            tally.rays += counters.rays;
            tally.non_finite += counters.non_finite;
        }
        Ok(tally)
    }
}

/// Nanoseconds of one core for each thing counted, as measured once (docs/PERFORMANCE.md); only their order matters.
const NANOSECONDS_PER_RAY: u64 = 90;
const NANOSECONDS_PER_PHOTON: u64 = 60;
const NANOSECONDS_PER_PIXEL: u64 = 250;

fn nominal_cost(counters: &Counters, pixels: usize) -> u64 {
    let nanoseconds = counters.rays * NANOSECONDS_PER_RAY
        + counters.photons_stored * NANOSECONDS_PER_PHOTON
        + pixels as u64 * NANOSECONDS_PER_PIXEL;
    nanoseconds / 1000 + 1
}
