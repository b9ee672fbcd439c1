//! `pause`: stops issuing work of a job.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;

/// Stop issuing work of a job.
///
/// What is being traced is still merged. `resume` lets it go on.
#[derive(Clone, Debug, Args)]
pub(super) struct Pause {
    /// The job's id.
    id: String,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Pause {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.coordinator.client()?.control(&self.id, "/pause").await.map(drop)
    }
}
