//! The two independent halves of an estimate: the pictures of its even and of its odd passes.

use super::{Color, DenoiseError};
use crate::estimate::{Estimate, Twin};

/// Two independent pictures of the same thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Twins {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// The even and the odd twin, W·sr⁻¹·m⁻².
    pub radiance: [Color; 2],
    /// The even twin's share of the passes in every row; the odd twin has the rest.
    pub even_shares: Vec<f32>,
}

impl Twins {
    /// Those of an estimate.
    pub fn of(estimate: &Estimate) -> Result<Self, DenoiseError> {
        if estimate.progress.iter().any(|progress| progress.passes.contains(&0)) {
            return Err(DenoiseError::OneTwin);
        }
        let even_shares = estimate.progress.iter().flat_map(|progress| {
            let share = f64::from(progress.passes[Twin::Even as usize]) / f64::from(progress.all_passes());
            std::iter::repeat_n(share as f32, (progress.region.row_end - progress.region.row_start) as usize)
        });
        let even_shares = even_shares.collect();
        let radiance = [Twin::Even, Twin::Odd].map(|twin| {
            let picture = estimate.twin_picture(twin);
            [0, 1, 2].map(|channel| picture.radiance.iter().map(|pixel| pixel[channel]).collect())
        });
        Ok(Self { width: estimate.width as usize, height: estimate.height as usize, radiance, even_shares })
    }

    pub(super) fn pixel_count(&self) -> usize {
        self.width * self.height
    }

    /// The twins' shares of the passes in a pixel.
    pub(super) fn shares(&self, pixel: usize) -> [f32; 2] {
        let even = self.even_shares[pixel / self.width];
        [even, 1.0 - even]
    }

    /// Mean of the absolute values.
    pub(super) fn mean(&self) -> f32 {
        let values = self.radiance.iter().flatten();
        let sum: f64 = values.map(|plane| plane.iter().map(|value| f64::from(value.abs())).sum::<f64>()).sum();
        (sum / (6 * self.pixel_count()) as f64) as f32
    }

    pub(super) fn scaled(&self, factor: f32) -> Self {
        let scale = |plane: &Vec<f32>| plane.iter().map(|value| value * factor).collect();
        let radiance = self.radiance.each_ref().map(|color| color.each_ref().map(scale));
        Self { radiance, even_shares: self.even_shares.clone(), ..*self }
    }

    /// Sum over the channels of the squared difference of the twins.
    pub(super) fn squared_difference(&self, pixel: usize) -> f32 {
        let [even, odd] = &self.radiance;
        (0..3).map(|channel| (even[channel][pixel] - odd[channel][pixel]).powi(2)).sum()
    }

    /// The picture of both by their shares, for these twins or for what was made of them.
    pub(super) fn join(&self, filtered: &[Color; 2]) -> Color {
        [0, 1, 2].map(|channel| {
            let value = |pixel: usize| {
                let [even, odd] = self.shares(pixel);
                even * filtered[0][channel][pixel] + odd * filtered[1][channel][pixel]
            };
            (0..self.pixel_count()).map(value).collect()
        })
    }
}
