//! `workers`: a coordinator's workers.

use clap::{Args, Subcommand};

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::terminal;
use crate::farm::job::WorkerStatus;

/// List a coordinator's workers, or send one away.
///
/// Number, state, threads, shards done, seconds since it was heard of, name, separated by tabs.
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct Workers {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
    #[command(subcommand)]
    task: Option<Task>,
}

#[derive(Clone, Debug, Subcommand)]
enum Task {
    /// Give a worker no further work. It finishes what it holds and leaves: `photonfarm worker` ends.
    Drain {
        /// The worker's number.
        id: String,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
}

impl Workers {
    pub(super) async fn run(self) -> Result<(), CliError> {
        if let Some(Task::Drain { id, coordinator }) = self.task {
            let worker = coordinator.client()?.drain_worker(&id).await?;
            terminal::note(&format!("{} leaves when it has done what it holds", worker.name));
            return Ok(());
        }
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
