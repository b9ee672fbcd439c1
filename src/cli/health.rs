//! `health`: whether a coordinator answers, for containers and scripts.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;

/// Ask whether a coordinator is well.
///
/// The exit code is 0 when it answers, or, with --ready, when it takes jobs; nothing is printed then. No token is needed.
#[derive(Clone, Debug, Args)]
pub(super) struct Health {
    /// Ask whether it takes jobs, not only whether it lives.
    #[arg(long)]
    ready: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Health {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.coordinator.client()?.check(if self.ready { "/readyz" } else { "/healthz" }).await
    }
}
