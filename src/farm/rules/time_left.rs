//! How long a job will still run.

use std::time::Duration;

use super::job::{Job, RateStart};
use crate::farm::job::JobState;

impl Job {
    /// Estimated seconds left: by passes, by the stop rule's seconds, or the smaller of both. `None` while it does not run.
    pub fn seconds_left(&self, now: Duration) -> Option<f64> {
        if self.has_ended() || self.state == JobState::Paused {
            return None;
        }
        let stop = self.terms.stop;
        let by_seconds = stop.seconds.map(|seconds| (seconds - self.seconds(now)).max(0.0));
        let total = self.plan.as_ref().filter(|_| stop.passes.is_some()).map(|plan| plan.passes);
        let by_passes = total
            .zip(self.seconds_per_merged_pass(now))
            .map(|(total, seconds)| seconds * f64::from(total - self.totals.passes.min(total)));
        match (by_seconds, by_passes) {
            (Some(seconds), Some(passes)) => Some(f64::min(seconds, passes)),
            (left, None) | (None, left) => left,
        }
    }

    fn seconds_per_merged_pass(&self, now: Duration) -> Option<f64> {
        let RateStart { passes, ran } = self.rate_from?;
        let merged = self.totals.passes.checked_sub(passes).filter(|merged| *merged > 0)?;
        Some((self.seconds(now) - ran.as_secs_f64()) / f64::from(merged))
    }
}
