//! `watch`: the progress of a job or a sequence until it ends.

use std::time::Duration;

use clap::Args;
use serde::Serialize;

use super::client::{Client, CoordinatorOption};
use super::exit_code::CliError;
use super::frames::is_sequence;
use super::progress::Progress;
use super::signals;
use super::terminal;
use super::tev::TevOption;
use crate::farm::job::{JobState, JobStatus};
use crate::farm::sequence::{SequenceState, SequenceStatus};

/// The pause between two looks at a sequence.
const LOOK: Duration = Duration::from_secs(1);

/// Follow a job or a sequence until it ends.
///
/// The exit code is 0 when it is done, 1 when it failed or was cancelled.
#[derive(Clone, Debug, Args)]
pub(super) struct Watch {
    /// The id of the job or sequence.
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
        if is_sequence(&self.id) {
            return self.watch_sequence(&client).await;
        }
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

    async fn watch_sequence(&self, client: &Client) -> Result<(), CliError> {
        self.tev.refuse_for_sequences()?;
        let mut progress = Progress::new();
        let status = tokio::select! {
            status = self.follow_sequence(client, &mut progress) => status?,
            interrupted = signals::interrupted() => return interrupted.and(Err(CliError::Interrupted)),
        };
        progress.finish();
        if !self.json {
            let (state, done, total) = (status.state.name(), status.frames_done, status.frames_total);
            terminal::note(&format!("{state}: {done} of {total} frames"));
        }
        match status.state {
            SequenceState::Failed => Err(CliError::Failed(status.error.unwrap_or_else(|| "a frame failed".to_owned()))),
            SequenceState::Cancelled => Err(CliError::Failed(format!("sequence {} was cancelled", status.id))),
            _ => Ok(()),
        }
    }

    /// Shows how a sequence goes until it ends.
    async fn follow_sequence(&self, client: &Client, progress: &mut Progress) -> Result<SequenceStatus, CliError> {
        let mut last = None;
        loop {
            let status = client.sequence(&self.id).await?;
            if !self.json {
                progress.show_sequence(&status);
            } else if last.as_ref() != Some(&status) {
                print_line(&status);
            }
            if !status.state.is_live() {
                return Ok(status);
            }
            last = Some(status);
            tokio::time::sleep(LOOK).await;
        }
    }
}

fn print_line(status: &impl Serialize) {
    let line = serde_json::to_string(status).map_err(CliError::failed).and_then(|line| terminal::result(&line));
    if let Err(problem) = line {
        terminal::note(&problem.to_string());
    }
}
