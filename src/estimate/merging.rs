//! The job's merged state per pixel, and the rule that folds tallies into it.
//!
//! Progressive photon mapping updates, after a pass that found `M` photons with flux `Φ` inside `R`
//! [HOJ08 eqs. 7–10, in the form of HJ09]:
//!
//! ```text
//! f = (N + αM)/(N + M)    R² ← f·R²    τ ← f·(τ + Φ)    N ← N + αM    L = τ/(π R² E)
//! ```
//!
//! Tallies of an epoch were traced with `R_used` while `R` already shrank; `s = R²/R_used²` rescales `M ← s·M`, `Φ ← s·Φ`
//! first. Two identities make the merge exact and cheap, and this file uses them:
//!
//! 1. `τ/R²` after an update is `τ/R² + Φ/R_used²`: the density `D = τ/R²` is a plain sum of `Φ/R_used²`. It is what is
//!    stored, so no flux is ever rescaled and the picture does not depend on how passes were cut into shards.
//! 2. A shard of `k` passes is folded as `k` equal updates with `M̂/k` each. With `d = M̂/(k·R_used²)` and `x = N/(d·R²)` one
//!    update maps `x → x + 1` and `R² → R²·(x + α)/(x + 1)`, hence `R²` is multiplied by `Π_{j<k} (x+j+α)/(x+j+1)` and `N` becomes
//!    `d·R²·(x + k)`.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

use super::picture::Picture;
use super::radius::{RadiusField, RadiusRule, typical_radius_squared};
use super::shard::{Region, Twin};
use super::tally::{PixelTally, Tally, TallyError};

/// What decides a pixel's radius, shared by both twins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelEstimate {
    /// R², m².
    pub radius_squared: f64,
    /// N, accumulated photons (not whole: α of each pass's).
    pub photons: f64,
}

/// What a pixel's passes add up to, of one twin or of both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelSums {
    /// τ/R² = Σ Φᵢ/R²ᵢ, W·sr⁻¹·m⁻².
    pub flux_density: [f64; 3],
    /// Σ of radiance over passes, W·sr⁻¹·m⁻².
    pub radiance: [f64; 3],
    /// Σ Φ'ᵢ/R²ᵢ of the flux inside half the disc's area, mean of the channels, W·sr⁻¹·m⁻².
    pub inner_flux_density: f64,
}

impl PixelSums {
    /// The picture's radiance, W·sr⁻¹·m⁻².
    pub fn mean_radiance(&self, scale: Scale) -> [f64; 3] {
        [0, 1, 2].map(|channel| self.radiance[channel] * scale.per_pass + self.flux_density[channel] * scale.per_photon)
    }
}

/// How far a region has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionProgress {
    /// The pixels.
    pub region: Region,
    /// Passes merged of each twin; the twin's next shard to merge starts after them.
    pub passes: [u32; 2],
    /// E, photons emitted in them.
    pub photons_emitted: [u64; 2],
}

impl RegionProgress {
    /// Passes merged of both twins.
    pub fn all_passes(&self) -> u32 {
        self.passes[0] + self.passes[1]
    }
}

/// The job's merged state.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Row-major, top row first.
    pub pixels: Vec<PixelEstimate>,
    /// The sums of each [`Twin`](super::shard::Twin), in the order of `pixels`.
    pub twins: [Vec<PixelSums>; 2],
    /// The regions, from top to bottom.
    pub progress: Vec<RegionProgress>,
    /// Contributions dropped because they were not finite.
    pub non_finite: u64,
    rule: RadiusRule,
    alpha: f64,
}

/// A tally that cannot be merged now.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// The tally itself is wrong.
    #[error(transparent)]
    Tally(#[from] TallyError),
    /// The region is not one of this estimate's.
    #[error("rows {}..{} are not a region of this job", .0.row_start, .0.row_end)]
    UnknownRegion(Region),
    /// Shards must be folded in order.
    #[error("shard starts at pass {found} where pass {expected} is next")]
    OutOfOrder {
        /// The next pass to merge.
        expected: u32,
        /// The shard's first pass.
        found: u32,
    },
}

