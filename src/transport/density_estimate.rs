//! Reflected radiance from the photons nearest to a point:
//!
//! ```text
//! L(x, ωo) = 1/(π r²)·Σ K(d/r)·f_r(ωp → ωo)·α_p        over the photons nearer than r
//! ```
//!
//! r is the distance of the k-th photon, at most the largest radius; [`Nearest`] says why the k-th itself does not count. Photons may have to
//! pass tests, and k may be chosen by how they lie.

use std::f32::consts::FRAC_1_PI;

use crate::math::Rgb;
use crate::scene::Scene;

use super::Counters;
use super::camera_walk::GatherPoint;
use super::kernel::Kernel;
use super::neighbor_choice::NeighborChoice;
use super::occlusion::{Occlusion, Sight};
use super::photon_map::{GatherQuery, Nearest, OriginLookup};
use super::plausibility::Plausibility;
use super::receiver::{Counting, Receiver};

/// How radiance is estimated from a photon map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DensityEstimate {
    /// k, at least 2.
    pub neighbors: usize,
    /// The largest r², m².
    pub largest_radius_squared: f32,
    /// K.
    pub kernel: Kernel,
    /// Which photons count only where their origin is seen.
    pub occlusion: Occlusion,
    /// Which tests photons have to pass.
    pub plausibility: Plausibility,
    /// Where fewer photons than these lie within the largest radius, none counts; at most k.
    pub fewest_photons: usize,
    /// By what fewer photons than k are chosen.
    pub choice: NeighborChoice,
}

impl DensityEstimate {
    /// Radiance that the lobes at `point` reflect of photons with at most `most_segments`, times the number of photons
    /// emitted, W·sr⁻¹·m⁻²; without the path's throughput.
    pub(crate) fn reflected(
        &self,
        scene: &Scene,
        map: &impl OriginLookup,
        point: &GatherPoint,
        most_segments: u32,
        found: &mut Nearest,
        counters: &mut Counters,
    ) -> Rgb {
        let receiver = Receiver::new(scene, &point.hit, point.view());
        let radius_squared = self.largest_radius_squared;
        let query = receiver.query(Counting { radius_squared, most_segments, caustics_only: false });
        map.nearest(&query, self.neighbors, found);
        self.leave_out(scene, map, point, &query, found, counters);
        let is_full = found.radius_squared() < query.radius_squared;
        if !is_full && found.photons().len() < self.fewest_photons {
            return Rgb::ZERO;
        }
        self.choice.narrow(map, &query, found);
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

    /// Finds the nearest photons that count, where some that were found do not.
    fn leave_out(
        &self,
        scene: &Scene,
        map: &impl OriginLookup,
        point: &GatherPoint,
        query: &GatherQuery,
        found: &mut Nearest,
        counters: &mut Counters,
    ) {
        let sight_within = |radius_squared: f32| {
            Sight::new(scene, &point.hit, &GatherQuery { radius_squared, ..*query }, self.occlusion)
        };
        let test = self.plausibility.at(&point.hit, query);
        let sight = sight_within(found.radius_squared());
        if test.is_none() && sight.is_none() {
            return;
        }
        let mut counts = |sight: &Option<Sight<'_>>, index: usize| {
            let photon = map.photon(index);
            test.is_none_or(|test| test.accepts(&photon))
                && sight.as_ref().is_none_or(|sight| sight.accepts(&photon, map.origin_distance(index), counters))
        };
        if found.photons().all(|(_, index)| counts(&sight, index)) {
            return;
        }
        let sight = sight_within(query.radius_squared);
        found.begin(query.radius_squared);
        map.visit_disc(query, |index, _| {
            let distance_squared = query.distance_squared(&map.photon(index));
            if distance_squared < found.radius_squared() && counts(&sight, index) {
                found.take(distance_squared, index);
                found.forget(self.neighbors);
            }
        });
        found.end(self.neighbors);
    }
}
