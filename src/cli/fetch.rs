//! `fetch`: a job's picture so far, into files.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::outputs::OutputOptions;

/// Write a job's picture so far to files.
#[derive(Clone, Debug, Args)]
pub(super) struct Fetch {
    /// The job's id.
    id: String,
    #[command(flatten)]
    output: OutputOptions,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Fetch {
    pub(super) async fn run(mut self) -> Result<(), CliError> {
        if self.output.outputs.is_empty() {
            self.output.outputs = vec![format!("{}.exr", self.id).into(), format!("{}.png", self.id).into()];
        }
        self.output.check()?;
        let client = self.coordinator.client()?;
        let job = client.job(&self.id).await?;
        if self.output.write(&client, &job).await? {
            return Ok(());
        }
        Err(CliError::Failed(format!("job {} has no picture yet; fetch it again in a moment", self.id)))
    }
}
