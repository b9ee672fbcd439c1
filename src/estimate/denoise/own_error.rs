//! How wrong a filtered picture is, told by the twins alone.
//!
//! F_A and F_B are the filtered twins, A and B the twins, a and b their shares of the passes. B is as good a witness of F_A as the truth, but for its own variance:
//!
//! ```text
//! E[(F_A − B)²] = E[(F_A − truth)²] + Var B        E[(A − B)²] = Var A + Var B,  Var A = b·E[(A − B)²]
//! (a·F_A + b·F_B − t)² = a·(F_A − t)² + b·(F_B − t)² − a·b·(F_A − F_B)²
//! ```
//!
//! The first holds as far as F_A does not depend on B, which it does a little by its weights; so what is left of the noise alone, a·b·(F_A − F_B)², is what is told at least.

use super::box_mean::box_mean;
use super::{Color, Twins};

/// Reach of the square over which errors are averaged, pixels.
pub(super) const REACH: usize = 4;
/// The floor of squared radiance that errors are compared with, as in relMSE, for a picture whose mean is 1.
const FLOOR: f64 = 1e-3;
/// The same where errors are averaged: dark pixels beside bright ones must not outweigh them.
pub(super) const SMOOTH_FLOOR: f64 = 1e-2;

/// What the twins tell.
pub(super) struct OwnError {
    /// Standard error of every pixel.
    pub(super) per_pixel: Vec<f32>,
    /// Of the whole picture.
    pub(super) relmse: f64,
}

/// The error of what was made of twins whose mean is 1.
pub(super) fn measure(twins: &Twins, filtered: &[Color; 2]) -> OwnError {
    let gray = gray(twins, filtered);
    let brightness = |pixel: usize, floor: f64| gray[pixel] * gray[pixel] + floor;
    let all = 0..twins.pixel_count();
    let mean = |value: &dyn Fn(usize) -> f64| {
        all.clone().map(|pixel| value(pixel) / brightness(pixel, FLOOR)).sum::<f64>() / all.len() as f64
    };
    let noise = mean(&|pixel| left_noise(twins, filtered, pixel));
    let relmse = mean(&|pixel| squared_error(twins, filtered, pixel)).max(noise);
    let left: Vec<f64> =
        all.clone().map(|pixel| left_noise(twins, filtered, pixel) / brightness(pixel, SMOOTH_FLOOR)).collect();
    let left = box_mean(&left, twins.width, REACH);
    // A pixel's own squared error is far too noisy to show. What the filtered twins differ by says where errors are, and the sum says how large.
    let factor = if noise > 0.0 { relmse / noise } else { 1.0 };
    let standard_error = |pixel: usize| (factor * left[pixel] * brightness(pixel, SMOOTH_FLOOR)).sqrt() as f32;
    OwnError { per_pixel: all.clone().map(standard_error).collect(), relmse }
}

/// Mean of the channels of what both filtered twins make up.
pub(super) fn gray(twins: &Twins, filtered: &[Color; 2]) -> Vec<f64> {
    let joined = twins.join(filtered);
    let [red, green, blue] = &joined;
    let all = red.iter().zip(green).zip(blue);
    all.map(|((red, green), blue)| (f64::from(*red) + f64::from(*green) + f64::from(*blue)) / 3.0).collect()
}

/// Squared error of a pixel, mean of the channels; may be negative by chance.
pub(super) fn squared_error(twins: &Twins, filtered: &[Color; 2], pixel: usize) -> f64 {
    let [even, odd] = twins.shares(pixel).map(f64::from);
    let channel = |channel: usize| {
        let at = |colors: &[Color; 2], twin: usize| f64::from(colors[twin][channel][pixel]);
        let [raw_even, raw_odd] = [0, 1].map(|twin| at(&twins.radiance, twin));
        let [new_even, new_odd] = [0, 1].map(|twin| at(filtered, twin));
        let variances = (even * even + odd * odd) * (raw_even - raw_odd).powi(2);
        even * (new_even - raw_odd).powi(2) + odd * (new_odd - raw_even).powi(2)
            - variances
            - even * odd * (new_even - new_odd).powi(2)
    };
    (0..3).map(channel).sum::<f64>() / 3.0
}

/// The part of it that the filtered twins do not share.
fn left_noise(twins: &Twins, filtered: &[Color; 2], pixel: usize) -> f64 {
    let [even, odd] = twins.shares(pixel).map(f64::from);
    let difference = |channel: usize| f64::from(filtered[0][channel][pixel]) - f64::from(filtered[1][channel][pixel]);
    even * odd * (0..3).map(|channel| difference(channel).powi(2)).sum::<f64>() / 3.0
}
