//! `serve`: a coordinator, with workers of its own if wanted.

use std::time::Duration;

use clap::Args;

use super::exit_code::CliError;
use super::farm_options::{farm_with_api, threads_per_worker};
use super::store_options::StoreOptions;
use super::{signals, terminal};
use crate::farm::{CoordinatorOptions, LocalFarm};

/// How long shards that are being traced are waited for.
const DRAIN_PATIENCE: Duration = Duration::from_secs(60);
/// Running jobs that are named when the coordinator stops.
const LISTED_JOBS: usize = 10;
/// The longest pause between snapshots, seconds: a day.
const LONGEST_INTERVAL: f64 = 86_400.0;

/// Run a coordinator.
///
/// It keeps scenes, jobs and pictures in a folder, and goes on from there when it is started again. It runs until Ctrl-C or SIGTERM; then it
/// waits for what is being traced.
#[derive(Clone, Debug, Args)]
pub(super) struct Serve {
    /// Address to listen at; port 0 takes any free one.
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
    listen: String,
    /// Workers to start in this process.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    workers: u16,
    /// Threads per worker [default: processors / workers].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    store: StoreOptions,
    /// Memory for the states of running jobs, GiB [default: half of this machine's].
    #[arg(long, value_name = "GIB")]
    memory: Option<f64>,
    /// Share of shards that a second worker traces to compare their bits, 0 to 1.
    #[arg(long, default_value_t = 0.01, value_name = "SHARE")]
    check_share: f64,
    /// Days after which ended jobs are deleted with their pictures, and scenes that no job refers to [default: never].
    #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u16).range(1..))]
    keep_days: Option<u16>,
    /// Name by which browsers, workers and programs may call this coordinator. May be repeated. Addresses, names without dots and names that
    /// end with .local, .internal, .localhost or .home.arpa need not be given.
    #[arg(long = "host-name", value_name = "NAME")]
    host_names: Vec<String>,
    /// Seconds between two snapshots of a job at least.
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS")]
    snapshot_interval: f64,
}

impl Serve {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let workers = usize::from(self.workers);
        let threads = threads_per_worker(self.threads.map(usize::from), workers);
        let options = self.options()?;
        let store = self.store.open().await?;
        match self.store.location()? {
            Some(location) => terminal::note(&format!("data is kept in {}", location.folder.display())),
            None => terminal::note("all is kept in memory and ends with this process"),
        }
        let builder = farm_with_api(workers, threads).listen(&self.listen).options(options).store(store);
        let mut farm = builder.start().await?;
        let live = farm.client().jobs().iter().filter(|job| !job.state.is_final()).count();
        if live > 0 {
            let (jobs, they) = if live == 1 { ("job goes", "it was") } else { ("jobs go", "they were") };
            terminal::note(&format!("{live} {jobs} on from where {they} stored"));
        }
        terminal::note(&format!("photonfarm listens at http://{}", farm.address()));
        let result = tokio::select! {
            result = signals::interrupted() => result,
            failure = farm.failure() => Err(failure.into()),
        };
        if result.is_ok() {
            self.drain(&farm).await;
        }
        let is_durable = self.store.location()?.is_some();
        let left = farm.client().jobs().iter().filter(|job| !job.state.is_final()).count();
        farm.stop().await;
        if is_durable && left > 0 {
            let jobs = if left == 1 {
                "1 job that has not ended is".to_owned()
            } else {
                format!("{left} jobs that have not ended are")
            };
            terminal::note(&format!("{jobs} stored; start `serve` with the same --data to go on"));
        }
        result
    }

    fn options(&self) -> Result<CoordinatorOptions, CliError> {
        let mut options = CoordinatorOptions { check_share: self.check_share, ..CoordinatorOptions::default() };
        if !(0.0..=1.0).contains(&self.check_share) {
            return Err(CliError::BadInput(format!("--check-share is {}; give 0 to 1", self.check_share)));
        }
        if let Some(memory) = self.memory {
            if !(memory.is_finite() && memory > 0.0) {
                return Err(CliError::BadInput(format!("--memory is {memory}; give a number of GiB above 0")));
            }
            options.limits.job_memory = (memory * f64::from(1 << 30)) as u64;
        }
        options.keep_ended = self.keep_days.map(|days| Duration::from_secs(86_400 * u64::from(days)));
        let interval = self.snapshot_interval;
        if !(0.0..=LONGEST_INTERVAL).contains(&interval) {
            let text = format!("--snapshot-interval is {interval}; give 0 to {LONGEST_INTERVAL} seconds");
            return Err(CliError::BadInput(text));
        }
        options.snapshot_interval = Duration::from_secs_f64(interval);
        options.host_names.clone_from(&self.host_names);
        Ok(options)
    }

    /// Waits for what is being traced. A further Ctrl-C ends that at once.
    async fn drain(&self, farm: &LocalFarm) {
        let running: Vec<_> = farm.client().jobs().into_iter().filter(|job| !job.state.is_final()).collect();
        for job in running.iter().take(LISTED_JOBS) {
            terminal::note(&format!("job {} is {} after {} passes", job.id, job.state.name(), job.passes_done));
        }
        if running.len() > LISTED_JOBS {
            terminal::note(&format!("and {} further jobs", running.len() - LISTED_JOBS));
        }
        if farm.client().leases() > 0 {
            terminal::note("waiting for the shards that are being traced; press Ctrl-C again to stop now");
        }
        let now = signals::interrupted();
        tokio::select! {
            () = farm.drain(DRAIN_PATIENCE) => {}
            _ = now => {}
        }
        signals::end_on_next_interrupt();
    }
}
