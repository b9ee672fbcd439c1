//! How the photons that pixels find shrink their radii [identity 2 of [`merging`](super::merging)].

use serde::{Deserialize, Serialize};

/// What decides the radii of all pixels, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Radii {
    /// R², m²; empty where the method gathers nothing.
    pub radius_squared: Vec<f64>,
    /// N, accumulated photons (not whole: α of each pass's); empty where they do not decide the radius.
    pub photons: Vec<f64>,
}

/// What decides a pixel's radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PixelEstimate {
    /// R², m².
    pub radius_squared: f64,
    /// N, accumulated photons.
    pub photons: f64,
}

/// A tally's part in the radii of some pixels.
pub(super) struct Shrinking<'a> {
    /// Photons found in all passes, per pixel.
    pub(super) found: &'a [f32],
    /// 1/R_used² of the same pixels, m⁻².
    pub(super) inverse_used: &'a [f64],
    /// α of the same pixels: the share of the photons that is kept; 1 where the radius is to stay.
    pub(super) kept: &'a [f64],
    pub(super) passes: u32,
}

/// Pixels that are shrunk together: their chains of products run side by side.
const LANES: usize = 8;

impl Radii {
    pub(super) fn new(first_radius_squared: &[f32], counts: bool) -> Self {
        let photons = vec![0.0; if counts { first_radius_squared.len() } else { 0 }];
        Self { radius_squared: first_radius_squared.iter().map(|radius| f64::from(*radius)).collect(), photons }
    }

    /// A pixel's radius and photons. Where the method has none, radius 1 and no photon stand for them.
    pub(super) fn pixel(&self, index: usize) -> PixelEstimate {
        PixelEstimate {
            radius_squared: self.radius_squared.get(index).copied().unwrap_or(1.0),
            photons: self.photons.get(index).copied().unwrap_or(0.0),
        }
    }

    /// Shrinks the radii of the pixels from `first` on, where photons decide them.
    pub(super) fn shrink(&mut self, first: usize, shrinking: &Shrinking<'_>) {
        if self.photons.is_empty() {
            return;
        }
        let pixels = first..first + shrinking.found.len();
        let radii = self.radius_squared[pixels.clone()].chunks_mut(LANES);
        let groups = radii.zip(self.photons[pixels].chunks_mut(LANES));
        let groups = groups.zip(shrinking.found.chunks(LANES)).zip(shrinking.inverse_used.chunks(LANES));
        let inverse_passes = 1.0 / f64::from(shrinking.passes);
        for ((((radii, photons), found), inverse_used), kept) in groups.zip(shrinking.kept.chunks(LANES)) {
            let mut densities = [0.0; LANES];
            for ((density, found), inverse_used) in densities.iter_mut().zip(found).zip(inverse_used) {
                *density = f64::from(*found) * inverse_used * inverse_passes;
            }
            let mut kept_lanes = [1.0; LANES];
            kept_lanes[..kept.len()].copy_from_slice(kept);
            shrink_lanes(radii, photons, &densities, (&kept_lanes, shrinking.passes));
        }
    }
}

/// Shrinks the radius of each of at most [`LANES`] pixels by equal updates that each found `density`·R² photons
/// [identity 2]. Pixels of density 0 stay as they are.
fn shrink_lanes(
    radii: &mut [f64],
    photons: &mut [f64],
    densities: &[f64; LANES],
    (kept, passes): (&[f64; LANES], u32),
) {
    let mut first = [0.0; LANES];
    for (((first, radius), photons), density) in first.iter_mut().zip(&*radii).zip(&*photons).zip(densities) {
        *first = if *density > 0.0 { photons / (density * radius) } else { 0.0 };
    }
    let product = shrink_products(&first, passes, kept);
    let pixels = radii.iter_mut().zip(photons).enumerate();
    for (lane, (radius, photons)) in pixels.filter(|(lane, _)| densities[*lane] > 0.0) {
        *radius *= product[lane];
        *photons = densities[lane] * *radius * (first[lane] + f64::from(passes));
    }
}

/// `Π_{j<passes} (first+j+kept)/(first+j+1)` for each lane, with one division per eight factors.
fn shrink_products(first: &[f64; LANES], passes: u32, kept: &[f64; LANES]) -> [f64; LANES] {
    let mut product = [1.0; LANES];
    for block in (0..passes).step_by(8) {
        let (mut above, mut below) = ([1.0; LANES], [1.0; LANES]);
        for j in block..passes.min(block + 8) {
            let j = f64::from(j);
            for lane in 0..LANES {
                above[lane] *= first[lane] + j + kept[lane];
                below[lane] *= first[lane] + j + 1.0;
            }
        }
        for lane in 0..LANES {
            product[lane] *= above[lane] / below[lane];
        }
    }
    product
}
