//! Camera subpaths.

use super::selection::Selection;
use super::vertex::{Vertex, reverse_pdf};
use super::weights::{Densities, Sums, Techniques, Weighting};
use crate::math::Rgb;
use crate::math::random::{PassRandom, PathRandom, dimension};
use crate::scene::Scene;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::light::Place;
use crate::scene::material::{Lobes, TransportMode};
use crate::transport::{Counters, Limits, shading};

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
struct Last {
    /// Where it was; the lens at first.
    place: Place,
    /// Density of the new direction by solid angle; 0 for a specular lobe.
    pdf: f32,
    /// Nothing turned the path yet: a scene that hides its lights hides the environment from it.
    straight: bool,
    /// Sums after the scattering, before the next segment.
    sums: Sums,
    /// Whether all scattering was specular.
    is_seen: bool,
}

impl CameraWalk<'_> {
    /// Traces the camera subpath of `pixel` (counted in the picture); each vertex with a lobe that has a density is shown to
    /// `visit`, which returns radiance. The radiance of all of them and of lights that were hit. `acceptance` is ηᵝ.
    #[inline]
    pub fn trace(
        &self,
        pixel: u32,
        acceptance: f32,
        counters: &mut Counters,
        mut visit: impl FnMut(&Vertex, &PathRandom, &mut Counters) -> Rgb,
    ) -> Rgb {
        let scene = self.scene;
        let random = self.random.path(pixel);
        let place = [pixel % scene.width, pixel / scene.width];
        let (mut ray, count) = scene.filtered_camera_ray(place, random.block(dimension::CAMERA));
        let (mut throughput, mut index_squared, mut radiance) = (Rgb::splat(count), 1.0, Rgb::ZERO);
        let mut last =
            Last { place: ray.origin.into(), pdf: 0.0, straight: true, sums: Sums::default(), is_seen: true };
        for segments in 1u32.. {
            if !self.limits.allows(segments) {
                break;
            }
            counters.rays += 1;
            let found = if segments == 1 { scene.intersect_from_camera(&ray) } else { scene.intersect(&ray) };
            if let Some((emitted, weight)) = self.emission(&ray, found.as_ref(), segments, &last, acceptance) {
                radiance += self.selection.shown(throughput * emitted, weight);
            }
            let Some(hit) = found else { break };
            let sums = self.arrive(&hit, segments, &last);
            let material = scene.material(hit.shape);
            if material.lobes().any(Lobes::SMOOTH) {
                radiance += visit(&Vertex { hit, throughput, sums, segments }, &random, counters);
            }
            let u = random.block(dimension::scattering(segments));
            let view = shading::view(&hit, TransportMode::Radiance);
            let Some(scattering) = shading::scatter(&hit, material, &view, [u[0], u[1], u[2]]) else { break };
            let sample = &scattering.sample;
            throughput *= scattering.weight;
            index_squared *= sample.relative_index * sample.relative_index;
            // Refraction scales radiance, which is no loss.
            let kept = throughput.abs().max_element() / count.abs() * index_squared;
            let survival = self.limits.survival(segments, kept);
            if u[3] >= survival {
                break;
            }
            throughput /= survival;
            let cosine = scattering.direction.dot(hit.geometric_normal).abs();
            let sums = if self.weighting.is_one_ended() {
                Sums::default()
            } else if sample.is_specular() {
                self.weighting.scatter_specular(&sums, cosine)
            } else {
                let reverse = reverse_pdf(scene, &hit, &view, sample.direction);
                self.weighting.scatter(&sums, Densities { forward: sample.pdf, reverse }, cosine)
            };
            let straight = last.straight && scattering.is_straight(&hit);
            let is_seen = last.is_seen && sample.is_specular();
            last = Last { place: scene.place(&hit), pdf: sample.pdf, straight, sums, is_seen };
            ray = hit.ray_to(scattering.direction);
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

    /// The radiance that a light sends along the last segment, and the weight of finding it by chance.
    #[inline]
    fn emission(
        &self,
        ray: &Ray,
        hit: Option<&Interaction>,
        segments: u32,
        last: &Last,
        acceptance: f32,
    ) -> Option<(Rgb, f32)> {
        let lights = &self.scene.lights;
        let arriving = match hit {
            Some(hit) => lights.emitted(&self.scene.geometry, &last.place, hit, last.is_seen),
            None if self.scene.hides_lights && last.straight => None,
            None => lights.environment(&last.place, ray.direction),
        };
        let (radiance, sampled) = arriving?;
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
            None => (last.sums, sampled * lights.environment_emission_ratio(&last.place, ray.direction)),
        };
        Some((radiance, self.weighting.hit(&sums, last.pdf, sampled, emitted, acceptance)))
    }
}
