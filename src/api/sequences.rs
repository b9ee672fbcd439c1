//! Sequences: many pictures of one scene, submitted, looked at, stopped together.

use axum::Extension;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::ApiState;
use super::extract::{JsonBody, PathValue, parse_sequence};
use super::guard::OwnSequence;
use super::jobs::{JobSubmission, base_scene, submission_problem};
use super::json_answer::Json;
use super::preferences::Preferences;
use super::problem::Problem;
use crate::farm::access::caller::Caller;
use crate::farm::sequence::{AtOnce, Frames, SequenceRequest, SequenceStatus};

/// A sequence to be rendered: many pictures of one scene in which things move, or of which the camera goes along a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SequenceSubmission {
    /// What all frames have in common. Each is a job of its own, with its number behind the job's name.
    pub job: JobSubmission,
    /// Which frames.
    pub frames: Frames,
    /// How many frames are rendered at the same time, 1 to 100 and 2 by default: while one ends, the next one keeps the workers busy.
    #[serde(default)]
    pub at_once: AtOnce,
}

/// Sequences that there are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub(crate) struct SequenceList {
    /// Oldest first. Their frames are left out; ask for one sequence, or for its jobs.
    pub sequences: Vec<SequenceStatus>,
}

/// Submits a sequence. Its first frame is checked; the others become jobs as those before them end.
#[utoipa::path(
    post, path = "/sequences", tag = "sequences", request_body = SequenceSubmission,
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "The same key again answers the sequence that there is"),
    ),
    responses(
        (status = 202, description = "Checked, and its first frame is queued", body = SequenceStatus, headers(("Location" = String))),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "More than /v1/limits allows", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Cannot be done", body = Problem, content_type = "application/problem+json"),
        (status = 429, description = "Too many jobs wait or run", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "The store is full, or the coordinator stops", body = Problem,
            content_type = "application/problem+json"),
    )
)]
pub(crate) async fn submit_sequence(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    preferences: Preferences,
    JsonBody(submission): JsonBody<SequenceSubmission>,
) -> Result<Response, Problem> {
    let SequenceSubmission { mut job, frames, at_once } = submission;
    let scene = base_scene(&state, &caller, &mut job).await?;
    let changes = job.scene_changes.take().unwrap_or_default();
    let request = SequenceRequest { job: job.request(scene), changes, frames, at_once };
    let id = state.coordinator.submit_sequence(request, &caller, preferences.key).await.map_err(submission_problem)?;
    let location = format!("/v1/sequences/{id}");
    let status = state.coordinator.sequence(id)?;
    Ok((StatusCode::ACCEPTED, [(header::LOCATION, location)], Json(status)).into_response())
}

/// Lists sequences.
#[utoipa::path(
    get, path = "/sequences", tag = "sequences",
    responses((status = 200, description = "All of them", body = SequenceList))
)]
pub(crate) async fn list_sequences(State(state): State<ApiState>) -> Json<SequenceList> {
    let without_jobs = |sequence| SequenceStatus { jobs: Vec::new(), ..sequence };
    Json(SequenceList { sequences: state.coordinator.sequences().into_iter().map(without_jobs).collect() })
}

/// Tells how a sequence is doing, frame by frame.
#[utoipa::path(
    get, path = "/sequences/{id}", tag = "sequences",
    params(("id" = String, Path, description = "The sequence's id")),
    responses(
        (status = 200, description = "Its status", body = SequenceStatus),
        (status = 404, description = "No such sequence", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn show_sequence(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
) -> Result<Json<SequenceStatus>, Problem> {
    Ok(Json(state.coordinator.sequence(parse_sequence(&id)?)?))
}

/// Issues no more work of a sequence. What is being traced is still merged.
#[utoipa::path(
    post, path = "/sequences/{id}/pause", tag = "sequences",
    params(("id" = String, Path, description = "The sequence's id")),
    responses(
        (status = 200, description = "Its status afterwards", body = SequenceStatus),
        (status = 404, description = "No such sequence", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It pauses or has ended", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn pause_sequence(
    State(state): State<ApiState>,
    OwnSequence(id): OwnSequence,
) -> Result<Json<SequenceStatus>, Problem> {
    Ok(Json(state.coordinator.pause_sequence(id).await?))
}

/// Lets a paused sequence go on, or one that failed because a frame could not become a job: that frame is tried again.
#[utoipa::path(
    post, path = "/sequences/{id}/resume", tag = "sequences",
    params(("id" = String, Path, description = "The sequence's id")),
    responses(
        (status = 200, description = "Its status afterwards", body = SequenceStatus),
        (status = 404, description = "No such sequence", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It does not pause", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn resume_sequence(
    State(state): State<ApiState>,
    OwnSequence(id): OwnSequence,
) -> Result<Json<SequenceStatus>, Problem> {
    Ok(Json(state.coordinator.resume_sequence(id).await?))
}

/// Stops a sequence and keeps its pictures. One that has ended stays as it is.
#[utoipa::path(
    post, path = "/sequences/{id}/cancel", tag = "sequences",
    params(("id" = String, Path, description = "The sequence's id")),
    responses(
        (status = 200, description = "Its status afterwards", body = SequenceStatus),
        (status = 404, description = "No such sequence", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn cancel_sequence(
    State(state): State<ApiState>,
    OwnSequence(id): OwnSequence,
) -> Result<Json<SequenceStatus>, Problem> {
    Ok(Json(state.coordinator.cancel_sequence(id).await?))
}

/// Deletes a sequence with its jobs and their pictures. One that runs is cancelled first.
#[utoipa::path(
    delete, path = "/sequences/{id}", tag = "sequences",
    params(("id" = String, Path, description = "The sequence's id")),
    responses(
        (status = 204, description = "Nothing of it is left"),
        (status = 404, description = "No such sequence", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn delete_sequence(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    OwnSequence(id): OwnSequence,
) -> Result<StatusCode, Problem> {
    state.coordinator.delete_sequence(&caller, id).await?;
    Ok(StatusCode::NO_CONTENT)
}
