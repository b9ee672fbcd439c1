//! `jobs`: a coordinator's jobs.

use std::num::NonZeroU32;

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::named::named;
use super::terminal;
use crate::api::jobs::JobsQuery;
use crate::farm::access::user::UserName;
use crate::farm::job::{JobState, JobStatus};

/// List a coordinator's jobs, all or those that are asked for.
///
/// Oldest first: id, state, passes, seconds, method, owner, name, separated by tabs, on a terminal under a line that says so. The state of a job that waits because no
/// worker is connected ends in "no worker".
#[derive(Clone, Debug, Args)]
pub(super) struct Jobs {
    /// Only jobs in this state.
    #[arg(long, value_parser = named(JobState::ALL, JobState::name))]
    state: Option<JobState>,
    /// Only jobs with this tag.
    #[arg(long, value_name = "WORD")]
    tag: Option<String>,
    /// Only jobs with this name.
    #[arg(long)]
    name: Option<String>,
    /// Only jobs of this user.
    #[arg(long, value_name = "USER")]
    owner: Option<UserName>,
    /// Only the frames of this sequence.
    #[arg(long, value_name = "ID")]
    sequence: Option<String>,
    /// Only jobs that were submitted after the one with this id.
    #[arg(long, value_name = "ID")]
    after: Option<String>,
    /// At most so many.
    #[arg(long, value_name = "COUNT")]
    limit: Option<NonZeroU32>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Jobs {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let Self { state, tag, name, owner, sequence, after, limit, json, coordinator } = self;
        let jobs = coordinator.client()?.jobs(&JobsQuery { state, tag, name, owner, sequence, after, limit }).await?;
        if json {
            return terminal::json(&jobs);
        }
        terminal::heads(&["ID", "STATE", "PASSES", "SECONDS", "METHOD", "OWNER", "NAME"])?;
        for job in jobs {
            terminal::result(&line(&job))?;
        }
        Ok(())
    }
}

/// A job's state, and whether nobody is there to work on it.
fn state(job: &JobStatus) -> String {
    let lacks = if job.waiting_for_workers_since.is_some() { ", no worker" } else { "" };
    format!("{}{lacks}", job.state.name())
}

fn line(job: &JobStatus) -> String {
    let state = state(job);
    let total = job.passes_total.map(|total| format!("/{total}")).unwrap_or_default();
    let name = job.name.as_deref().unwrap_or("-");
    let owner = job.owner.as_ref().map_or("-", UserName::as_str);
    format!("{}\t{state}\t{}{total}\t{:.1}\t{}\t{owner}\t{name}", job.id, job.passes_done, job.seconds, job.method)
}
