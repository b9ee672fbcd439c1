//! `point`: light from one point, the same into every direction.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `intensity` | radiant intensity | W·sr⁻¹ | 1 |
//! | `position` | where it is; or the origin of `to_world` | m | origin |

use std::f32::consts::PI;

use glam::DVec3;

use super::importance::{Aim, Lamp, LightImportance};
use super::{DirectSample, EmittedPhoton};
use crate::math::color::luminance;
use crate::math::{Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::{ToWorld, to_single};

/// A point light.
#[derive(Clone, Debug)]
pub struct Point {
    position: Vec3,
    intensity: Rgb,
}

/// Reads `intensity`.
pub(crate) fn read_intensity(fields: &mut Fields<'_>) -> Result<Rgb, SceneError> {
    let rgb = fields.rgb("intensity")?.unwrap_or([1.0; 3]);
    Ok(Rgb::new(rgb[0] as f32, rgb[1] as f32, rgb[2] as f32))
}

impl Point {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>) -> Result<Self, SceneError> {
        if fields.has("position") && fields.has("to_world") {
            let remedy = "give one of them";
            return Err(fields.error("position", "a point light has both \"position\" and \"to_world\"", remedy));
        }
        let position = fields.vector("position")?.unwrap_or(DVec3::ZERO);
        let position = to_single(ToWorld::read(fields)?.point(position), fields)?;
        Ok(Self { position, intensity: read_intensity(fields)? })
    }

    /// 4πI.
    pub fn power(&self) -> Rgb {
        self.intensity * (4.0 * PI)
    }

    /// The same into every direction.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        let intensity = luminance(self.intensity);
        LightImportance::Near(Lamp { center: self.position, radius: 0.0, intensity, aim: Aim::Everywhere })
    }

    /// I/d².
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        let to_light = self.position - point;
        let distance = to_light.length();
        (distance > 0.0).then(|| DirectSample {
            direction: to_light / distance,
            distance,
            weighted_radiance: self.intensity / (distance * distance),
            pdf_solid_angle: 0.0,
            emission_ratio: warp::SPHERE_PDF / (distance * distance),
        })
    }

    /// A direction uniform over the sphere.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, _place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        Some(EmittedPhoton::from_point(self.position, warp::sphere(direction), self.power(), warp::SPHERE_PDF))
    }
}
