//! `rm`: deletes a job and its pictures.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;

/// Delete a job and its pictures.
///
/// One that runs is cancelled first.
#[derive(Clone, Debug, Args)]
pub(super) struct Remove {
    /// The job's id.
    id: String,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Remove {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.coordinator.client()?.delete(&self.id).await
    }
}
