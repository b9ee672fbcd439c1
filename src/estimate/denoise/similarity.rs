//! How alike the surroundings of two pixels are, beyond what noise explains: the weights of non-local means.
//!
//! With the variance V of a pixel (sum over its channels), two pixels i and j of the patches around p and q differ by
//!
//! ```text
//! d(i, j) = (|c_i − c_j|² − (V_i + min(V_i, V_j)))/(V_i + V_j)
//! ```
//!
//! which is about 0 where only noise makes a difference [Rousselle et al. 2012]. The mean over a patch makes the similarity
//! exp(−max(0, mean d)). Each d counts up to a bound: one outlier says no more than that two pixels differ.

use wide::f32x8;

use super::planes::{GROUPS, LANES, Layout, TILE, exp, lanes};
use super::{Color, Twins, box_mean::box_mean};

/// Pixels on each side of one that make up its patch.
pub const PATCH: usize = 3;
/// The most that two pixels differ.
pub const MOST_DISSIMILAR: f32 = 30.0;
/// Reach of the square in which variances are averaged, pixels: two twins alone tell little of a single pixel.
const VARIANCE_REACH: usize = 2;
/// Added to variances: those of two pixels that are known exactly must not be divided by.
const LEAST_VARIANCE: f32 = 1e-12;
/// Rows of a tile with those of its outermost patches.
const PATCH_ROWS: usize = TILE[1] + 2 * PATCH;
/// Columns of the same, in whole lanes.
const PATCH_COLUMNS: usize = (TILE[0] + 2 * PATCH).div_ceil(LANES) * LANES;

/// A twin that tells which pixels are alike.
pub(super) struct Guide {
    color: Color,
    variance: Vec<f32>,
}

impl Guide {
    /// Both twins.
    pub(super) fn of(twins: &Twins, layout: &Layout) -> [Self; 2] {
        let difference = |pixel: usize| f64::from(twins.squared_difference(pixel));
        let differences: Vec<f64> = (0..twins.pixel_count()).map(difference).collect();
        let mut spread = box_mean(&differences, twins.width, VARIANCE_REACH);
        // Where twins agree to the bit there is no noise: a lamp, the sky, or nothing at all.
        spread.iter_mut().zip(&differences).filter(|(_, own)| **own == 0.0).for_each(|(spread, _)| *spread = 0.0);
        [0, 1].map(|twin| {
            // The expected square is the sum of both variances, and each is as large as the other's share of the passes.
            let variance = |pixel: usize| spread[pixel] as f32 * twins.shares(pixel)[1 - twin];
            let variance: Vec<f32> = (0..twins.pixel_count()).map(variance).collect();
            let color = twins.radiance[twin].each_ref().map(|channel| layout.plane(channel));
            Self { color, variance: layout.plane(&variance) }
        })
    }

    /// How the lanes from `place` on differ from those at `other`.
    #[inline(always)]
    fn dissimilarity(&self, place: usize, other: usize) -> f32x8 {
        let square = |channel: &Vec<f32>| {
            let difference = lanes(channel, place) - lanes(channel, other);
            difference * difference
        };
        let [red, green, blue] = &self.color;
        let variances = [lanes(&self.variance, place), lanes(&self.variance, other)];
        let by_noise = variances[0] + variances[0].fast_min(variances[1]);
        let both = variances[0] + variances[1] + f32x8::splat(LEAST_VARIANCE);
        ((square(red) + square(green) + square(blue) - by_noise) / both).fast_min(f32x8::splat(MOST_DISSIMILAR))
    }

    /// The similarity of every pixel of a tile with the one that lies `offset` away, in groups of lanes, row by row.
    pub(super) fn similarities(
        &self,
        layout: &Layout,
        corner: [usize; 2],
        offset: [isize; 2],
        mut take: impl FnMut(usize, f32x8),
    ) {
        let mut across = [[0.0f32; TILE[0]]; PATCH_ROWS];
        let mut row = [0.0f32; PATCH_COLUMNS];
        for (index, across) in across.iter_mut().enumerate() {
            let place = layout.shifted(layout.place(corner[0], corner[1] + index), [-(PATCH as isize); 2]);
            let other = layout.shifted(place, offset);
            for column in (0..PATCH_COLUMNS).step_by(LANES) {
                let dissimilarity = self.dissimilarity(place + column, other + column);
                row[column..column + LANES].copy_from_slice(&dissimilarity.to_array());
            }
            for column in (0..TILE[0]).step_by(LANES) {
                let sum =
                    (0..=2 * PATCH).map(|step| lanes(&row, column + step)).fold(f32x8::ZERO, |sum, next| sum + next);
                across[column..column + LANES].copy_from_slice(&sum.to_array());
            }
        }
        for group in 0..GROUPS {
            let (column, row) = (group * LANES % TILE[0], group * LANES / TILE[0]);
            let patch = across[row..=row + 2 * PATCH].iter();
            let sum = patch.map(|across| lanes(across, column)).fold(f32x8::ZERO, |sum, next| sum + next);
            let mean = sum * f32x8::splat(1.0 / (2 * PATCH + 1).pow(2) as f32);
            take(group, exp(-mean.fast_max(f32x8::ZERO)));
        }
    }
}
