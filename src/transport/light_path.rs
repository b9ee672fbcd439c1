//! The one loop of paths from lights: photons, and the light subpaths of bidirectional methods.

use super::counters::Counters;
use super::limits::Limits;
use super::shading::{self, Scattering};
use super::walk::Walk;
use crate::math::random::{Numbers, dimension};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::light::EmittedPhoton;
use crate::scene::light::emission_guide::{EmissionGuide, EmissionPoint};
use crate::scene::material::{TransportMode, View};

/// What a method does along a path from a light.
pub(crate) trait LightVertices<N: Numbers> {
    /// The path of the photon `emitted` comes to a surface, with `walk.throughput` as its flux.
    fn arrive(&mut self, walk: &Walk, hit: &Interaction, emitted: &EmittedPhoton, random: &N, counters: &mut Counters);

    /// It is scattered there, and goes on.
    fn leave(&mut self, hit: &Interaction, view: &View, scattering: &Scattering);

    /// Whether what is still to come of the path matters; else it ends.
    #[inline(always)]
    fn goes_on(&self) -> bool {
        true
    }
}

/// Where the path with the numbers `random` starts.
#[inline(always)]
pub(crate) fn emission_point(scene: &Scene, guide: Option<&EmissionGuide>, random: &impl Numbers) -> EmissionPoint {
    let place = random.block(dimension::EMISSION);
    let direction = random.block(dimension::EMISSION_DIRECTION);
    scene.lights.emission_point(guide, [place[0], place[1], place[2]], [direction[0], direction[1]])
}

/// Follows a photon with the numbers `random`, which starts where `guide` says, to its end; it leaves at least one segment to the camera.
#[inline]
pub(crate) fn trace_light_path<N: Numbers>(
    scene: &Scene,
    guide: Option<&EmissionGuide>,
    limits: &Limits,
    random: &N,
    counters: &mut Counters,
    vertices: &mut impl LightVertices<N>,
) {
    counters.photons_emitted += 1;
    let start = emission_point(scene, guide, random);
    if let Some(emitted) = scene.lights.emit_at(&scene.geometry, &start) {
        follow_photon(scene, &emitted, limits, random, counters, vertices);
    }
}

/// Follows the photon `emitted` with the numbers `random` to its end.
#[inline]
pub(crate) fn follow_photon<N: Numbers>(
    scene: &Scene,
    emitted: &EmittedPhoton,
    limits: &Limits,
    random: &N,
    counters: &mut Counters,
    vertices: &mut impl LightVertices<N>,
) {
    let peak = emitted.flux.max_element();
    if !(peak > 0.0 && peak.is_finite()) {
        counters.non_finite += u64::from(!peak.is_finite());
        return;
    }
    let mut walk = Walk::from_light(scene, emitted, random);
    while limits.allows(walk.segments + 2) && vertices.goes_on() {
        let step = walk.step(scene, random, counters);
        let Some(hit) = step.surface() else { return };
        vertices.arrive(&walk, hit, emitted, random, counters);
        if !vertices.goes_on() {
            return;
        }
        let u = random.block(dimension::scattering(walk.segments));
        let view = shading::view(hit, TransportMode::Flux);
        let Some(scattering) = shading::scatter(hit, scene.material(hit.shape), &view, [u[0], u[1], u[2]]) else {
            return;
        };
        if !walk.follow_by_roulette(scene, hit, &scattering, limits, u[3]) {
            return;
        }
        vertices.leave(hit, &view, &scattering);
    }
}
