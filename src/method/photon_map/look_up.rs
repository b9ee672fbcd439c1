//! How a map is looked at.

use super::parameters::Parameters;
use crate::method::parameter_values::Auto;
use crate::transport::density_estimate::DensityEstimate;
use crate::transport::first_radius::{FIRST_GATHER_PHOTONS, RadiusBounds};
use crate::transport::plausibility::Plausibility;

/// How a map is looked at.
pub(super) struct LookUp {
    pub(super) estimate: DensityEstimate,
    /// What a search starts with, m; sizes the map's cells.
    pub(super) first_radius: f32,
}

impl Parameters {
    /// A look-up of the `photons` of a map, at most as wide as the parameters or the scene allow.
    pub(super) fn look_up(&self, neighbors: u32, scene_radius: f32, photons: u32) -> LookUp {
        let automatic = largest_radius_squared(scene_radius, neighbors, photons);
        let largest_radius_squared = match self.largest_radius.meters() {
            Auto::Value(radius) => radius * radius,
            Auto::Auto => automatic,
        };
        let Self { kernel, occlusion, neighbor_choice: choice, .. } = *self;
        let estimate = DensityEstimate {
            neighbors: neighbors as usize,
            largest_radius_squared,
            kernel,
            occlusion,
            plausibility: Plausibility {
                least_arrival_cosine: self.arrival_angle.least_cosine(),
                culls_behind: self.culling_plane.is_on(),
            },
            fewest_photons: 0,
            choice,
        };
        LookUp { estimate, first_radius: largest_radius_squared.min(automatic).sqrt() }
    }

    /// The same, black where it finds too few photons: a look-up of caustics.
    pub(super) fn caustic_look_up(&self, scene_radius: f32, photons_per_pass: u32) -> LookUp {
        let mut look_up = self.look_up(self.caustic_neighbors.get(), scene_radius, photons_per_pass);
        look_up.estimate.fewest_photons = self.fewest_hundredths().div_ceil(100) as usize;
        look_up
    }

    /// The fewest photons that a look-up of caustics may find, in hundredths.
    pub(super) fn fewest_hundredths(&self) -> u32 {
        self.fewest_photons.get() * self.caustic_neighbors.get()
    }
}

/// The largest r² where the user named none, m²: half the area that `neighbors` photons would have on the scene's
/// bounding sphere, at most 5 % of its radius. Surfaces are smaller than that sphere, so at mean brightness about k are
/// found. Larger discs would find more in the dark, but blur it, and bring more light over edges than they take.
fn largest_radius_squared(scene_radius: f32, neighbors: u32, photons: u32) -> f32 {
    // Two or three photons are stored per emitted one in a closed room.
    let bounds = RadiusBounds::new(scene_radius, 2 * photons as usize);
    let mean = bounds.guess * (neighbors as f32 / FIRST_GATHER_PHOTONS);
    (0.5 * mean).clamp(f32::MIN_POSITIVE, RadiusBounds::largest_squared(scene_radius))
}
