//! Trust but verify: a share of shards is traced by a second worker and compared bit for bit; a third one decides a mismatch.

use std::collections::BTreeMap;

use crate::farm::ids::{JobId, WorkerId};

/// Workers that are asked at most about one shard: with three different results nobody is known to be right.
const OPINIONS: usize = 5;

/// A hash of all bits of a tally.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest(pub [u8; 32]);

/// The share of shards that are checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckShare(f64);

impl CheckShare {
    /// `share` of all shards, 0 to 1.
    pub fn new(share: f64) -> Self {
        Self(share.clamp(0.0, 1.0))
    }

    /// Whether shard `index` of `job` is one of them: by chance, but always the same.
    pub fn takes(self, job: JobId, index: u64) -> bool {
        let mut mixed = job.number().wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ index.wrapping_mul(0xd1b5_4a32_d192_ed03);
        mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
        mixed ^= mixed >> 32;
        ((mixed >> 11) as f64) < self.0 * (1u64 << 53) as f64
    }
}

/// What a worker returned for a shard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Opinion {
    worker: WorkerId,
    digest: Digest,
}

/// What a further result tells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The merged result is right.
    Verified,
    /// Two results differ: another worker must be asked.
    Undecided,
    /// These workers returned something else than two others.
    Odd(Vec<WorkerId>),
    /// No two of many workers agree.
    Hopeless,
}

/// The checks of one job. The first opinion of each is the one that was merged.
#[derive(Clone, Debug, Default)]
pub struct Checks {
    pending: BTreeMap<u64, Vec<Opinion>>,
    /// Shards that two workers agree on.
    pub verified: u64,
    /// Shards on which two workers did not agree.
    pub mismatched: u64,
}

impl Checks {
    /// A shard was merged that is to be checked.
    pub fn begin(&mut self, shard: u64, worker: WorkerId, digest: Digest) {
        self.pending.insert(shard, vec![Opinion { worker, digest }]);
    }

    /// A shard that `worker` may trace to check it; none that is in `held`.
    pub fn next_for(&self, worker: WorkerId, is_held: impl Fn(u64) -> bool) -> Option<u64> {
        let others = |opinions: &[Opinion]| opinions.iter().all(|opinion| opinion.worker != worker);
        self.pending.iter().find(|(shard, opinions)| others(opinions) && !is_held(**shard)).map(|(shard, _)| *shard)
    }

    /// Another worker's result for `shard`. `None` when nobody asked.
    pub fn compare(&mut self, shard: u64, worker: WorkerId, digest: Digest) -> Option<Verdict> {
        let opinions = self.pending.get_mut(&shard)?;
        opinions.push(Opinion { worker, digest });
        let votes = |digest: Digest| opinions.iter().filter(|opinion| opinion.digest == digest).count();
        let Some(right) = opinions.iter().map(|opinion| opinion.digest).find(|digest| votes(*digest) >= 2) else {
            self.mismatched += u64::from(opinions.len() == 2);
            if opinions.len() < OPINIONS {
                return Some(Verdict::Undecided);
            }
            self.pending.remove(&shard);
            return Some(Verdict::Hopeless);
        };
        let odd: Vec<WorkerId> =
            opinions.iter().filter(|opinion| opinion.digest != right).map(|opinion| opinion.worker).collect();
        self.pending.remove(&shard);
        self.verified += 1;
        Some(if odd.is_empty() { Verdict::Verified } else { Verdict::Odd(odd) })
    }

    /// Shards below `shard` cannot be traced again: their radii are gone.
    pub fn give_up_below(&mut self, shard: u64) {
        self.pending = self.pending.split_off(&shard);
    }

    /// Whether two workers disagree about a shard and no third has said anything yet.
    pub fn undecided(&self) -> Option<u64> {
        self.pending.iter().find(|(_, opinions)| opinions.len() > 1).map(|(shard, _)| *shard)
    }
}
