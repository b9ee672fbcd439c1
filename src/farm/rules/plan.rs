//! How a job's passes are cut into shards and epochs.
//!
//! A plan is a pure function of the picture's size, the pilot's counted cost and the stop rule's passes: never of workers or
//! time. It is what makes a job's picture the same bits on any farm.
//!
//! ```text
//! epoch 0                              epoch 1
//! region 0: s s s … (16)  region 1: …  region 0: s s s … (16)  region 1: …        s = passes_in_shard(epoch) passes
//! ```
//!
//! Two shards that follow each other share a range of passes: the first takes the even ones, the second the odd ones, so that
//! a job's two twins grow alike.
//!
//! Shards start with one pass and double every epoch until one costs about a second. So a first picture comes soon,
//! the radii, which shrink fastest in the first passes, are refreshed then too, and the cut does not depend on how many
//! passes will be made: a job that is stopped after n passes has traced the shards of a job of n passes.
//! A job may ask for another cut ([`Cut`]); it is stored with the job.

use serde::{Deserialize, Serialize};

use crate::estimate::{RadiusRule, Region, Shard, Twin};
use crate::farm::cut::Cut;

/// Pixels of a region; a worker holds one tally and one radius field of this size.
const REGION_PIXELS: u64 = 4 << 20;
/// What a full-grown shard costs, nominal microseconds of one core.
const SHARD_COST: u64 = 1_000_000;
/// What a shard costs at most, however many passes a user asks for: ten minutes.
const LONGEST_SHARD: u64 = 600_000_000;
/// Shards of one region in an epoch.
const SHARDS_PER_EPOCH: u32 = 16;
/// How many epochs a radius field may be behind.
const EPOCH_LAG: u32 = 1;
/// For so many epochs more than merging needs them, radius fields are kept to check shards.
const CHECKED_EPOCHS: u32 = 2;
/// Passes when no stop rule names them; pass indices are 32-bit.
pub const PASSES_LIMIT: u32 = 1 << 31;

/// The cut of a job.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Bands from top to bottom, each of at most 4 Mpixel (or one row).
    pub regions: Vec<Region>,
    /// What one pass of the largest region costs, nominal microseconds of one core.
    pub cost_per_pass: u64,
    /// Passes of a full-grown shard, at least 1.
    pub passes_per_shard: u32,
    /// Shards of one region in an epoch.
    pub shards_per_epoch: u32,
    /// Epoch `e` is traced with the radii after all epochs up to `e − 1 − epoch_lag`.
    pub epoch_lag: u32,
    /// Passes at which the job is complete.
    pub passes: u32,
    /// Whether radii come from pixel statistics, so that epochs must wait for merges.
    pub radius_rule: RadiusRule,
}

/// A shard and its place in the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedShard {
    /// What to trace.
    pub shard: Shard,
    /// Index of its region.
    pub region: u32,
    /// Epoch for which its radius field was taken: 0 means the first radii.
    pub field_epoch: u32,
}

impl Plan {
    /// Cuts a job. `cost_per_pass` is the pilot's, in nominal microseconds for the whole picture; `passes` is `None`
    /// when only seconds stop the job.
    pub fn new(width: u32, height: u32, cost_per_pass: u64, passes: Option<u32>, radius_rule: RadiusRule) -> Self {
        let regions = bands(width, height);
        let rows = regions.iter().map(|region| u64::from(region.rows())).max().unwrap_or(1);
        let cost = (cost_per_pass.saturating_mul(rows) / u64::from(height.max(1))).max(1);
        Self {
            width,
            height,
            regions,
            cost_per_pass: cost,
            passes_per_shard: (SHARD_COST / cost).clamp(1, 1 << 20) as u32,
            shards_per_epoch: SHARDS_PER_EPOCH,
            epoch_lag: EPOCH_LAG,
            passes: passes.unwrap_or(PASSES_LIMIT).clamp(1, PASSES_LIMIT),
            radius_rule,
        }
    }

    /// The same with the cut that a user asked for. Whoever loses a shard, or waits for one, loses no more than [`LONGEST_SHARD`].
    pub fn with_cut(self, cut: Cut) -> Self {
        let most = (LONGEST_SHARD / self.cost_per_pass.max(1)).clamp(1, u64::from(Cut::MOST_PASSES)) as u32;
        Self {
            passes_per_shard: cut.passes_per_shard.map_or(self.passes_per_shard, |passes| passes.min(most)),
            shards_per_epoch: cut.shards_per_epoch.unwrap_or(self.shards_per_epoch),
            ..self
        }
    }

    /// Passes of a shard in `epoch`; the job's last shard may have fewer.
    pub fn passes_in_shard(&self, epoch: u32) -> u32 {
        1u32.checked_shl(epoch).unwrap_or(u32::MAX).min(self.passes_per_shard)
    }

    /// Shards in the whole job.
    pub fn shard_count(&self) -> u64 {
        let (epoch, first_pass) = self.last_epoch();
        let whole = u64::from(epoch) * self.shards_in_epoch();
        whole + self.shards_of_region(epoch, u64::from(first_pass)) * self.regions.len() as u64
    }

