//! `resume`: lets a paused job go on.

use clap::Args;

use super::exit_code::CliError;
use super::one_job::OneJob;

/// Let a paused job or sequence go on.
///
/// Also one that paused because the disk was full, or because workers were lost over it.
#[derive(Clone, Debug, Args)]
pub(super) struct Resume {
    #[command(flatten)]
    job: OneJob,
}

impl Resume {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.job.control("/resume").await
    }
}
