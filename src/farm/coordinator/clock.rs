//! The coordinator's time.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use tokio::time::Instant;

/// Time since start, and what it is called outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    started: Instant,
    started_unix: Duration,
}

impl Clock {
    /// Starts now.
    pub(super) fn start() -> Self {
        let started_unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { started: Instant::now(), started_unix }
    }

    /// Time since start.
    pub(super) fn now(&self) -> Duration {
        self.started.elapsed()
    }

    /// Milliseconds since 1970, now.
    pub(super) fn unix_milliseconds(&self) -> i64 {
        self.unix(self.now()).as_millis() as i64
    }

    /// Time since 1970 at `now`.
    pub(super) fn unix(&self, now: Duration) -> Duration {
        self.started_unix + now
    }
}
