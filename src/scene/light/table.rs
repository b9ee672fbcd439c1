//! All lights of a scene: photons pick them by power, surfaces mostly by what may arrive.

mod variants;

use std::sync::Arc;

use super::area::Emission;
use super::emission_guide::{EmissionGuide, EmissionPoint};
use super::groups::LightGroups;
use super::importance::{BY_POWER, LightImportance, Place};
use super::importance_sampler::ImportanceSampler;
use super::visibility::{LightVisibility, VisibilityCell};
use super::{DirectSample, EmittedPhoton, FirstSegment, Light, Origin, SeenPoint};
use crate::math::color::luminance;
use crate::math::discrete::Discrete;
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::ray::Shear;
use crate::scene::geometry::surface::{NO_LIGHT, SEEN_ONLY};
use crate::scene::geometry::{Geometry, Interaction, Ray};

/// The lights, and the probabilities with which they are picked.
#[derive(Clone)]
pub struct LightTable {
    lights: Arc<[Light]>,
    /// What the user calls them, by index; empty where they have no names.
    names: Arc<[String]>,
    /// Which of them belong together.
    groups: Arc<LightGroups>,
    /// What is seen and lights nothing; shapes hold [`SEEN_ONLY`] plus an index.
    seen_only: Vec<Emission>,
    by_power: Discrete,
    /// For photons and light subpaths; by power, unless it is known better.
    by_emission: Discrete,
    by_place: ImportanceSampler,
    /// Of each light by index.
    importances: Arc<[LightImportance]>,
    /// Surfaces count as no nearer to a light when one is picked, m.
    nearest: f32,
    /// What is known of occlusion.
    visibility: Option<LightVisibility>,
    /// Index of the light that surrounds the scene.
    environment: Option<usize>,
    has_extent: bool,
    /// Tree indices of all emitting primitives, when they are so few that testing them all costs less than a ray.
    few_emitters: Option<Vec<u32>>,
}

/// A light that was picked.
#[derive(Clone, Copy, Debug)]
pub struct LightPick {
    /// Its index.
    pub index: usize,
    /// How often it is picked on average, of one pick the probability.
    pub picks: f32,
}

/// Light that a direction found by chance.
#[derive(Clone, Copy, Debug)]
pub struct FoundLight {
    /// Index of the light.
    pub index: usize,
    /// What arrives, W·sr⁻¹·m⁻².
    pub radiance: Rgb,
    /// The density by solid angle with which the light, once it is picked, is sampled there.
    pub pdf: f32,
}

/// Up to so many primitives are tested one by one.
const FEW: usize = 8;
/// Surfaces count as no nearer to a light than this share of the scene's radius when one is picked.
const NEAREST: f32 = 1e-4;
/// Lights with less than this part of the largest share in a cell are left to picks by power.
const LEAST_SEEN: f32 = 0.01;

/// Tree indices of all emitting primitives, if they are few.
fn few_emitters(lights: &[Light]) -> Option<Vec<u32>> {
    let primitives = lights.iter().filter_map(|light| match light {
        Light::AreaLight(area) => Some(area.primitives()),
        _ => None,
    });
    let emitters: Vec<u32> = primitives.flatten().copied().collect();
    (emitters.len() <= FEW).then_some(emitters)
}

impl LightTable {
    /// A table of the lights in `geometry`; `None` when no light emits anything.
    pub fn new(lights: Vec<Light>, geometry: &Geometry) -> Option<Self> {
        let powers: Vec<f64> = lights.iter().map(|light| f64::from(luminance(light.power()))).collect();
        let by_power = Discrete::new(&powers)?;
        let importances: Vec<LightImportance> = lights.iter().map(|light| light.importance(geometry)).collect();
        let nearest = NEAREST * geometry.bounding_sphere().1;
        let by_place = ImportanceSampler::new(&importances, nearest);
        let environment = lights.iter().position(Light::is_environment);
        let has_extent = lights.iter().any(Light::has_extent);
        let few_emitters = few_emitters(&lights);
        Some(Self {
            lights: lights.into(),
            names: Arc::default(),
            groups: Arc::default(),
            seen_only: Vec::new(),
            by_emission: by_power.clone(),
            by_power,
            by_place,
            importances: importances.into(),
            nearest,
            visibility: None,
            environment,
            has_extent,
            few_emitters,
        })
    }

