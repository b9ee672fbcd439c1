//! `projector`: light from one point that throws an image along the +z axis of `to_world`, as a camera with the same
//! parameters would see it.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `irradiance` | π times this is what arrives at unit depth on a plane across the axis, also a texture | W·m⁻² | 1 |
//! | `scale` | factor on it | – | 1 |
//! | `fov`, `fov_axis`, `focal_length` | how wide the image is thrown: see [`crate::scene::camera`] | – | `50mm` |
//!
//! The intensity at an angle θ from the axis is π·E/cos³θ, so that an even image looks even on the plane apart from the cosine
//! there. Textures but bitmaps are thrown as squares.

use std::f32::consts::PI;

use glam::DVec3;

use super::importance::{Aim, Lamp, LightImportance};
use super::{DirectSample, EmittedPhoton};
use crate::math::color::luminance;
use crate::math::{Rgb, Vec2, Vec3};
use crate::scene::camera;
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::{ToWorld, to_single};
use crate::scene::texture::{Texture, TextureReader};

/// A projector.
#[derive(Clone, Debug)]
pub struct Projector {
    position: Vec3,
    /// Unit axes: left, up, forward.
    axes: [Vec3; 3],
    /// Tangents of the half angles along x and y.
    half_extent: Vec2,
    irradiance: Texture,
    scale: f32,
}

impl Projector {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let to_world = ToWorld::read(fields)?;
        to_world.check_similarity(fields)?;
        let irradiance = textures.color(fields, "irradiance")?.unwrap_or(Texture::grey(1.0));
        let scale = fields.float("scale")?.unwrap_or(1.0);
        if scale < 0.0 {
            return Err(fields.error(
                "scale",
                format!("\"scale\" is {}", shown_number(scale)),
                "give a number of at least 0",
            ));
        }
        let [width, height] = irradiance.size();
        let axis = |axis: DVec3| to_world.vector(axis).normalize().as_vec3();
        Ok(Self {
            position: to_single(to_world.point(DVec3::ZERO), fields)?,
            axes: [axis(DVec3::X), axis(DVec3::Y), axis(DVec3::Z)],
            half_extent: camera::half_extent(fields, width, height)?,
            irradiance,
            scale: (scale * to_world.scale()) as f32,
        })
    }

    /// Area of the image on a plane at unit depth, m².
    fn area(&self) -> f32 {
        4.0 * self.half_extent.x * self.half_extent.y
    }

    /// What a direction carries, W·sr⁻¹, and its cosine against the axis; `None` outside of the image.
    #[inline]
    fn intensity(&self, direction: Vec3) -> Option<(Rgb, f32)> {
        let [x, y, cosine] = self.axes.map(|axis| axis.dot(direction));
        if cosine <= 0.0 {
            return None;
        }
        let uv = Vec2::splat(0.5) - Vec2::new(x, y) / (self.half_extent * (2.0 * cosine));
        if !(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()) {
            return None;
        }
        let intensity = self.irradiance.color(&uv.into()) * (PI * self.scale / (cosine * cosine * cosine));
        Some((intensity, cosine))
    }

    /// The density of [`Projector::emit`] by solid angle at a cosine against the axis.
    fn pdf(&self, cosine: f32) -> f32 {
        1.0 / (self.area() * cosine * cosine * cosine)
    }

    /// π times the image's mean times its area at unit depth.
    pub fn power(&self) -> Rgb {
        self.irradiance.mean() * (PI * self.scale * self.area())
    }

    /// Its brightest direction's intensity in the whole cone round the image, with room for rounding at its rim.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        const ROOM: f32 = 1e-4;
        let cosine = 1.0 / (1.0 + self.half_extent.length_squared()).sqrt();
        let brightest = luminance(self.irradiance.range()[1]) * PI * self.scale / (cosine * cosine * cosine);
        let aim = Aim::Cone(self.axes[2], cosine - ROOM);
        LightImportance::Near(Lamp { center: self.position, radius: 0.0, intensity: brightest, aim })
    }

    /// I(direction)/d².
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, point: Vec3, _u: [f32; 2]) -> Option<DirectSample> {
        let to_light = self.position - point;
        let distance = to_light.length();
        let direction = to_light / distance;
        let (intensity, cosine) = self.intensity(-direction)?;
        (distance > 0.0 && intensity != Rgb::ZERO).then(|| DirectSample {
            direction,
            distance,
            weighted_radiance: intensity / (distance * distance),
            pdf_solid_angle: 0.0,
            emission_ratio: self.pdf(cosine) / (distance * distance),
        })
    }

    /// A direction through a place uniform over the image.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, _place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let [left, up, forward] = self.axes;
        let place = (Vec2::splat(1.0) - Vec2::from_array(direction) * 2.0) * self.half_extent;
        let direction = (left * place.x + up * place.y + forward).normalize();
        let (intensity, cosine) = self.intensity(direction)?;
        let pdf = self.pdf(cosine);
        Some(EmittedPhoton::from_point(self.position, direction, intensity / pdf, pdf))
    }
}
