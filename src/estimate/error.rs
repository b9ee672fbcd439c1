//! How far a picture is from the truth, told by the job's own passes, without a reference.
//!
//! **Noise.** The even and the odd passes are two independent estimates `A` and `B` of the same picture. With shares `a` and `b`
//! of the passes, `E[a·b·(A − B)²]` is the variance of `a·A + b·B`, whatever the distribution and although passes are
//! spread evenly among each other.
//!
//! **Bias.** A density estimate's bias grows with the disc's area where the density is smooth: `L(R²) ≈ L + c·R²`. Inside half the area it
//! is half as much, so `2·(L(R²) − L(R²/2))` estimates it, with noise. The product of the two twins' estimates has no noise in
//! the mean: `E[D_A·D_B] = bias²`. At edges the bias falls slower than the area, and what is told is about right only for
//! all pixels along an edge together (0.079 for 0.076 in `spot-mirror`).
//!
//! Errors are relative as in `relMSE = mean((L − truth)²/(Y² + 10⁻³·m²))`, Y the truth's mean of channels in the pixel and m that of
//! the picture. What stands for Y here is the mean of the pixels around: a pixel's own value rises and falls with its own error, so that
//! errors would look small where they are large. It counts itself only where it is known well.
//!
//! **Light where there is none.** Where a disc reaches from the dark into bright light, the picture is no measure of Y: it is bright because it is wrong.
//! There Y is the picture less its bias, in so far as both twins tell it. Noise, too, makes both say so by chance, and then error and Y are wrong
//! together. But noise says the opposite as often: what is found with the sign of one twin's bias turned around is what chance brings, and is
//! subtracted. The rest counts when it is more than chance.

use super::declaration::{FLUX, INNER_FLUX, PlaneDeclaration, PlaneRule};
use super::merging::{Estimate, RegionProgress};
use super::reading::Scale;
use super::shard::Twin;

/// The floor of squared radiance that errors are compared with, as a share of the picture's squared mean.
const FLOOR: f64 = 1e-3;
/// Pixels on each side of one that may be averaged for Y.
const REACHES: [usize; 5] = [0, 1, 2, 3, 5];
/// Y is the mean of the smallest neighbourhood whose mean has at most this relative variance; the pixel itself is left out.
const KNOWN: f64 = 0.1;
/// Y is the pixel's own value where that has at most this relative variance.
const KNOWN_ALONE: f64 = 0.01;
/// Errors in blocks of this many pixels on a side count as independent.
const BLOCK: usize = 16;
/// How often a bound holds.
pub(crate) const CONFIDENCE: f64 = 0.95;
/// One-sided 95 % of a normal distribution, in standard deviations.
const DEVIATIONS: f64 = 1.645;
/// Y is at least this share of the picture, however large the bias.
const LEAST_SHARE: f64 = 0.25;
/// From so many standard deviations on, what the bias hides is more than chance.
const CERTAIN: f64 = 2.0;
/// Averaging makes the error of dark pixels beside bright ones look smaller: by up to this factor for nearly all pictures of our
/// references (docs/measured/ERROR-BOUNDS.md).
const MARGIN: f64 = 1.15;

/// A picture's error as its own passes tell it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorEstimate {
    /// relMSE by noise.
    pub noise: f64,
    /// The part of it that camera paths bring by themselves. It falls with the passes; noise of density estimates falls slower.
    pub sampled_noise: f64,
    /// relMSE by bias; 0 without density estimates.
    pub bias: f64,
    /// What relMSE is below with 95 % confidence.
    pub bound: f64,
}

/// What a pixel's twins tell.
#[derive(Clone, Copy, Default)]
struct PixelError {
    /// Mean of the channels of the radiance, W·sr⁻¹·m⁻².
    gray: f64,
    /// Variance, mean of the channels.
    variance: f64,
    /// The same of what camera paths bring by themselves.
    sampled_variance: f64,
    /// What each twin tells of the bias of `gray`.
    bias: [f64; 2],
    /// Mean of the squared channels over the square of their mean.
    colored: f64,
}

impl PixelError {
    /// From what the twins, which have these shares of the passes, say of radiance, of its sampled part and of the bias.
    fn new(shares: [f64; 2], radiance: [[f64; 3]; 2], sampled: [[f64; 3]; 2], bias: [f64; 2]) -> Self {
        let mean = [0, 1, 2].map(|c| shares[0] * radiance[0][c] + shares[1] * radiance[1][c]);
        let gray = mean.iter().sum::<f64>() / 3.0;
        let squares = mean.iter().map(|value| value * value).sum::<f64>() / 3.0;
        let colored = if gray > 0.0 { squares / (gray * gray) } else { 1.0 };
        let variance =
            |[a, b]: [[f64; 3]; 2]| shares[0] * shares[1] * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() / 3.0;
        Self { gray, variance: variance(radiance), sampled_variance: variance(sampled), bias, colored }
    }

