//! `submit`: sends a scene and prints the job's id.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::job_options::JobOptions;
use super::terminal;

/// Send a scene to a coordinator; prints the job's id.
///
/// Nothing else goes to standard output.
#[derive(Clone, Debug, Args)]
pub(super) struct Submit {
    #[command(flatten)]
    job: JobOptions,
    /// Print the job's status as JSON instead.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Submit {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let client = self.coordinator.client()?;
        let job = self.job.send(&client, self.job.options.pack(&self.job.scene)?).await?;
        if self.json { terminal::json(&job) } else { terminal::result(&job.id) }
    }
}
