//! What is done to workers.

use super::shared::Shared;
use crate::farm::access::caller::Caller;
use crate::farm::error::FarmError;
use crate::farm::ids::WorkerId;
use crate::farm::job::WorkerStatus;
use crate::farm::rules::{Answer, Event};

impl Shared {
    /// Gives a worker no further work; it leaves when it has done what it holds.
    pub(super) fn drain_worker(&self, caller: &Caller, id: &str) -> Result<WorkerStatus, FarmError> {
        let unknown = || FarmError::UnknownWorker(id.to_owned());
        let worker = WorkerId::new(id.parse().map_err(|_| unknown())?);
        if self.apply(Event::WorkerDrained { worker }) != Answer::Done {
            return Err(unknown());
        }
        let workers = self.lock().workers(&self.clock, self.options.lease_duration);
        // It may have left at once.
        let status = workers.into_iter().find(|status| status.id == worker.to_string()).ok_or_else(unknown)?;
        self.record_deed(caller, &format!("worker {} was told to leave", status.name));
        Ok(status)
    }
}
