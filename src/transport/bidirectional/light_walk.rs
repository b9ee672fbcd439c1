//! Light subpaths.

use super::vertex::{Vertex, reverse_pdf};
use super::weights::{Densities, Weighting};
use crate::math::random::{PassRandom, PathRandom, dimension};
use crate::scene::Scene;
use crate::scene::geometry::Ray;
use crate::scene::material::{Lobes, TransportMode};
use crate::transport::{Counters, Limits, shading};

/// What all light subpaths of a pass share.
#[derive(Clone, Copy)]
pub struct LightWalk<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Limits on whole paths.
    pub limits: Limits,
    /// How techniques share a path.
    pub weighting: Weighting,
    /// The pass's random numbers.
    pub random: &'a PassRandom,
}

impl LightWalk<'_> {
    /// Traces light subpath `path` and shows each vertex with a lobe that has a density to `visit`, with the path's numbers.
    #[inline]
    pub fn trace(
        &self,
        path: u32,
        counters: &mut Counters,
        mut visit: impl FnMut(&Vertex, &PathRandom, &mut Counters),
    ) {
        let scene = self.scene;
        let random = self.random.path(path);
        counters.photons_emitted += 1;
        let place = random.block(dimension::EMISSION);
        let direction = random.block(dimension::EMISSION_DIRECTION);
        let emitted = scene.lights.emit(&scene.geometry, [place[0], place[1], place[2]], [direction[0], direction[1]]);
        let Some(emitted) = emitted else { return };
        let peak = emitted.flux.max_element();
        if !(peak > 0.0 && peak.is_finite()) {
            counters.non_finite += u64::from(!peak.is_finite());
            return;
        }
        let mut ray = Ray::new(emitted.origin, emitted.direction);
        let (mut throughput, mut sums) = (emitted.flux, Default::default());
        for segments in 1u32.. {
            if !self.limits.allows(segments + 1) {
                return;
            }
            counters.rays += 1;
            let Some(hit) = scene.intersect(&ray) else { return };
            let cosine = hit.outgoing.dot(hit.geometric_normal).abs();
            sums = match segments {
                1 => {
                    let first = scene.lights.first_segment(&scene.geometry, &emitted, &scene.place(&hit));
                    self.weighting.start_light(&first, cosine)
                }
                _ => self.weighting.arrive(&sums, hit.distance * hit.distance, cosine),
            };
            let material = scene.material(hit.shape);
            if material.lobes().any(Lobes::SMOOTH) {
                visit(&Vertex { hit, throughput, sums, segments }, &random, counters);
            }
            let u = random.block(dimension::scattering(segments));
            let view = shading::view(&hit, TransportMode::Flux);
            let Some(scattering) = shading::scatter(&hit, material, &view, [u[0], u[1], u[2]]) else { return };
            throughput *= scattering.weight;
            let survival = self.limits.survival(segments, throughput.max_element() / peak);
            if u[3] >= survival {
                return;
            }
            throughput /= survival;
            let cosine = scattering.direction.dot(hit.geometric_normal).abs();
            sums = if scattering.sample.is_specular() {
                self.weighting.scatter_specular(&sums, cosine)
            } else {
                let reverse = reverse_pdf(scene, &hit, &view, scattering.sample.direction);
                self.weighting.scatter(&sums, Densities { forward: scattering.sample.pdf, reverse }, cosine)
            };
            ray = hit.ray_to(scattering.direction);
        }
    }
}
