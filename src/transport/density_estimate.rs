//! Reflected radiance from the photons nearest to a point:
//!
//! ```text
//! L(x, ωo) = 1/(π r²)·Σ K(d/r)·f_r(ωp → ωo)·α_p        over the photons nearer than r
//! ```
//!
//! r is the distance of the k-th photon, at most the largest radius; [`Nearest`] says why the k-th itself does not count.

use std::f32::consts::FRAC_1_PI;

use crate::math::{Rgb, octahedral};
use crate::scene::Scene;
use crate::scene::material::Lobes;

use super::camera_walk::GatherPoint;
use super::kernel::Kernel;
use super::photon_map::{GatherQuery, Nearest, PhotonMap};

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
        map: &PhotonMap,
        point: &GatherPoint,
        most_segments: u32,
        found: &mut Nearest,
    ) -> Rgb {
        let hit = &point.hit;
        let (material, view) = (scene.material(hit.shape), point.view());
        let constant = material.constant_value(&view);
        let query = GatherQuery {
            position: hit.position,
            normal: point.facing_normal(),
            radius_squared: self.largest_radius_squared,
            most_segments,
            caustics_only: false,
            both_sides: material.lobes().any(Lobes::TRANSMISSIVE),
        };
        map.nearest(&query, self.neighbors, found);
        let inverse_radius_squared = 1.0 / found.radius_squared();
        let mut sum = Rgb::ZERO;
        for (distance_squared, index) in found.photons() {
            let weight = self.kernel.weight(distance_squared * inverse_radius_squared);
            sum += map.flux(index)
                * weight
                * constant.unwrap_or_else(|| {
                    let incident = octahedral::decode(map.photon(index).direction);
                    material.evaluate(&view, hit.frame.to_local(incident))
                });
        }
        sum * (inverse_radius_squared * FRAC_1_PI)
    }
}
