//! `directional`: parallel light from infinitely far away.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `irradiance` | irradiance on a surface that faces the light | W·m⁻² | 1 |
//! | `direction` | where the light travels; or the +z axis of `to_world` | – | +z |

use std::f32::consts::PI;

use glam::DVec3;

use super::{DirectSample, EmittedPhoton, Surroundings};
use crate::math::{Frame, Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::ToWorld;

/// A distant light.
#[derive(Clone, Debug)]
pub struct Directional {
    axis: Frame,
    irradiance: Rgb,
    surroundings: Surroundings,
}

impl Directional {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, surroundings: Surroundings) -> Result<Self, SceneError> {
        if fields.has("direction") && fields.has("to_world") {
            let remedy = "give one of them";
            return Err(fields.error("direction", "a directional light has \"direction\" and \"to_world\"", remedy));
        }
        let direction = match fields.vector("direction")? {
            Some(direction) => direction,
            None => ToWorld::read(fields)?.vector(DVec3::Z),
        };
        let Some(direction) = direction.try_normalize() else {
            return Err(fields.error("direction", "\"direction\" has no length", "give a vector that is not zero"));
        };
        let rgb = fields.rgb("irradiance")?.unwrap_or([1.0; 3]);
        let irradiance = Rgb::new(rgb[0] as f32, rgb[1] as f32, rgb[2] as f32);
        Ok(Self { axis: Frame::from_normal(direction.as_vec3()), irradiance, surroundings })
    }

    /// E·πR²: what falls on the disc of the scene's bounding sphere.
    pub fn power(&self) -> Rgb {
        self.irradiance * (PI * self.surroundings.radius * self.surroundings.radius)
    }

    /// E from one direction.
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, _point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        Some(DirectSample {
            direction: -self.axis.normal,
            distance: f32::INFINITY,
            weighted_radiance: self.irradiance,
            pdf_solid_angle: 0.0,
            emission_ratio: 1.0 / self.surroundings.disc_area(),
        })
    }

    /// From a point uniform on the disc.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, place: [f32; 2], _direction: [f32; 2]) -> Option<EmittedPhoton> {
        let origin = self.surroundings.disc_point(&self.axis, place);
        Some(self.surroundings.photon(origin, self.axis.normal, self.power(), 1.0))
    }
}

impl Surroundings {
    /// A point uniform on the disc that faces the scene from behind, for light that travels along `axis`' normal.
    #[inline]
    pub fn disc_point(&self, axis: &Frame, u: [f32; 2]) -> Vec3 {
        let point = warp::disc(u) * self.radius;
        self.center + axis.tangent * point.x + axis.bitangent * point.y - axis.normal * self.radius
    }
}
