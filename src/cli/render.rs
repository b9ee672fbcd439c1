//! `render`: a scene on this machine, by a coordinator and workers in this process.

mod sequence;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::client::Client;
use super::exit_code::CliError;
use super::farm_options::{farm_with_api, threads_per_worker};
use super::frames::FrameOptions;
use super::job_options::JobOptions;
use super::outputs::{OutputOptions, default_outputs};
use super::preview::PreviewOptions;
use super::progress::{Progress, acceptance, passes_of, rate};
use super::scene_input::picture_name;
use super::tev::{TevOption, TevViewer};
use super::{signals, terminal, weight_maps};
use crate::evaluation::{ProcessStopwatch, TimeShares, on_threads, time_shares};
use crate::farm::job::{JobState, JobStatus};
use crate::import::{UNNAMED, load_bytes};
use crate::method::MethodChoice;
use crate::scene::Scene;

/// Render a scene on this machine.
///
/// Without -o the picture goes to NAME.exr and NAME.png in the current folder, NAME being the scene file's, or its
/// folder's where the file is called scene. Ctrl-C stops, writes the picture so far, and gives exit code 130.
#[derive(Clone, Debug, Args)]
pub(super) struct Render {
    #[command(flatten)]
    job: JobOptions,
    #[command(flatten)]
    output: OutputOptions,
    #[command(flatten)]
    frames: FrameOptions,
    #[command(flatten)]
    preview: PreviewOptions,
    #[command(flatten)]
    tev: TevOption,
    /// Also render how the method weighs its strategies: weights per pixel as layers of this file, and a sheet of them beside
    /// it as .png. Each strategy is a job of as many passes as the picture: of --length N, or else those of 2 to 4 segments.
    #[arg(long, value_name = "FILE.exr", conflicts_with = "frames")]
    weight_maps: Option<PathBuf>,
    /// Also tell what a pass spends its processor time on: tracing, density estimates, multiple importance weights. Takes a few
    /// seconds more.
    #[arg(long, conflicts_with = "frames")]
    time_shares: bool,
    /// Workers to start; the picture does not depend on it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    workers: u16,
    /// Threads per worker [default: processors / workers]; the picture does not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Render {
    pub(super) async fn run(mut self) -> Result<(), CliError> {
        if self.output.outputs.is_empty() {
            self.output.outputs = default_outputs(&self.job.scene);
        }
        self.output.check()?;
        if self.job.light_groups {
            self.output.check_light_groups()?;
        }
        self.weight_maps.as_deref().map(weight_maps::check).transpose()?;
        self.preview.check(self.frames.frames(&self.job.options)?.is_some())?;
        let scene = self.job.options.pack(&self.job.scene)?;
        let frames = self.frames.of(&scene, &self.job.options)?;
        let workers = usize::from(self.workers);
        let threads = threads_per_worker(self.threads.map(usize::from), workers);
        let mut farm = farm_with_api(workers, threads).start().await?;
        let client = Client::new(&farm.url(), None, None)?;
        let rendered = async {
            match frames {
                Some(frames) => self.render_sequence(&client, scene, &frames, workers * threads).await,
                None => self.render(&client, scene, workers * threads).await,
            }
        };
        let result = tokio::select! {
            result = rendered => result,
            failure = farm.failure() => Err(failure.into()),
        };
        farm.stop().await;
        result
    }

    async fn render(&self, client: &Client, scene: Vec<u8>, threads: usize) -> Result<(), CliError> {
        let kept = self.time_shares.then(|| scene.clone());
        let job = tokio::select! {
            job = self.job.send(client, scene) => job?,
            interrupted = signals::interrupted() => return interrupted.and(Err(CliError::Interrupted)),
        };
        let strategies = self.weight_maps.as_ref().map(|_| weight_maps::strategies(&job)).transpose()?;
        let progress = Progress::new();
        let name = picture_name(&self.job.scene).to_string_lossy().into_owned();
        let viewer = self.tev.show(client, &job.id, name, &self.output.layers);
        let (status, interrupted) = follow_shown(client, &job.id, progress, viewer).await?;
        if status.state == JobState::Failed {
            let error = CliError::Failed(status.error.unwrap_or_else(|| "the job failed".to_owned()));
            return Err(error.about(&self.job.scene));
        }
        let written = self.output.write(client, &status).await?;
        terminal::note(&rates(&status, threads));
        if let Some(scene) = kept.filter(|_| !interrupted) {
            terminal::note(&time_shares_of(&status, &scene, threads)?);
        }
        match (interrupted, written) {
            (true, true) => Err(CliError::Interrupted),
            (true, false) => {
                terminal::note("nothing was rendered yet: no picture is written");
                Err(CliError::Interrupted)
            }
            (false, true) => match self.weight_maps.as_deref().zip(strategies) {
                Some((file, strategies)) => weight_maps::write(client, &status, &strategies, file).await,
                None => Ok(()),
            },
            (false, false) => Err(CliError::Failed("the job ended without a picture; give it more time".to_owned())),
        }
    }
}

/// One line on what a pass of the job spends its time on.
fn time_shares_of(job: &JobStatus, scene: &[u8], threads: usize) -> Result<String, CliError> {
    let scene = Arc::new(Scene::prepare(&load_bytes(UNNAMED, scene, &[])?)?);
    let choice = MethodChoice { name: job.method.clone(), parameters: job.parameters.clone() };
    let measure = || time_shares(&scene, &choice, job.seed, &mut ProcessStopwatch::start()?);
    let TimeShares { pass, density_estimates, weights } =
        on_threads(threads, measure).and_then(|shares| shares).map_err(CliError::failed)?;
    let mut text = format!("a pass takes {pass:.3} processor-seconds");
    let shares = [("density estimates with their weights", density_estimates), ("weights", weights)];
    for (what, share) in shares {
        text += &share.map_or(String::new(), |share| format!(", {what} {:.0} %", 100.0 * share));
    }
    Ok(text)
}

/// Shows how a job goes until it ends. Its last status, and whether the user stopped it.
async fn follow_shown(
    client: &Client,
    id: &str,
    mut progress: Progress,
    viewer: TevViewer,
) -> Result<(JobStatus, bool), CliError> {
    let show = |status: &JobStatus| {
        progress.show(status);
        viewer.update(status);
    };
    let (status, interrupted) = follow_or_cancel(client, id, show).await?;
    progress.finish();
    viewer.update(&status);
    viewer.finish().await?;
    Ok((status, interrupted))
}

/// The job's last status, and whether the user stopped it.
pub(super) async fn follow_or_cancel(
    client: &Client,
    id: &str,
    show: impl FnMut(&JobStatus),
) -> Result<(JobStatus, bool), CliError> {
    tokio::select! {
        status = client.follow(id, show) => return Ok((status?, false)),
        interrupted = signals::interrupted() => interrupted?,
    }
    signals::end_on_next_interrupt();
    client.control(id, "/cancel").await?;
    Ok((client.follow(id, |_| ()).await?, true))
}

fn rates(status: &JobStatus, threads: usize) -> String {
    let photons = match status.photons_emitted {
        0 => String::new(),
        photons => format!(", {photons} photons"),
    };
    let of_threads = if threads == 1 { "thread" } else { "threads" };
    format!(
        "{}{photons}, {}, {:.1} s, {threads} {of_threads}{}",
        passes_of(status.passes_done),
        rate(status),
        status.seconds,
        acceptance(status),
    )
}
