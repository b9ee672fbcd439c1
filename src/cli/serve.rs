//! `serve`: a coordinator, with workers of its own if wanted.

use clap::Args;

use super::exit_code::CliError;
use super::local_farm::{LocalFarm, threads_per_worker};
use super::{signals, terminal};

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
        let mut farm = LocalFarm::start(&self.listen, workers, threads).await?;
        terminal::note(&format!("photonfarm listens at http://{}", farm.address));
        let result = tokio::select! {
            result = signals::interrupted() => result,
            failure = farm.failure() => Err(failure),
        };
        signals::end_on_next_interrupt();
        farm.stop().await;
        result
    }
}
