//! The two estimates of every pixel: a mean of what is alike beyond doubt, and a linear fit over all that may be alike.
//!
//! With s the similarity of two pixels by the other twin, x the difference of their features, and n = exp(−|x|²/reach²), the mean has the weights s⁴·n and the
//! fit the weights s·n. The fit is the constant β₀ that minimises
//!
//! ```text
//! Σ s·n·(c − β₀ − β·x)² + Σ_j (ridge·Σ s·n·x_j² + prior)·β_j²
//! ```
//!
//! by elimination in its normal equations; β itself is not needed, since x is 0 in the pixel [Bitterli et al. 2016].

use rayon::prelude::*;
use wide::f32x8;

use super::planes::{GROUPS, LANES, Layout, TILE, exp, lanes, window};
use super::similarity::Guide;
use super::{Color, FEATURES, Twins};

/// Pixels on each side of one that may help it.
pub const WINDOW: usize = 7;
/// How far apart features of pixels may be that help each other, in standard deviations of the picture's features.
pub const FEATURE_REACH: f32 = 1.0;
/// Slopes along features that hardly vary in a window, or follow from others, are held back by this share of how much they vary.
pub const RIDGE: f32 = 1e-3;
/// What holds slopes back where few pixels count.
pub const SLOPE_PRIOR: f32 = 0.1;
/// Beyond this an exponential is 0 for our purposes, and f32 still has it.
const MOST_EXPONENT: f32 = 80.0;
/// Features and the constant, which is the last.
const UNKNOWNS: usize = FEATURES + 1;

/// Both estimates of both twins.
pub(super) struct Fits {
    /// Means, by twin.
    pub(super) mean: [Color; 2],
    /// Linear fits, by twin.
    pub(super) linear: [Color; 2],
}

/// What lanes of pixels get: by estimate (mean, linear), twin and channel.
type GroupFits = [[[f32x8; 3]; 2]; 2];

/// All that pixels are estimated from, with margins.
struct Input {
    layout: Layout,
    guides: [Guide; 2],
    colors: [Color; 2],
    features: [Vec<f32>; FEATURES],
    inside: Vec<f32>,
    window: Vec<[isize; 2]>,
}

/// Estimates every pixel of both twins, each with weights of the other. Runs on the calling rayon pool.
pub(super) fn fit(twins: &Twins, features: &[Vec<f32>; FEATURES]) -> Fits {
    let layout = Layout::new(twins.width, twins.height);
    let input = Input {
        guides: Guide::of(twins, &layout),
        colors: twins.radiance.each_ref().map(|color| color.each_ref().map(|channel| layout.plane(channel))),
        features: features.each_ref().map(|feature| layout.plane(feature)),
        inside: layout.inside(),
        window: window(),
        layout,
    };
    let tiles: Vec<Vec<GroupFits>> =
        (0..layout.tile_count()).into_par_iter().map(|tile| input.tile(layout.corner(tile))).collect();
    let empty = || [0, 1].map(|_| [0, 1, 2].map(|_| vec![0.0; twins.pixel_count()]));
    let mut fits = [empty(), empty()];
    for (tile, groups) in tiles.iter().enumerate() {
        for (group, found) in groups.iter().enumerate() {
            put(twins, layout.corner(tile), group, found, &mut fits);
        }
    }
    let [mean, linear] = fits;
    Fits { mean, linear }
}

/// Writes what a group of a tile got to where its pixels lie, as far as they are in the picture.
fn put(twins: &Twins, corner: [usize; 2], group: usize, found: &GroupFits, fits: &mut [[Color; 2]; 2]) {
    let [column, row] = [corner[0] + group * LANES % TILE[0], corner[1] + group * LANES / TILE[0]];
    if row >= twins.height || column >= twins.width {
        return;
    }
    let first = row * twins.width + column;
    let count = LANES.min(twins.width - column);
    for (found, planes) in found.as_flattened().as_flattened().iter().zip(fits.as_flattened_mut().as_flattened_mut()) {
        planes[first..first + count].copy_from_slice(&found.to_array()[..count]);
    }
}

impl Input {
    /// The estimates of a tile's pixels, group by group.
    fn tile(&self, corner: [usize; 2]) -> Vec<GroupFits> {
        let size = self.window.len();
        let similarities = self.guides.each_ref().map(|guide| {
            let mut all = vec![f32x8::ZERO; GROUPS * size];
            for (index, offset) in self.window.iter().enumerate() {
                guide.similarities(&self.layout, corner, *offset, |group, found| all[group * size + index] = found);
            }
            all
        });
        let estimate = |group: usize| {
            let place = self.layout.place(corner[0] + group * LANES % TILE[0], corner[1] + group * LANES / TILE[0]);
            let of_group = similarities.each_ref().map(|all| &all[group * size..(group + 1) * size]);
            self.group(place, of_group)
        };
        (0..GROUPS).map(estimate).collect()
    }

