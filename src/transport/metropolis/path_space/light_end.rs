//! Where a path leaves a light, and what the first segment carries.

use std::f32::consts::PI;

use crate::math::{Rgb, Vec3};
use crate::scene::Scene;
use crate::scene::geometry::Interaction;
use crate::scene::geometry::surface::SEEN_ONLY;
use crate::scene::light::{EmittedPhoton, Light, Origin, Place, SeenPoint};
use crate::transport::metropolis::mutation::Source;

/// The first vertex of a path, x₀.
#[derive(Clone, Copy, Debug)]
pub enum LightEnd {
    /// A place of an emitting surface.
    Surface {
        /// Index of the light.
        light: u32,
        /// Tree index of the primitive.
        primitive: u32,
        /// m, off the surface.
        position: Vec3,
        /// Unit normal on the side that emits.
        normal: Vec3,
        /// W·sr⁻¹·m⁻², the same in all directions.
        radiance: Rgb,
    },
    /// A direction of light that surrounds the scene, its place among directions.
    Distant {
        /// Index of the light.
        light: u32,
        /// Unit direction towards it.
        direction: Vec3,
    },
    /// A light that directions never hit: of a point, or of one direction.
    Delta {
        /// Index of the light.
        light: u32,
    },
    /// Emission that is seen and lights nothing, W·sr⁻¹·m⁻².
    SeenOnly {
        /// m, off the surface.
        position: Vec3,
        /// Unit normal on the side that emits.
        normal: Vec3,
        /// W·sr⁻¹·m⁻².
        radiance: Rgb,
    },
}

/// The first segment of a path, seen from its end x₁.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightSegment {
    /// Unit direction from x₁ to the light.
    pub direction: Vec3,
    /// m; infinite where the light is no place.
    pub distance: f32,
    /// What arrives at x₁ but for the geometry: W·sr⁻¹·m⁻², of [`LightEnd::Delta`] W·m⁻².
    pub radiance: Rgb,
    /// The geometry term without the cosine at x₁: cos θ₀/d², m⁻²; 1 where x₀ is a direction or nothing.
    pub geometry: f64,
    /// Density of x₀ when a place of a light is sampled: by area, by solid angle, or a probability.
    pub place: f64,
    /// Density of x₀ and x₁ when a photon is emitted, without the cosine at x₁.
    pub emission: f64,
    /// cos θ₀; 1 where x₀ is no surface.
    pub cosine: f64,
}

impl LightEnd {
    /// Where a photon started.
    pub fn of_photon(scene: &Scene, photon: &EmittedPhoton) -> Self {
        let light = photon.light;
        match photon.origin_kind {
            Origin::Surface { primitive, normal } => {
                let radiance = photon.flux * (photon.pdf / photon.direction.dot(normal));
                Self::Surface { light, primitive, position: photon.origin, normal, radiance }
            }
            Origin::Distant { .. } if scene.lights.lights()[light as usize].is_environment() => {
                Self::Distant { light, direction: -photon.direction }
            }
            Origin::Distant { .. } | Origin::Point => Self::Delta { light },
        }
    }

    /// A place of a light that is picked by power.
    pub fn sample(scene: &Scene, source: &mut Source) -> Option<Self> {
        let numbers = [0; 5].map(|_| source.number());
        let point = scene.lights.emission_point(None, [numbers[0], numbers[1], numbers[2]], [numbers[3], numbers[4]]);
        Self::at(scene, point.light, numbers)
    }

    /// The place of a light that the first two numbers pick.
    pub fn at(scene: &Scene, light: u32, numbers: [f32; 5]) -> Option<Self> {
        let [x, y, _, u, v] = numbers;
        match &scene.lights.lights()[light as usize] {
            Light::AreaLight(area) => {
                let photon = area.emit(&scene.geometry, [x, y], [u, v])?;
                Some(Self::of_photon(scene, &EmittedPhoton { light, ..photon }))
            }
            other if other.is_environment() => {
                let center = scene.geometry.bounding_sphere().0;
                let direction = other.sample_direct(&scene.geometry, center, [x, y])?.direction;
                Some(Self::Distant { light, direction })
            }
            _ => Some(Self::Delta { light }),
        }
    }

