//! Workers, and whether the coordinator itself is well.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::ApiState;
use crate::farm::job::WorkerStatus;

/// All workers.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct WorkerList {
    /// By name.
    pub workers: Vec<WorkerStatus>,
}

/// That the coordinator answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Health {
    /// Always `ok`.
    pub status: &'static str,
    /// Version of the program.
    pub version: &'static str,
}

/// Lists all registered workers.
#[utoipa::path(
    get, path = "/workers", tag = "workers",
    responses((status = 200, description = "All workers, by name", body = WorkerList))
)]
pub async fn list_workers(State(state): State<ApiState>) -> Json<WorkerList> {
    Json(WorkerList { workers: state.coordinator.workers() })
}

/// Answers as long as the coordinator does.
#[utoipa::path(get, path = "/healthz", tag = "health", responses((status = 200, description = "Well", body = Health)))]
pub async fn health() -> Json<Health> {
    Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION") })
}
