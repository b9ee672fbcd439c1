//! `render --frames`: a sequence, picture by picture.

use std::collections::HashSet;

use super::{Render, follow_shown, rates};
use crate::cli::client::Client;
use crate::cli::exit_code::CliError;
use crate::cli::progress::Progress;
use crate::cli::scene_input::picture_name;
use crate::cli::{signals, terminal};
use crate::farm::job::{JobState, JobStatus};
use crate::farm::sequence::{Frame, numbered};

impl Render {
    /// Renders frame after frame: of each only its picture stays.
    pub(super) async fn render_sequence(
        &self,
        client: &Client,
        scene: Vec<u8>,
        frames: &[Frame],
        threads: usize,
    ) -> Result<(), CliError> {
        self.preview.check_apart(&self.output.outputs, frames.iter().map(|frame| frame.number))?;
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
            if self.preview.is_wanted() {
                let fetched = client.image(&status.id, &self.output.preview_image()).await?;
                preview.extend(fetched.bytes());
            }
            client.delete_job(&status.id).await?;
            if status.scene != base {
                client.delete_scene(&status.scene).await?;
            }
        }
        self.preview.write(&preview)
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
        let name = numbered(&picture_name(&self.job.scene).to_string_lossy(), frame.number);
        let viewer = self.tev.show(client, &job.id, name, &self.output.layers);
        let (status, interrupted) = follow_shown(client, &job.id, progress, viewer).await?;
        if status.state == JobState::Failed {
            let error = status.error.unwrap_or_else(|| "the job failed".to_owned());
            return Err(CliError::Failed(format!("{heading}: {error}")).about(&self.job.scene));
        }
        if !self.output.of_frame(frame.number).write(client, &status).await? && !interrupted {
            return Err(CliError::Failed(format!("{heading} ended without a picture; give it more time")));
        }
        terminal::note(&rates(&status, threads));
        Ok((status, interrupted))
    }
}
