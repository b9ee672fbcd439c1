//! Vertices of camera subpaths in media that scatter light, for methods that make nothing but camera subpaths.

use super::camera_walk::{CameraWalk, Last};
use super::weights::{Densities, Sums, Techniques};
use crate::math::random::{Numbers, dimension};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Ray;
use crate::scene::light::Place;
use crate::transport::Counters;
use crate::transport::visibility::{Joint, SHADOW_END, transmittance};
use crate::transport::walk::Walk;

impl CameraWalk<'_> {
    /// Where the path goes on from `position`, with the density by solid angle.
    #[cold]
    #[inline(never)]
    pub(super) fn scattered(&self, walk: Walk, position: Vec3, random: &impl Numbers) -> Option<(Walk, Last)> {
        let medium = self.scene.medium(walk.medium)?;
        let [x, y, ..] = random.block(dimension::scattering(walk.steps));
        let (direction, pdf) = medium.phase.sample(walk.ray.direction, [x, y]);
        Some((walk.scattered(position, direction), Last { pdf, sums: Sums::default(), is_seen: false }))
    }

    /// The radiance that a sampled point of a light adds at `position`.
    #[cold]
    #[inline(never)]
    pub(super) fn light_in_medium(
        &self,
        walk: Walk,
        position: Vec3,
        random: &impl Numbers,
        counters: &mut Counters,
    ) -> Rgb {
        let scene = self.scene;
        let segments = walk.segments + 1;
        let takes = self.weighting.techniques.any(Techniques::DIRECT)
            && self.limits.allows(segments)
            && self.selection.takes(segments, 1, walk.segments + 1);
        if !takes {
            return Rgb::ZERO;
        }
        let u = random.block(dimension::light(walk.steps));
        let sample = scene.lights.sample_direct(&scene.geometry, &Place::from(position), [u[0], u[1], u[2]]);
        let (Some(light), Some(medium)) = (sample, scene.medium(walk.medium)) else { return Rgb::ZERO };
        let pdf = medium.phase.value(walk.ray.direction, light.direction);
        let joint = Joint {
            ray: Ray { origin: position, direction: light.direction, length: light.distance * SHADOW_END },
            medium: walk.medium,
            blockers: self.blockers(),
            random,
            step: walk.steps,
        };
        let passing = transmittance(scene, &joint, counters);
        let densities = Densities { forward: pdf, reverse: 0.0 };
        let weight = self.weighting.direct(&Sums::default(), densities, 1.0, &light, 0.0);
        self.selection.shown(walk.throughput * pdf * light.weighted_radiance * passing, weight)
    }
}
