//! `spot`: light from one point into a cone around the +z axis of `to_world`.
//!
//! | parameter | meaning | unit, range | default |
//! |---|---|---|---|
//! | `intensity` | radiant intensity on the axis | W·sr⁻¹ | 1 |
//! | `cutoff_angle` | half angle beyond which there is no light | degrees, 0 to 180 | 20 |
//! | `texture` | colors the light: the image fills the square round the cone, its u along x, its v along y | – | white |
//! | `beam_width` | half angle up to which intensity is full; it falls linearly with the angle from here | degrees, up to the cutoff | ¾ cutoff |

use std::f32::consts::PI;

use glam::DVec3;

use super::importance::{Aim, Lamp, LightImportance};
use super::point::read_intensity;
use super::{DirectSample, EmittedPhoton};
use crate::math::color::luminance;
use crate::math::{Frame, Rgb, Vec2, Vec3, warp};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::{ToWorld, to_single};
use crate::scene::texture::{Texture, TextureReader};

/// A spot light.
#[derive(Clone, Debug)]
pub struct Spot {
    position: Vec3,
    axis: Frame,
    intensity: Rgb,
    /// Radians.
    cutoff: f32,
    /// Radians.
    beam_width: f32,
    one_minus_cosine: f32,
    power: Rgb,
    image: Option<Image>,
}

/// What colors the light.
#[derive(Clone, Debug)]
struct Image {
    texture: Texture,
    /// Unit axes across the light's.
    across: [Vec3; 2],
    /// Of the cutoff angle.
    tangent: f32,
}

impl Image {
    /// The color of a direction whose cosine against the axis is `cosine`.
    #[inline]
    fn color(&self, direction: Vec3, cosine: f32) -> Rgb {
        let place = Vec2::from_array(self.across.map(|axis| axis.dot(direction))) / (cosine * self.tangent);
        self.texture.color(&(place * 0.5 + 0.5).into())
    }
}

/// Directions along each axis that tell the power of a spot with an image.
const PROBES: usize = 64;

impl Spot {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let to_world = ToWorld::read(fields)?;
        let texture = textures.color(fields, "texture")?;
        let intensity = read_intensity(fields)?;
        let cutoff = fields.float("cutoff_angle")?.unwrap_or(20.0);
        if !(cutoff > 0.0 && cutoff <= 180.0) {
            let problem = format!("\"cutoff_angle\" is {} degrees", shown_number(cutoff));
            return Err(fields.error("cutoff_angle", problem, "give an angle above 0 and up to 180 degrees"));
        }
        let beam_width = fields.float("beam_width")?.unwrap_or(0.75 * cutoff);
        if !(0.0..=cutoff).contains(&beam_width) {
            let problem = format!("\"beam_width\" is {} degrees", shown_number(beam_width));
            return Err(fields.error(
                "beam_width",
                problem,
                format!("give an angle from 0 to the cutoff, {}", shown_number(cutoff)),
            ));
        }
        let (cutoff, beam_width) = (cutoff.to_radians(), beam_width.to_radians());
        let across = [DVec3::X, DVec3::Y].map(|axis| to_world.vector(axis).normalize().as_vec3());
        let image = texture.map(|texture| Image { texture, across, tangent: libm::tan(cutoff) as f32 });
        let mut spot = Self {
            position: to_single(to_world.point(DVec3::ZERO), fields)?,
            axis: Frame::from_normal(to_world.vector(DVec3::Z).normalize().as_vec3()),
            intensity,
            cutoff: cutoff as f32,
            beam_width: beam_width as f32,
            one_minus_cosine: (2.0 * libm::sin(0.5 * cutoff) * libm::sin(0.5 * cutoff)) as f32,
            power: intensity * solid_angle(cutoff, beam_width) as f32,
            image,
        };
        if spot.image.is_some() {
            spot.power = spot.probed_power();
        }
        Ok(spot)
    }

    /// The mean flux of directions all over the cone.
    fn probed_power(&self) -> Rgb {
        let middle = |index: usize| (index as f32 + 0.5) / PROBES as f32;
        let probes = (0..PROBES * PROBES).map(|index| {
            let local = warp::cone(self.one_minus_cosine, [middle(index % PROBES), middle(index / PROBES)]);
            self.intensity_at(self.axis.to_world(local), local.z)
        });
        probes.sum::<Rgb>() * (2.0 * PI * self.one_minus_cosine / (PROBES * PROBES) as f32)
    }

    /// Intensity in a direction whose cosine against the axis is `cosine`.
    #[inline]
    fn intensity_at(&self, direction: Vec3, cosine: f32) -> Rgb {
        let intensity = self.falloff(cosine);
        match &self.image {
            Some(image) if intensity != Rgb::ZERO => intensity * image.color(direction, cosine),
            _ => intensity,
        }
    }

    /// Intensity without an image.
    #[inline]
    fn falloff(&self, cosine: f32) -> Rgb {
        let angle = libm::acosf(cosine.clamp(-1.0, 1.0));
        if angle >= self.cutoff {
            return Rgb::ZERO;
        }
        if angle <= self.beam_width {
            return self.intensity;
        }
        self.intensity * ((self.cutoff - angle) / (self.cutoff - self.beam_width))
    }

    /// The integral of the intensity over the cone.
    pub fn power(&self) -> Rgb {
        self.power
    }

    /// Full intensity in the whole cone, with room for rounding at its rim.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        const ROOM: f32 = 1e-4;
        let aim = Aim::Cone(self.axis.normal, 1.0 - self.one_minus_cosine - ROOM);
        let brightest = self.image.as_ref().map_or(1.0, |image| luminance(image.texture.range()[1]));
        let intensity = luminance(self.intensity) * brightest;
        LightImportance::Near(Lamp { center: self.position, radius: 0.0, intensity, aim })
    }

    /// I(angle)/d².
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        let to_light = self.position - point;
        let distance = to_light.length();
        let direction = to_light / distance;
        let intensity = self.intensity_at(-direction, -direction.dot(self.axis.normal));
        (distance > 0.0 && intensity != Rgb::ZERO).then(|| DirectSample {
            direction,
            distance,
            weighted_radiance: intensity / (distance * distance),
            pdf_solid_angle: 0.0,
            emission_ratio: self.cone_pdf() / (distance * distance),
        })
    }

    /// A direction uniform in the cone.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, _place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let local = warp::cone(self.one_minus_cosine, direction);
        let direction = self.axis.to_world(local);
        let flux = self.intensity_at(direction, local.z) * (2.0 * PI * self.one_minus_cosine);
        Some(EmittedPhoton::from_point(self.position, direction, flux, self.cone_pdf()))
    }

    /// The density of directions in the cone by solid angle.
    fn cone_pdf(&self) -> f32 {
        1.0 / (2.0 * PI * self.one_minus_cosine)
    }
}

/// ∫ falloff dω in closed form, sr: a full cone up to `beam` and a linear ramp in the angle from there to `cutoff`, radians.
fn solid_angle(cutoff: f64, beam: f64) -> f64 {
    let tau = std::f64::consts::TAU;
    if beam >= cutoff {
        return tau * (1.0 - libm::cos(cutoff));
    }
    // ∫ sin a da from 0 to b is 1 - cos b; ∫ (c - a)/(c - b) sin a da from b to c is cos b - (sin c - sin b)/(c - b).
    tau * (1.0 - (libm::sin(cutoff) - libm::sin(beam)) / (cutoff - beam))
}
