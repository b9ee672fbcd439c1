//! `jobs`: a coordinator's jobs.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::terminal;
use crate::farm::job::JobStatus;

/// List a coordinator's jobs.
///
/// Oldest first: id, state, passes, seconds, method, separated by tabs.
#[derive(Clone, Debug, Args)]
pub(super) struct Jobs {
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Jobs {
    pub(super) async fn run(self) -> Result<(), CliError> {
        for job in self.coordinator.client()?.jobs().await? {
            terminal::result(&line(&job))?;
        }
        Ok(())
    }
}

fn line(job: &JobStatus) -> String {
    let state = job.state.name();
    let total = job.passes_total.map(|total| format!("/{total}")).unwrap_or_default();
    format!("{}\t{state}\t{}{total}\t{:.1}\t{}", job.id, job.passes_done, job.seconds, job.method)
}
