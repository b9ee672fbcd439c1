//! Which of a pixel's two estimates is taken: the one with the smaller error around it, as the twins tell.

use super::box_mean::box_mean;
use super::fits::Fits;
use super::own_error::{REACH, SMOOTH_FLOOR, gray, squared_error};
use super::{Color, Twins};

/// Reach of the square over which choices are averaged, pixels, so that none of their borders shows.
const BLEND: usize = 1;

/// Joins both estimates of each twin. Twins choose together, or the choice would depend on the noise of one.
pub(super) fn choose(twins: &Twins, fits: Fits) -> [Color; 2] {
    let gray = gray(twins, &fits.mean);
    // In the difference of two errors, the noise of the witness cancels.
    let more = |pixel: usize| {
        let [mean, linear] = [&fits.mean, &fits.linear].map(|filtered| squared_error(twins, filtered, pixel));
        (linear - mean) / (gray[pixel] * gray[pixel] + SMOOTH_FLOOR)
    };
    let more: Vec<f64> = (0..twins.pixel_count()).map(more).collect();
    let is_linear = |more: &f64| if *more < 0.0 { 1.0 } else { 0.0 };
    let linear: Vec<f64> = box_mean(&more, twins.width, REACH).iter().map(is_linear).collect();
    let shares = box_mean(&linear, twins.width, BLEND);
    let Fits { mut mean, linear } = fits;
    for (mean, linear) in mean.as_flattened_mut().iter_mut().zip(linear.as_flattened()) {
        for ((mean, linear), share) in mean.iter_mut().zip(linear).zip(&shares) {
            *mean += *share as f32 * (linear - *mean);
        }
    }
    mean
}
