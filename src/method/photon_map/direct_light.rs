//! How direct light is found where a camera path ends [Wald 1999, section 4.2]: by light samples, or with the help of photons that came straight
//! from lights.
//!
//! | `direct` | light at a wide lobe | bias |
//! |---|---|---|
//! | `sample` | light and material samples share it [4.2.1] | none |
//! | `photons` | density estimate of first hits | that of the estimate |
//! | `shadow_photons` | as `sample`, but a light whose photons nearby are all lit counts as seen, one whose photons are all shadow as hidden [4.2.2] | objects that every photon missed throw no shadow, and shadows' rims lie where photons part |
//! | `photon_direct` | as `sample`, with lights picked by the energy of their photons nearby, and one as usual [4.2.3] | none |
//!
//! First hits are traced again, with the random numbers of the pass's photons and so to the same places: of all photons only they need to know
//! their light, and shadows have to go on from there in any case.
//!
//! A look-up serves the points of a row of pixels that follow it closely: its photons only say how often lights are picked, so a
//! look-up of the wrong place costs noise at most. Rows begin without one, so that neither threads nor regions change a picture.

use std::sync::atomic::AtomicBool;

use super::TwoPasses;
use super::look_up::LookUp;
use super::parameters::{DirectMode, Parameters};
use crate::math::random::{MOST_PARTS, PassRandom, PathRandom, Stream};
use crate::math::{Rgb, Vec3};
use crate::method::Pass;
use crate::method::parameter_values::Auto;
use crate::transport::Counters;
use crate::transport::camera_walk::GatherPoint;
use crate::transport::direct_light::{direct_light, planned_direct_light};
use crate::transport::direct_photons::{LIT_SEGMENTS, Stored, trace_direct_photons};
use crate::transport::first_radius::RadiusBounds;
use crate::transport::light_plan::{LightEnergies, LightPlan};
use crate::transport::light_sights::LightSights;
use crate::transport::photon_map::{LightLookup, LightSegment, Nearest, PhotonMap};
use crate::transport::receiver::{Counting, Receiver};

/// A look-up is used again where normals agree this well.
const LEAST_COSINE: f32 = 0.9;

/// How a pass finds direct light, with the photons that it needs.
pub(super) enum DirectLight<D> {
    /// By one light sample.
    OneSample,
    /// By several.
    Samples,
    /// By first hits.
    Photons(D),
    /// By light samples, with first hits and shadow photons.
    ShadowPhotons(D),
    /// By light samples that first hits pick.
    PhotonDirect(D),
}

impl<D> DirectLight<D> {
    /// The same with photons in another structure.
    pub(super) fn map<E>(self, other: impl FnOnce(D) -> E) -> DirectLight<E> {
        match self {
            Self::OneSample => DirectLight::OneSample,
            Self::Samples => DirectLight::Samples,
            Self::Photons(photons) => DirectLight::Photons(other(photons)),
            Self::ShadowPhotons(photons) => DirectLight::ShadowPhotons(other(photons)),
            Self::PhotonDirect(photons) => DirectLight::PhotonDirect(other(photons)),
        }
    }
}

impl Parameters {
    /// A look-up of direct photons. Those that only pick lights may lie as far away as any.
    pub(super) fn direct_look_up(&self, scene_radius: f32, photons_per_pass: u32) -> LookUp {
        let mut look_up = self.look_up(self.direct_neighbors.get(), scene_radius, photons_per_pass);
        if self.direct == DirectMode::PhotonDirect && self.largest_radius.meters() == Auto::Auto {
            look_up.estimate.largest_radius_squared = RadiusBounds::largest_squared(scene_radius);
        }
        look_up
    }
}

impl TwoPasses {
    /// What pixels that look at set `set` of the pass's maps need for direct light; `total` counts what it took. `None`: cancelled.
    pub(super) fn trace_direct(
        &self,
        stream: Stream,
        pass: &Pass<'_>,
        set: u32,
        total: &mut Counters,
        cancel: &AtomicBool,
    ) -> Option<DirectLight<PhotonMap<LightSegment>>> {
        let random = PassRandom::independent(self.seed, stream, pass.index).part(set, MOST_PARTS);
        let settings = self.photon_settings(&random, self.photons_per_pass, pass.guide);
        let mut trace = |kind: Stored| {
            let (photons, counters) =
                trace_direct_photons(&self.scene, &settings, kind, self.grid(&self.direct), cancel)?;
            *total += counters;
            Some(photons)
        };
        Some(match self.parameters.direct {
            DirectMode::Sample if self.parameters.direct_samples.get() == 1 => DirectLight::OneSample,
            DirectMode::Sample => DirectLight::Samples,
            DirectMode::Photons => DirectLight::Photons(trace(Stored::Lit)?),
            DirectMode::ShadowPhotons => DirectLight::ShadowPhotons(trace(Stored::LitAndShadows)?),
            DirectMode::PhotonDirect => DirectLight::PhotonDirect(trace(Stored::Lit)?),
        })
    }
}

