//! `jobs`: a coordinator's jobs.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::terminal;
use crate::farm::job::JobStatus;

/// List a coordinator's jobs.
///
/// Oldest first: id, state, passes, seconds, method, name, separated by tabs.
#[derive(Clone, Debug, Args)]
pub(super) struct Jobs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Jobs {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let jobs = self.coordinator.client()?.jobs().await?;
        if self.json {
            return terminal::json(&jobs);
        }
        for job in jobs {
            terminal::result(&line(&job))?;
        }
        Ok(())
    }
}

fn line(job: &JobStatus) -> String {
    let state = job.state.name();
    let total = job.passes_total.map(|total| format!("/{total}")).unwrap_or_default();
    let name = job.name.as_deref().unwrap_or("-");
    format!("{}\t{state}\t{}{total}\t{:.1}\t{}\t{name}", job.id, job.passes_done, job.seconds, job.method)
}
