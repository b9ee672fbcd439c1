//! A worker: leases shards, traces them, sends tallies.

use tokio_util::sync::CancellationToken;

/// What a worker is told.
#[derive(Clone, Debug)]
pub struct WorkerOptions {
    /// Base address of the coordinator, for example `http://127.0.0.1:7878`.
    pub coordinator: String,
    /// Name shown in the list of workers.
    pub name: String,
    /// Rendering threads, at least 1.
    pub threads: usize,
}

/// Why a worker stopped other than by being asked.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The coordinator's address is not one.
    #[error("\"{address}\" is not an address of a coordinator ({problem}); write http://HOST:PORT")]
    BadAddress {
        /// As given.
        address: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The rendering threads or the HTTP client could not be made.
    #[error("the worker cannot start: {0}")]
    Start(String),
    /// The coordinator does not speak to this worker, for example because their builds differ.
    #[error("the coordinator refuses this worker: {0}")]
    Refused(String),
}

/// Works for a coordinator until `shutdown` is cancelled. Outages are waited out, with growing pauses.
///
/// On shutdown the shard in hand is given back, so that another worker gets it at once.
pub async fn run_worker(options: WorkerOptions, shutdown: CancellationToken) -> Result<(), WorkerError> {
    let _ = (options, shutdown);
    todo!("lands with the worker")
}
