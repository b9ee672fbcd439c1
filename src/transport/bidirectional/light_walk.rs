//! Light subpaths.

use super::vertex::{Vertex, reverse_pdf};
use super::weights::{Densities, Sums, Weighting};
use crate::math::random::{Numbers, PassRandom, PathRandom};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::light::EmittedPhoton;
use crate::scene::material::{Lobes, View};
use crate::transport::light_path::{LightVertices, trace_light_path};
use crate::transport::shading::Scattering;
use crate::transport::walk::Walk;
use crate::transport::{Counters, Limits};

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
    pub fn trace(&self, path: u32, counters: &mut Counters, visit: impl FnMut(&Vertex, &PathRandom, &mut Counters)) {
        self.trace_with(&self.random.path(path), counters, visit);
    }

    /// The same with numbers of any origin.
    #[inline]
    pub fn trace_with<N: Numbers>(
        &self,
        random: &N,
        counters: &mut Counters,
        visit: impl FnMut(&Vertex, &N, &mut Counters),
    ) {
        let mut weighing = Weighing { walk: self, sums: Sums::default(), visit };
        trace_light_path(self.scene, None, &self.limits, random, counters, &mut weighing);
    }
}

/// Carries along what weights need.
struct Weighing<'a, V> {
    walk: &'a LightWalk<'a>,
    sums: Sums,
    visit: V,
}

impl<N: Numbers, V: FnMut(&Vertex, &N, &mut Counters)> LightVertices<N> for Weighing<'_, V> {
    #[inline(always)]
    fn arrive(&mut self, walk: &Walk, hit: &Interaction, emitted: &EmittedPhoton, random: &N, counters: &mut Counters) {
        let LightWalk { scene, weighting, .. } = self.walk;
        let cosine = hit.outgoing.dot(hit.geometric_normal).abs();
        self.sums = match walk.segments {
            1 => {
                let first = scene.lights.first_segment(&scene.geometry, emitted, &scene.place(hit));
                weighting.start_light(&first, cosine)
            }
            _ => weighting.arrive(&self.sums, hit.distance * hit.distance, cosine),
        };
        if scene.lobes_at(hit.shape).any(Lobes::SMOOTH) {
            (self.visit)(&Vertex::new(walk, hit, self.sums), random, counters);
        }
    }

    #[inline(always)]
    fn leave(&mut self, hit: &Interaction, view: &View, scattering: &Scattering) {
        let LightWalk { scene, weighting, .. } = self.walk;
        let cosine = scattering.direction.dot(hit.geometric_normal).abs();
        self.sums = if scattering.sample.is_specular() {
            weighting.scatter_specular(&self.sums, cosine)
        } else {
            let reverse = reverse_pdf(scene, hit, view, scattering.sample.direction);
            weighting.scatter(&self.sums, Densities { forward: scattering.sample.pdf, reverse }, cosine)
        };
    }
}
