//! Workers, what happened, and whether the coordinator itself is well.

use axum::Extension;
use axum::extract::State;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::ApiState;
use super::extract::{PathValue, QueryValues, parse_job};
use super::json_answer::Json;
use super::problem::Problem;
use crate::farm::access::caller::Caller;
use crate::farm::job::WorkerStatus;
use crate::farm::store::journal::JournalRow;
use crate::farm::wire::BUILD;
use crate::farm::{FarmError, Limits};

/// All workers.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct WorkerList {
    /// By name.
    pub workers: Vec<WorkerStatus>,
}

/// That the coordinator answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct Health {
    /// Always `ok`.
    pub status: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// Which build of it.
    pub build: &'static str,
}

/// Lists all registered workers.
#[utoipa::path(
    get, path = "/workers", tag = "workers",
    responses((status = 200, description = "All workers, by name", body = WorkerList))
)]
pub(crate) async fn list_workers(State(state): State<ApiState>) -> Json<WorkerList> {
    Json(WorkerList { workers: state.coordinator.workers() })
}

/// Gives a worker no further work. It finishes what it holds, delivers it, and leaves: `photonfarm worker` ends. For admins.
#[utoipa::path(
    post, path = "/workers/{id}/drain", tag = "workers",
    params(("id" = String, Path, description = "The worker's number")),
    responses(
        (status = 200, description = "How it is doing", body = WorkerStatus),
        (status = 404, description = "No such worker", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn drain_worker(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    PathValue(id): PathValue<String>,
) -> Result<Json<WorkerStatus>, Problem> {
    Ok(Json(state.coordinator.drain_worker(&caller, &id)?))
}

/// Answers as long as the coordinator does.
#[utoipa::path(get, path = "/healthz", tag = "health", responses((status = 200, description = "Well", body = Health)))]
pub(crate) async fn health() -> Json<Health> {
    Json(Health { status: "ok", version: env!("CARGO_PKG_VERSION"), build: BUILD })
}

/// Answers 200 while jobs and workers are taken here.
#[utoipa::path(
    get, path = "/readyz", tag = "health",
    responses(
        (status = 200, description = "Ready", body = Health),
        (status = 503, description = "It stops, or stands by", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn readiness(State(state): State<ApiState>) -> Result<Json<Health>, Problem> {
    if state.coordinator.is_closed() { Err(FarmError::ShuttingDown.into()) } else { Ok(health().await) }
}

/// What this program is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct Version {
    /// Version of the program.
    pub version: &'static str,
    /// Version and a hash of everything that decides what the program computes. Only equal builds work on one picture.
    pub build: &'static str,
}

/// Tells version and build.
#[utoipa::path(get, path = "/version", tag = "health", responses((status = 200, description = "The program", body = Version)))]
pub(crate) async fn version() -> Json<Version> {
    Json(Version { version: env!("CARGO_PKG_VERSION"), build: BUILD })
}

/// Tells what is accepted here.
#[utoipa::path(get, path = "/limits", tag = "health", responses((status = 200, description = "All limits", body = Limits)))]
pub(crate) async fn limits(State(state): State<ApiState>) -> Json<Limits> {
    Json(state.coordinator.limits().clone())
}

/// Part of the journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct Journal {
    /// Oldest first.
    pub lines: Vec<JournalLine>,
}

/// Something that happened on the farm.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct JournalLine {
    /// Its place in the journal; later lines have larger ones.
    pub sequence: i64,
    /// When, milliseconds since 1970.
    pub time: i64,
    /// The job that it is about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<String>,
    /// The worker that it is about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worker: Option<String>,
    /// What happened.
    pub text: String,
}

/// Which part of the journal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct JournalQuery {
    /// Only lines after the one with this sequence number; 0 by default.
    #[serde(default)]
    pub after: i64,
    /// Only lines about this job.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<String>,
}

/// Lines of an answer at most.
const LINES: u16 = 1000;

/// Tells what happened: who joined and left, how jobs went on, who was given access by whom. At most 1000 lines.
#[utoipa::path(
    get, path = "/journal", tag = "workers", params(JournalQuery),
    responses(
        (status = 200, description = "Lines, oldest first", body = Journal),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn journal(
    State(state): State<ApiState>,
    QueryValues(query): QueryValues<JournalQuery>,
) -> Result<Json<Journal>, Problem> {
    let job = query.job.as_deref().map(parse_job).transpose()?;
    let rows = state.coordinator.journal(query.after, job, LINES).await?;
    let line = |row: JournalRow| JournalLine {
        sequence: row.sequence,
        time: row.time,
        job: row.job.map(|job| job.to_string()),
        worker: row.worker,
        text: row.text,
    };
    Ok(Json(Journal { lines: rows.into_iter().map(line).collect() }))
}
