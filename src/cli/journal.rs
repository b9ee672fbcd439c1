//! `journal`: what happened on a farm.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::terminal;
use crate::api::workers::{JournalLine, JournalQuery};

/// Tell what happened on a farm: who joined and left, how jobs went on, who was given access by whom.
///
/// Oldest first: time (UTC), job, worker, what happened, separated by tabs.
#[derive(Clone, Debug, Args)]
pub(super) struct Journal {
    /// Only lines about this job.
    #[arg(long, value_name = "ID")]
    job: Option<String>,
    /// Only lines after the one with this number; `--json` tells the numbers.
    #[arg(long, default_value_t = 0, value_name = "NUMBER")]
    after: i64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Journal {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let client = self.coordinator.client()?;
        let mut query = JournalQuery { after: self.after, job: self.job };
        let mut all = Vec::new();
        // An answer holds a part of the journal only.
        loop {
            let lines = client.journal(&query).await?;
            let Some(last) = lines.last() else { break };
            query.after = last.sequence;
            if self.json {
                all.extend(lines);
            } else {
                lines.iter().try_for_each(|line| terminal::result(&shown(line)))?;
            }
        }
        if self.json { terminal::json(&all) } else { Ok(()) }
    }
}

fn shown(line: &JournalLine) -> String {
    let JournalLine { time, job, worker, text, .. } = line;
    let (job, worker) = (job.as_deref().unwrap_or("-"), worker.as_deref().unwrap_or("-"));
    format!("{}\t{job}\t{worker}\t{text}", terminal::moment(*time))
}
