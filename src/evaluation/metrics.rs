//! Error metrics of a picture against a reference. All sums run in f64, in row order.

use serde::{Deserialize, Serialize};

use super::flip::mean_flip;
use super::shown::{Shown, exposure_factor};
use super::similarity::structural_similarity;
use crate::estimate::Picture;

/// Side of the square blocks in which local bias is looked for, pixels.
const BLOCK_SIDE: usize = 8;
/// Share of pixels that the trimmed metric keeps: the worst 0.1 % are left out.
const KEPT_SHARE: f64 = 0.999;

/// How a picture differs from its reference. Y is the channel mean of a reference pixel, m the reference's mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Root mean square error over pixels and channels, W·sr⁻¹·m⁻².
    pub rmse: f64,
    /// `rmse / m`.
    pub rel_rmse: f64,
    /// Mean of `error² / (Y² + 10⁻³·m²)`.
    pub relmse: f64,
    /// The same without the worst 0.1 % of pixels.
    pub relmse_trimmed: f64,
    /// Relative error of the mean of the whole picture.
    pub bias: f64,
    /// Relative error of the mean of red, green and blue.
    pub bias_rgb: [f64; 3],
    /// Largest absolute relative bias of any 8 × 8 block: `|mean − block reference| / (block reference + 0.01·m)`.
    pub block_bias_max: f64,
    /// SSIM [Wang et al. 2004] of the pictures as shown, the reference's mean luminance at 0.18: 1 for equal ones. Empty for pictures less
    /// than 11 pixels wide or high.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ssim: Option<f64>,
    /// Mean FLIP [Andersson et al. 2020] of the pictures as shown: 0 for equal ones, at most 1.
    pub flip: f64,
    /// The reference's own noise: what it adds to the errors above. Empty when it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_noise: Option<ReferenceNoise>,
}

/// What the reference's own standard error adds to the metrics; do not expect to get below it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceNoise {
    /// Its part of `rmse`.
    pub rmse: f64,
    /// Its part of `relmse`.
    pub relmse: f64,
    /// `rmse²` less its part: what is left for the picture, below 0 by chance when there is nothing left.
    pub mse_left: f64,
    /// `relmse` less its part.
    pub relmse_left: f64,
}

/// Pictures that cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The sizes differ.
    #[error("the {what} has {found} pixels where the reference has {expected}; compare pictures of the same size")]
    SizeMismatch {
        /// Which picture.
        what: &'static str,
        /// Width × height of the reference.
        expected: String,
        /// Width × height of the other one.
        found: String,
    },
    /// A pixel is infinite or not a number: every mean would be too.
    #[error("the {what} has {value} at column {column}, row {row}; mend that pixel in both pictures, say by 0")]
    NotFinite {
        /// Which picture.
        what: &'static str,
        /// Its column, from 0.
        column: usize,
        /// Its row, from 0.
        row: usize,
        /// Red, green and blue.
        value: String,
    },
    /// There is nothing to compare.
    #[error("the reference has no pixels; give a picture that has some")]
    Empty,
}

/// Compares `image` with `reference`. `standard_error` holds the reference's standard error per pixel (of the channel
/// mean; the mean of its channels is used).
pub fn compare(
    image: &Picture,
    reference: &Picture,
    standard_error: Option<&Picture>,
) -> Result<Metrics, CompareError> {
    check_size("image", image, reference)?;
    check_finite("image", image)?;
    check_finite("reference", reference)?;
    let mean = mean_of(&reference.radiance);
    let denominators: Vec<f64> =
        reference.radiance.iter().map(|pixel| channel_mean(pixel).powi(2) + 1e-3 * mean * mean).collect();
    let squares: Vec<f64> = image.radiance.iter().zip(&reference.radiance).map(squared_error).collect();
    let mut relative: Vec<f64> = squares.iter().zip(&denominators).map(|(square, below)| square / below).collect();
    let rmse = average(&squares).sqrt();
    let relmse = average(&relative);
    relative.sort_by(f64::total_cmp);
    let kept = (KEPT_SHARE * relative.len() as f64) as usize;
    let reference_noise = match standard_error {
        None => None,
        Some(noise) => {
            check_size("standard error", noise, reference)?;
            check_finite("standard error", noise)?;
            Some(noise_part(noise, &denominators, rmse, relmse))
        }
    };
    let factor = exposure_factor(reference);
    let [image_shown, reference_shown] = [image, reference].map(|picture| Shown::new(picture, factor));
    Ok(Metrics {
        rmse,
        rel_rmse: rmse / mean,
        relmse,
        relmse_trimmed: average(&relative[..kept]),
        bias: (mean_of(&image.radiance) - mean) / mean,
        bias_rgb: [0, 1, 2].map(|channel| channel_bias(image, reference, channel)),
        block_bias_max: largest_block_bias(image, reference, mean),
        ssim: structural_similarity(&image_shown, &reference_shown),
        flip: mean_flip(&image_shown, &reference_shown),
        reference_noise,
    })
}

