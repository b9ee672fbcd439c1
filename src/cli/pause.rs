//! `pause`: stops issuing work of a job.

use clap::Args;

use super::exit_code::CliError;
use super::one_job::OneJob;

/// Stop issuing work of a job or a sequence.
///
/// What is being traced is still merged. `resume` lets it go on.
#[derive(Clone, Debug, Args)]
pub(super) struct Pause {
    #[command(flatten)]
    job: OneJob,
}

impl Pause {
    pub(super) async fn run(self) -> Result<(), CliError> {
        self.job.control("/pause").await
    }
}
