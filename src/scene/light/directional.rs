//! `directional`: parallel light from infinitely far away.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `irradiance` | irradiance on a surface that faces the light | W·m⁻² | 1 |
//! | `direction` | where the light travels; or the +z axis of `to_world` | – | +z |

use glam::DVec3;

use super::{DirectSample, EmittedPhoton, LightImportance, Surroundings};
use crate::math::color::luminance;
use crate::math::{Rgb, Vec3};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::ToWorld;

/// A distant light.
#[derive(Clone, Debug)]
pub struct Directional {
    /// Where the light travels, a unit vector.
    direction: Vec3,
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
        Ok(Self { direction: direction.as_vec3(), irradiance, surroundings })
    }

    /// What falls on the box around the scene.
    pub fn power(&self) -> Rgb {
        self.irradiance * self.surroundings.silhouette(self.direction)
    }

    /// The same everywhere.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        LightImportance::Far { irradiance: luminance(self.irradiance) }
    }

    /// E from one direction.
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, _point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        Some(DirectSample {
            direction: -self.direction,
            distance: f32::INFINITY,
            weighted_radiance: self.irradiance,
            pdf_solid_angle: 0.0,
            emission_ratio: 1.0 / self.surroundings.silhouette(self.direction),
        })
    }

    /// From a place uniform over the silhouette of the box around the scene.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, place: [f32; 2], _direction: [f32; 2]) -> Option<EmittedPhoton> {
        Some(self.surroundings.photon(self.direction, place, self.irradiance, 1.0))
    }
}
