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

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::declaration::{ACCEPTED, Declaration, DeclarationError, NON_FINITE, PHOTONS_EMITTED, PROPOSED, PlaneRule};
use super::radius::{RadiusField, RadiusRule, typical_radius_squared};
use super::shard::{Region, Shard};
use super::shrinking::{Radii, Shrinking};
use super::tally::{ProposalCount, Tally, TallyError};

/// How often chains accepted proposals of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Acceptance {
    /// The kind.
    pub proposal: String,
    /// What was proposed and what was accepted.
    pub count: ProposalCount,
}

/// How far a region has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionProgress {
    /// The pixels.
    pub region: Region,
    /// Passes merged of each twin; the twin's next shard to merge starts after them.
    pub passes: [u32; 2],
    /// The sums of the declared scalars over those passes.
    pub scalars: [Vec<f64>; 2],
}

impl RegionProgress {
    fn new(region: Region, declaration: &Declaration) -> Self {
        let zeros = vec![0.0; declaration.scalars.len()];
        Self { region, passes: [0; 2], scalars: [zeros.clone(), zeros] }
    }

    /// Passes merged of both twins.
    pub fn all_passes(&self) -> u32 {
        self.passes[0] + self.passes[1]
    }
}

/// The job's merged state: for each twin the sums of the declared planes, and the radii where the method gathers.
///
/// Planes are arrays of their own, so that what a method does not declare takes no memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// The regions, from top to bottom.
    pub progress: Vec<RegionProgress>,
    pub(super) declaration: Arc<Declaration>,
    /// Of each [`Twin`](super::shard::Twin) the declared planes, channel after channel, each channel row-major; empty where the
    /// estimate keeps no sums.
    pub(super) twins: [Vec<Vec<f64>>; 2],
    /// What decides the gather radii, shared by both twins.
    pub(super) radii: Radii,
}