    /// Squared bias, mean of the channels; may be negative.
    fn squared_bias(&self) -> f64 {
        self.bias[0] * self.bias[1] * self.colored
    }

    /// What is added to the squared relative bias when Y is without the bias, less what chance brings.
    fn hidden(&self, floor: f64) -> f64 {
        let inverse_square = |gray: f64| 1.0 / (gray * gray + floor);
        let told = |a: f64, b: f64| {
            let less = (self.gray - a.min(b)).max(LEAST_SHARE * self.gray);
            if a > 0.0 && b > 0.0 { a * b * (inverse_square(less) - inverse_square(self.gray)) } else { 0.0 }
        };
        let [a, b] = self.bias;
        (told(a, b) - 0.5 * (told(a, -b) + told(-a, b))) * self.colored
    }
}

impl Estimate {
    /// The error of [`Estimate::picture`]; `None` before each twin has a pass in every region.
    pub fn error(&self) -> Option<ErrorEstimate> {
        let pixels = self.pixel_errors()?;
        let count = pixels.len() as f64;
        let mean = pixels.iter().map(|pixel| pixel.gray).sum::<f64>() / count;
        if mean <= 0.0 {
            return None;
        }
        let (width, height) = (self.width as usize, self.height as usize);
        let floor = FLOOR * mean * mean;
        let smooth = Smooth::new(&pixels, width, height, floor);
        let (mut blocks, mut hidden) = (Blocks::new(width, height), Blocks::new(width, height));
        let (mut noise, mut sampled_noise, mut bias) = (0.0, 0.0, 0.0);
        for (index, pixel) in pixels.iter().enumerate() {
            let (row, column) = (index / width, index % width);
            let scale = smooth.inverse_square(row, column);
            let (by_noise, by_bias) = (pixel.variance * scale, pixel.squared_bias() * scale);
            (noise, bias) = (noise + by_noise / count, bias + by_bias / count);
            sampled_noise += pixel.sampled_variance * scale / count;
            blocks.add(row, column, by_noise + by_bias);
            hidden.add(row, column, pixel.hidden(floor));
        }
        if hidden.mean() > CERTAIN * hidden.deviation() {
            bias += hidden.mean();
            blocks.join(&hidden);
        }
        let bias = bias.max(0.0);
        let bound = MARGIN * (noise + bias) + DEVIATIONS * blocks.deviation();
        Some(ErrorEstimate { noise, sampled_noise, bias, bound })
    }

    /// The standard error of every pixel of [`Estimate::picture`], W·sr⁻¹·m⁻²: by noise alone, root mean square of the channels and of the
    /// 3 × 3 pixels around, since two twins tell little of a single one. `None` before each twin has a pass in every region.
    pub fn standard_error(&self) -> Option<Vec<f32>> {
        let pixels = self.pixel_errors()?;
        let (width, height) = (self.width as usize, self.height as usize);
        let around = |place: usize, size: usize| place.saturating_sub(1)..(place + 2).min(size);
        let at = |index: usize| {
            let (rows, columns) = (around(index / width, height), around(index % width, width));
            let count = rows.len() * columns.len();
            let row_sum =
                |row: usize| pixels[row * width..][columns.clone()].iter().map(|pixel| pixel.variance).sum::<f64>();
            (rows.map(row_sum).sum::<f64>() / count as f64).sqrt() as f32
        };
        Some((0..pixels.len()).map(at).collect())
    }

    fn pixel_errors(&self) -> Option<Vec<PixelError>> {
        let mut pixels = Vec::with_capacity(self.pixel_count());
        for progress in &self.progress {
            self.region_errors(progress, &mut pixels)?;
        }
        Some(pixels)
    }

    fn region_errors(&self, progress: &RegionProgress, pixels: &mut Vec<PixelError>) -> Option<()> {
        let scale = |twin| progress.scale(&self.declaration, &[twin]);
        let scales = [scale(Twin::Even)?, scale(Twin::Odd)?];
        let shares = progress.passes.map(|passes| f64::from(passes) / f64::from(progress.all_passes()));
        for row in self.rows_of(progress) {
            let of_twin = |twin: Twin, takes: fn(&PlaneDeclaration) -> bool| {
                self.radiance_of(row.clone(), &[twin], &scales[twin as usize], takes)
            };
            let radiance = TWINS.map(|twin| of_twin(twin, |_| true));
            let sampled = TWINS.map(|twin| of_twin(twin, |plane| plane.rule != PlaneRule::FluxOverRadius));
            for (column, pixel) in row.clone().enumerate() {
                let at = |twins: &[[Vec<f64>; 3]; 2]| {
                    twins.each_ref().map(|channels| channels.each_ref().map(|channel| channel[column]))
                };
                let bias = TWINS.map(|twin| self.bias_of(pixel, twin, &scales[twin as usize]));
                pixels.push(PixelError::new(shares, at(&radiance), at(&sampled), bias));
            }
        }
        Some(())
    }