    /// Index of the first shard of `epoch`.
    pub fn epoch_start(&self, epoch: u32) -> u64 {
        (u64::from(epoch) * self.shards_in_epoch()).min(self.shard_count())
    }

    /// The epoch that shard `index` belongs to.
    pub fn epoch_of(&self, index: u64) -> u32 {
        (index / self.shards_in_epoch()) as u32
    }

    /// The epoch whose shards' radius field is that of `epoch`: 0 for the first radii.
    pub fn field_epoch(&self, epoch: u32) -> u32 {
        match self.radius_rule {
            RadiusRule::Statistics | RadiusRule::Uniformity if epoch > self.epoch_lag => epoch,
            _ => 0,
        }
    }

    /// Shard `index` in the job's one order: by epoch, then region, then pass. `None` past the end.
    pub fn shard(&self, index: u64) -> Option<PlannedShard> {
        let epoch = u32::try_from(index / self.shards_in_epoch()).ok()?;
        let (last_epoch, _) = self.last_epoch();
        if epoch > last_epoch {
            return None;
        }
        let (start, passes) = (self.first_pass(epoch), self.passes_in_shard(epoch));
        let per_region = self.shards_of_region(epoch, start);
        let within = index % self.shards_in_epoch();
        let region = usize::try_from(within / per_region).ok()?;
        let (pair, odd) = (within % per_region / 2, within % per_region % 2);
        let pair_start = start + pair * 2 * u64::from(passes);
        let pair_passes = (2 * u64::from(passes)).min(u64::from(self.passes) - pair_start);
        let shard = Shard {
            first_pass: (pair_start + odd) as u32,
            passes: (pair_passes + 1 - odd) as u32 / 2,
            region: *self.regions.get(region)?,
        };
        Some(PlannedShard { shard, region: region as u32, field_epoch: self.field_epoch(epoch) })
    }

    /// How many shards must be merged before shard `index` may be issued.
    ///
    /// Under `statistics` and `uniformity` its radius field must exist; under `schedule` only the buffer of early results is bounded.
    pub fn merged_before(&self, index: u64) -> u64 {
        match self.radius_rule {
            RadiusRule::Statistics | RadiusRule::Uniformity => {
                self.epoch_start(self.epoch_of(index).saturating_sub(self.epoch_lag))
            }
            RadiusRule::Schedule => (index + 1).saturating_sub(4 * u64::from(self.shards_per_epoch)),
        }
    }

    /// The first epoch whose radius fields are still there when the shards of `epoch` are merged: those of earlier epochs serve checks.
    pub fn first_field_kept(&self, epoch: u32) -> u32 {
        self.field_epoch(epoch.saturating_sub(CHECKED_EPOCHS))
    }

    /// The first shard that can still be checked while those of `epoch` are issued: the radii of earlier ones may go before a check of
    /// theirs is done.
    pub fn first_checkable(&self, epoch: u32) -> u64 {
        match self.radius_rule {
            RadiusRule::Statistics | RadiusRule::Uniformity => {
                self.epoch_start(epoch.saturating_sub(CHECKED_EPOCHS - 1))
            }
            _ => 0,
        }
    }

    /// Shards that must be merged before every region has a pass.
    pub fn shards_until_covered(&self) -> u64 {
        let per_region = u64::from(self.passes.min(self.shards_per_epoch));
        (self.regions.len() as u64 - 1) * per_region + 1
    }

    /// The first shard from `end` on at which a job can end so that no pass is missing before its last one.
    pub fn end_without_gap(&self, end: u64) -> u64 {
        let is_half_a_pair = |planned: PlannedShard| planned.shard.twin() == Twin::Even && planned.shard.passes > 1;
        let last = end.checked_sub(1).and_then(|last| self.shard(last));
        if last.is_some_and(is_half_a_pair) { end + 1 } else { end }
    }

    /// How many shards from the first one on are the same in every longer job of this kind: only the state after so many of them can
    /// be continued to more passes.
    pub fn shards_of_longer_jobs(&self) -> u64 {
        let longer = self.with_passes(None);
        let (last_epoch, _) = self.last_epoch();
        (self.epoch_start(last_epoch)..self.shard_count())
            .find(|index| self.shard(*index) != longer.shard(*index))
            .unwrap_or_else(|| self.shard_count())
    }

    /// Passes at which a job can end that has merged `shards` of a longer one: those of the last pair of them, both halves.
    pub fn passes_after(&self, shards: u64) -> u32 {
        let longer = self.with_passes(None);
        let Some(last) = shards.checked_sub(1).and_then(|last| longer.shard(last)) else { return 1 };
        let pair_start = last.shard.first_pass - u32::from(last.shard.twin() == Twin::Odd);
        pair_start + 2 * last.shard.passes
    }

    /// The same cut with another end.
    pub fn with_passes(&self, passes: Option<u32>) -> Self {
        Self { passes: passes.unwrap_or(PASSES_LIMIT).clamp(1, PASSES_LIMIT), ..self.clone() }
    }

