//! A vertex of a subpath, and what it reflects towards another.

use super::weights::{Densities, Sums};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Interaction;
use crate::scene::material::{TransportMode, View};
use crate::scene::{MediumIndex, Scene};
use crate::transport::shading;
use crate::transport::walk::Walk;

/// A vertex of a subpath.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Where.
    pub hit: Interaction,
    /// What arrives: un-normalised flux of a light subpath, W; throughput of a camera subpath, times what its place on the film
    /// counts, which may be negative.
    pub throughput: Rgb,
    /// Its part of the weights.
    pub sums: Sums,
    /// Segments of the subpath up to here.
    pub segments: u32,
    /// Its steps, which address random numbers.
    pub steps: u32,
    /// The medium that it came through.
    pub medium: MediumIndex,
}

/// What a vertex scatters into a given direction.
#[derive(Clone, Copy, Debug)]
pub struct Reflected {
    /// The BSDF with the cosine factor of its mode: with the shading normal for radiance; for flux with the true normal and the
    /// shading correction [Veach 1997, eq. 5.19].
    pub value: Rgb,
    /// Cosine between the direction and the true normal, positive.
    pub cosine: f32,
    view: View,
    incident: Vec3,
}

/// The densities of a scattering from `view` to the local direction `incident`, and back.
#[inline]
pub(super) fn densities(scene: &Scene, hit: &Interaction, view: &View, incident: Vec3) -> Densities {
    let material = scene.material(hit.shape);
    Densities { forward: material.pdf(view, incident), reverse: reverse_pdf(scene, hit, view, incident) }
}

/// The density of coming back: from the local direction `incident` to where `view` looks.
#[inline]
pub(super) fn reverse_pdf(scene: &Scene, hit: &Interaction, view: &View, incident: Vec3) -> f32 {
    let mode = match view.mode {
        TransportMode::Radiance => TransportMode::Flux,
        TransportMode::Flux => TransportMode::Radiance,
    };
    scene.material(hit.shape).pdf(&View { outgoing: incident, mode, ..*view }, view.outgoing)
}

impl Vertex {
    /// Where a walk came to a surface.
    #[inline(always)]
    pub fn new(walk: &Walk, hit: &Interaction, sums: Sums) -> Self {
        let Walk { throughput, segments, steps, medium, .. } = *walk;
        Self { hit: *hit, throughput, sums, segments, steps, medium }
    }

    /// What lobes with a density scatter into `direction`, a unit vector; `None` where that is nothing, or would leak through the
    /// surface.
    #[inline]
    pub fn reflect(&self, scene: &Scene, mode: TransportMode, direction: Vec3) -> Option<Reflected> {
        let hit = &self.hit;
        let view = shading::view(hit, mode);
        let incident = hit.frame.to_local(direction);
        let (cosine_in, cosine_out) = (direction.dot(hit.geometric_normal), hit.outgoing.dot(hit.geometric_normal));
        if cosine_in * incident.z <= 0.0 || cosine_out * view.outgoing.z <= 0.0 {
            return None;
        }
        let value = scene.material(hit.shape).evaluate(&view, incident);
        if value == Rgb::ZERO {
            return None;
        }
        let factor = match mode {
            TransportMode::Radiance => incident.z.abs(),
            TransportMode::Flux => (cosine_in * view.outgoing.z / cosine_out).abs(),
        };
        Some(Reflected { value: value * factor, cosine: cosine_in.abs(), view, incident })
    }

    /// Densities of the direction of what it reflects, and of the way back. Only weights need them, and only where nothing is
    /// in the way.
    #[inline]
    pub fn pdf(&self, scene: &Scene, reflected: &Reflected) -> Densities {
        densities(scene, &self.hit, &reflected.view, reflected.incident)
    }

    /// The same where nothing but the density of the direction matters.
    #[inline]
    pub fn forward_pdf(&self, scene: &Scene, reflected: &Reflected) -> Densities {
        let forward = scene.material(self.hit.shape).pdf(&reflected.view, reflected.incident);
        Densities { forward, reverse: 0.0 }
    }
}
