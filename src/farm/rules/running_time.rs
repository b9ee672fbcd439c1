//! How long a job has been running.

use std::time::Duration;

/// Time that adds up while it runs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RunningTime {
    /// Of earlier runs.
    pub(super) before: Duration,
    since: Option<Duration>,
}

impl RunningTime {
    pub(super) fn start(&mut self, now: Duration) {
        self.since.get_or_insert(now);
    }

    pub(super) fn stop(&mut self, now: Duration) {
        self.before = self.total(now);
        self.since = None;
    }

    pub(super) fn total(&self, now: Duration) -> Duration {
        self.before + self.since.map_or(Duration::ZERO, |since| now.saturating_sub(since))
    }
}
