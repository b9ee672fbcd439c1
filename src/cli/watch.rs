//! `watch`: a job's progress until it ends.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::progress::Progress;
use super::signals;
use super::terminal;
use super::tev::TevOption;
use crate::farm::job::{JobState, JobStatus};

/// Follow a job until it ends.
///
/// The exit code is 0 when it is done, 1 when it failed or was cancelled.
#[derive(Clone, Debug, Args)]
pub(super) struct Watch {
    /// The job's id.
    id: String,
    /// Print every status as a line of JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    tev: TevOption,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Watch {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let client = self.coordinator.client()?;
        let mut progress = Progress::new();
        let viewer = self.tev.show(&client, &self.id, self.id.clone(), &[]);
        let show = |status: &JobStatus| {
            viewer.update(status);
            if self.json { print_line(status) } else { progress.show(status) }
        };
        let status = tokio::select! {
            status = client.follow(&self.id, show) => status?,
            interrupted = signals::interrupted() => return interrupted.and(Err(CliError::Interrupted)),
        };
        if self.json {
            progress.finish()
        } else {
            progress.finish_with(&status)
        }
        viewer.finish().await?;
        match status.state {
            JobState::Failed => Err(CliError::Failed(status.error.unwrap_or_else(|| "the job failed".to_owned()))),
            JobState::Cancelled => Err(CliError::Failed(format!("job {} was cancelled", status.id))),
            _ => Ok(()),
        }
    }
}

fn print_line(status: &JobStatus) {
    let line = serde_json::to_string(status).map_err(CliError::failed).and_then(|line| terminal::result(&line));
    if let Err(problem) = line {
        terminal::note(&problem.to_string());
    }
}