    /// Shards of one region in `epoch`, which starts at pass `start`.
    fn shards_of_region(&self, epoch: u32, start: u64) -> u64 {
        let (left, pair) = (u64::from(self.passes) - start, 2 * u64::from(self.passes_in_shard(epoch)));
        (left / pair * 2 + (left % pair).min(2)).min(u64::from(self.shards_per_epoch))
    }

    fn shards_in_epoch(&self) -> u64 {
        u64::from(self.shards_per_epoch) * self.regions.len() as u64
    }

    /// First pass of `epoch`, wherever the job ends.
    fn first_pass(&self, epoch: u32) -> u64 {
        let growing = self.passes_per_shard.next_power_of_two().ilog2().min(epoch);
        let grown = u64::from(epoch - growing) * u64::from(self.passes_per_shard);
        u64::from(self.shards_per_epoch) * ((1u64 << growing) - 1 + grown)
    }

    /// The epoch with the last pass, and its first pass.
    fn last_epoch(&self) -> (u32, u32) {
        let last_pass = u64::from(self.passes - 1);
        let growing = self.passes_per_shard.next_power_of_two().ilog2();
        let grown_from = self.first_pass(growing);
        let epoch = if last_pass >= grown_from {
            let epoch_passes = u64::from(self.shards_per_epoch) * u64::from(self.passes_per_shard);
            growing + ((last_pass - grown_from) / epoch_passes) as u32
        } else {
            (last_pass / u64::from(self.shards_per_epoch) + 1).ilog2()
        };
        (epoch, self.first_pass(epoch) as u32)
    }
}

/// Equal bands of at most `REGION_PIXELS` pixels, but at least one row each.
fn bands(width: u32, height: u32) -> Vec<Region> {
    let pixels = u64::from(width) * u64::from(height);
    let count = pixels.div_ceil(REGION_PIXELS).clamp(1, u64::from(height.max(1)));
    let edge = |index: u64| (u64::from(height) * index / count) as u32;
    (0..count).map(|index| Region { row_start: edge(index), row_end: edge(index + 1) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every region gets passes 0, 1, 2, … without gap or repetition, in epochs of the stated size.
    #[test]
    fn shards_cover_all_passes_in_order() {
        for (height, cost, passes) in [(64, 1, 1), (64, 150_000, 1000), (9000, 3_000_000, 77), (64, 330_000, 4097)] {
            let plan = Plan::new(2048, height, cost, Some(passes), RadiusRule::Statistics);
            let mut next = vec![[0, 1]; plan.regions.len()];
            for index in 0..plan.shard_count() {
                let planned = plan.shard(index).expect("inside the plan");
                let next = &mut next[planned.region as usize][planned.shard.twin() as usize];
                assert_eq!(planned.shard.first_pass, *next, "{plan:?} shard {index}");
                *next += 2 * planned.shard.passes;
            }
            let ends = [passes.next_multiple_of(2), passes / 2 * 2 + 1];
            assert!(next.iter().all(|next| *next == ends), "{plan:?}");
            assert_eq!(plan.shard(plan.shard_count()), None);
        }
    }

    /// A job of n passes starts with the shards of a longer one.
    #[test]
    fn the_cut_does_not_depend_on_the_end() {
        let long = Plan::new(64, 64, 100_000, None, RadiusRule::Statistics);
        let end = long.shard(40).expect("a long job").shard.first_pass;
        let short = Plan::new(64, 64, 100_000, Some(end), RadiusRule::Statistics);
        assert_eq!(short.shard_count(), 40);
        assert!((0..40).all(|index| short.shard(index) == long.shard(index)));
    }

    /// However many passes a user asks for, a shard costs no more than ten minutes, and at least one pass is made.
    #[test]
    fn asked_for_cuts_are_bounded_by_cost() {
        let passes = |cost| {
            let cut = Cut { passes_per_shard: Some(1000), shards_per_epoch: None };
            Plan::new(64, 64, cost, None, RadiusRule::Statistics).with_cut(cut).passes_per_shard
        };
        assert_eq!([1, 3_000_000, u64::MAX / 2].map(passes), [1000, 200, 1]);
    }

    /// Shards that are cut short by a job's end are no shards of a longer one, and neither is what follows them.
    #[test]
    fn what_a_longer_job_shares_ends_at_the_first_shard_that_is_cut_short() {
        for (height, cost) in [(64, 30_000), (64, 1), (9000, 1_000_000)] {
            let endless = Plan::new(2048, height, cost, None, RadiusRule::Statistics);
            for passes in 1..200 {
                let short = Plan::new(2048, height, cost, Some(passes), RadiusRule::Statistics);
                let shared = short.shards_of_longer_jobs();
                assert!((0..shared).all(|index| short.shard(index) == endless.shard(index)), "{short:?}");
                let is_cut = shared == short.shard_count() || short.shard(shared) != endless.shard(shared);
                assert!(is_cut, "{short:?}: {shared}");
                assert_eq!(short.with_passes(None), endless);
            }
        }
    }
}
