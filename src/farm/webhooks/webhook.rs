//! An address that is told, and a message on its way there.

use std::fmt;
use std::time::Duration;

/// An address that is told of jobs.
#[derive(Clone, PartialEq, Eq)]
pub struct Webhook {
    /// What to call it.
    pub id: String,
    /// Where messages are sent.
    pub url: String,
    /// Signs them; 32 bytes.
    pub key: Vec<u8>,
    /// When it was added, milliseconds since 1970.
    pub created: i64,
}

impl fmt::Debug for Webhook {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Webhook({}, {})", self.id, self.url)
    }
}

/// A message that was not taken yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// By what the receiver knows one that comes again.
    pub id: String,
    /// The webhook.
    pub webhook: String,
    /// What is said, as JSON.
    pub body: String,
    /// How often it was sent.
    pub attempt: u32,
    /// When it is sent next, milliseconds since 1970.
    pub due: i64,
}

/// Pauses after attempts that failed: at once, then as Standard Webhooks recommend; about three days in all.
const PAUSES: [u64; 9] = [5, 300, 1_800, 7_200, 18_000, 36_000, 50_400, 72_000, 86_400];

impl Message {
    /// The pause before the next attempt; `None` when it is given up.
    pub fn pause(&self) -> Option<Duration> {
        PAUSES.get(self.attempt as usize).map(|seconds| Duration::from_secs(*seconds))
    }
}