    /// What a twin tells of the bias of a pixel's mean radiance; 0 without density estimates.
    fn bias_of(&self, pixel: usize, twin: Twin, scale: &Scale) -> f64 {
        let Some(inner) = self.plane_sums(INNER_FLUX, twin).next() else { return 0.0 };
        let channels = |outer: &[f64]| [0, 1, 2].map(|channel| outer[channel * self.pixel_count() + pixel]);
        let outer = self.plane_sums(FLUX, twin).map(|outer| channels(outer).iter().sum::<f64>() / 3.0).sum::<f64>();
        2.0 * (outer - 2.0 * inner[pixel]) * scale.per_photon
    }
}

const TWINS: [Twin; 2] = [Twin::Even, Twin::Odd];

/// Means over the neighbourhoods of pixels.
struct Smooth {
    width: usize,
    height: usize,
    /// Sums of gray and of variance over all pixels above and to the left, with a row and a column of zeros first.
    sums: Vec<[f64; 2]>,
    /// Added to squared radiance.
    floor: f64,
}

impl Smooth {
    fn new(pixels: &[PixelError], width: usize, height: usize, floor: f64) -> Self {
        let stride = width + 1;
        let mut sums = vec![[0.0; 2]; stride * (height + 1)];
        for row in 0..height {
            let mut left = [0.0; 2];
            for column in 0..width {
                let pixel = &pixels[row * width + column];
                left = [left[0] + pixel.gray, left[1] + pixel.variance];
                let above = sums[row * stride + column + 1];
                sums[(row + 1) * stride + column + 1] = [above[0] + left[0], above[1] + left[1]];
            }
        }
        Self { width, height, sums, floor }
    }

    /// 1/(Y² + floor) of a pixel.
    fn inverse_square(&self, row: usize, column: usize) -> f64 {
        let own = self.mean(row, column, 0)[0];
        let mut inverse = 0.0;
        for reach in REACHES {
            // A single pixel's variance is too noisy to trust: that of its neighbours stands for it.
            let [around, variance, pixels] = self.mean(row, column, reach.max(1));
            let (gray, pixels, known) = match reach {
                0 => (own, 1.0, KNOWN_ALONE),
                _ if pixels < 2.0 => break,
                _ => ((around * pixels - own) / (pixels - 1.0), pixels - 1.0, KNOWN),
            };
            inverse = 1.0 / (gray * gray + self.floor);
            if variance / pixels * inverse < known {
                break;
            }
        }
        inverse
    }

    /// Mean gray and variance of the pixels within `reach`, and their number.
    fn mean(&self, row: usize, column: usize, reach: usize) -> [f64; 3] {
        let [top, left] = [row, column].map(|place| place.saturating_sub(reach));
        let (bottom, right) = ((row + reach + 1).min(self.height), (column + reach + 1).min(self.width));
        let at = |row: usize, column: usize| self.sums[row * (self.width + 1) + column];
        let [above_left, above, before, whole] = [at(top, left), at(top, right), at(bottom, left), at(bottom, right)];
        let pixels = ((bottom - top) * (right - left)) as f64;
        let mean = |part: usize| (whole[part] - above[part] - before[part] + above_left[part]) / pixels;
        [mean(0), mean(1), pixels]
    }
}

/// A value of every pixel, summed over blocks that count as independent.
struct Blocks {
    width: usize,
    /// Sum and number of pixels of each block.
    sums: Vec<(f64, f64)>,
}

impl Blocks {
    fn new(width: usize, height: usize) -> Self {
        Self { width: width.div_ceil(BLOCK), sums: vec![(0.0, 0.0); width.div_ceil(BLOCK) * height.div_ceil(BLOCK)] }
    }

    fn add(&mut self, row: usize, column: usize, value: f64) {
        let block = &mut self.sums[row / BLOCK * self.width + column / BLOCK];
        *block = (block.0 + value, block.1 + 1.0);
    }

    /// Adds the values of `other` to those of the same pixels.
    fn join(&mut self, other: &Self) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(block, other)| block.0 += other.0);
    }

    /// Pixels.
    fn count(&self) -> f64 {
        self.sums.iter().map(|(_, count)| count).sum()
    }

    /// The mean of all pixels.
    fn mean(&self) -> f64 {
        self.sums.iter().map(|(sum, _)| sum).sum::<f64>() / self.count()
    }

    /// The standard deviation of the mean, from the differences of blocks.
    fn deviation(&self) -> f64 {
        let mean = self.mean();
        let squares: f64 = self.sums.iter().map(|(sum, count)| (sum - mean * count).powi(2)).sum();
        squares.sqrt() / self.count()
    }
}