impl Estimate {
    /// An estimate without passes. `regions` cover the picture from top to bottom; `initial_radius_squared` has one
    /// positive finite value per pixel.
    pub fn new(
        width: u32,
        height: u32,
        regions: &[Region],
        initial_radius_squared: &[f32],
        rule: RadiusRule,
        alpha: f64,
    ) -> Self {
        assert_eq!(initial_radius_squared.len(), width as usize * height as usize, "one radius per pixel");
        let pixel = |radius_squared: &f32| PixelEstimate { radius_squared: f64::from(*radius_squared), photons: 0.0 };
        let progress = |region: &Region| RegionProgress { region: *region, passes: [0; 2], photons_emitted: [0; 2] };
        let sums = vec![PixelSums::default(); initial_radius_squared.len()];
        Self {
            width,
            height,
            pixels: initial_radius_squared.iter().map(pixel).collect(),
            twins: [sums.clone(), sums],
            progress: regions.iter().map(progress).collect(),
            non_finite: 0,
            rule,
            alpha,
        }
    }

    /// The rule by which its radii shrink.
    pub fn radius_rule(&self) -> RadiusRule {
        self.rule
    }

    /// α of that rule.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Passes merged in every region.
    pub fn passes(&self) -> u32 {
        self.progress.iter().map(RegionProgress::all_passes).min().unwrap_or(0)
    }

    /// Photons emitted, summed over regions.
    pub fn photons_emitted(&self) -> u64 {
        self.progress.iter().flat_map(|progress| progress.photons_emitted).sum()
    }

    /// Folds the next tally of its region into the state. `field` holds the radii with which it was traced.
    pub fn merge(&mut self, tally: &Tally, field: &RadiusField) -> Result<(), MergeError> {
        tally.check()?;
        let shard = tally.shard;
        let expected = shard.region.pixel_count(self.width);
        if tally.pixels.len() != expected {
            return Err(TallyError::WrongSize { expected, found: tally.pixels.len() }.into());
        }
        let progress = self
            .progress
            .iter_mut()
            .find(|progress| progress.region == shard.region)
            .ok_or(MergeError::UnknownRegion(shard.region))?;
        let twin = shard.twin() as usize;
        let next = 2 * progress.passes[twin] + twin as u32;
        if next != shard.first_pass {
            return Err(MergeError::OutOfOrder { expected: next, found: shard.first_pass });
        }
        if field.radius_squared.len() != tally.pixels.len() {
            let (expected, found) = (tally.pixels.len(), field.radius_squared.len());
            return Err(TallyError::WrongSize { expected, found }.into());
        }
        let start = shard.region.row_start as usize * self.width as usize;
        let range = start..start + tally.pixels.len();
        let (pixels, sums) = (&mut self.pixels[range.clone()], &mut self.twins[twin][range]);
        let inverse_passes = 1.0 / f64::from(shard.passes);
        let groups = pixels.chunks_mut(LANES).zip(sums.chunks_mut(LANES));
        let groups = groups.zip(tally.pixels.chunks(LANES)).zip(field.radius_squared.chunks(LANES));
        for (((pixels, sums), found), used) in groups {
            let mut densities = [0.0; LANES];
            for (((sums, found), used), density) in sums.iter_mut().zip(found).zip(used).zip(&mut densities) {
                let inverse_used = 1.0 / f64::from(*used);
                sums.add(found, inverse_used);
                *density = f64::from(found.photons) * inverse_used * inverse_passes;
            }
            if self.rule == RadiusRule::Statistics {
                shrink_radii(pixels, &densities, shard.passes, self.alpha);
            }
        }
        progress.passes[twin] += shard.passes;
        progress.photons_emitted[twin] += tally.photons_emitted;
        self.non_finite += tally.non_finite;
        Ok(())
    }

    /// The radii with which passes that start now are to be traced in `region`.
    ///
    /// Under `schedule` this is always the first radius, with `base_pass` 0.
    pub fn radius_field(&self, region: Region) -> RadiusField {
        let start = region.row_start as usize * self.width as usize;
        let pixels = &self.pixels[start..start + region.pixel_count(self.width)];
        let merged = self.progress.iter().find(|progress| progress.region == region);
        RadiusField {
            // Below that there is nothing to gather, and single precision has no such numbers: they would become 0.
            radius_squared: pixels.iter().map(|pixel| (pixel.radius_squared as f32).max(f32::MIN_POSITIVE)).collect(),
            base_pass: match self.rule {
                RadiusRule::Statistics => merged.map_or(0, RegionProgress::all_passes),
                RadiusRule::Schedule => 0,
            },
            typical_radius_squared: self.typical_radius_squared(),
        }
    }

    /// The median radius² of the whole picture, m².
    pub fn typical_radius_squared(&self) -> f32 {
        typical_radius_squared(self.pixels.iter().map(|pixel| pixel.radius_squared as f32))
    }

