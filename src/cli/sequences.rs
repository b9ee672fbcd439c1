//! `sequences`: a coordinator's sequences.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::terminal;
use crate::farm::access::user::UserName;
use crate::farm::sequence::SequenceStatus;

/// List a coordinator's sequences.
///
/// Oldest first: id, state, frames that are done and all, percent of all that is done, owner, name, separated by tabs, on a terminal under a line
/// that says so. `photonfarm jobs --sequence ID` lists the frames of one.
#[derive(Clone, Debug, Args)]
pub(super) struct Sequences {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Sequences {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let sequences = self.coordinator.client()?.sequences().await?;
        if self.json {
            return terminal::json(&sequences);
        }
        terminal::heads(&["ID", "STATE", "FRAMES", "DONE", "OWNER", "NAME"])?;
        for sequence in sequences {
            terminal::result(&line(&sequence))?;
        }
        Ok(())
    }
}

fn line(sequence: &SequenceStatus) -> String {
    let SequenceStatus { id, state, frames_done, frames_total, progress, .. } = sequence;
    let owner = sequence.owner.as_ref().map_or("-", UserName::as_str);
    let (state, percent, name) = (state.name(), 100.0 * progress, sequence.name.as_deref().unwrap_or("-"));
    format!("{id}\t{state}\t{frames_done}/{frames_total}\t{percent:.0} %\t{owner}\t{name}")
}
