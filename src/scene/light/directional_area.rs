//! `directionalarea`: a flat shape that emits along its normal alone, as a wide collimated beam.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `radiance` | flux per area of the shape, which is the irradiance on what faces it; may be a texture | W·m⁻² | 1 |
//!
//! The name is Mitsuba's, although the number is no radiance: light of one direction has none. Rays cannot hit that direction by
//! chance, so the shape itself looks black. Mitsuba's `path` sees none of the light; here direct light is sampled, too.

use super::area::Emission;
use super::{DirectSample, EmittedPhoton, LightImportance, Origin};
use crate::math::color::luminance;
use crate::math::discrete::Discrete;
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::ray::{Ray, Shear};
use crate::scene::geometry::{Geometry, Primitive};
use crate::scene::texture::Texture;

/// A flat shape that emits along its normal.
#[derive(Clone, Debug)]
pub struct DirectionalArea {
    radiance: Texture,
    /// Tree indices of its primitives, ascending.
    primitives: Vec<u32>,
    by_area: Discrete,
    /// m².
    area: f32,
    /// Unit normal: where the light travels.
    normal: Vec3,
}

/// Whether primitives lie in one plane, all with the same outside.
pub(crate) fn is_flat(primitives: &[Primitive]) -> bool {
    /// Rounding of normals, and of places as a share of the shape's size.
    const ROUNDING: f32 = 1e-4;
    let Some(first) = primitives.first().map(|primitive| primitive.sample([0.5; 2])) else { return false };
    let corners = primitives.iter().map(Primitive::bounds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let size = corners.map_or(0.0, |(low, high)| low.distance(high));
    primitives.iter().all(|primitive| {
        let point = primitive.sample([0.5; 2]);
        let off = (point.position - first.position).dot(first.normal).abs();
        primitive.is_flat() && point.normal.dot(first.normal) > 1.0 - ROUNDING && off <= ROUNDING * size
    })
}

impl DirectionalArea {
    /// A light over the primitives at tree indices `primitives`, which are flat; `None` when they have no area.
    pub fn new(emission: Emission, primitives: Vec<u32>, geometry: &Geometry) -> Option<Self> {
        let areas: Vec<f64> = primitives.iter().map(|index| f64::from(geometry.primitive(*index).area())).collect();
        let by_area = Discrete::new(&areas)?;
        let area = by_area.total() as f32;
        let normal = geometry.primitive(*primitives.first()?).sample([0.5; 2]).normal;
        Some(Self { radiance: emission.radiance, primitives, by_area, area, normal })
    }

    /// The mean over texture space times the area.
    pub fn power(&self) -> Rgb {
        self.radiance.mean() * self.area
    }

    /// The same at every distance.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        LightImportance::Far { irradiance: luminance(self.radiance.range()[1]) }
    }

    /// From the place of the light that the normal leads from to `point`.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        let ray = Ray::new(point, -self.normal);
        let shear = Shear::new(ray.direction);
        let (primitive, hit) = self.primitives.iter().find_map(|index| {
            let hit = geometry.primitive(*index).intersect(&ray, &shear, f32::INFINITY)?;
            Some((*index, hit))
        })?;
        let surface = geometry.primitive(primitive).surface(&ray, &hit);
        let place = geometry.texture_point_at(primitive, surface.position, hit.barycentric);
        let distance = hit.distance - surface.error;
        (distance > 0.0).then(|| DirectSample {
            direction: -self.normal,
            distance,
            weighted_radiance: self.radiance.color(&place),
            pdf_solid_angle: 0.0,
            emission_ratio: 1.0 / self.area,
        })
    }

    /// From a place uniform by area.
    #[inline]
    pub fn emit(&self, geometry: &Geometry, place: [f32; 2], _direction: [f32; 2]) -> Option<EmittedPhoton> {
        let (pick, rest) = self.by_area.pick(place[0]);
        let (point, place) = geometry.sample_for_texture(self.primitives[pick], [rest, place[1]]);
        Some(EmittedPhoton {
            origin: point.position + self.normal * point.error,
            direction: self.normal,
            flux: self.radiance.color(&place) * self.area,
            pdf: 1.0 / self.area,
            // As of light from outside, whose direction is in both densities.
            origin_kind: Origin::Distant { sampling_ratio: self.area },
            light: 0,
        })
    }
}
