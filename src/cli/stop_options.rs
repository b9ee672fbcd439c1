//! When a job stops, as the command line says it.

use clap::Args;

use crate::farm::job::StopRule;

/// When a job stops; by several, whatever comes first.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct StopOptions {
    /// Stop after this many passes in all.
    #[arg(long)]
    passes: Option<u32>,
    /// Stop after this many seconds in all.
    #[arg(long)]
    seconds: Option<f64>,
    /// Stop when the picture's relMSE is below this, as the job itself estimates with 95 % confidence.
    #[arg(long, value_name = "RELMSE")]
    error: Option<f64>,
}

impl StopOptions {
    pub(super) fn rule(self) -> StopRule {
        StopRule { passes: self.passes, seconds: self.seconds, error: self.error }
    }
}
