//! Reflected radiance from the photons nearest to a point:
//!
//! ```text
//! L(x, ωo) = 1/(π r²)·Σ K(d/r)·f_r(ωp → ωo)·α_p        over the photons nearer than r
//! ```
//!
//! r is the distance of the k-th photon, at most the largest radius; [`Nearest`] says why the k-th itself does not count.

use std::f32::consts::FRAC_1_PI;

use crate::math::Rgb;
use crate::scene::Scene;

use super::camera_walk::GatherPoint;
use super::kernel::Kernel;
use super::photon_map::{Nearest, PhotonLookup};
use super::receiver::{Counting, Receiver};

/// How radiance is estimated from a photon map.
#[derive(Clone, Copy, Debug)]
pub struct DensityEstimate {
    /// k, at least 2.
    pub neighbors: usize,
    /// The largest r², m².
    pub largest_radius_squared: f32,
    /// K.
    pub kernel: Kernel,
}

impl DensityEstimate {
    /// Radiance that the lobes at `point` reflect of photons with at most `most_segments`, times the number of photons
    /// emitted, W·sr⁻¹·m⁻²; without the path's throughput.
    pub fn reflected(
        &self,
        scene: &Scene,
        map: &impl PhotonLookup,
        point: &GatherPoint,
        most_segments: u32,
        found: &mut Nearest,
    ) -> Rgb {
        let receiver = Receiver::new(scene, &point.hit, point.view());
        let radius_squared = self.largest_radius_squared;
        let query = receiver.query(Counting { radius_squared, most_segments, caustics_only: false });
        map.nearest(&query, self.neighbors, found);
        let inverse_radius_squared = 1.0 / found.radius_squared();
        let mut sum = Rgb::ZERO;
        for (distance_squared, index) in found.photons() {
            let weight = self.kernel.weight(distance_squared * inverse_radius_squared);
            sum += map.flux(index)
                * weight
                * receiver.constant().unwrap_or_else(|| receiver.value(receiver.incident(map.direction(index))));
        }
        sum * (inverse_radius_squared * FRAC_1_PI)
    }
}