fn check_size(what: &'static str, other: &Picture, reference: &Picture) -> Result<(), CompareError> {
    if reference.radiance.is_empty() {
        return Err(CompareError::Empty);
    }
    if (other.width, other.height) == (reference.width, reference.height) {
        return Ok(());
    }
    let size = |picture: &Picture| format!("{} × {}", picture.width, picture.height);
    Err(CompareError::SizeMismatch { what, expected: size(reference), found: size(other) })
}

fn check_finite(what: &'static str, picture: &Picture) -> Result<(), CompareError> {
    let infinite = |pixel: &[f32; 3]| !pixel.iter().all(|channel| channel.is_finite());
    let Some(index) = picture.radiance.iter().position(infinite) else { return Ok(()) };
    let (column, row) = (index % picture.width as usize, index / picture.width as usize);
    let value = picture.radiance[index].map(|channel| channel.to_string()).join(", ");
    Err(CompareError::NotFinite { what, column, row, value })
}

fn noise_part(standard_error: &Picture, denominators: &[f64], rmse: f64, relmse: f64) -> ReferenceNoise {
    let squares: Vec<f64> = standard_error.radiance.iter().map(|pixel| channel_mean(pixel).powi(2)).collect();
    let relative: Vec<f64> = squares.iter().zip(denominators).map(|(square, below)| square / below).collect();
    let (square, relative) = (average(&squares), average(&relative));
    ReferenceNoise {
        rmse: square.sqrt(),
        relmse: relative,
        mse_left: rmse * rmse - square,
        relmse_left: relmse - relative,
    }
}

/// Mean over channels of the squared error of a pixel.
fn squared_error((image, reference): (&[f32; 3], &[f32; 3])) -> f64 {
    let squares = image.iter().zip(reference).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    squares.sum::<f64>() / 3.0
}

fn channel_bias(image: &Picture, reference: &Picture, channel: usize) -> f64 {
    let mean = |picture: &Picture| {
        let values = picture.radiance.iter().map(|pixel| f64::from(pixel[channel]));
        values.sum::<f64>() / picture.radiance.len() as f64
    };
    // A channel that is black in the reference would divide by zero.
    mean(image) / mean(reference).max(1e-12) - 1.0
}

fn largest_block_bias(image: &Picture, reference: &Picture, mean: f64) -> f64 {
    let (width, height) = (reference.width as usize, reference.height as usize);
    let mut largest = 0.0f64;
    for top in (0..height).step_by(BLOCK_SIDE) {
        for left in (0..width).step_by(BLOCK_SIDE) {
            let block = |picture: &Picture| block_mean(picture, left, top);
            let expected = block(reference);
            largest = largest.max((block(image) - expected).abs() / (expected + 1e-2 * mean));
        }
    }
    largest
}

/// Mean of the block whose top left pixel is `left`, `top`; blocks at the right and lower edge may be smaller.
fn block_mean(picture: &Picture, left: usize, top: usize) -> f64 {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let columns = left..(left + BLOCK_SIDE).min(width);
    let rows = top..(top + BLOCK_SIDE).min(height);
    let count = columns.len() * rows.len();
    let pixels = rows.flat_map(|row| &picture.radiance[row * width + columns.start..row * width + columns.end]);
    pixels.map(channel_mean).sum::<f64>() / count as f64
}

fn mean_of(pixels: &[[f32; 3]]) -> f64 {
    pixels.iter().map(channel_mean).sum::<f64>() / pixels.len() as f64
}

fn channel_mean(pixel: &[f32; 3]) -> f64 {
    pixel.iter().map(|channel| f64::from(*channel)).sum::<f64>() / 3.0
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
