//! Trust but verify: a share of shards is traced by a second worker and compared bit for bit; a third one decides a mismatch.
//!
//! A job waits for its checks before it ends, and before shards are issued that would cost an older check its radii, as long as
//! somebody is there to do them. Workers are told apart by their names: who registers anew does not check itself.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::farm::ids::JobId;

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
#[derive(Clone, Debug, PartialEq, Eq)]
struct Opinion {
    worker: String,
    digest: Digest,
}

/// A shard that was merged and is to be traced again. The first opinion is the one that was merged.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Check {
    opinions: Vec<Opinion>,
    /// When the last opinion came.
    since: Duration,
}

impl Check {
    fn has_heard(&self, worker: &str) -> bool {
        self.opinions.iter().any(|opinion| opinion.worker == worker)
    }
}

/// A check that nobody can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GivenUp {
    /// The shard.
    pub shard: u64,
    /// Whether two workers returned different bits.
    pub is_disputed: bool,
}

/// What a further result tells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The merged result is right.
    Verified,
    /// Two results differ: another worker must be asked.
    Undecided,
    /// These workers returned something else than two others.
    Odd(Vec<String>),
    /// No two of many workers agree.
    Hopeless,
}

/// The checks of one job.
#[derive(Clone, Debug, Default)]
pub struct Checks {
    pending: BTreeMap<u64, Check>,
    /// Shards that two workers agree on.
    pub verified: u64,
    /// Shards on which two workers did not agree.
    pub mismatched: u64,
    /// Shards that were to be checked, but nobody was there to do it.
    pub unchecked: u64,
}

impl Checks {
    /// What was found so far, with nothing left to do.
    pub fn counts(&self) -> Self {
        Self { pending: BTreeMap::new(), ..*self }
    }

    /// A shard was merged at `now` that is to be checked.
    pub fn begin(&mut self, now: Duration, shard: u64, worker: String, digest: Digest) {
        self.pending.insert(shard, Check { opinions: vec![Opinion { worker, digest }], since: now });
    }

    /// A shard that `worker` may trace to check it; none that `is_held`.
    pub fn next_for(&self, worker: &str, is_held: impl Fn(u64) -> bool) -> Option<u64> {
        self.pending
            .iter()
            .find(|(shard, check)| !check.has_heard(worker) && !is_held(**shard))
            .map(|(shard, _)| *shard)
    }

    /// Another worker's result for `shard`. `None` when nobody asked.
    pub fn compare(&mut self, now: Duration, shard: u64, worker: String, digest: Digest) -> Option<Verdict> {
        let check = self.pending.get_mut(&shard)?;
        check.since = now;
        check.opinions.push(Opinion { worker, digest });
        let opinions = &check.opinions;
        let votes = |digest: Digest| opinions.iter().filter(|opinion| opinion.digest == digest).count();
        let Some(right) = opinions.iter().map(|opinion| opinion.digest).find(|digest| votes(*digest) >= 2) else {
            self.mismatched += u64::from(opinions.len() == 2);
            if opinions.len() < OPINIONS {
                return Some(Verdict::Undecided);
            }
            self.pending.remove(&shard);
            return Some(Verdict::Hopeless);
        };
        let odd = opinions.iter().filter(|opinion| opinion.digest != right);
        let odd: Vec<String> = odd.map(|opinion| opinion.worker.clone()).collect();
        self.pending.remove(&shard);
        self.verified += 1;
        Some(if odd.is_empty() { Verdict::Verified } else { Verdict::Odd(odd) })
    }

    /// The first shard whose check is not done.
    pub fn oldest(&self) -> Option<u64> {
        self.pending.keys().next().copied()
    }

    /// From `now` on it is waited anew for all that is not done, because nobody could do it before.
    pub fn wait_anew(&mut self, now: Duration) {
        self.pending.values_mut().for_each(|check| check.since = now);
    }

    /// Gives up what nobody of `workers` can do, and what nobody did for `patience`; answers it.
    pub fn give_up(&mut self, now: Duration, patience: Duration, workers: &[&str]) -> Vec<GivenUp> {
        let is_hopeless = |_: &u64, check: &mut Check| {
            workers.iter().all(|worker| check.has_heard(worker)) || now.saturating_sub(check.since) >= patience
        };
        let given_up = self.pending.extract_if(.., is_hopeless);
        let given_up: Vec<GivenUp> =
            given_up.map(|(shard, check)| GivenUp { shard, is_disputed: check.opinions.len() > 1 }).collect();
        self.unchecked += given_up.len() as u64;
        given_up
    }
}
