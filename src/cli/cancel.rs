//! `cancel`: stops a job and keeps its picture.

use clap::Args;

use super::exit_code::CliError;
use super::one_job::OneJob;

/// Stop a job, or all of a sequence, and keep the picture.
///
/// What that has ended already stays as it is.
#[derive(Clone, Debug, Args)]
pub(super) struct Cancel {
    #[command(flatten)]
    job: OneJob,
}

impl Cancel {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.job.control("/cancel").await
    }
}
