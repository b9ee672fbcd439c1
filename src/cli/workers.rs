//! `workers`: a coordinator's workers.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::terminal;
use crate::farm::job::WorkerStatus;

/// List a coordinator's workers.
///
/// Number, state, threads, shards done, seconds since it was heard of, name, separated by tabs.
#[derive(Clone, Debug, Args)]
pub(super) struct Workers {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Workers {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let workers = self.coordinator.client()?.workers().await?;
        if self.json {
            return terminal::json(&workers);
        }
        terminal::heads(&["NUMBER", "STATE", "THREADS", "SHARDS", "HEARD", "NAME"])?;
        for worker in workers {
            let WorkerStatus { id, name, state, threads, shards_done, idle_seconds, .. } = &worker;
            terminal::result(&format!("{id}\t{}\t{threads}\t{shards_done}\t{idle_seconds:.1}\t{name}", state.name()))?;
        }
        Ok(())
    }
}
