//! Camera subpaths.
//!
//! In scenes with media, methods that make nothing but camera subpaths pass straight through panes, holes of masks and the borders
//! of media: those are no vertices and add no segment, and light is sampled through them.

use super::selection::Selection;
use super::vertex::{Vertex, reverse_pdf};
use super::weights::{Densities, Sums, Techniques, Weighting};
use crate::math::Rgb;
use crate::math::random::{Numbers, PassRandom, PathRandom, dimension};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::material::{Lobes, TransportMode, View};
use crate::transport::shading::{self, Scattering};
use crate::transport::visibility::Blockers;
use crate::transport::walk::Walk;
use crate::transport::{Counters, Limits};

/// The most steps of a path that passes surfaces: what is left is lost in rounding.
const MOST_STEPS: u32 = 4096;

/// What all camera subpaths of a pass share.
#[derive(Clone, Copy)]
pub struct CameraWalk<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Limits on whole paths.
    pub limits: Limits,
    /// How techniques share a path.
    pub weighting: Weighting,
    /// Which paths count.
    pub selection: Selection,
    /// The pass's random numbers.
    pub random: &'a PassRandom,
}

/// The last scattering of a walk.
#[derive(Clone, Copy)]
pub(super) struct Last {
    /// Density of the new direction by solid angle; 0 for a specular lobe, and at the lens.
    pub(super) pdf: f32,
    /// Sums after the scattering, before the next segment.
    pub(super) sums: Sums,
    /// Whether all scattering was specular.
    pub(super) is_seen: bool,
}

impl CameraWalk<'_> {
    /// What is in the way between a camera vertex and a light.
    #[inline]
    pub(super) fn blockers(&self) -> Blockers {
        match self.weighting.is_one_ended() && !self.scene.media.is_empty() {
            true => Blockers::Turning,
            false => Blockers::All,
        }
    }

    /// Traces the camera subpath of `pixel` (counted in the picture); each vertex with a lobe that has a density is shown to
    /// `visit`, which returns radiance. The radiance of all of them and of lights that were hit. `acceptance` is ηᵝ.
    #[inline]
    pub fn trace(
        &self,
        pixel: u32,
        acceptance: f32,
        counters: &mut Counters,
        visit: impl FnMut(&Vertex, &PathRandom, &mut Counters) -> Rgb,
    ) -> Rgb {
        self.trace_with(&self.random.path(pixel), pixel, acceptance, counters, visit)
    }

    /// The same with numbers of any origin.
    #[inline]
    pub fn trace_with<N: Numbers>(
        &self,
        random: &N,
        pixel: u32,
        acceptance: f32,
        counters: &mut Counters,
        mut visit: impl FnMut(&Vertex, &N, &mut Counters) -> Rgb,
    ) -> Rgb {
        let scene = self.scene;
        let place = [pixel % scene.width, pixel / scene.width];
        let (ray, count) = scene.filtered_camera_ray(place, random.block(dimension::CAMERA));
        let mut walk = Walk::from_camera(scene, ray, count);
        let mut last = Last { pdf: 0.0, sums: Sums::default(), is_seen: true };
        let (mut radiance, passes) = (Rgb::ZERO, self.blockers() == Blockers::Turning);
        while self.limits.allows(walk.segments + 1) {
            let step = walk.step(scene, random, counters);
            if let Some(position) = step.medium() {
                radiance += self.light_in_medium(walk, position, random, counters);
                let Some(scattered) = self.scattered(walk, position, random) else { break };
                (walk, last) = scattered;
                if walk.survives(&self.limits, random.block(dimension::scattering(walk.steps))[3]) {
                    continue;
                }
                break;
            }
            let found = step.surface();
            if let Some((emitted, weight)) = self.emission(&walk, found, &last, acceptance) {
                radiance += self.selection.shown(walk.throughput * emitted, weight);
            }
            let Some(hit) = found else { break };
            let sums = self.arrive(hit, walk.segments, &last);
            let material = scene.material(hit.shape);
            if scene.lobes_at(hit.shape).any(Lobes::SMOOTH) {
                radiance += visit(&Vertex::new(&walk, hit, sums), random, counters);
            }
            let u = random.block(dimension::scattering(walk.steps));
            let view = shading::view(hit, TransportMode::Radiance);
            let Some(scattering) = shading::scatter(hit, material, &view, [u[0], u[1], u[2]]) else { break };
            if passes && scattering.is_straight(hit) {
                walk.pass(scene, hit, &scattering);
                if walk.steps < MOST_STEPS && walk.throughput != Rgb::ZERO {
                    continue;
                }
                break;
            }
            if !walk.follow_by_roulette(scene, hit, &scattering, &self.limits, u[3]) {
                break;
            }
            let is_seen = last.is_seen && scattering.sample.is_specular();
            last = Last { pdf: scattering.sample.pdf, sums: self.leave(hit, &view, &scattering, &sums), is_seen };
        }
        radiance
    }

    #[inline]
    fn arrive(&self, hit: &Interaction, segments: u32, last: &Last) -> Sums {
        if self.weighting.is_one_ended() {
            return Sums::default();
        }
        let cosine = hit.outgoing.dot(hit.geometric_normal).abs();
        if segments > 1 {
            return self.weighting.arrive(&last.sums, hit.distance * hit.distance, cosine);
        }
        let camera = &self.scene.camera;
        let pdf = camera.pdf(-hit.outgoing) * self.scene.film.whole_pixel_count();
        self.weighting.start_camera(pdf, camera.spread(-hit.outgoing, hit.distance), cosine)
    }

    #[inline]
    fn leave(&self, hit: &Interaction, view: &View, scattering: &Scattering, sums: &Sums) -> Sums {
        if self.weighting.is_one_ended() {
            return Sums::default();
        }
        let cosine = scattering.direction.dot(hit.geometric_normal).abs();
        if scattering.sample.is_specular() {
            return self.weighting.scatter_specular(sums, cosine);
        }
        let reverse = reverse_pdf(self.scene, hit, view, scattering.sample.direction);
        self.weighting.scatter(sums, Densities { forward: scattering.sample.pdf, reverse }, cosine)
    }

    /// The radiance that a light sends along the last segment, and the weight of finding it by chance.
    #[inline]
    fn emission(&self, walk: &Walk, hit: Option<&Interaction>, last: &Last, acceptance: f32) -> Option<(Rgb, f32)> {
        let (lights, segments) = (&self.scene.lights, walk.segments);
        let (radiance, sampled) = walk.arriving(self.scene, hit, last.is_seen)?;
        let takes_part = segments == 1 || self.weighting.techniques.any(Techniques::HIT);
        if !takes_part || !self.selection.takes(segments, 0, segments + 1) {
            return None;
        }
        // Lights that are seen directly can be found in no other way.
        if segments == 1 {
            return Some((radiance, 1.0));
        }
        let (sums, emitted) = match hit {
            Some(hit) => (self.arrive(hit, segments, last), lights.emission_pdf(&self.scene.geometry, hit)),
            None => (last.sums, sampled * lights.environment_emission_ratio(&walk.place, walk.ray.direction)),
        };
        Some((radiance, self.weighting.hit(&sums, last.pdf, sampled, emitted, acceptance)))
    }
}
