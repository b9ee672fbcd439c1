//! `extend`: lets an ended job go on.

use clap::Args;

use super::exit_code::CliError;
use super::one_job::OneJob;
use super::stop_options::StopOptions;

/// Let an ended job go on to a later end.
///
/// It goes on from its stored state; the picture has the bits of the longer job.
#[derive(Clone, Debug, Args)]
pub(super) struct Extend {
    #[command(flatten)]
    job: OneJob,
    #[command(flatten)]
    stop: StopOptions,
}

impl Extend {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.job.answer(&self.job.client()?.extend(&self.job.id, &self.stop.rule()).await?)
    }
}
