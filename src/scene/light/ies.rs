//! `ies`: light from one point with the measured intensities of a luminaire, an IES file (ANSI/IES LM-63).
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `filename` | the IES file, relative to the scene | | required |
//! | `intensity` | factor on all of its intensities, for example the lamp's color | – | 1 |
//! | `to_world` | where it is and how it is turned; a similarity, whose scale changes nothing | m | identity |
//!
//! The direction below the luminaire (vertical angle 0) is +z, as the axis of a `spot`; horizontal angle 0 is +x and 90 is
//! -y, which is an upright luminaire turned by half a turn about x. Candelas are divided by 179 lm·W⁻¹, the efficacy of
//! equal-energy white light that Radiance uses, so that an area light of L·179 cd·m⁻² and this agree: I = cd/179 W·sr⁻¹.
//!
//! Intensity is linear in both angles between those measured [LM-63-02, 5], and 0 outside of them. Photons leave with a
//! density by (cos θ, φ) that is constant in cells of at most 2.5°, and proportional to the intensity's integral over each. The
//! size of the luminous opening is not used: light leaves from a point.

mod lm63;
mod profile;

use std::sync::Arc;

use glam::DVec3;

use super::importance::{Aim, Lamp, LightImportance};
use super::point::read_intensity;
use super::{DirectSample, EmittedPhoton};
use crate::math::color::luminance;
use crate::math::{Rgb, Vec3, warp};
use crate::scene::bundle::Bundle;
use crate::scene::error::{Location, SceneError};
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::{ToWorld, to_single};
use profile::Profile;

/// Lumens per watt.
const EFFICACY: f32 = 179.0;

/// A point light with a measured distribution.
#[derive(Clone, Debug)]
pub struct Ies {
    position: Vec3,
    /// Unit vectors of its own x, y and z.
    axes: [Vec3; 3],
    profile: Arc<Profile>,
    /// W·sr⁻¹ for one candela.
    scale: Rgb,
}

impl Ies {
    /// Reads the parameters and the file.
    pub fn read(fields: &mut Fields<'_>, bundle: &Bundle) -> Result<Self, SceneError> {
        let Some(name) = fields.string("filename")? else {
            let remedy = "name the IES file, relative to the scene";
            return Err(SceneError::new(fields.location(), "emitter \"ies\" has no \"filename\"", remedy));
        };
        let bytes = bundle.read(name, fields.location_of("filename"))?;
        let location = Location { file: name.to_owned(), ..Location::default() };
        let photometry = lm63::read(&bytes, &location)?;
        let dark = || SceneError::new(&location, "the luminaire emits nothing", "give candela values above 0");
        let profile = Profile::new(&photometry).ok_or_else(dark)?;
        let to_world = ToWorld::read(fields)?;
        to_world.check_similarity(fields)?;
        Ok(Self {
            position: to_single(to_world.point(DVec3::ZERO), fields)?,
            axes: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis).normalize().as_vec3()),
            profile: Arc::new(profile),
            scale: read_intensity(fields)? / EFFICACY,
        })
    }

    /// The integral of the intensity over all directions.
    pub fn power(&self) -> Rgb {
        self.scale * self.profile.flux()
    }

    /// Its mean intensity into every direction.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        let intensity = luminance(self.power()) * warp::SPHERE_PDF;
        LightImportance::Near(Lamp { center: self.position, radius: 0.0, intensity, aim: Aim::Everywhere })
    }

    /// I(direction)/d².
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        let to_light = self.position - point;
        let distance = to_light.length();
        let direction = to_light / distance;
        let [x, y, z] = self.axes.map(|axis| -direction.dot(axis));
        let local = Vec3::new(x, -y, z);
        let candelas = self.profile.candelas(local);
        (distance > 0.0 && candelas > 0.0).then(|| DirectSample {
            direction,
            distance,
            weighted_radiance: self.scale * (candelas / (distance * distance)),
            pdf_solid_angle: 0.0,
            emission_ratio: self.profile.pdf(local) / (distance * distance),
        })
    }

    /// A direction by the profile's density.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let (local, weighted, pdf) = self.profile.sample(place[0], direction);
        let [x, y, z] = self.axes;
        let direction = (x * local.x - y * local.y + z * local.z).normalize();
        let flux = self.scale * weighted;
        Some(EmittedPhoton::from_point(self.position, direction, flux, pdf))
    }
}
