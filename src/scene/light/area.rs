//! `area`: a shape that emits the same radiance from every point of its outside, into every direction.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `radiance` | emitted radiance | W·sr⁻¹·m⁻² | 1 |

use std::f32::consts::PI;

use super::{DirectSample, EmittedPhoton};
use crate::math::discrete::Discrete;
use crate::math::{Frame, Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::{Geometry, Interaction, Primitive};

/// An emitting shape.
#[derive(Clone, Debug)]
pub struct AreaLight {
    radiance: Rgb,
    /// Tree indices of its primitives.
    primitives: Vec<u32>,
    /// Over `primitives`, by area.
    by_area: Discrete,
    area: f32,
}

/// Reads `radiance`.
pub fn read_radiance(fields: &mut Fields<'_>) -> Result<Rgb, SceneError> {
    let rgb = fields.rgb("radiance")?.unwrap_or([1.0; 3]);
    Ok(Rgb::new(rgb[0] as f32, rgb[1] as f32, rgb[2] as f32))
}

impl AreaLight {
    /// A light over the primitives at tree indices `primitives`; `None` when they have no area.
    pub fn new(radiance: Rgb, primitives: Vec<u32>, geometry: &Geometry) -> Option<Self> {
        let areas: Vec<f64> = primitives.iter().map(|index| f64::from(geometry.primitive(*index).area())).collect();
        let by_area = Discrete::new(&areas)?;
        let area = by_area.total() as f32;
        Some(Self { radiance, primitives, by_area, area })
    }

    /// Tree indices of its primitives.
    pub fn primitives(&self) -> &[u32] {
        &self.primitives
    }

    /// π·A·L: one side emits.
    pub fn power(&self) -> Rgb {
        self.radiance * (PI * self.area)
    }

    /// The radiance, where the outside is seen.
    #[inline]
    pub fn emitted(&self, hit: &Interaction) -> Rgb {
        if hit.frame.normal.dot(hit.outgoing) > 0.0 { self.radiance } else { Rgb::ZERO }
    }

    fn single_sphere(&self, geometry: &Geometry) -> Option<crate::scene::geometry::sphere::Sphere> {
        match (self.primitives.as_slice(), geometry.primitive(self.primitives[0])) {
            ([_], Primitive::Sphere(sphere)) => Some(*sphere),
            _ => None,
        }
    }

    /// A point uniform by area, or in the cone that a sphere fills.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, point: Vec3, u: [f32; 2]) -> Option<DirectSample> {
        let in_cone = self.single_sphere(geometry).and_then(|sphere| sphere.sample_cone(point, u));
        let (target, cone_pdf) = match in_cone {
            Some((target, pdf)) => (target, Some(pdf)),
            None => {
                let (index, rest) = self.by_area.pick(u[0]);
                (geometry.primitive(self.primitives[index]).sample([rest, u[1]]), None)
            }
        };
        // The target is kept off its own surface so that rounding cannot hide it.
        let to_light = target.position + target.normal * target.error - point;
        let distance = to_light.length();
        let direction = to_light / distance;
        let cosine = -direction.dot(target.normal);
        if !(cosine > 0.0 && distance > 0.0) {
            return None;
        }
        let pdf_solid_angle = cone_pdf.unwrap_or(distance * distance / (cosine * self.area));
        let weighted_radiance = self.radiance / pdf_solid_angle;
        Some(DirectSample { direction, distance, weighted_radiance, pdf_solid_angle })
    }

    /// The density of [`AreaLight::sample_direct`].
    #[inline]
    pub fn direct_pdf(&self, geometry: &Geometry, point: Vec3, hit: &Interaction) -> f32 {
        if let Some(pdf) = self.single_sphere(geometry).and_then(|sphere| sphere.cone_pdf(point)) {
            return pdf;
        }
        let cosine = hit.geometric_normal.dot(hit.outgoing);
        if cosine <= 0.0 { 0.0 } else { hit.position.distance_squared(point) / (cosine * self.area) }
    }

    /// A point by area and a direction by the cosine: the flux is π·A·L.
    #[inline]
    pub fn emit(&self, geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let (index, rest) = self.by_area.pick(place[0]);
        let point = geometry.primitive(self.primitives[index]).sample([rest, place[1]]);
        let local = warp::cosine_hemisphere(direction);
        Some(EmittedPhoton {
            origin: point.position + point.normal * point.error,
            direction: Frame::from_normal(point.normal).to_world(local),
            flux: self.power(),
        })
    }
}
