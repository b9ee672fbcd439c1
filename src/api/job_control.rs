//! Jobs that are there: paused, resumed, extended, copied, renamed, deleted.

use axum::Extension;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::ApiState;
use super::extract::{JsonBody, PathValue, parse_job};
use super::guard::OwnJob;
use super::jobs::{JobView, accepted};
use super::json_answer::Json;
use super::preferences::{Preferences, is_version_meant};
use super::problem::Problem;
use crate::farm::access::caller::Caller;
use crate::farm::coordinator::JobChanges;
use crate::farm::job::{JobStatus, Priority, StopRule};

/// What of a job may change at any time. What is left out stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct JobPatch {
    /// What people call it; an empty one is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Words to find it by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tags: Option<Vec<String>>,
    /// Its share of the farm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priority: Option<Priority>,
}

/// What a copy of a job has different. What is left out is as it was submitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CloneRequest {
    /// Its method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Method parameters that override those of the original.
    #[serde(default)]
    #[schema(value_type = Object)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// When to stop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopRule>,
    /// Seed of all random numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// What people call it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Words to find it by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tags: Option<Vec<String>>,
    /// Its share of the farm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priority: Option<Priority>,
}

/// Changes name, tags or priority of a job.
#[utoipa::path(
    patch, path = "/jobs/{id}", tag = "jobs", request_body = JobPatch,
    params(
        ("id" = String, Path, description = "The job's id"),
        ("If-Match" = Option<String>, Header, description = "The ETag of the job that is meant to be changed"),
    ),
    responses(
        (status = 200, description = "Its status afterwards", body = JobView, headers(("ETag" = String))),
        (status = 412, description = "It was changed since", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Cannot be done", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn change_job(
    State(state): State<ApiState>,
    OwnJob(id): OwnJob,
    headers: HeaderMap,
    JsonBody(patch): JsonBody<JobPatch>,
) -> Result<Response, Problem> {
    let JobPatch { name, tags, priority } = patch;
    let is_meant = |job: &JobStatus| is_version_meant(job, &headers);
    let changed = state.coordinator.change(id, JobChanges { name, tags, priority }, is_meant).await?;
    Ok(Preferences::default().answer(StatusCode::OK, changed))
}

/// Stops issuing work of a job. What is being traced is still merged.
#[utoipa::path(
    post, path = "/jobs/{id}/pause", tag = "jobs",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "Its status afterwards", body = JobView),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It pauses or has ended", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn pause_job(State(state): State<ApiState>, OwnJob(id): OwnJob) -> Result<Json<JobView>, Problem> {
    Ok(Json(state.coordinator.pause(id).await?.into()))
}

/// Lets a paused job go on.
#[utoipa::path(
    post, path = "/jobs/{id}/resume", tag = "jobs",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "Its status afterwards", body = JobView),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It does not pause", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn resume_job(State(state): State<ApiState>, OwnJob(id): OwnJob) -> Result<Json<JobView>, Problem> {
    Ok(Json(state.coordinator.resume(id).await?.into()))
}

/// Lets an ended job go on to a later end, from its stored state to the bits of the longer job.
#[utoipa::path(
    post, path = "/jobs/{id}/extend", tag = "jobs", request_body = StopRule,
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "Its status afterwards", body = JobView),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It has not ended, or nothing is stored of it", body = Problem,
            content_type = "application/problem+json"),
        (status = 422, description = "The end is not later", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn extend_job(
    State(state): State<ApiState>,
    OwnJob(id): OwnJob,
    JsonBody(stop): JsonBody<StopRule>,
) -> Result<Json<JobView>, Problem> {
    Ok(Json(state.coordinator.extend(id, stop).await?.into()))
}

/// Submits a copy of a job, also of somebody else's, with some differences.
#[utoipa::path(
    post, path = "/jobs/{id}/clone", tag = "jobs", request_body = CloneRequest,
    params(
        ("id" = String, Path, description = "The job's id"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key again answers the job that there is"),
        ("Prefer" = Option<String>, Header, description = "wait=SECONDS waits for the job's end, at most 60 seconds; Preference-Applied says how long"),
    ),
    responses(
        (status = 200, description = "It has ended, and Prefer: wait waited for that", body = JobView,
            headers(("Location" = String), ("Preference-Applied" = String, description = "The wait that was granted"))),
        (status = 202, description = "Checked and queued", body = JobView,
            headers(("Location" = String), ("Preference-Applied" = String, description = "The wait that was granted"))),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Cannot be done", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn clone_job(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    preferences: Preferences,
    PathValue(id): PathValue<String>,
    JsonBody(changes): JsonBody<CloneRequest>,
) -> Result<Response, Problem> {
    let mut request = state.coordinator.request(parse_job(&id)?)?;
    let CloneRequest { method, parameters, stop, seed, name, tags, priority } = changes;
    if method.is_some() && method != request.method {
        // Another method has other parameters.
        request.parameters.clear();
    }
    request.parameters.extend(parameters);
    request.method = method.or(request.method);
    request.stop = stop.unwrap_or(request.stop);
    request.seed = seed.unwrap_or(request.seed);
    request.name = name.or(request.name);
    request.tags = tags.unwrap_or(request.tags);
    request.priority = priority.unwrap_or(request.priority);
    // A copy is a job of its own.
    request.frame = None;
    accepted(&state, &caller, preferences, request).await
}

/// Deletes a job and its pictures. One that runs is cancelled first.
#[utoipa::path(
    delete, path = "/jobs/{id}", tag = "jobs",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 204, description = "Nothing of it is left"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn delete_job(State(state): State<ApiState>, OwnJob(id): OwnJob) -> Result<StatusCode, Problem> {
    state.coordinator.delete(id).await?;
    Ok(StatusCode::NO_CONTENT)
}
