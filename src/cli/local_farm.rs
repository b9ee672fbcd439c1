//! A coordinator and workers in this process, talking HTTP like any others.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio::task::{JoinHandle, JoinSet};
use tokio_util::sync::CancellationToken;

use super::exit_code::CliError;
use crate::api;
use crate::farm::worker::{WorkerError, WorkerOptions, run_worker};
use crate::farm::{CoordinatorHandle, CoordinatorOptions};

/// How long requests and workers may take to end.
const SHUTDOWN_PATIENCE: Duration = Duration::from_secs(10);

/// A running coordinator with its embedded workers.
pub(super) struct LocalFarm {
    /// Where it listens.
    pub(super) address: SocketAddr,
    coordinator: CoordinatorHandle,
    server: JoinHandle<std::io::Result<()>>,
    server_shutdown: CancellationToken,
    workers: JoinSet<Result<(), WorkerError>>,
    workers_shutdown: CancellationToken,
}

impl LocalFarm {
    /// Listens at `listen` and starts `workers` workers of `threads` threads.
    pub(super) async fn start(listen: &str, workers: usize, threads: usize) -> Result<Self, CliError> {
        let cannot_listen =
            |error| CliError::Failed(format!("cannot listen at {listen}: {error}; give a free address as HOST:PORT"));
        let listener = TcpListener::bind(listen).await.map_err(cannot_listen)?;
        let address = listener.local_addr().map_err(cannot_listen)?;
        let coordinator = CoordinatorHandle::start(CoordinatorOptions::default());
        let (server_shutdown, workers_shutdown) = (CancellationToken::new(), CancellationToken::new());
        let application = api::application(coordinator.clone(), server_shutdown.clone());
        let stopped = server_shutdown.clone().cancelled_owned();
        let server =
            tokio::spawn(async move { axum::serve(listener, application).with_graceful_shutdown(stopped).await });
        let mut farm =
            Self { address, coordinator, server, server_shutdown, workers: JoinSet::new(), workers_shutdown };
        for index in 1..=workers {
            let options = WorkerOptions { coordinator: farm.loopback_url(), name: format!("local-{index}"), threads };
            farm.workers.spawn(run_worker(options, farm.workers_shutdown.clone()));
        }
        Ok(farm)
    }

    /// An address at which this process reaches the coordinator.
    pub(super) fn loopback_url(&self) -> String {
        match self.address {
            SocketAddr::V4(address) if address.ip().is_unspecified() => format!("http://127.0.0.1:{}", address.port()),
            SocketAddr::V6(address) if address.ip().is_unspecified() => format!("http://[::1]:{}", address.port()),
            address => format!("http://{address}"),
        }
    }

    /// Waits until the server or an embedded worker fails; for ever when all is well.
    pub(super) async fn failure(&mut self) -> CliError {
        loop {
            tokio::select! {
                ended = &mut self.server => return CliError::Failed(match ended {
                    Ok(Err(error)) => format!("the coordinator's server failed: {error}"),
                    _ => "the coordinator's server ended".to_owned(),
                }),
                Some(ended) = self.workers.join_next() => match ended {
                    Ok(Ok(())) => {}
                    Ok(Err(error)) => return CliError::failed(error),
                    Err(error) => return CliError::Failed(format!("a worker crashed: {error}")),
                },
            }
        }
    }

    /// Lets workers give back their shards, merges what has arrived, answers open requests and stops.
    pub(super) async fn stop(mut self) {
        self.coordinator.drain();
        self.workers_shutdown.cancel();
        let orderly = async {
            while self.workers.join_next().await.is_some() {}
            self.coordinator.shutdown().await;
            self.server_shutdown.cancel();
            let _ = (&mut self.server).await;
        };
        if tokio::time::timeout(SHUTDOWN_PATIENCE, orderly).await.is_err() {
            tracing::warn!("requests or workers did not end in time; they are cut off");
            self.server_shutdown.cancel();
        }
    }
}

/// Threads per worker: as asked for, else the processors divided among the workers.
pub(super) fn threads_per_worker(asked: Option<usize>, workers: usize) -> usize {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    asked.unwrap_or(processors / workers.max(1)).max(1)
}