/// Direct light in one row of pixels.
pub(super) struct DirectRow<'a, D> {
    method: &'a TwoPasses,
    direct: &'a DirectLight<D>,
    found: Nearest,
    energies: LightEnergies,
    sights: LightSights,
    /// Where `energies` were looked up.
    looked_up: Option<LookedUp>,
}

/// Where photons were looked up.
#[derive(Clone, Copy)]
struct LookedUp {
    position: Vec3,
    normal: Vec3,
    radius_squared: f32,
}

impl<'a, D: LightLookup> DirectRow<'a, D> {
    /// A row of which nothing is known.
    pub(super) fn new(method: &'a TwoPasses, direct: &'a DirectLight<D>) -> Self {
        let (found, energies, sights) = (Nearest::default(), LightEnergies::default(), LightSights::default());
        Self { method, direct, found, energies, sights, looked_up: None }
    }

    /// Direct radiance that the lobes at a point reflect, without the path's throughput.
    #[inline]
    pub(super) fn reflected(&mut self, at: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
        if at.goes_on || matches!(self.direct, DirectLight::OneSample) {
            return direct_light(&self.method.scene, at, random, counters);
        }
        self.reflected_otherwise(at, random, counters)
    }

    /// The same where it is not one light sample.
    fn reflected_otherwise(&mut self, at: &GatherPoint, random: &PathRandom, counters: &mut Counters) -> Rgb {
        let TwoPasses { scene, parameters, photons_per_pass, direct: look_up, .. } = self.method;
        let samples = parameters.direct_samples.get();
        match self.direct {
            DirectLight::OneSample | DirectLight::Samples => self.sampled([samples, 0], at, random, counters),
            DirectLight::Photons(photons) => {
                let reflected = look_up.estimate.reflected(scene, photons, at, LIT_SEGMENTS, &mut self.found, counters);
                reflected / *photons_per_pass as f32
            }
            DirectLight::ShadowPhotons(photons) => {
                self.find(photons, at, LIT_SEGMENTS + 1);
                self.sights.judge(photons, &self.found);
                self.sampled([samples, 0], at, random, counters)
            }
            DirectLight::PhotonDirect(photons) => {
                self.find_energies(photons, at);
                self.sampled([1, samples], at, random, counters)
            }
        }
    }

    /// Direct light by so many samples, picked as usual and by photons.
    fn sampled(
        &self,
        [usual, by_photons]: [u32; 2],
        at: &GatherPoint,
        random: &PathRandom,
        counters: &mut Counters,
    ) -> Rgb {
        let plan = LightPlan { usual, by_photons, energies: &self.energies };
        let sight = |light: usize| self.sights.of(light);
        planned_direct_light(&self.method.scene, at, &plan, sight, random, counters)
    }

    /// Finds the photons around a point.
    fn find(&mut self, photons: &D, at: &GatherPoint, most_segments: u32) -> LookedUp {
        let TwoPasses { scene, direct, .. } = self.method;
        let radius_squared = direct.estimate.largest_radius_squared;
        let query = Receiver::new(scene, &at.hit, at.view()).query(Counting {
            radius_squared,
            most_segments,
            caustics_only: false,
        });
        photons.nearest(&query, direct.estimate.neighbors, &mut self.found);
        LookedUp { position: query.position, normal: query.normal, radius_squared: self.found.radius_squared() }
    }

    /// Finds what photons brought of each light to a point, or keeps what was found close by.
    fn find_energies(&mut self, photons: &D, at: &GatherPoint) {
        let reuse = self.method.parameters.direct_reuse.get() as f32;
        let serves = |last: LookedUp| {
            let reach = reuse * reuse * last.radius_squared;
            at.hit.position.distance_squared(last.position) < reach
                && at.facing_normal().dot(last.normal) > LEAST_COSINE
        };
        if self.looked_up.is_some_and(serves) {
            return;
        }
        self.looked_up = Some(self.find(photons, at, LIT_SEGMENTS));
        self.energies.clear();
        for (_, index) in self.found.photons() {
            self.energies.add(photons.light(index) as usize, photons.flux(index));
        }
    }
}
