//! Users who want the same thing come one after the other.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::OwnedMutexGuard;
use tokio::time::timeout;

use crate::farm::error::FarmError;

/// How long a user's request waits for those before it.
const PATIENCE: Duration = Duration::from_secs(15);

/// What is done one after the other.
#[derive(Debug, Default)]
pub(super) struct Turn(Arc<tokio::sync::Mutex<()>>);

impl Turn {
    /// Waits for its turn.
    ///
    /// # Errors
    /// Those before do not end, for example because the store does not answer them.
    pub(super) async fn take(&self) -> Result<OwnedMutexGuard<()>, FarmError> {
        let late = |_| FarmError::Store { problem: "others wait for the store already".to_owned() };
        timeout(PATIENCE, self.0.clone().lock_owned()).await.map_err(late)
    }

    /// The turn, if nobody has it.
    pub(super) fn take_now(&self) -> Option<OwnedMutexGuard<()>> {
        self.0.clone().try_lock_owned().ok()
    }
}