/// A tally that cannot be merged now.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// The tally itself is wrong.
    #[error(transparent)]
    Tally(#[from] TallyError),
    /// The tally is of another method than the estimate.
    #[error("the tally holds other planes than this job's")]
    OtherDeclaration,
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

/// First radii that do not fit a picture, or a method that contradicts itself.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EstimateError {
    /// The method contradicts itself.
    #[error(transparent)]
    Declaration(#[from] DeclarationError),
    /// The number of values is wrong.
    #[error("{plane} has {found} values where {expected} are needed")]
    WrongSize {
        /// What has the wrong size.
        plane: &'static str,
        /// Values needed.
        expected: usize,
        /// Values that came.
        found: usize,
    },
}

/// Pixels that are added at a time: their numbers stay in the first-level cache.
const BLOCK: usize = 1024;

impl Estimate {
    /// An estimate without passes. `regions` cover the picture from top to bottom; `first_radius_squared` has one positive
    /// finite value per pixel, or none where the declaration has no radii.
    pub fn new(
        width: u32,
        height: u32,
        regions: &[Region],
        declaration: Arc<Declaration>,
        first_radius_squared: &[f32],
    ) -> Result<Self, EstimateError> {
        declaration.check()?;
        let pixels = width as usize * height as usize;
        let (expected, found) = (if declaration.has_radii() { pixels } else { 0 }, first_radius_squared.len());
        if found != expected {
            return Err(EstimateError::WrongSize { plane: "the radius field", expected, found });
        }
        let channels = |summed: bool, channels: usize| if summed { channels * pixels } else { 0 };
        let planes = declaration.planes.iter().map(|plane| vec![0.0; channels(plane.is_summed(), plane.channels)]);
        let planes: Vec<Vec<f64>> = planes.collect();
        Ok(Self {
            width,
            height,
            progress: regions.iter().map(|region| RegionProgress::new(*region, &declaration)).collect(),
            twins: [planes.clone(), planes],
            radii: Radii::new(first_radius_squared, declaration.shrinks_by_count()),
            declaration,
        })
    }

    /// What planes and scalars there are.
    pub fn declaration(&self) -> &Arc<Declaration> {
        &self.declaration
    }

    /// Pixels of the picture.
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Passes merged in every region.
    pub fn passes(&self) -> u32 {
        self.progress.iter().map(RegionProgress::all_passes).min().unwrap_or(0)
    }

    /// A scalar, summed over twins and regions; 0 when it is not declared.
    pub fn scalar(&self, name: &str) -> f64 {
        let Some(index) = self.declaration.scalar(name) else { return 0.0 };
        self.progress.iter().flat_map(|progress| progress.scalars.each_ref().map(|scalars| scalars[index])).sum()
    }

    /// Photons emitted, summed over regions.
    pub fn photons_emitted(&self) -> u64 {
        self.scalar(PHOTONS_EMITTED) as u64
    }

    /// How often chains accepted what was proposed to them, by kind; empty for methods without chains.
    pub fn acceptance(&self) -> Vec<Acceptance> {
        let count = |kind: &str, what: &str| self.scalar(&format!("{kind}{what}")) as u64;
        let of = |kind: &str| Acceptance {
            proposal: kind.to_owned(),
            count: ProposalCount { proposed: count(kind, PROPOSED), accepted: count(kind, ACCEPTED) },
        };
        self.declaration.proposals().map(of).collect()
    }

    /// Contributions dropped because they were not finite.
    pub fn non_finite(&self) -> u64 {
        self.scalar(NON_FINITE) as u64
    }

    /// Folds the next tally of its region into the state. `field` holds the radii with which it was traced.
    pub fn merge(&mut self, tally: &Tally, field: &RadiusField) -> Result<(), MergeError> {
        tally.check()?;
        let (index, pixels) = self.place_of(tally, field)?;
        for start in (0..pixels).step_by(BLOCK) {
            self.merge_block(tally, field, start, BLOCK.min(pixels - start));
        }
        let (progress, twin) = (&mut self.progress[index], tally.shard.twin() as usize);
        progress.passes[twin] += tally.shard.passes;
        progress.scalars[twin].iter_mut().zip(&tally.scalars).for_each(|(sum, value)| *sum += value);
        Ok(())
    }

    /// The index of the region of a tally that can be merged now, and its number of pixels.
    fn place_of(&self, tally: &Tally, field: &RadiusField) -> Result<(usize, usize), MergeError> {
        let Shard { region, first_pass, .. } = tally.shard;
        if tally.declaration != self.declaration {
            return Err(MergeError::OtherDeclaration);
        }
        let (expected, found) = (region.pixel_count(self.width), region.pixel_count(tally.width));
        if found != expected {
            return Err(TallyError::WrongSize { expected, found }.into());
        }
        let index = self.progress.iter().position(|progress| progress.region == region);
        let index = index.ok_or(MergeError::UnknownRegion(region))?;
        let twin = tally.shard.twin() as usize;
        let next = 2 * self.progress[index].passes[twin] + twin as u32;
        if next != first_pass {
            return Err(MergeError::OutOfOrder { expected: next, found: first_pass });
        }
        let (radii, found) = (if self.declaration.has_radii() { expected } else { 0 }, field.radius_squared.len());
        if found != radii {
            return Err(TallyError::WrongSize { expected: radii, found }.into());
        }
        Ok((index, expected))
    }

    /// Adds `count` pixels of a tally, from pixel `start` of its region on.
    fn merge_block(&mut self, tally: &Tally, field: &RadiusField, start: usize, count: usize) {
        let region_pixels = tally.shard.region.pixel_count(self.width);
        let first = tally.shard.region.row_start as usize * self.width as usize + start;
        let all = self.pixel_count();
        let [mut inverse_used, mut kept] = [[0.0; BLOCK]; 2];
        let used = field.radius_squared.get(start..start + count).unwrap_or_default();
        inverse_used.iter_mut().zip(used).for_each(|(inverse, used)| *inverse = 1.0 / f64::from(*used));
        let sums = &mut self.twins[tally.shard.twin() as usize];
        for ((declared, found), sums) in self.declaration.planes.iter().zip(&tally.planes).zip(sums) {
            for channel in 0..declared.channels {
                let found = &found[channel * region_pixels + start..][..count];
                let place = channel * all + first..channel * all + first + count;
                match declared.rule {
                    PlaneRule::Sum | PlaneRule::Ratio { .. } => add(&mut sums[place], found),
                    PlaneRule::FluxOverRadius => add_scaled(&mut sums[place], found, &inverse_used),
                    PlaneRule::SquaredFluxOverRadius => add_scaled_twice(&mut sums[place], found, &inverse_used),
                    PlaneRule::Count => {}
                }
            }
        }
        if let Some(counted) = self.declaration.counted() {
            // After the sums, which may decide whether a radius shrinks.
            self.keep_shares(first, &mut kept[..count]);
            let (found, passes) = (&tally.planes[counted][start..][..count], tally.shard.passes);
            let (inverse_used, kept) = (&inverse_used[..count], &kept[..count]);
            self.radii.shrink(first, &Shrinking { found, inverse_used, kept, passes });
        }
    }

    /// The radii with which passes that start now are to be traced in `region`; no radii where the method has none.
    ///
    /// Under `schedule` this is always the first radius, with `base_pass` 0.
    pub fn radius_field(&self, region: Region) -> RadiusField {
        if !self.declaration.has_radii() {
            return RadiusField::none();
        }
        let start = region.row_start as usize * self.width as usize;
        let radii = &self.radii.radius_squared[start..start + region.pixel_count(self.width)];
        let merged = self.progress.iter().find(|progress| progress.region == region);
        RadiusField {
            // Below that there is nothing to gather, and single precision has no such numbers: they would become 0.
            radius_squared: radii.iter().map(|radius| (*radius as f32).max(f32::MIN_POSITIVE)).collect(),
            base_pass: match self.declaration.radius_rule {
                RadiusRule::Statistics | RadiusRule::Uniformity => merged.map_or(0, RegionProgress::all_passes),
                RadiusRule::Schedule => 0,
            },
            typical_radius_squared: self.typical_radius_squared(),
        }
    }

    /// The median radius² of the whole picture, m²; 1 where there are no radii.
    pub fn typical_radius_squared(&self) -> f32 {
        typical_radius_squared(self.radii.radius_squared.iter().map(|radius| *radius as f32))
    }
}

/// Adds values to sums.
fn add(sums: &mut [f64], found: &[f32]) {
    sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += f64::from(*found));
}

/// Adds flux that was gathered with R_used² = 1/`inverse_used` [identity 1].
fn add_scaled(sums: &mut [f64], found: &[f32], inverse_used: &[f64]) {
    let sums = sums.iter_mut().zip(found).zip(inverse_used);
    sums.for_each(|((sum, found), inverse)| *sum += f64::from(*found) * inverse);
}

/// The same of squared flux.
fn add_scaled_twice(sums: &mut [f64], found: &[f32], inverse_used: &[f64]) {
    let sums = sums.iter_mut().zip(found).zip(inverse_used);
    sums.for_each(|((sum, found), inverse)| *sum += f64::from(*found) * inverse * inverse);
}