    /// What picks know of occlusion.
    pub fn visibility(&self) -> Option<&LightVisibility> {
        self.visibility.as_ref()
    }

    /// A cell with these shares of the lights by index; `None` when none of them emits anything.
    pub(super) fn visibility_cell(&self, shares: &[f32]) -> Option<VisibilityCell> {
        // Lights of another group are neither picked nor compared with.
        let share = |light: usize| if self.lights[light].is_dark() { 0.0 } else { shares[light] };
        let least = LEAST_SEEN * (0..shares.len()).map(share).fold(0.0, f32::max);
        let kept = |light: usize| if share(light) < least { 0.0 } else { share(light) };
        let powers = (0..shares.len()).map(|light| f64::from(kept(light) * self.by_power.probability(light)));
        let by_power = Discrete::new(&powers.collect::<Vec<f64>>())?;
        Some(VisibilityCell { by_place: ImportanceSampler::of_shares(&self.importances, self.nearest, kept), by_power })
    }

    /// The lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// What the user calls a light; empty where it has no name.
    pub fn name(&self, index: usize) -> &str {
        self.names.get(index).map_or("", String::as_str)
    }

    /// What the importance of a light is computed from.
    pub(super) fn importance(&self, index: usize) -> &LightImportance {
        &self.importances[index]
    }

    /// Whether directions can hit any light by chance.
    pub fn has_extent(&self) -> bool {
        self.has_extent
    }

    /// Whether there is a light that no direction hits by chance.
    pub fn has_points(&self) -> bool {
        self.lights.iter().any(|light| !light.has_extent())
    }

    /// Whether `ray` could reach any light if nothing were in between. False spares a walk through the whole scene.
    #[inline]
    pub fn may_be_hit(&self, geometry: &Geometry, ray: &Ray) -> bool {
        let Some(emitters) = self.few_emitters.as_ref().filter(|_| self.environment.is_none()) else { return true };
        let shear = Shear::new(ray.direction);
        emitters.iter().any(|index| geometry.primitive(*index).intersect(ray, &shear, ray.length).is_some())
    }

    /// Picks a light for `place` with `u` in [0, 1); its index and probability. `None` where no light shines to.
    #[inline]
    pub fn pick(&self, place: &Place, u: f32) -> Option<(usize, f32)> {
        if self.lights.len() == 1 {
            return Some((0, 1.0));
        }
        if let Some(visibility) = &self.visibility {
            return self.pick_seen(visibility.cell(place.position), place, u);
        }
        let by_power = place.by_power();
        let (index, at_place) = if u < by_power {
            let index = self.by_power.pick(u / by_power).0;
            (index, self.by_place.probability(place, index))
        } else {
            self.by_place.pick(place, (u - by_power) / (1.0 - by_power))?
        };
        Some((index, self.mixed(place, index, at_place)))
    }

    /// The probability with which [`LightTable::pick`] takes a light at `place`.
    #[inline]
    pub fn probability(&self, place: &Place, index: usize) -> f32 {
        if self.lights.len() == 1 {
            return 1.0;
        }
        match &self.visibility {
            None => self.mixed(place, index, self.by_place.probability(place, index)),
            Some(visibility) => {
                let cell = visibility.cell(place.position);
                self.mixed_seen(cell, place, index, cell.by_place.probability(place, index))
            }
        }
    }

    /// The probability of a pick of which a share goes by power, and the rest with probability `at_place`.
    #[inline]
    fn mixed(&self, place: &Place, index: usize, at_place: f32) -> f32 {
        let by_power = place.by_power();
        by_power * self.by_power.probability(index) + (1.0 - by_power) * at_place
    }

