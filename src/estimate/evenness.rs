//! Whether the flux that a pixel found lies evenly in its discs: under [`RadiusRule::Uniformity`] radii shrink only where it does not.
//!
//! Where flux is even, a disc of any size estimates its density without bias, and a larger one with less noise; so the radius stays, as in chi-squared progressive
//! photon mapping [Lin et al. 2020]. Three sums tell whether it is: with the weight w of a photon (its part of the flux, mean of the channels), φ the direction in
//! which it lies from the disc's middle, and a sign that is + inside half the disc's area,
//!
//! ```text
//! a = Σ w·cos φ/R²    b = Σ w·sin φ/R²    c = Σ ±w/R²    v = Σ w²/R⁴    X = (2·a² + 2·b² + c²)/v
//! ```
//!
//! over all photons of all passes, each with the R of its pass. Where flux is even, a, b and c have mean 0 and the variances v/2, v/2 and v, so that X is
//! distributed as chi-squared with three degrees of freedom. They say what counts in sectors would say, with fewer numbers, and no border of a sector can hide a line.
//! c is what [`error`](super::error) takes the bias of: the disc shrinks while the picture's own bias shows through its noise, or an edge does.
//!
//! **How large X may be.** Tests at 5 % are good at what they are made for, not at small errors: c of a smooth density is half of its bias, and v the variance of the
//! picture, so that X = 7.8 may mean a bias² of 31 times the variance, where a quarter of a half would be best. Simulated in the plane, squared errors after 1024 passes over those
//! of `statistics`: even 0.1, a ramp 0.5, an edge 1.1, a bump 2.3, waves 4.8 with the 5 % of 7.8; 0.4, 0.8, 1.3, 1.3 and 1.8 with the median. Hence the median.
//!
//! **Consistency.** Where X is large, the update is that of `statistics`; elsewhere it is the same with α = 1: R stays and all photons count. So R² never falls faster than
//! under `statistics`, N grows at least as fast, and the noise vanishes. Where flux is not even in discs that stay, a, b or c grow with the passes and the root
//! of v with their square root, so that X rises above any bound and R shrinks again. What is even stays, and has no bias. (A disc in which nothing but higher orders is
//! uneven, the same in both halves of its area and on all sides, is taken for even.)

use super::declaration::{FLUX, FLUX_SLOPE, INNER_FLUX, SQUARED_FLUX};
use super::merging::Estimate;
use super::radius::RadiusRule;
use super::shard::Twin;

/// The median of chi-squared with three degrees of freedom: X of even flux exceeds it half of the time.
const UNEVEN: f64 = 2.366;

impl Estimate {
    /// Sets the share of photons that each pixel from `first` on keeps, α where its radius is to shrink and 1 where it is to stay.
    pub(super) fn keep_shares(&self, first: usize, kept: &mut [f64]) {
        kept.fill(self.declaration.alpha);
        if self.declaration.radius_rule != RadiusRule::Uniformity {
            return;
        }
        let Some(sums) = EvennessSums::of(self) else { return };
        for (pixel, kept) in (first..).zip(kept) {
            if sums.chi_squared(pixel) < UNEVEN {
                *kept = 1.0;
            }
        }
    }
}

/// The sums of both twins, one after the other.
struct EvennessSums<'a> {
    pixels: usize,
    /// Of all light groups.
    flux: Vec<&'a [f64]>,
    inner_flux: Vec<&'a [f64]>,
    slope: Vec<&'a [f64]>,
    squared_flux: Vec<&'a [f64]>,
}

impl<'a> EvennessSums<'a> {
    /// `None` where the method does not declare them all.
    fn of(estimate: &'a Estimate) -> Option<Self> {
        let of_both = |kind: &'static str| {
            let sums = [Twin::Even, Twin::Odd].into_iter().flat_map(move |twin| estimate.plane_sums(kind, twin));
            Some(sums.collect::<Vec<_>>()).filter(|sums| !sums.is_empty())
        };
        Some(Self {
            pixels: estimate.pixel_count(),
            flux: of_both(FLUX)?,
            inner_flux: of_both(INNER_FLUX)?,
            slope: of_both(FLUX_SLOPE)?,
            squared_flux: of_both(SQUARED_FLUX)?,
        })
    }

    /// X of a pixel; 0 before it found a photon.
    fn chi_squared(&self, pixel: usize) -> f64 {
        let channel = |sums: &[&[f64]], channel: usize| {
            let place = channel * self.pixels + pixel;
            sums.iter().fold(0.0, |sum, plane| sum + plane[place])
        };
        let flux = (channel(&self.flux, 0) + channel(&self.flux, 1) + channel(&self.flux, 2)) / 3.0;
        let [a, b] = [0, 1].map(|axis| channel(&self.slope, axis));
        let c = 2.0 * channel(&self.inner_flux, 0) - flux;
        let v = channel(&self.squared_flux, 0);
        if v > 0.0 { (2.0 * (a * a + b * b) + c * c) / v } else { 0.0 }
    }
}
