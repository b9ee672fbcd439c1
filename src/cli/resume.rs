//! `resume`: lets a paused job go on.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;

/// Let a paused job go on.
///
/// Also one that paused because the disk was full, or because workers were lost over it.
#[derive(Clone, Debug, Args)]
pub(super) struct Resume {
    /// The job's id.
    id: String,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Resume {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.coordinator.client()?.control(&self.id, "/resume").await.map(drop)
    }
}
