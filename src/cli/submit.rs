//! `submit`: sends a scene and prints the id of its job or sequence.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::frames::FrameOptions;
use super::job_options::JobOptions;
use super::terminal;
use crate::farm::sequence::AtOnce;

/// Send a scene to a coordinator; prints the job's id.
///
/// Nothing else goes to standard output. With --frames it prints the id of a sequence, whose frames are jobs; watch, fetch, pause, resume, cancel
/// and rm take it, too.
#[derive(Clone, Debug, Args)]
pub(super) struct Submit {
    #[command(flatten)]
    job: JobOptions,
    #[command(flatten)]
    frames: FrameOptions,
    /// Frames that are rendered at the same time, 1 to 100 [default: 2].
    #[arg(long, value_name = "N", value_parser = at_once, requires = "frames")]
    frames_at_once: Option<AtOnce>,
    /// Print the status of the job or sequence as JSON instead.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Submit {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let client = self.coordinator.client()?;
        let frames = self.frames.frames(&self.job.options)?;
        let scene = self.job.options.pack(&self.job.scene)?;
        if let Some(frames) = frames {
            let at_once = self.frames_at_once.unwrap_or_default();
            let sequence = self.job.send_sequence(&client, scene, frames, at_once).await?;
            return if self.json { terminal::json(&sequence) } else { terminal::result(&sequence.id) };
        }
        let job = self.job.send(&client, scene).await?;
        if self.json { terminal::json(&job) } else { terminal::result(&job.id) }
    }
}

fn at_once(text: &str) -> Result<AtOnce, String> {
    let number = text.parse::<u8>().ok().and_then(|number| AtOnce::try_from(number).ok());
    number.ok_or_else(|| format!("give a number from 1 to {}", AtOnce::MOST))
}