    /// Picks that know what is hidden: [`BY_POWER`] of them go by power, what goes by power beyond that by seen power, and the rest by
    /// seen importance. What was taken for hidden by chance is still found by power.
    fn pick_seen(&self, cell: &VisibilityCell, place: &Place, u: f32) -> Option<(usize, f32)> {
        let by_power = place.by_power().max(BY_POWER);
        let by_index = |index: usize| (index, cell.by_place.probability(place, index));
        let (index, at_place) = if u < BY_POWER {
            by_index(self.by_power.pick(u / BY_POWER).0)
        } else if u < by_power {
            by_index(cell.by_power.pick((u - BY_POWER) / (by_power - BY_POWER)).0)
        } else {
            cell.by_place.pick(place, (u - by_power) / (1.0 - by_power))?
        };
        Some((index, self.mixed_seen(cell, place, index, at_place)))
    }

    /// The probability of such a pick.
    fn mixed_seen(&self, cell: &VisibilityCell, place: &Place, index: usize, at_place: f32) -> f32 {
        let by_power = place.by_power().max(BY_POWER);
        BY_POWER * self.by_power.probability(index)
            + (by_power - BY_POWER) * cell.by_power.probability(index)
            + (1.0 - by_power) * at_place
    }

    /// Picks a light with `u[2]` and samples what may arrive from it at `place`; densities include the pick.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, place: &Place, u: [f32; 3]) -> Option<DirectSample> {
        let (index, probability) = self.pick(place, u[2])?;
        self.sample_light(geometry, place, LightPick { index, picks: probability }, [u[0], u[1]])
    }

    /// Samples what may arrive at `place` from a light; densities include how often it is picked.
    #[inline(always)]
    pub fn sample_light(
        &self,
        geometry: &Geometry,
        place: &Place,
        LightPick { index, picks }: LightPick,
        u: [f32; 2],
    ) -> Option<DirectSample> {
        let sample = self.lights[index].sample_direct(geometry, place.position, u)?;
        Some(DirectSample {
            weighted_radiance: sample.weighted_radiance / picks,
            pdf_solid_angle: sample.pdf_solid_angle * picks,
            emission_ratio: sample.emission_ratio * (self.emission_pick(index as u32) / picks),
            ..sample
        })
    }

    /// Radiance that a hit emits back along the path, and the density by solid angle with which
    /// [`LightTable::sample_direct`] from `place` finds it. `is_seen`: nothing but specular surfaces lie between the hit and
    /// the camera.
    #[inline]
    pub fn emitted(&self, geometry: &Geometry, place: &Place, hit: &Interaction, is_seen: bool) -> Option<(Rgb, f32)> {
        if hit.shape.light == NO_LIGHT {
            return None;
        }
        if hit.shape.light >= SEEN_ONLY {
            return self.shown(hit, is_seen);
        }
        let FoundLight { index, radiance, pdf } = self.found_at(geometry, place, hit)?;
        Some((radiance, pdf * self.probability(place, index)))
    }

    /// The light that a hit is of, where it emits anything back along the path to `place`.
    #[inline(always)]
    pub fn found_at(&self, geometry: &Geometry, place: &Place, hit: &Interaction) -> Option<FoundLight> {
        if hit.shape.light >= SEEN_ONLY {
            return None;
        }
        let index = hit.shape.light as usize;
        let radiance = self.lights[index].emitted(hit);
        if radiance == Rgb::ZERO {
            return None;
        }
        let pdf = self.lights[index].direct_pdf(geometry, place.position, &SeenPoint::of(hit));
        Some(FoundLight { index, radiance, pdf })
    }

    /// The light outside of the scene that shines from `direction`.
    #[inline]
    pub fn found_outside(&self, direction: Vec3) -> Option<FoundLight> {
        let index = self.environment?;
        let (radiance, pdf) = self.lights[index].environment(direction)?;
        Some(FoundLight { index, radiance, pdf })
    }

    #[cold]
    fn shown(&self, hit: &Interaction, is_seen: bool) -> Option<(Rgb, f32)> {
        if !is_seen {
            return None;
        }
        let radiance = self.seen_only.get((hit.shape.light - SEEN_ONLY) as usize)?.at(hit);
        (radiance != Rgb::ZERO).then_some((radiance, 0.0))
    }

    /// The density by area and solid angle with which [`LightTable::emit`] sends a photon from a hit of a light back along the
    /// path.
    #[inline]
    pub fn emission_pdf(&self, geometry: &Geometry, hit: &Interaction) -> f32 {
        if hit.shape.light >= SEEN_ONLY {
            return 0.0;
        }
        let index = hit.shape.light as usize;
        self.lights[index].emission_pdf(geometry, &SeenPoint::of(hit)) * self.emission_pick(index as u32)
    }

    /// What other ways of sampling the first segment of a photon path there are, from the place that it hits first.
    #[inline]
    pub fn first_segment(&self, geometry: &Geometry, photon: &EmittedPhoton, hit: &Place) -> FirstSegment {
        let pick = self.probability(hit, photon.light as usize);
        let light = &self.lights[photon.light as usize];
        match photon.origin_kind {
            Origin::Surface { primitive, normal } => {
                let seen = SeenPoint { primitive, position: photon.origin, cosine: normal.dot(photon.direction) };
                let direct = light.direct_pdf(geometry, hit.position, &seen) * pick;
                let light_sampling = direct * seen.cosine / photon.pdf;
                FirstSegment { light_sampling, light_hit: 1.0 / photon.pdf, light_cosine: seen.cosine }
            }
            Origin::Point => {
                let light_sampling = pick * hit.position.distance_squared(photon.origin) / photon.pdf;
                FirstSegment { light_sampling, light_hit: 0.0, light_cosine: 1.0 }
            }
            // The direction is in both densities.
            Origin::Distant { sampling_ratio } => FirstSegment {
                light_sampling: sampling_ratio * (pick / self.emission_pick(photon.light)),
                light_hit: if light.is_environment() { 1.0 / photon.pdf } else { 0.0 },
                light_cosine: 1.0,
            },
        }
    }

    /// Over the density of [`LightTable::environment`] at `place`: that of a photon which comes from `direction` through it, by
    /// area across the direction, m⁻².
    #[inline]
    pub fn environment_emission_ratio(&self, place: &Place, direction: Vec3) -> f32 {
        self.environment.map_or(0.0, |index| {
            let picks = self.emission_pick(index as u32) / self.probability(place, index);
            self.lights[index].environment_emission_ratio(direction) * picks
        })
    }

    /// Radiance that arrives at `place` from `direction` outside of the scene, and the density by solid angle with which
    /// [`LightTable::sample_direct`] takes it.
    #[inline]
    pub fn environment(&self, place: &Place, direction: Vec3) -> Option<(Rgb, f32)> {
        let FoundLight { index, radiance, pdf } = self.found_outside(direction)?;
        Some((radiance, pdf * self.probability(place, index)))
    }

    /// The probability with which a photon comes from a light, without a guide.
    #[inline]
    pub fn emission_pick(&self, light: u32) -> f32 {
        self.by_emission.probability(light as usize)
    }

    /// Where photons with these numbers start: as `guide` says, else anywhere on a light that is picked.
    #[inline(always)]
    pub fn emission_point(&self, guide: Option<&EmissionGuide>, place: [f32; 3], direction: [f32; 2]) -> EmissionPoint {
        let numbers = [place[0], place[1], direction[0], direction[1]];
        match guide {
            Some(guide) => guide.point(numbers, place[2]),
            None => EmissionPoint { light: self.by_emission.pick(place[2]).0 as u32, numbers, density: 1.0 },
        }
    }

    /// Emits a photon; its flux and its density include how often photons start there.
    #[inline]
    pub fn emit_at(&self, geometry: &Geometry, point: &EmissionPoint) -> Option<EmittedPhoton> {
        let [x, y, u, v] = point.numbers;
        let photon = self.lights[point.light as usize].emit(geometry, [x, y], [u, v])?;
        let pick = self.emission_pick(point.light) * point.density;
        Some(EmittedPhoton { flux: photon.flux / pick, pdf: photon.pdf * pick, light: point.light, ..photon })
    }

    /// Picks a light by power and emits a photon; its flux includes the pick.
    #[inline]
    pub fn emit(&self, geometry: &Geometry, place: [f32; 3], direction: [f32; 2]) -> Option<EmittedPhoton> {
        self.emit_at(geometry, &self.emission_point(None, place, direction))
    }
}
