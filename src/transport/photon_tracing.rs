//! Photon paths: from a light through the scene, stored wherever a surface has a smooth lobe.

use crate::math::octahedral;
use crate::math::random::{PassRandom, dimension};
use crate::scene::Scene;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::material::{Lobes, TransportMode};

use super::counters::Counters;
use super::limits::Limits;
use super::photon_map::Photon;
use super::shading;

/// Which photons of a pass are traced and stored.
#[derive(Clone, Copy, Debug)]
pub struct PhotonSettings<'a> {
    /// Limits on the whole path; a photon leaves at least one segment to the camera.
    pub limits: Limits,
    /// Photons with fewer segments are not stored: 2 leaves direct light to sampling, 1 stores all.
    pub first_stored_segment: u32,
    /// Whether narrow lobes take all photons, or only those that just specular surfaces scattered.
    pub narrow_takes_all: bool,
    /// The pass's random numbers.
    pub random: &'a PassRandom,
    /// Photon paths of a pass.
    pub paths: u32,
}

/// Traces photon path `path` and appends what it stores to `photons`.
#[inline]
pub fn trace_photon(
    scene: &Scene,
    settings: &PhotonSettings<'_>,
    path: u32,
    photons: &mut Vec<Photon>,
    counters: &mut Counters,
) {
    let random = settings.random.path(path);
    counters.photons_emitted += 1;
    let place = random.block(dimension::EMISSION);
    let direction = random.block(dimension::EMISSION_DIRECTION);
    let emitted = scene.lights.emit(&scene.geometry, [place[0], place[1], place[2]], [direction[0], direction[1]]);
    let Some(emitted) = emitted else { return };
    let mut ray = Ray::new(emitted.origin, emitted.direction);
    let mut flux = emitted.flux;
    let emitted_peak = flux.max_element();
    if !(emitted_peak > 0.0 && emitted_peak.is_finite()) {
        counters.non_finite += u64::from(!emitted_peak.is_finite());
        return;
    }
    let mut scattered = false;
    for segments in 1u32.. {
        if !settings.limits.allows(segments + 1) {
            return;
        }
        counters.rays += 1;
        let Some(hit) = scene.intersect(&ray) else { return };
        let material = scene.material(hit.shape);
        let takers = if settings.narrow_takes_all || !scattered { Lobes::SMOOTH } else { Lobes::WIDE };
        if segments >= settings.first_stored_segment && material.lobes().any(takers) {
            photons.extend(stored(&hit, flux, segments, scattered));
        }
        let u = random.block(dimension::scattering(segments));
        let view = shading::view(&hit, TransportMode::Flux);
        let Some(scattering) = shading::scatter(&hit, material, &view, [u[0], u[1], u[2]]) else { return };
        scattered |= !scattering.sample.is_specular();
        flux *= scattering.weight;
        let survival = settings.limits.survival(segments, flux.max_element() / emitted_peak);
        if u[3] >= survival {
            return;
        }
        flux /= survival;
        ray = hit.ray_to(scattering.direction);
    }
}

/// The photon as it is kept. A density estimate measures flux per true area while the material weighs it by the shading
/// normal's cosine, hence the factor `|ω·Ns|/|ω·Ng|`, 1 on flat surfaces.
#[inline]
pub fn stored(hit: &Interaction, flux: crate::math::Rgb, segments: u32, scattered: bool) -> Option<Photon> {
    let cosine = hit.outgoing.dot(hit.geometric_normal);
    let facing = if cosine < 0.0 { -hit.geometric_normal } else { hit.geometric_normal };
    let shading_cosine = hit.outgoing.dot(hit.frame.normal);
    if shading_cosine * cosine <= 0.0 {
        return None;
    }
    let flux = flux * (shading_cosine / cosine);
    Some(Photon::new(hit.position, octahedral::encode(hit.outgoing), facing, flux, segments, scattered))
}
