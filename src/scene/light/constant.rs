//! `constant`: the same radiance from every direction around the scene.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `radiance` | radiance of the surroundings | W·sr⁻¹·m⁻² | 1 |

use std::f32::consts::PI;

use super::{DirectSample, EmittedPhoton, Surroundings};
use crate::math::{Frame, Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;

/// A uniform environment.
#[derive(Clone, Debug)]
pub struct Constant {
    radiance: Rgb,
    surroundings: Surroundings,
}

impl Constant {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, surroundings: Surroundings) -> Result<Self, SceneError> {
        let rgb = fields.rgb("radiance")?.unwrap_or([1.0; 3]).map(|channel| channel as f32);
        Ok(Self { radiance: Rgb::from_array(rgb), surroundings })
    }

    /// Its radiance.
    pub fn radiance(&self) -> Rgb {
        self.radiance
    }

    /// What its photons start from.
    pub fn surroundings(&self) -> &Surroundings {
        &self.surroundings
    }

    /// The density of [`Constant::sample_direct`] by solid angle.
    pub fn direct_pdf(&self) -> f32 {
        warp::SPHERE_PDF
    }

    /// π·L·4πR²: what enters the scene's bounding sphere.
    pub fn power(&self) -> Rgb {
        self.radiance * (4.0 * PI * PI * self.surroundings.radius * self.surroundings.radius)
    }

    /// A direction uniform over the sphere.
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, _point: Vec3, u: [f32; 2]) -> Option<DirectSample> {
        Some(DirectSample {
            direction: warp::sphere(u),
            distance: f32::INFINITY,
            weighted_radiance: self.radiance / warp::SPHERE_PDF,
            pdf_solid_angle: warp::SPHERE_PDF,
            emission_ratio: 1.0 / self.surroundings.disc_area(),
        })
    }

    /// A direction uniform over the sphere and a point uniform on the disc across it.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let axis = Frame::from_normal(warp::sphere(direction));
        let origin = self.surroundings.disc_point(&axis, place);
        Some(self.surroundings.photon(origin, axis.normal, self.power(), warp::SPHERE_PDF))
    }
}
