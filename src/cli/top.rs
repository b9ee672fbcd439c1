//! `top`: a coordinator's jobs and workers, live.

use std::time::Duration;

use clap::Args;
use console::{Term, truncate_str};
use tokio::time::sleep;

use super::client::{Client, CoordinatorOption};
use super::exit_code::CliError;
use super::signals;
use super::terminal;
use crate::api::jobs::JobsQuery;
use crate::farm::job::{JobStatus, WorkerStatus};

/// Lines of jobs and workers where there is no terminal.
const LINES: usize = 1000;

/// Watch a coordinator's jobs and workers, live, until Ctrl-C.
///
/// Where standard output is no terminal, it prints them once.
#[derive(Clone, Debug, Args)]
pub(super) struct Top {
    /// Seconds between two looks.
    #[arg(long, default_value_t = 2.0, value_parser = interval)]
    interval: f64,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Top {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let client = self.coordinator.client()?;
        let screen = Term::stdout();
        if !screen.is_term() {
            return look(&client, LINES).await?.iter().try_for_each(|line| terminal::result(line));
        }
        tokio::select! {
            result = self.repeat(&client, &screen) => result,
            interrupted = signals::interrupted() => interrupted,
        }
    }

    async fn repeat(&self, client: &Client, screen: &Term) -> Result<(), CliError> {
        loop {
            let (height, width) = screen.size();
            let shown = match look(client, usize::from(height).saturating_sub(1)).await {
                // The coordinator may come back.
                Err(CliError::Unreachable(problem)) => vec![problem],
                lines => lines?,
            };
            let lines: Vec<_> = shown.iter().map(|line| truncate_str(line, width.into(), "…")).collect();
            let drawn = screen.clear_screen().and_then(|()| screen.write_line(&lines.join("\n")));
            drawn.map_err(|problem| CliError::File(format!("cannot write to the terminal: {problem}")))?;
            sleep(Duration::from_secs_f64(self.interval)).await;
        }
    }
}

/// Seconds between two looks, by their text.
fn interval(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|seconds: &f64| (0.1..=3600.0).contains(seconds));
    number.ok_or_else(|| "give 0.1 to 3600 seconds".to_owned())
}

/// At most so many lines on how things are: live jobs first, then the workers.
async fn look(client: &Client, most: usize) -> Result<Vec<String>, CliError> {
    let all = JobsQuery::default();
    let (jobs, workers) = tokio::try_join!(client.jobs(&all), client.workers())?;
    let live: Vec<&JobStatus> = jobs.iter().filter(|job| !job.state.is_final()).collect();
    let rate = live.iter().fold(0.0, |rate, job| rate + job.photons_per_second);
    let threads: u32 = workers.iter().map(|worker| worker.threads).sum();
    let mut lines = vec![
        format!(
            "{} live of {} jobs, {} workers with {threads} threads, {:.2} million photons/s",
            live.len(),
            jobs.len(),
            workers.len(),
            rate / 1e6
        ),
        String::new(),
        format!(
            "{:<14} {:<9} {:>16} {:>5} {:>9} {:>7}  {:<8} {}",
            "job", "state", "passes", "done", "error <", "workers", "owner", "name"
        ),
    ];
    // Newest last, so that on a small screen the oldest of those that run are seen.
    lines.extend(live.iter().map(|job| job_line(job)));
    lines.push(String::new());
    lines.push(format!("{:<24} {:<9} {:>7} {:>8} {:>6}", "worker", "state", "threads", "shards", "heard"));
    lines.extend(workers.iter().map(worker_line));
    if lines.len() > most {
        let left_out = lines.len() - most + 1;
        lines.truncate(most.saturating_sub(1));
        lines.push(format!("… and {left_out} further lines"));
    }
    Ok(lines)
}

fn job_line(job: &JobStatus) -> String {
    let total = job.passes_total.map_or_else(|| "∞".to_owned(), |total| total.to_string());
    let passes = format!("{}/{total}", job.passes_done);
    let by_passes = job.passes_total.map_or(0.0, |total| f64::from(job.passes_done) / f64::from(total));
    let by_seconds = job.stop.seconds.map_or(0.0, |seconds| job.seconds / seconds);
    let done = format!("{:.0} %", 100.0 * by_passes.max(by_seconds).min(1.0));
    let bound = job.estimated_error.map_or_else(|| "-".to_owned(), |error| format!("{:.1e}", error.bound));
    let owner = job.owner.as_ref().map_or("-", |owner| owner.as_str());
    let name = job.name.as_deref().unwrap_or("-");
    let (id, state, workers) = (&job.id, job.state.name(), job.workers);
    format!("{id:<14} {state:<9} {passes:>16} {done:>5} {bound:>9} {workers:>7}  {owner:<8} {name}")
}

fn worker_line(worker: &WorkerStatus) -> String {
    let WorkerStatus { name, state, threads, shards_done, idle_seconds, .. } = worker;
    format!("{name:<24} {:<9} {threads:>7} {shards_done:>8} {idle_seconds:>4.0} s", state.name())
}
