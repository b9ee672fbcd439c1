//! `render --frames`: a sequence, picture by picture.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{Render, follow_shown, rates};
use crate::cli::client::Client;
use crate::cli::exit_code::CliError;
use crate::cli::frames::Frame;
use crate::cli::progress::Progress;
use crate::cli::scene_input::picture_name;
use crate::cli::{signals, terminal};
use crate::estimate::picture_files::{check_writable, encode_animated_png, write_file};
use crate::farm::job::{JobState, JobStatus};

/// How the frames of a sequence are shown together.
#[derive(Clone, Debug, Args)]
pub(super) struct PreviewOptions {
    /// With --frames: also write all frames as one animated PNG, which browsers play.
    #[arg(long, value_name = "FILE.png", requires = "frames")]
    preview: Option<PathBuf>,
    /// Frames per second of that.
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u16).range(1..=1000), requires = "preview")]
    frame_rate: u16,
}

impl PreviewOptions {
    /// Refuses a file that is no PNG or cannot be written.
    pub(super) fn check(&self) -> Result<(), CliError> {
        let Some(file) = &self.preview else { return Ok(()) };
        if file.extension().is_none_or(|extension| extension != "png") {
            return Err(CliError::Usage(format!("--preview \"{}\" is no PNG; end its name in .png", file.display())));
        }
        Ok(check_writable(file)?)
    }

    fn write(&self, file: &Path, frames: &[Vec<u8>]) -> Result<(), CliError> {
        write_file(file, &encode_animated_png(frames, self.frame_rate)?)?;
        terminal::note(&format!("wrote {}", file.display()));
        Ok(())
    }
}

impl Render {
    /// Renders frame after frame: of each only its picture stays.
    pub(super) async fn render_sequence(
        &self,
        client: &Client,
        scene: Vec<u8>,
        frames: &[Frame],
        threads: usize,
    ) -> Result<(), CliError> {
        let base = self.job.upload(client, scene).await?;
        let (mut told, mut preview) = (HashSet::new(), Vec::new());
        for (index, frame) in frames.iter().enumerate() {
            let job = tokio::select! {
                job = self.job.submit(client, &base, Some(frame)) => job?,
                interrupted = signals::interrupted() => return interrupted.and(Err(CliError::Interrupted)),
            };
            self.job.tell_notices(&job, &mut told);
            let heading = format!("frame {}, {} of {}", frame.number, index + 1, frames.len());
            let (status, interrupted) = self.render_frame(client, &job, frame, &heading, threads).await?;
            if interrupted {
                return Err(CliError::Interrupted);
            }
            if self.preview.preview.is_some() {
                let fetched = client.image(&status.id, &self.output.preview_image()).await?;
                preview.extend(fetched.bytes());
            }
            client.delete_job(&status.id).await?;
            if status.scene != base {
                client.delete_scene(&status.scene).await?;
            }
        }
        match &self.preview.preview {
            Some(file) => self.preview.write(file, &preview),
            None => Ok(()),
        }
    }

    /// Waits for a frame's picture and writes it. Tells the job's end, and whether the user stopped it.
    async fn render_frame(
        &self,
        client: &Client,
        job: &JobStatus,
        frame: &Frame,
        heading: &str,
        threads: usize,
    ) -> Result<(JobStatus, bool), CliError> {
        let mut progress = Progress::new();
        progress.announce(heading);
        let name = frame.name(&picture_name(&self.job.scene).to_string_lossy());
        let viewer = self.tev.show(client, &job.id, name, &self.output.layers);
        let (status, interrupted) = follow_shown(client, &job.id, progress, viewer).await?;
        if status.state == JobState::Failed {
            let error = status.error.unwrap_or_else(|| "the job failed".to_owned());
            return Err(CliError::Failed(format!("{heading}: {error}")).about(&self.job.scene));
        }
        if !self.output.of_frame(frame).write(client, &status).await? && !interrupted {
            return Err(CliError::Failed(format!("{heading} ended without a picture; give it more time")));
        }
        terminal::note(&rates(&status, threads));
        Ok((status, interrupted))
    }
}
