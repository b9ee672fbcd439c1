//! `extend`: lets an ended job go on.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use crate::farm::job::StopRule;

/// Let an ended job go on to a later end.
///
/// It goes on from its stored state; the picture has the bits of the longer job.
#[derive(Clone, Debug, Args)]
pub(super) struct Extend {
    /// The job's id.
    id: String,
    /// Stop after this many passes in all.
    #[arg(long)]
    passes: Option<u32>,
    /// Stop after this many seconds in all.
    #[arg(long)]
    seconds: Option<f64>,
    /// Stop when the picture's relMSE is below this.
    #[arg(long, value_name = "RELMSE")]
    error: Option<f64>,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Extend {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let stop = StopRule { passes: self.passes, seconds: self.seconds, error: self.error };
        self.coordinator.client()?.extend(&self.id, &stop).await.map(drop)
    }
}