    /// Where a camera subpath hit a light by chance. `is_seen`: nothing but specular surfaces lie between the hit and the camera.
    pub fn of_hit(scene: &Scene, hit: &Interaction, is_seen: bool) -> Option<Self> {
        let place = Place::from(hit.position);
        let (radiance, _) = scene.lights.emitted(&scene.geometry, &place, hit, is_seen)?;
        let position = hit.offset_towards(hit.outgoing);
        let is_front = hit.outgoing.dot(hit.geometric_normal) > 0.0;
        let normal = if is_front { hit.geometric_normal } else { -hit.geometric_normal };
        let light = hit.shape.light;
        Some(match light >= SEEN_ONLY {
            true => Self::SeenOnly { position, normal, radiance },
            false => Self::Surface { light, primitive: hit.primitive, position, normal, radiance },
        })
    }

    /// The light outside of the scene in `direction`.
    pub fn outside(scene: &Scene, direction: Vec3) -> Option<Self> {
        let found = scene.lights.found_outside(direction)?;
        Some(Self::Distant { light: found.index as u32, direction })
    }

    /// Index of the light; `None` for emission that lights nothing.
    pub fn index(&self) -> Option<u32> {
        match *self {
            Self::Surface { light, .. } | Self::Distant { light, .. } | Self::Delta { light } => Some(light),
            Self::SeenOnly { .. } => None,
        }
    }

    /// Whether a camera subpath can hit it.
    pub fn can_be_hit(&self) -> bool {
        !matches!(self, Self::Delta { .. })
    }

    /// Where light starts in directions that can be turned; `first` is the segment to `to`.
    pub fn position(&self, scene: &Scene, first: &LightSegment, to: Vec3) -> Option<Vec3> {
        match *self {
            Self::Surface { position, .. } | Self::SeenOnly { position, .. } => Some(position),
            Self::Delta { light } => match &scene.lights.lights()[light as usize] {
                Light::Directional(_) | Light::DirectionalArea(_) => None,
                _ => Some(to + first.direction * first.distance),
            },
            Self::Distant { .. } => None,
        }
    }

    /// The segment to a point x₁; `None` where it carries nothing.
    pub fn segment(&self, scene: &Scene, to: Vec3) -> Option<LightSegment> {
        let (lights, geometry) = (&scene.lights, &scene.geometry);
        match *self {
            Self::Surface { light, primitive, position, normal, radiance } => {
                let mut segment = surface_segment(position, normal, radiance, to)?;
                let pick = f64::from(lights.emission_pick(light));
                let of_light = &lights.lights()[light as usize];
                let density = |cosine: f32| {
                    pick * f64::from(of_light.emission_pdf(geometry, &SeenPoint { primitive, position, cosine }))
                };
                segment.place = density(1.0) * f64::from(PI);
                segment.emission = density(segment.cosine as f32) / f64::from(position.distance_squared(to));
                Some(segment)
            }
            Self::SeenOnly { position, normal, radiance } => surface_segment(position, normal, radiance, to),
            Self::Distant { light, direction } => {
                let of_light = &lights.lights()[light as usize];
                let (radiance, density) = of_light.environment(direction)?;
                let place = f64::from(density) * f64::from(lights.emission_pick(light));
                let emission = place * f64::from(of_light.environment_emission_ratio(direction));
                let (distance, geometry, cosine) = (f32::INFINITY, 1.0, 1.0);
                Some(LightSegment { direction, distance, radiance, geometry, place, emission, cosine })
            }
            Self::Delta { light } => {
                let sample = lights.lights()[light as usize].sample_direct(geometry, to, [0.5; 2])?;
                let place = f64::from(lights.emission_pick(light));
                let emission = place * f64::from(sample.emission_ratio);
                let (direction, distance, radiance) = (sample.direction, sample.distance, sample.weighted_radiance);
                Some(LightSegment { direction, distance, radiance, geometry: 1.0, place, emission, cosine: 1.0 })
            }
        }
    }
}

/// A segment from a surface, without the densities with which it is sampled.
fn surface_segment(position: Vec3, normal: Vec3, radiance: Rgb, to: Vec3) -> Option<LightSegment> {
    let offset = position - to;
    let distance = offset.length();
    let direction = offset / distance;
    let cosine = f64::from(-direction.dot(normal));
    let geometry = cosine / f64::from(distance * distance);
    (cosine > 0.0 && geometry.is_finite()).then_some(LightSegment {
        direction,
        distance,
        radiance,
        geometry,
        place: 0.0,
        emission: 0.0,
        cosine,
    })
}
