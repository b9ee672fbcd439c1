//! What `render` and `submit` are told about a job.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use clap::Args;

use super::client::Client;
use super::exit_code::CliError;
use super::scene_file::in_users_file;
use super::scene_input::{picture_name, scene_help};
use super::scene_options::SceneOptions;
use super::stop_options::StopOptions;
use super::terminal;
use crate::api::jobs::JobSubmission;
use crate::api::sequences::SequenceSubmission;
use crate::farm::cut::Cut;
use crate::farm::job::{JobStatus, Priority};
use crate::farm::sequence::{AtOnce, Frame, Frames, SequenceStatus, numbered};

/// A scene and how to render it.
#[derive(Clone, Debug, Args)]
pub(super) struct JobOptions {
    #[arg(help = scene_help())]
    pub(super) scene: PathBuf,
    /// Method, or auto for the one that short trials find to be the fastest; the scene's own integrator when it is not given.
    #[arg(long)]
    method: Option<String>,
    /// Method parameter: a JSON value, or else text. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    settings: Vec<(String, serde_json::Value)>,
    /// Only paths of so many segments; short for --set length=N.
    #[arg(long, value_name = "N")]
    length: Option<u16>,
    /// Only paths of so many light and camera vertices; short for --set strategy=S,T.
    #[arg(long, value_name = "S,T")]
    strategy: Option<String>,
    /// Hints where light comes from, for methods that take `user_paths`: a JSON file with a list of
    /// {"points": [[x, y, z], …], "cones": [degrees]}, from a lamp to a surface that is no mirror.
    #[arg(long, value_name = "FILE")]
    user_paths: Option<PathBuf>,
    #[command(flatten)]
    stop: StopOptions,
    /// Passes of a full-grown shard, 1 to 1024; by default as many as cost one core about a second. Other cuts have other bits.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Cut::MOST_PASSES)))]
    passes_per_shard: Option<u32>,
    /// Shards of a region between two refreshes of the radii, even, 2 to 4096; 16 by default. More let more workers trace one picture.
    #[arg(long, value_name = "N", value_parser = shards_per_epoch)]
    shards_per_epoch: Option<u32>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// What people call the job.
    #[arg(long)]
    name: Option<String>,
    /// Word to find the job by. May be repeated.
    #[arg(long = "tag", value_name = "WORD")]
    pub(super) tags: Vec<String>,
    /// The job's share of the farm beside others, 1 to 1000.
    #[arg(long, default_value = "100", value_parser = priority)]
    priority: Priority,
    /// Keep the light of each light group of the scene apart: EXR files get a layer for each, whose sum is the picture. A pass costs as much as one
    /// for each group.
    #[arg(long)]
    pub(super) light_groups: bool,
    #[command(flatten)]
    pub(super) options: SceneOptions,
}

impl JobOptions {
    /// Uploads the scene and submits the job, and tells its notices. What is said of the scene names the user's file.
    pub(super) async fn send(&self, client: &Client, scene: Vec<u8>) -> Result<JobStatus, CliError> {
        // What is wrong with the other options is told before anything is sent.
        self.submission()?;
        let scene = self.upload(client, scene).await?;
        let job = self.submit(client, &scene, None).await?;
        self.tell_notices(&job, &mut HashSet::new());
        Ok(job)
    }

    /// Uploads the scene, and answers its hash.
    pub(super) async fn upload(&self, client: &Client, scene: Vec<u8>) -> Result<String, CliError> {
        client.upload_scene(scene).await.map_err(|error| error.about(&self.scene))
    }

    /// Submits the job of a scene that was uploaded, or one frame of it.
    pub(super) async fn submit(
        &self,
        client: &Client,
        scene: &str,
        frame: Option<&Frame>,
    ) -> Result<JobStatus, CliError> {
        let mut submission = self.submission()?;
        submission.scene = Some(scene.to_owned());
        if let Some(frame) = frame {
            submission.name = Some(numbered(&self.sequence_name(), frame.number));
            submission.scene_changes = Some(frame.changes.clone());
            submission.seed = submission.seed.wrapping_add(frame.seed);
        }
        client.submit(&submission).await.map_err(|error| error.about(&self.scene))
    }

    /// What the frames of a sequence are called, before their numbers.
    fn sequence_name(&self) -> String {
        self.name.clone().unwrap_or_else(|| picture_name(&self.scene).to_string_lossy().into_owned())
    }

