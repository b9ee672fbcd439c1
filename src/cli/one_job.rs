//! A job or a sequence of a coordinator, and what is said of it after something was done to it.

use clap::Args;
use serde::Serialize;

use super::client::{Client, CoordinatorOption};
use super::exit_code::CliError;
use super::frames::is_sequence;
use super::terminal;

/// A job of a coordinator.
#[derive(Clone, Debug, Args)]
pub(super) struct OneJob {
    /// The id of the job; cancel, pause and resume take that of a sequence, too.
    pub(super) id: String,
    /// Print the job's status afterwards as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl OneJob {
    pub(super) fn client(&self) -> Result<Client, CliError> {
        self.coordinator.client()
    }

    /// Does something to it that needs no more than its name (`/cancel`, `/pause`, `/resume`).
    pub(super) async fn control(&self, what: &str) -> Result<(), CliError> {
        let client = self.client()?;
        if is_sequence(&self.id) {
            return self.answer(&client.control_sequence(&self.id, what).await?);
        }
        self.answer(&client.control(&self.id, what).await?)
    }

    /// Says what became of it, where that is wanted.
    pub(super) fn answer(&self, status: &impl Serialize) -> Result<(), CliError> {
        if self.json { terminal::json(status) } else { Ok(()) }
    }
}
