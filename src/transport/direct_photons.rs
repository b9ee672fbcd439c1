//! Photons that came straight from lights, and shadow photons behind them, by which direct light is found or sampled.
//!
//! Shadow photons [Jensen & Christensen 1995; Wald 1999, section 4.2.2]: where a
//! photon meets its first surface it goes on as a shadow, straight through everything, and every further surface that it comes to is marked.

use std::sync::atomic::AtomicBool;

use super::counters::Counters;
use super::light_path::emission_point;
use super::photon_map::{Grid, LightPhoton, LightSegment, PhotonMap, trace_with};
use super::photon_tracing::{PhotonSettings, stored};
use super::shading;
use super::walk::Walk;
use crate::math::Rgb;
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::material::{Lobes, TransportMode};

/// The most surfaces that a shadow photon marks. Those behind are left without, which costs shadow rays and nothing else.
const MOST_SHADOWS: u32 = 32;

/// What is stored of the photons of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// First hits: photons of one segment.
    Lit,
    /// These, and shadow photons: photons of two segments, without flux.
    LitAndShadows,
}

/// Photons of more segments are shadow photons.
pub const LIT_SEGMENTS: u32 = 1;

/// The first segments of the photon paths of `settings`, the same that [`trace_photon`](super::photon_tracing::trace_photon) begins with;
/// `None` when `cancel` was set meanwhile. They are counted as rays and as stored photons, not as emitted: those are counted there.
pub fn trace_direct_photons(
    scene: &Scene,
    settings: &PhotonSettings<'_>,
    kind: Stored,
    grid: Grid,
    cancel: &AtomicBool,
) -> Option<(PhotonMap<LightSegment>, Counters)> {
    let trace_path = |path: u32, photons: &mut Vec<LightPhoton>, counters: &mut Counters| {
        trace_direct_photon(scene, settings, kind, path, photons, counters);
    };
    let (chunks, counters) = trace_with(settings.paths, &grid, cancel, trace_path)?;
    Some((PhotonMap::build(&chunks, grid), counters))
}

fn trace_direct_photon(
    scene: &Scene,
    settings: &PhotonSettings<'_>,
    kind: Stored,
    path: u32,
    photons: &mut Vec<LightPhoton>,
    counters: &mut Counters,
) {
    let random = settings.random.path(path);
    let Some(emitted) = scene.lights.emit_at(&scene.geometry, &emission_point(scene, settings.guide, &random)) else {
        return;
    };
    let peak = emitted.flux.max_element();
    if !(peak > 0.0 && peak.is_finite() && settings.limits.allows(2)) {
        return;
    }
    let mut walk = Walk::from_light(scene, &emitted, &random);
    let step = walk.step(scene, &random, counters);
    let Some(first) = step.surface() else { return };
    let mut segment = LightSegment { light: emitted.light, length: first.distance };
    let mut store = |hit: &Interaction, segment: LightSegment, flux: Rgb, segments: u32| {
        let photon = receives(scene, hit).then(|| stored(hit, flux, segments, false)).flatten();
        photons.extend(photon.map(|photon| LightPhoton { photon, extra: segment }));
    };
    store(first, segment, walk.throughput, LIT_SEGMENTS);
    if kind == Stored::Lit {
        return;
    }
    let mut hit = *first;
    for _ in 0..MOST_SHADOWS {
        counters.rays += 1;
        let Some(next) = scene.intersect(&hit.ray_to(emitted.direction)) else { return };
        segment.length += next.distance;
        store(&next, segment, Rgb::ZERO, LIT_SEGMENTS + 1);
        hit = next;
    }
}

/// Whether a surface reflects any light on the side that a photon came to, as far as that is known at once: matt surfaces are black from behind.
fn receives(scene: &Scene, hit: &Interaction) -> bool {
    let material = scene.material(hit.shape);
    let is_black = || material.constant_value(&shading::view(hit, TransportMode::Flux)) == Some(Rgb::ZERO);
    material.lobes().any(Lobes::SMOOTH) && !is_black()
}
