//! `constant`: the same radiance from every direction around the scene.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `radiance` | radiance of the surroundings | W·sr⁻¹·m⁻² | 1 |

use std::f32::consts::PI;

use super::{DirectSample, EmittedPhoton, LightImportance, Surroundings};
use crate::math::color::luminance;
use crate::math::{Rgb, Vec3, warp};
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
        // It is the same in all directions.
        fields.ignore(&["to_world"]);
        let rgb = fields.rgb("radiance")?.unwrap_or([1.0; 3]).map(|channel| channel as f32);
        Ok(Self { radiance: Rgb::from_array(rgb), surroundings })
    }

    /// Its radiance.
    pub fn radiance(&self) -> Rgb {
        self.radiance
    }

    /// The density of [`Constant::sample_direct`] by solid angle.
    pub fn direct_pdf(&self) -> f32 {
        warp::SPHERE_PDF
    }

    /// See [`DirectSample::emission_ratio`]; photons have the density 1/(π·surface) of the box around the scene, m⁻².
    pub fn emission_ratio(&self) -> f32 {
        1.0 / (PI * self.surroundings.surface() * warp::SPHERE_PDF)
    }

    /// π·L times the surface of the box around the scene: what enters it.
    pub fn power(&self) -> Rgb {
        self.radiance * (PI * self.surroundings.surface())
    }

    /// π·L on every surface.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        LightImportance::Far { irradiance: PI * luminance(self.radiance) }
    }

    /// A direction uniform over the sphere.
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, _point: Vec3, u: [f32; 2]) -> Option<DirectSample> {
        Some(DirectSample {
            direction: warp::sphere(u),
            distance: f32::INFINITY,
            weighted_radiance: self.radiance / warp::SPHERE_PDF,
            pdf_solid_angle: warp::SPHERE_PDF,
            emission_ratio: self.emission_ratio(),
        })
    }

    /// From a point uniform on the box around the scene, in a direction by its cosine there.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        Some(self.surroundings.uniform_photon(place, direction, self.power()))
    }
}