    /// Uploads the scene and submits its frames, and tells the notices of the first one.
    pub(super) async fn send_sequence(
        &self,
        client: &Client,
        scene: Vec<u8>,
        frames: Frames,
        at_once: AtOnce,
    ) -> Result<SequenceStatus, CliError> {
        let mut job = self.submission()?;
        job.scene = Some(self.upload(client, scene).await?);
        job.name = Some(self.sequence_name());
        let submission = SequenceSubmission { job, frames, at_once };
        let sequence = client.submit_sequence(&submission).await.map_err(|error| error.about(&self.scene))?;
        if let Some(first) = sequence.jobs.first() {
            self.tell_notices(&client.job(&first.job).await?, &mut HashSet::new());
        }
        Ok(sequence)
    }

    /// Tells a job's notices, but for those that were told.
    pub(super) fn tell_notices(&self, job: &JobStatus, told: &mut HashSet<String>) {
        for notice in &job.notices {
            if told.insert(notice.clone()) {
                terminal::note(&format!("note: {}", in_users_file(notice, &self.scene)));
            }
        }
    }

    /// The request, without its scene.
    fn submission(&self) -> Result<JobSubmission, CliError> {
        let length = self.length.map(|length| ("length".to_owned(), length.into()));
        let strategy = self.strategy.clone().map(|strategy| ("strategy".to_owned(), strategy.into()));
        let user_paths = self.user_paths.as_deref().map(user_paths).transpose()?;
        Ok(JobSubmission {
            scene: None,
            scene_inline: None,
            scene_changes: None,
            method: self.method.clone(),
            parameters: parameters(self.settings.iter().cloned().chain(length).chain(strategy).chain(user_paths))?,
            stop: self.stop.rule(),
            cut: Cut { passes_per_shard: self.passes_per_shard, shards_per_epoch: self.shards_per_epoch },
            seed: self.seed,
            name: self.name.clone(),
            tags: self.tags.clone(),
            priority: self.priority,
            light_groups: self.light_groups,
        })
    }
}

/// Method parameters by name.
///
/// # Errors
/// One that is given twice.
pub(super) fn parameters(
    settings: impl IntoIterator<Item = (String, serde_json::Value)>,
) -> Result<serde_json::Map<String, serde_json::Value>, CliError> {
    let mut parameters = serde_json::Map::new();
    for (name, value) in settings {
        if parameters.contains_key(&name) {
            return Err(CliError::Usage(format!("method parameter \"{name}\" is given twice; give it once")));
        }
        parameters.insert(name, value);
    }
    Ok(parameters)
}

/// The parameter that a file of paths stands for.
fn user_paths(file: &Path) -> Result<(String, serde_json::Value), CliError> {
    let text = std::fs::read_to_string(file).map_err(|error| CliError::File(format!("{}: {error}", file.display())))?;
    let paths = serde_json::from_str(&text)
        .map_err(|error| CliError::BadInput(format!("{}: it is not JSON: {error}", file.display())))?;
    Ok(("user_paths".to_owned(), paths))
}

/// A method parameter: a name and a JSON value, or else text.
pub(super) fn setting(text: &str) -> Result<(String, serde_json::Value), String> {
    let (key, value) = define(text)?;
    let value = serde_json::from_str(&value).unwrap_or(serde_json::Value::String(value));
    Ok((key, value))
}

/// Shards between two refreshes of the radii: both twins have as many.
fn shards_per_epoch(text: &str) -> Result<u32, String> {
    let number =
        text.parse().ok().filter(|shards: &u32| (2..=Cut::MOST_SHARDS).contains(shards) && shards.is_multiple_of(2));
    number.ok_or_else(|| format!("give an even number from 2 to {}", Cut::MOST_SHARDS))
}

/// A name and a value with `=` between.
pub(super) fn define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.is_empty() => Ok((key.to_owned(), value.to_owned())),
        _ => Err("write a name, =, and a value".to_owned()),
    }
}

/// A job's share of the farm.
pub(super) fn priority(text: &str) -> Result<Priority, String> {
    let number: u16 = text.parse().map_err(|_| "give a number from 1 to 1000".to_owned())?;
    Priority::try_from(number).map_err(|problem| problem.to_string())
}
