//! What a shard's pixels add up where light groups are kept apart: sums of each group, which become one tally.

use std::sync::Arc;

use super::declaration::{Declaration, PlaneDeclaration, PlaneRule};
use super::shard::Shard;
use super::shard_sums::ShardSums;
use super::tally::Tally;

/// The sums of a shard's pixels of the light of one group.
#[derive(Clone, Debug)]
pub struct GroupSums {
    /// The group's name.
    pub group: String,
    /// What its light adds up to.
    pub sums: ShardSums,
    /// Photons that its lights emitted.
    pub photons_emitted: u64,
}

impl GroupSums {
    /// What its photons' flux is multiplied with, where means are over the photons of all groups.
    fn flux_scale(&self, photons_emitted: u64) -> f32 {
        if self.photons_emitted == 0 { 1.0 } else { (photons_emitted as f64 / self.photons_emitted as f64) as f32 }
    }

    /// A declared plane of the group, or its part of a plane of all groups.
    fn plane(&self, declared: &PlaneDeclaration, photons_emitted: u64) -> Option<Vec<f32>> {
        let scale = match declared.rule {
            PlaneRule::FluxOverRadius => self.flux_scale(photons_emitted),
            PlaneRule::SquaredFluxOverRadius => self.flux_scale(photons_emitted).powi(2),
            PlaneRule::Sum | PlaneRule::Count | PlaneRule::Ratio { .. } => 1.0,
        };
        let mut plane = self.sums.plane(declared)?;
        plane.iter_mut().for_each(|value| *value *= scale);
        Some(plane)
    }
}

impl Tally {
    /// The declared planes of what light groups add up: planes of a group hold its light alone, all others the sum over groups. Every
    /// photon counts as one of the photons of all groups.
    pub fn from_groups(shard: Shard, width: u32, declaration: &Arc<Declaration>, groups: &[GroupSums]) -> Self {
        let photons_emitted = groups.iter().map(|group| group.photons_emitted).sum();
        let mut tally = Self::zero(shard, width, declaration);
        for (declared, sum) in declaration.planes.iter().zip(&mut tally.planes) {
            let is_part = |group: &&GroupSums| declared.light_group.as_ref().is_none_or(|name| *name == group.group);
            for plane in groups.iter().filter(is_part).filter_map(|group| group.plane(declared, photons_emitted)) {
                sum.iter_mut().zip(plane).for_each(|(sum, value)| *sum += value);
            }
        }
        tally
    }
}
