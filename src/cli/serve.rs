//! `serve`: a coordinator, with workers of its own if wanted.

use std::time::Duration;

use clap::Args;

use super::exit_code::CliError;
use super::farm_options::{farm_with_api, threads_per_worker};
use super::{signals, terminal};
use crate::farm::LocalFarm;

/// How long shards that are being traced are waited for.
const DRAIN_PATIENCE: Duration = Duration::from_secs(60);

/// Run a coordinator.
///
/// It runs until Ctrl-C or SIGTERM.
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
}

impl Serve {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let workers = usize::from(self.workers);
        let threads = threads_per_worker(self.threads.map(usize::from), workers);
        let mut farm = farm_with_api(workers, threads).listen(&self.listen).start().await?;
        terminal::note(&format!("photonfarm listens at http://{}", farm.address()));
        let result = tokio::select! {
            result = signals::interrupted() => result,
            failure = farm.failure() => Err(failure.into()),
        };
        if result.is_ok() {
            self.drain(&farm).await;
        }
        farm.stop().await;
        result
    }

    /// Waits for what is being traced. A further Ctrl-C ends that at once.
    async fn drain(&self, farm: &LocalFarm) {
        let running: Vec<_> = farm.client().jobs().into_iter().filter(|job| !job.state.is_final()).collect();
        for job in &running {
            terminal::note(&format!("job {} is {} after {} passes", job.id, job.state.name(), job.passes_done));
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
