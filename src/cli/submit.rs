//! `submit`: sends a scene and prints the job's id.

use std::collections::HashSet;

use clap::Args;

use super::client::{Client, CoordinatorOption};
use super::exit_code::CliError;
use super::frames::{Frame, FrameOptions};
use super::job_options::JobOptions;
use super::terminal;
use crate::api::job_control::JobPatch;
use crate::farm::job::JobStatus;

/// Send a scene to a coordinator; prints the job's id.
///
/// Nothing else goes to standard output. With --frames it prints the ids of all frames' jobs, one a line; they share a tag by which `jobs --tag`
/// finds them.
#[derive(Clone, Debug, Args)]
pub(super) struct Submit {
    #[command(flatten)]
    job: JobOptions,
    #[command(flatten)]
    frames: FrameOptions,
    /// Print the job's status as JSON instead.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Submit {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let client = self.coordinator.client()?;
        let scene = self.job.options.pack(&self.job.scene)?;
        if let Some(frames) = self.frames.of(&scene, &self.job.options)? {
            return self.submit_sequence(&client, scene, &frames).await;
        }
        let job = self.job.send(&client, scene).await?;
        if self.json { terminal::json(&job) } else { terminal::result(&job.id) }
    }

    /// Submits all frames of a sequence. The scene goes over the network once: a frame is a change of it.
    async fn submit_sequence(mut self, client: &Client, scene: Vec<u8>, frames: &[Frame]) -> Result<(), CliError> {
        let base = self.job.upload(client, scene).await?;
        let (mut jobs, mut told): (Vec<JobStatus>, _) = (Vec::new(), HashSet::new());
        for frame in frames {
            let mut job = self.job.submit(client, &base, Some(frame)).await?;
            self.job.tell_notices(&job, &mut told);
            if jobs.is_empty() {
                // Nothing but the first job's id tells this sequence from others.
                self.job.tags.push(format!("sequence-{}", job.id));
                job = client
                    .change(&job.id, &JobPatch { tags: Some(self.job.tags.clone()), ..JobPatch::default() })
                    .await?;
            }
            if !self.json {
                terminal::result(&job.id)?;
            }
            jobs.push(job);
        }
        if let (Some(first), Some(tag)) = (jobs.first(), self.job.tags.last()) {
            terminal::note(&format!("{} jobs from {} on have the tag {tag}", jobs.len(), first.id));
        }
        if self.json { terminal::json(&jobs) } else { Ok(()) }
    }
}
