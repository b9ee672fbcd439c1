//! All lights of a scene, picked by power.

use super::{DirectSample, EmittedPhoton, FirstSegment, Light, Origin, SeenPoint};
use crate::math::color::luminance;
use crate::math::discrete::Discrete;
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::ray::Shear;
use crate::scene::geometry::surface::NO_LIGHT;
use crate::scene::geometry::{Geometry, Interaction, Ray};

/// The lights, and the probabilities with which they are picked.
pub struct LightTable {
    lights: Vec<Light>,
    by_power: Discrete,
    /// Index of the light that surrounds the scene.
    environment: Option<usize>,
    has_extent: bool,
    /// Tree indices of all emitting primitives, when they are so few that testing them all costs less than a ray.
    few_emitters: Option<Vec<u32>>,
}

/// Up to so many primitives are tested one by one.
const FEW: usize = 8;

impl LightTable {
    /// A table; `None` when no light emits anything.
    pub fn new(lights: Vec<Light>) -> Option<Self> {
        let powers: Vec<f64> = lights.iter().map(|light| f64::from(luminance(light.power()))).collect();
        let by_power = Discrete::new(&powers)?;
        let environment = lights.iter().position(Light::is_environment);
        let has_extent = lights.iter().any(Light::has_extent);
        let emitters: Vec<u32> = lights
            .iter()
            .filter_map(|light| match light {
                Light::AreaLight(area) => Some(area.primitives()),
                _ => None,
            })
            .flatten()
            .copied()
            .collect();
        let few_emitters = (emitters.len() <= FEW).then_some(emitters);
        Some(Self { lights, by_power, environment, has_extent, few_emitters })
    }

    /// The lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
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

    /// Picks a light with `u[0]` and samples what may arrive from it at `point`; densities include the pick.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, point: Vec3, u: [f32; 3]) -> Option<DirectSample> {
        let (index, _) = self.by_power.pick(u[2]);
        let probability = self.by_power.probability(index);
        let sample = self.lights[index].sample_direct(geometry, point, [u[0], u[1]])?;
        Some(DirectSample {
            weighted_radiance: sample.weighted_radiance / probability,
            pdf_solid_angle: sample.pdf_solid_angle * probability,
            ..sample
        })
    }

    /// Radiance that a hit emits back along the path, and the density by solid angle with which
    /// [`LightTable::sample_direct`] from `point` finds it.
    #[inline]
    pub fn emitted(&self, geometry: &Geometry, point: Vec3, hit: &Interaction) -> Option<(Rgb, f32)> {
        if hit.shape.light == NO_LIGHT {
            return None;
        }
        let index = hit.shape.light as usize;
        let radiance = self.lights[index].emitted(hit);
        if radiance == Rgb::ZERO {
            return None;
        }
        let pdf =
            self.lights[index].direct_pdf(geometry, point, &SeenPoint::of(hit)) * self.by_power.probability(index);
        Some((radiance, pdf))
    }

    /// The density by area and solid angle with which [`LightTable::emit`] sends a photon from a hit of a light back along the
    /// path.
    #[inline]
    pub fn emission_pdf(&self, geometry: &Geometry, hit: &Interaction) -> f32 {
        if hit.shape.light == NO_LIGHT {
            return 0.0;
        }
        let index = hit.shape.light as usize;
        self.lights[index].emission_pdf(geometry, &SeenPoint::of(hit)) * self.by_power.probability(index)
    }

    /// What other ways of sampling the first segment of a photon path there are, from where it hits first.
    #[inline]
    pub fn first_segment(&self, geometry: &Geometry, photon: &EmittedPhoton, hit: Vec3) -> FirstSegment {
        let pick = self.by_power.probability(photon.light as usize);
        let light = &self.lights[photon.light as usize];
        match photon.origin_kind {
            Origin::Surface { primitive, normal } => {
                let seen = SeenPoint { primitive, position: photon.origin, cosine: normal.dot(photon.direction) };
                let direct = light.direct_pdf(geometry, hit, &seen) * pick;
                let light_sampling = direct * seen.cosine / photon.pdf;
                FirstSegment { light_sampling, light_hit: 1.0 / photon.pdf, light_cosine: seen.cosine }
            }
            Origin::Point => {
                let light_sampling = pick * hit.distance_squared(photon.origin) / photon.pdf;
                FirstSegment { light_sampling, light_hit: 0.0, light_cosine: 1.0 }
            }
            // The pick and the direction are in both densities.
            Origin::Distant { sampling_ratio } => FirstSegment {
                light_sampling: sampling_ratio,
                light_hit: if light.is_environment() { 1.0 / photon.pdf } else { 0.0 },
                light_cosine: 1.0,
            },
        }
    }

    /// Over the density of [`LightTable::environment`]: that of a photon which comes from `direction` through a given point
    /// across it, m⁻².
    #[inline]
    pub fn environment_emission_ratio(&self, direction: Vec3) -> f32 {
        self.environment.map_or(0.0, |index| self.lights[index].environment_emission_ratio(direction))
    }

    /// Radiance that arrives from `direction` outside of the scene, and the density by solid angle of sampling it.
    #[inline]
    pub fn environment(&self, direction: Vec3) -> Option<(Rgb, f32)> {
        let index = self.environment?;
        let (radiance, pdf) = self.lights[index].environment(direction)?;
        Some((radiance, pdf * self.by_power.probability(index)))
    }

    /// Picks a light by power and emits a photon; its flux includes the pick.
    #[inline]
    pub fn emit(&self, geometry: &Geometry, place: [f32; 3], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let (index, _) = self.by_power.pick(place[2]);
        let photon = self.lights[index].emit(geometry, [place[0], place[1]], direction)?;
        let pick = self.by_power.probability(index);
        Some(EmittedPhoton { flux: photon.flux / pick, pdf: photon.pdf * pick, light: index as u32, ..photon })
    }
}
