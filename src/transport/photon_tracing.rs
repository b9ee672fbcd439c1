//! Photon paths: from a light through the scene, stored wherever a surface has a smooth lobe.

use crate::math::octahedral;
use crate::math::random::{Numbers, PassRandom};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::light::EmittedPhoton;
use crate::scene::light::emission_guide::EmissionGuide;
use crate::scene::material::{Lobes, View};

use super::counters::Counters;
use super::light_path::{LightVertices, trace_light_path};
use super::limits::Limits;
use super::photon_map::{PathSegment, Photon, TracedPhoton};
use super::shading::Scattering;
use super::walk::Walk;

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
    /// Where photons start; by power without one.
    pub guide: Option<&'a EmissionGuide>,
}

/// Traces photon path `path` and appends what it stores to `photons`.
#[inline]
pub fn trace_photon<R: TracedPhoton>(
    scene: &Scene,
    settings: &PhotonSettings<'_>,
    path: u32,
    photons: &mut Vec<R>,
    counters: &mut Counters,
) {
    trace_photon_with(scene, settings, path, &settings.random.path(path), photons, counters);
}

/// The same of a path with other numbers.
#[inline]
pub fn trace_photon_with<R: TracedPhoton>(
    scene: &Scene,
    settings: &PhotonSettings<'_>,
    path: u32,
    random: &impl Numbers,
    photons: &mut Vec<R>,
    counters: &mut Counters,
) {
    let mut storing = Storing { scene, settings, path, photons, scattered: false };
    trace_light_path(scene, settings.guide, &settings.limits, random, counters, &mut storing);
}

/// Stores photons where a path meets surfaces.
struct Storing<'a, R> {
    scene: &'a Scene,
    settings: &'a PhotonSettings<'a>,
    path: u32,
    photons: &'a mut Vec<R>,
    /// Whether a lobe with a density scattered the path.
    scattered: bool,
}

impl<R: TracedPhoton, N: Numbers> LightVertices<N> for Storing<'_, R> {
    #[inline(always)]
    fn arrive(&mut self, walk: &Walk, hit: &Interaction, _: &EmittedPhoton, _: &N, _: &mut Counters) {
        let Self { scene, settings, path, scattered, .. } = *self;
        let takers = if settings.narrow_takes_all || !scattered { Lobes::SMOOTH } else { Lobes::WIDE };
        if walk.segments >= settings.first_stored_segment
            && scene.lobes_at(hit.shape).any(takers)
            && let Some(photon) = stored(hit, walk.throughput, walk.segments, scattered)
        {
            self.photons.push(R::traced(photon, PathSegment { path, length: hit.distance }));
        }
    }

    #[inline(always)]
    fn leave(&mut self, _: &Interaction, _: &View, scattering: &Scattering) {
        self.scattered |= !scattering.sample.is_specular();
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
