//! `clone`: a job once more, with some differences.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::job_options::{parameters, priority, setting};
use super::stop_options::StopOptions;
use super::terminal;
use crate::api::job_control::CloneRequest;
use crate::farm::job::Priority;

/// Submit a copy of a job; prints its id.
///
/// What is not given is as in the original.
#[derive(Clone, Debug, Args)]
pub(super) struct CloneJob {
    /// The original's id.
    id: String,
    /// Method; the original's parameters are left behind when it is another one.
    #[arg(long)]
    method: Option<String>,
    /// Method parameter: a JSON value, or else text. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    settings: Vec<(String, serde_json::Value)>,
    #[command(flatten)]
    stop: StopOptions,
    /// Seed of all random numbers.
    #[arg(long)]
    seed: Option<u64>,
    /// What people call it.
    #[arg(long)]
    name: Option<String>,
    /// Word to find it by, in place of all that the original has. May be repeated.
    #[arg(long = "tag", value_name = "WORD")]
    tags: Option<Vec<String>>,
    /// Its share of the farm beside others, 1 to 1000.
    #[arg(long, value_parser = priority)]
    priority: Option<Priority>,
    /// Print the job's status as JSON instead.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl CloneJob {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let Self { id, method, settings, stop, seed, name, tags, priority, json, coordinator } = self;
        let stop = stop.rule();
        let changes = CloneRequest {
            method,
            parameters: parameters(settings)?,
            stop: (!stop.is_empty()).then_some(stop),
            seed,
            name,
            tags,
            priority,
        };
        let job = coordinator.client()?.clone_job(&id, &changes).await?;
        if json { terminal::json(&job) } else { terminal::result(&job.id) }
    }
}
