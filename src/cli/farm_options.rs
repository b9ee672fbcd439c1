//! A coordinator and workers in this process, as `render` and `serve` start them.

use axum::Router;
use tokio_util::sync::CancellationToken;

use super::exit_code::CliError;
use crate::api;
use crate::farm::CoordinatorHandle;
use crate::farm::local_farm::{LocalFarm, LocalFarmBuilder, LocalFarmError};
use crate::farm::worker::WorkerError;

/// A farm with the API and the page.
pub(super) fn farm_with_api(workers: usize, threads: usize) -> LocalFarmBuilder {
    let routes = |coordinator: CoordinatorHandle, shutdown: CancellationToken| -> Router {
        api::router(api::ApiState { coordinator, shutdown })
    };
    LocalFarm::builder().workers(workers).threads(threads).routes(routes)
}

/// Threads per worker: as asked for, else the processors divided among the workers.
pub(super) fn threads_per_worker(asked: Option<usize>, workers: usize) -> usize {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    asked.unwrap_or(processors / workers.max(1)).max(1)
}

impl From<LocalFarmError> for CliError {
    fn from(error: LocalFarmError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<WorkerError> for CliError {
    fn from(error: WorkerError) -> Self {
        match error {
            WorkerError::BadAddress { .. } => Self::Usage(error.to_string()),
            WorkerError::Refused(_) => Self::Unreachable(error.to_string()),
            WorkerError::Start(_) => Self::failed(error),
        }
    }
}
