//! Pictures as eyes get them: exposed and in sRGB. What SSIM and FLIP look at.

use super::plane::Plane;
use crate::estimate::Picture;
use crate::math::Rgb;
use crate::math::color::luminance;

/// Where the mean luminance of a reference is put: the grey of a photographer's card.
const MIDDLE_GREY: f64 = 0.18;

/// A picture between 0 and 1, encoded with the sRGB transfer function (IEC 61966-2-1).
pub(super) struct Shown {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Red, green and blue per pixel, row-major.
    pub(super) pixels: Vec<[f64; 3]>,
}

/// The factor that puts the mean luminance of `reference` at middle grey; 1 for a black one.
pub fn exposure_factor(reference: &Picture) -> f64 {
    let sum: f64 = reference.radiance.iter().map(|pixel| f64::from(luminance(Rgb::from_array(*pixel)))).sum();
    let mean = sum / reference.radiance.len() as f64;
    if mean > 0.0 { MIDDLE_GREY / mean } else { 1.0 }
}

impl Shown {
    /// The picture multiplied by `factor`. A screen has no more than white and no less than black: values end there.
    pub(super) fn new(picture: &Picture, factor: f64) -> Self {
        let encode = |radiance: f32| encoded((f64::from(radiance) * factor).clamp(0.0, 1.0));
        let pixels = picture.radiance.iter().map(|pixel| pixel.map(encode)).collect();
        Self { width: picture.width as usize, height: picture.height as usize, pixels }
    }

    /// One value per pixel.
    pub(super) fn plane(&self, value: impl Fn(&[f64; 3]) -> f64) -> Plane {
        Plane { width: self.width, height: self.height, values: self.pixels.iter().map(value).collect() }
    }
}

fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of the sRGB transfer function.
pub(super) fn decoded(value: f64) -> f64 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