    /// Radiance as estimated so far: `L = Σradiance/passes + D/(π·E/passes)/passes`. Regions without a pass are black.
    pub fn picture(&self) -> Picture {
        self.picture_of(&[Twin::Even, Twin::Odd])
    }

    /// The same of one twin alone.
    pub fn twin_picture(&self, twin: Twin) -> Picture {
        self.picture_of(&[twin])
    }

    fn picture_of(&self, twins: &[Twin]) -> Picture {
        let mut radiance = vec![[0.0f32; 3]; self.pixels.len()];
        for progress in &self.progress {
            let start = progress.region.row_start as usize * self.width as usize;
            let range = start..start + progress.region.pixel_count(self.width);
            let Some(scale) = progress.scale(twins) else { continue };
            for (index, output) in range.clone().zip(&mut radiance[range]) {
                *output = self.sums(index, twins).mean_radiance(scale).map(|value| value as f32);
            }
        }
        Picture { width: self.width, height: self.height, radiance }
    }

    /// What the passes of `twins` add up to in a pixel.
    pub fn sums(&self, pixel: usize, twins: &[Twin]) -> PixelSums {
        let mut total = PixelSums::default();
        for sums in twins.iter().map(|twin| &self.twins[*twin as usize][pixel]) {
            for channel in 0..3 {
                total.flux_density[channel] += sums.flux_density[channel];
                total.radiance[channel] += sums.radiance[channel];
            }
            total.inner_flux_density += sums.inner_flux_density;
        }
        total
    }
}

/// What sums of passes are multiplied with to become radiance.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// For radiance: one over the passes.
    pub per_pass: f64,
    /// For flux densities: one over π·E.
    pub per_photon: f64,
}

impl RegionProgress {
    /// The scale of the sums of `twins`; `None` when they have no pass.
    pub fn scale(&self, twins: &[Twin]) -> Option<Scale> {
        let passes: u32 = twins.iter().map(|twin| self.passes[*twin as usize]).sum();
        let photons: u64 = twins.iter().map(|twin| self.photons_emitted[*twin as usize]).sum();
        // Without photons there is no flux that this could scale.
        let per_photon = 1.0 / (std::f64::consts::PI * photons.max(1) as f64);
        (passes > 0).then(|| Scale { per_pass: 1.0 / f64::from(passes), per_photon })
    }
}

impl PixelSums {
    /// Adds sums that were gathered with R_used² = 1/`inverse_used` [identity 1].
    fn add(&mut self, found: &PixelTally, inverse_used: f64) {
        for channel in 0..3 {
            self.radiance[channel] += f64::from(found.radiance[channel]);
            self.flux_density[channel] += f64::from(found.flux[channel]) * inverse_used;
        }
        self.inner_flux_density += f64::from(found.inner_flux) * inverse_used;
    }
}

/// Pixels that are shrunk together: their chains of products run side by side.
const LANES: usize = 8;

/// Shrinks the radius of each of at most [`LANES`] pixels by `passes` equal updates that each found `density`·R² photons
/// [identity 2]. Pixels of density 0 stay as they are.
fn shrink_radii(pixels: &mut [PixelEstimate], densities: &[f64; LANES], passes: u32, alpha: f64) {
    let mut first = [0.0; LANES];
    for ((first, pixel), density) in first.iter_mut().zip(&*pixels).zip(densities) {
        *first = if *density > 0.0 { pixel.photons / (density * pixel.radius_squared) } else { 0.0 };
    }
    let product = shrink_products(&first, passes, alpha);
    for (lane, pixel) in pixels.iter_mut().enumerate().filter(|(lane, _)| densities[*lane] > 0.0) {
        pixel.radius_squared *= product[lane];
        pixel.photons = densities[lane] * pixel.radius_squared * (first[lane] + f64::from(passes));
    }
}

/// `Π_{j<passes} (first+j+α)/(first+j+1)` for each lane, with one division per eight factors.
fn shrink_products(first: &[f64; LANES], passes: u32, alpha: f64) -> [f64; LANES] {
    let mut product = [1.0; LANES];
    for block in (0..passes).step_by(8) {
        let (mut above, mut below) = ([1.0; LANES], [1.0; LANES]);
        for j in block..passes.min(block + 8) {
            let j = f64::from(j);
            for lane in 0..LANES {
                above[lane] *= first[lane] + j + alpha;
                below[lane] *= first[lane] + j + 1.0;
            }
        }
        for lane in 0..LANES {
            product[lane] *= above[lane] / below[lane];
        }
    }
    product
}
