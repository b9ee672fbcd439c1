//! `fetch`: the picture so far of a job, or those of a sequence, into files.

use clap::Args;

use super::client::{Client, CoordinatorOption};
use super::exit_code::CliError;
use super::frames::is_sequence;
use super::outputs::OutputOptions;
use super::preview::PreviewOptions;
use super::terminal;

/// Write a job's picture so far to files, or those of all frames of a sequence.
///
/// The number of a frame goes into the files' names, as NAME.0001.exr.
#[derive(Clone, Debug, Args)]
pub(super) struct Fetch {
    /// The id of the job or sequence.
    id: String,
    #[command(flatten)]
    output: OutputOptions,
    #[command(flatten)]
    preview: PreviewOptions,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Fetch {
    pub(super) async fn run(mut self) -> Result<(), CliError> {
        if self.output.outputs.is_empty() {
            self.output.outputs = vec![format!("{}.exr", self.id).into(), format!("{}.png", self.id).into()];
        }
        self.output.check()?;
        self.preview.check(is_sequence(&self.id))?;
        let client = self.coordinator.client()?;
        if is_sequence(&self.id) {
            return self.fetch_frames(&client).await;
        }
        let job = client.job(&self.id).await?;
        if self.output.write(&client, &job).await? {
            return Ok(());
        }
        Err(CliError::Failed(format!("job {} has no picture yet; fetch it again in a moment", self.id)))
    }

    async fn fetch_frames(&self, client: &Client) -> Result<(), CliError> {
        let sequence = client.sequence(&self.id).await?;
        self.preview.check_apart(&self.output.outputs, sequence.jobs.iter().map(|frame| frame.frame))?;
        let (mut preview, mut written) = (Vec::new(), 0);
        for frame in &sequence.jobs {
            let job = client.job(&frame.job).await?;
            written += u32::from(self.output.of_frame(frame.frame).write(client, &job).await?);
            if self.preview.is_wanted() {
                preview.extend(client.image(&job.id, &self.output.preview_image()).await?.bytes());
            }
        }
        if written == 0 {
            let text = format!("sequence {} has no picture yet; fetch it again in a moment", self.id);
            return Err(CliError::Failed(text));
        }
        if written < sequence.frames_total {
            terminal::note(&format!("only {written} of {} frames have a picture so far", sequence.frames_total));
        }
        self.preview.write(&preview)
    }
}
