//! The workers' protocol over HTTP, to be mounted under `/farm/v1`.

use axum::Router;

use super::coordinator::CoordinatorHandle;

/// Routes for workers: register, lease, heartbeat, result, release, scenes and radius fields.
pub fn router(coordinator: CoordinatorHandle) -> Router {
    let _ = coordinator;
    todo!("lands with the coordinator")
}
