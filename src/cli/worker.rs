//! `worker`: traces shards for a coordinator.

use clap::Args;
use tokio_util::sync::CancellationToken;

use super::exit_code::CliError;
use super::farm_options::threads_per_worker;
use super::log_option::LogOption;
use super::signals;
use super::token_option::TokenOption;
use super::trust_options::TrustOptions;
use crate::farm::dial::Dialer;
use crate::farm::prepared_scenes::PreparedScenes;
use crate::farm::worker::{KEPT_SCENES, WorkerOptions, run_worker};

/// Work for a coordinator.
///
/// It runs until Ctrl-C or SIGTERM, and waits outages of the coordinator out.
#[derive(Clone, Debug, Args)]
pub(super) struct Worker {
    /// Address of the coordinator; of several that stand in for each other, separated by commas.
    #[arg(long, env = "PHOTONFARM_URL", value_name = "URL")]
    coordinator: String,
    #[command(flatten)]
    token: TokenOption,
    #[command(flatten)]
    trust: TrustOptions,
    #[command(flatten)]
    pub(super) log: LogOption,
    /// Rendering threads [default: all processors].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Name in the coordinator's list of workers [default: worker and the process id].
    #[arg(long)]
    name: Option<String>,
}

impl Worker {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let dialer = Dialer::tcp(self.trust.settings(&self.coordinator)?);
        let options = WorkerOptions {
            coordinator: self.coordinator,
            name: self.name.unwrap_or_else(|| format!("worker-{}", std::process::id())),
            threads: threads_per_worker(self.threads.map(usize::from), 1),
            token: self.token.read()?,
            scenes: PreparedScenes::new(KEPT_SCENES),
            dialer,
        };
        let shutdown = CancellationToken::new();
        let asked_to_stop = async {
            if let Err(error) = signals::interrupted().await {
                tracing::warn!(%error, "the worker cannot be stopped gently");
                std::future::pending::<()>().await;
            }
            shutdown.cancel();
            signals::end_on_next_interrupt();
            std::future::pending::<()>().await;
        };
        let result = tokio::select! {
            result = run_worker(options, shutdown.clone()) => result,
            () = asked_to_stop => Ok(()),
        };
        result.map_err(CliError::from)
    }
}
