//! `cancel`: stops a job and keeps its picture.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;

/// Stop a job and keep its picture.
///
/// A job that has ended already stays as it is.
#[derive(Clone, Debug, Args)]
pub(super) struct Cancel {
    /// The job's id.
    id: String,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Cancel {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.coordinator.client()?.cancel(&self.id).await.map(drop)
    }
}
