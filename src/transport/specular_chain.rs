//! Caustic photons: a path from a light that only mirrors and glass scatter, to the first surface that does otherwise.

use super::counters::Counters;
use super::light_path::{LightVertices, follow_photon};
use super::photon_map::{PathSegment, TracedPhoton};
use super::photon_tracing::{PhotonSettings, stored};
use super::projection::SpecularBoxes;
use super::shading::Scattering;
use super::walk::Walk;
use crate::math::random::Numbers;
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::light::EmittedPhoton;
use crate::scene::light::emission_guide::EmissionPoint;
use crate::scene::material::{Lobes, View};

/// What kind of chain a path begins with [Wald 1999, section 4.6.2].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Characteristic {
    /// A bit for each interaction, 0 for reflection and 1 for transmission, behind a 1; of long chains the last 64.
    interactions: u64,
    /// Caustic photons that it left.
    photons: u32,
}

impl Characteristic {
    /// Of a path that no specular surface scattered.
    const NONE: Self = Self { interactions: 1, photons: 0 };
}

/// Where the chains of a pass come from.
#[derive(Clone, Copy)]
pub(crate) struct ChainTracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// How the pass traces photons.
    pub settings: &'a PhotonSettings<'a>,
    /// Photons that meet none of them are not followed.
    pub boxes: Option<&'a SpecularBoxes>,
}

impl ChainTracer<'_> {
    /// Follows the photon that starts at `start` as far as it may leave caustic photons, which are appended to `photons` as those of
    /// path `path`; its scattering has the numbers `random`.
    pub(crate) fn trace<R: TracedPhoton>(
        &self,
        start: &EmissionPoint,
        path: u32,
        random: &impl Numbers,
        photons: &mut Vec<R>,
        counters: &mut Counters,
    ) -> Characteristic {
        let Self { scene, settings, boxes } = *self;
        let Some(emitted) = scene.lights.emit_at(&scene.geometry, start) else { return Characteristic::NONE };
        if boxes.is_some_and(|boxes| !boxes.may_be_met(&emitted)) {
            return Characteristic::NONE;
        }
        counters.photons_emitted += 1;
        let mut chain = Chain { scene, path, photons, characteristic: Characteristic::NONE, goes_on: true };
        follow_photon(scene, &emitted, &settings.limits, random, counters, &mut chain);
        chain.characteristic
    }
}

/// A chain on its way.
struct Chain<'a, R> {
    scene: &'a Scene,
    path: u32,
    photons: &'a mut Vec<R>,
    characteristic: Characteristic,
    /// Whether only specular surfaces scattered the path, and the next may.
    goes_on: bool,
}

impl<R: TracedPhoton, N: Numbers> LightVertices<N> for Chain<'_, R> {
    #[inline(always)]
    fn arrive(&mut self, walk: &Walk, hit: &Interaction, _: &EmittedPhoton, _: &N, _: &mut Counters) {
        let lobes = self.scene.material(hit.shape).lobes();
        // The first surface has direct light.
        if walk.segments > 1 && lobes.any(Lobes::SMOOTH) {
            let photon = stored(hit, walk.throughput, walk.segments, false);
            let segment = PathSegment { path: self.path, length: hit.distance };
            self.characteristic.photons += u32::from(photon.is_some());
            self.photons.extend(photon.map(|photon| R::traced(photon, segment)));
        }
        self.goes_on = lobes.any(Lobes::SPECULAR);
    }

    #[inline(always)]
    fn leave(&mut self, hit: &Interaction, _: &View, scattering: &Scattering) {
        self.goes_on = scattering.sample.is_specular();
        let normal = hit.geometric_normal;
        let is_transmission = scattering.direction.dot(normal) * hit.outgoing.dot(normal) < 0.0;
        self.characteristic.interactions = self.characteristic.interactions << 1 | u64::from(is_transmission);
    }

    #[inline(always)]
    fn goes_on(&self) -> bool {
        self.goes_on
    }
}