    /// The estimates of the lanes at `place`.
    fn group(&self, place: usize, similarities: [&[f32x8]; 2]) -> GroupFits {
        let mut sums = [Sums::ZERO; 2];
        for (index, offset) in self.window.iter().enumerate() {
            let other = self.layout.shifted(place, *offset);
            let mut features = [f32x8::ONE; UNKNOWNS];
            let mut distance = f32x8::ZERO;
            for (difference, plane) in features.iter_mut().zip(&self.features) {
                *difference = lanes(plane, other) - lanes(plane, place);
                distance = difference.mul_add(*difference, distance);
            }
            let exponent = (distance * f32x8::splat(FEATURE_REACH.powi(-2))).fast_min(f32x8::splat(MOST_EXPONENT));
            let near = exp(-exponent) * lanes(&self.inside, other);
            for (twin, sums) in sums.iter_mut().enumerate() {
                let color = self.colors[twin].each_ref().map(|channel| lanes(channel, other));
                sums.add(similarities[1 - twin][index], near, &features, color);
            }
        }
        let [even, odd] = sums;
        let (means, linear) = ([even.mean(), odd.mean()], [even.linear(), odd.linear()]);
        [means, linear]
    }
}

/// What is summed over a window for one twin.
#[derive(Clone, Copy)]
struct Sums {
    /// Of the mean: weights, and colors times weights.
    weight: f32x8,
    color: [f32x8; 3],
    /// Of the fit: the lower triangle of the normal equations, and their right side.
    normal: [[f32x8; UNKNOWNS]; UNKNOWNS],
    right: [[f32x8; 3]; UNKNOWNS],
}

impl Sums {
    const ZERO: Self = Self {
        weight: f32x8::ZERO,
        color: [f32x8::ZERO; 3],
        normal: [[f32x8::ZERO; UNKNOWNS]; UNKNOWNS],
        right: [[f32x8::ZERO; 3]; UNKNOWNS],
    };

    #[inline(always)]
    fn add(&mut self, similarity: f32x8, near: f32x8, features: &[f32x8; UNKNOWNS], color: [f32x8; 3]) {
        let squared = similarity * similarity;
        let strict = squared * squared * near;
        self.weight += strict;
        for (sum, color) in self.color.iter_mut().zip(color) {
            *sum = strict.mul_add(color, *sum);
        }
        let weight = similarity * near;
        for row in 0..UNKNOWNS {
            let weighted = weight * features[row];
            for (sum, feature) in self.normal[row][..=row].iter_mut().zip(features) {
                *sum = weighted.mul_add(*feature, *sum);
            }
            for (sum, color) in self.right[row].iter_mut().zip(color) {
                *sum = weighted.mul_add(color, *sum);
            }
        }
    }

    /// A pixel is always like itself: the weights never add up to 0.
    fn mean(&self) -> [f32x8; 3] {
        self.color.map(|color| color / self.weight)
    }

    /// The constant of the fit; where it is negative, which no light is, the fit's plain weighted mean.
    fn linear(mut self) -> [f32x8; 3] {
        let (normal, right) = (&mut self.normal, &mut self.right);
        let constant = UNKNOWNS - 1;
        let plain = right[constant].map(|sum| sum / normal[constant][constant]);
        for (index, row) in normal[..constant].iter_mut().enumerate() {
            row[index] = row[index].mul_add(f32x8::splat(1.0 + RIDGE), f32x8::splat(SLOPE_PRIOR));
        }
        for pivot in 0..constant {
            let inverse = f32x8::ONE / normal[pivot][pivot];
            let below: [f32x8; UNKNOWNS] = std::array::from_fn(|row| normal[row][pivot]);
            let known = right[pivot];
            for row in pivot + 1..UNKNOWNS {
                let factor = -(below[row] * inverse);
                for (value, below) in normal[row][pivot + 1..=row].iter_mut().zip(&below[pivot + 1..=row]) {
                    *value = factor.mul_add(*below, *value);
                }
                for (value, known) in right[row].iter_mut().zip(known) {
                    *value = factor.mul_add(known, *value);
                }
            }
        }
        [0, 1, 2].map(|channel| {
            let fitted = right[constant][channel] / normal[constant][constant];
            fitted.simd_lt(f32x8::ZERO).select(plain[channel], fitted)
        })
    }
}
