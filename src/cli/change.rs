//! `change`: another name, other tags, another priority.

use clap::Args;

use super::exit_code::CliError;
use super::job_options::priority;
use super::one_job::OneJob;
use crate::api::job_control::JobPatch;
use crate::farm::job::Priority;

/// Change name, tags or priority of a job.
///
/// What is not given stays.
#[derive(Clone, Debug, Args)]
pub(super) struct Change {
    #[command(flatten)]
    job: OneJob,
    /// What people call it; an empty one is none.
    #[arg(long)]
    name: Option<String>,
    /// Word to find it by, in place of all that it has. May be repeated.
    #[arg(long = "tag", value_name = "WORD")]
    tags: Option<Vec<String>>,
    /// Its share of the farm beside others, 1 to 1000.
    #[arg(long, value_parser = priority)]
    priority: Option<Priority>,
}

impl Change {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let Self { job, name, tags, priority } = self;
        job.answer(&job.client()?.change(&job.id, &JobPatch { name, tags, priority }).await?)
    }
}
