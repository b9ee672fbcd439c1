//! Work that takes long leaves the threads that answer.

use crate::farm::error::FarmError;

/// Runs `work` on a thread that may block.
pub(in crate::farm) async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, FarmError> + Send + 'static,
) -> Result<T, FarmError> {
    match tokio::task::spawn_blocking(work).await {
        Ok(result) => result,
        Err(problem) => {
            tracing::error!(%problem, "the coordinator's own work failed");
            Err(FarmError::Internal(problem.to_string()))
        }
    }
}
