//! Jobs: submitted, looked at, changed.

use std::num::NonZeroU32;

use axum::Extension;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::ApiState;
use super::extract::{JsonBody, PathValue, QueryValues, parse_job, parse_sequence};
use super::guard::OwnJob;
use super::json_answer::Json;
use super::preferences::Preferences;
use super::problem::Problem;
use super::schemas::{Changes, InlineScene};
use crate::farm::FarmError;
use crate::farm::access::caller::Caller;
use crate::farm::access::user::UserName;
use crate::farm::cut::Cut;
use crate::farm::ids::JobId;
use crate::farm::job::{JobFilter, JobRequest, JobState, JobStatus, Priority, SceneChanges, StopRule};

/// A job to be made. Exactly one of `scene` and `scene_inline` is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct JobSubmission {
    /// Hash of an uploaded scene, 64 hexadecimal digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// The scene itself: a dictionary as Mitsuba 3's `load_dict` takes it, or a string of Mitsuba 3 XML. It stands alone;
    /// scenes that refer to files are uploaded as an archive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<InlineScene>)]
    pub scene_inline: Option<serde_json::Value>,
    /// What is changed of the scene. The changed scene is kept as a scene of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Changes>)]
    pub scene_changes: Option<SceneChanges>,
    /// Method; the scene's own integrator when it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Method parameters that override the scene's.
    #[serde(default)]
    #[schema(value_type = Object)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// When to stop; after the method's `passes` when nothing is given.
    #[serde(default)]
    pub stop: StopRule,
    /// How finely it is cut into what workers trace; pictures of different cuts have different bits.
    #[serde(default, skip_serializing_if = "Cut::is_empty")]
    pub cut: Cut,
    /// Seed of all random numbers; 0 by default.
    #[serde(default)]
    pub seed: u64,
    /// What people call it; at most 200 bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Words to find it by; at most 20 of at most 100 bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
    /// Its share of the farm.
    #[serde(default)]
    pub priority: Priority,
    /// Whether the light of each light group of its scene is kept apart, as a layer of the picture; false by default. A pass then costs as much as
    /// one for each group.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub light_groups: bool,
}

/// A job's status with its addresses.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct JobView {
    /// How it is doing.
    #[serde(flatten)]
    pub status: JobStatus,
    /// Where to go from here.
    pub links: JobLinks,
}

/// Addresses that belong to a job.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct JobLinks {
    /// The job itself.
    #[serde(rename = "self")]
    pub this: String,
    /// Its status as it changes, as server-sent events.
    pub events: String,
    /// Its picture so far, to look at.
    pub image_png: String,
    /// Its picture so far, to compute with.
    pub image_exr: String,
    /// Its own error estimate over time, a chart.
    pub chart_svg: String,
    /// A layer in false colors, with its scale.
    pub map_png: String,
    /// POST here to stop it.
    pub cancel: String,
}

/// Jobs that were asked for.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct JobList {
    /// Oldest first.
    pub jobs: Vec<JobView>,
    /// The id to ask for further jobs after; empty when these are all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_after: Option<String>,
}

/// Which jobs to list. What is left out leaves all.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct JobsQuery {
    /// Only jobs in this state.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[param(inline)]
    pub state: Option<JobState>,
    /// Only jobs with this tag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tag: Option<String>,
    /// Only jobs with this name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Only jobs of this user.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[param(value_type = Option<String>)]
    pub owner: Option<UserName>,
    /// Only the frames of this sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sequence: Option<String>,
    /// Only jobs that were submitted after the one with this id, which need not be there any more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    /// At most so many jobs, 1 or more; all by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[param(value_type = Option<u32>, minimum = 1)]
    pub limit: Option<NonZeroU32>,
}

impl From<JobStatus> for JobView {
    fn from(status: JobStatus) -> Self {
        let this = format!("/v1/jobs/{}", status.id);
        let links = JobLinks {
            events: format!("{this}/events"),
            image_png: format!("{this}/image.png"),
            image_exr: format!("{this}/image.exr"),
            chart_svg: format!("{this}/chart.svg"),
            map_png: format!("{this}/map.png"),
            cancel: format!("{this}/cancel"),
            this,
        };
        Self { status, links }
    }
}

/// Submits a job.
#[utoipa::path(
    post, path = "/jobs", tag = "jobs", request_body = JobSubmission,
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "The same key again answers the job that there is"),
        ("Prefer" = Option<String>, Header, description = "wait=SECONDS waits for the job's end, at most 60 seconds; Preference-Applied says how long"),
    ),
    responses(
        (status = 200, description = "It has ended, and Prefer: wait waited for that", body = JobView,
            headers(("Location" = String), ("Preference-Applied" = String, description = "The wait that was granted"))),
        (status = 202, description = "Checked and queued", body = JobView,
            headers(("Location" = String), ("Preference-Applied" = String, description = "The wait that was granted"))),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "More than /v1/limits allows", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Cannot be done", body = Problem, content_type = "application/problem+json"),
        (status = 429, description = "Too many jobs wait or run", body = Problem,
            content_type = "application/problem+json"),
        (status = 503, description = "The store is full, or the coordinator stops", body = Problem,
            content_type = "application/problem+json"),
    )
)]
pub(crate) async fn submit_job(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    preferences: Preferences,
    JsonBody(mut submission): JsonBody<JobSubmission>,
) -> Result<Response, Problem> {
    let (hash, bytes) = scene_of(&state, &caller, &mut submission).await?;
    let scene = match bytes {
        Some(bytes) => state.coordinator.add_scene_of(bytes, &caller).await?.hash,
        None => hash,
    };
    let request = submission.request(scene);
    accepted(&state, &caller, preferences, request).await
}

/// What would become of a job.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct Validation {
    /// Hash of its scene.
    pub scene: String,
    /// Its method, `auto` where trials would choose it.
    pub method: String,
    /// All parameters of the method, defaults written out.
    #[schema(value_type = Object)]
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// Its stop rule.
    pub stop: StopRule,
    /// The light groups that it keeps apart; empty unless that is asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub light_groups: Vec<String>,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
}

/// Tells what would become of a job, or what is wrong with it. Nothing is kept or traced.
#[utoipa::path(
    post, path = "/jobs/validate", tag = "jobs", request_body = JobSubmission,
    responses(
        (status = 200, description = "It can be rendered", body = Validation),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "More than /v1/limits allows", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Cannot be done", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn validate_job(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    JsonBody(mut submission): JsonBody<JobSubmission>,
) -> Result<Json<Validation>, Problem> {
    let (hash, bytes) = scene_of(&state, &caller, &mut submission).await?;
    let checked = state.coordinator.validate(submission.request(hash), bytes).await.map_err(submission_problem)?;
    let JobStatus { scene, method, parameters, stop, light_groups, width, height, notices, .. } = checked;
    Ok(Json(Validation { scene, method, parameters, stop, light_groups, width, height, notices }))
}

/// The hash of a job's scene that is there, or the bytes of one that is not yet, with the changes that the job asks for.
async fn scene_of(
    state: &ApiState,
    caller: &Caller,
    submission: &mut JobSubmission,
) -> Result<(String, Option<Vec<u8>>), Problem> {
    let (hash, bytes) = unchanged_scene(submission)?;
    let Some(changes) = submission.scene_changes.take().filter(|changes| !changes.is_empty()) else {
        return Ok((hash, bytes));
    };
    let changed = match bytes {
        Some(bytes) => state.coordinator.changed(bytes.into(), changes, caller).await?,
        None => state.coordinator.changed_scene(&hash, changes).await.map_err(submission_problem)?,
    };
    Ok((String::new(), Some(changed)))
}

/// The hash of a job's scene before its changes; one that came with the job is uploaded.
pub(super) async fn base_scene(
    state: &ApiState,
    caller: &Caller,
    submission: &mut JobSubmission,
) -> Result<String, Problem> {
    match unchanged_scene(submission)? {
        (_, Some(bytes)) => Ok(state.coordinator.add_scene_of(bytes, caller).await?.hash),
        (hash, None) => Ok(hash),
    }
}

/// The hash of a job's scene, or the bytes of one that comes with it.
#[expect(clippy::result_large_err, reason = "made at most once a request")]
fn unchanged_scene(submission: &mut JobSubmission) -> Result<(String, Option<Vec<u8>>), Problem> {
    match (submission.scene.take(), submission.scene_inline.take()) {
        (Some(hash), None) => Ok((hash, None)),
        (None, Some(scene)) => Ok((String::new(), Some(inline_scene_bytes(scene)?))),
        (found, _) => Err(one_scene(found.is_some())),
    }
}

/// A job has exactly one scene.
fn one_scene(has_two: bool) -> Problem {
    let detail = if has_two { "the job has two scenes" } else { "the job has no scene" };
    Problem::bad_request(detail, "give either scene (a hash) or scene_inline")
}

impl JobSubmission {
    /// The same with a scene that is there.
    pub(super) fn request(self, scene: String) -> JobRequest {
        let Self { method, parameters, stop, cut, seed, name, tags, priority, light_groups, .. } = self;
        let frame = None;
        JobRequest { scene, method, parameters, stop, cut, seed, name, tags, priority, light_groups, frame }
    }
}

#[expect(clippy::result_large_err, reason = "made at most once a request")]
fn inline_scene_bytes(scene: serde_json::Value) -> Result<Vec<u8>, Problem> {
    match scene {
        serde_json::Value::String(xml) => Ok(xml.into_bytes()),
        serde_json::Value::Object(_) => Ok(scene.to_string().into_bytes()),
        _ => Err(Problem::bad_request(
            "scene_inline is neither a dictionary nor a string",
            "give a Mitsuba 3 dictionary, or Mitsuba 3 XML as a string",
        )),
    }
}

/// An unknown scene is a fault of the body here, not of the address.
pub(super) fn submission_problem(error: FarmError) -> Problem {
    let unknown_scene = matches!(error, FarmError::UnknownScene(_));
    let problem = Problem::from(error);
    let status = if unknown_scene { StatusCode::UNPROCESSABLE_ENTITY.as_u16() } else { problem.status };
    Problem { status, ..problem }
}

/// An id in a query. Its job need not be there, but it has to be one.
#[expect(clippy::result_large_err, reason = "made at most once a request")]
fn parse_after(text: &str) -> Result<JobId, Problem> {
    text.parse().map_err(|_| {
        Problem::new(StatusCode::BAD_REQUEST, "bad-query", format!("after is \"{text}\", which is no job's id"))
            .remedy("give the next_after of the page before")
    })
}

/// Lists jobs.
#[utoipa::path(
    get, path = "/jobs", tag = "jobs", params(JobsQuery),
    responses(
        (status = 200, description = "Jobs, oldest first", body = JobList),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn list_jobs(
    State(state): State<ApiState>,
    QueryValues(query): QueryValues<JobsQuery>,
) -> Result<Json<JobList>, Problem> {
    let JobsQuery { state: wanted, tag, name, owner, sequence, after, limit } = query;
    let sequence = sequence.as_deref().map(parse_sequence).transpose()?;
    let after = after.as_deref().map(parse_after).transpose()?;
    let limit = limit.map_or(usize::MAX, |limit| limit.get() as usize);
    let filter = JobFilter { state: wanted, tag, name, owner, sequence, after };
    // One more tells whether there are more.
    let mut found = state.coordinator.find_jobs(&filter, limit.saturating_add(1));
    let are_more = found.len() > limit;
    found.truncate(limit);
    let next_after = found.last().filter(|_| are_more).map(|job| job.id.clone());
    Ok(Json(JobList { jobs: found.into_iter().map(JobView::from).collect(), next_after }))
}

/// Tells how a job is doing.
#[utoipa::path(
    get, path = "/jobs/{id}", tag = "jobs",
    params(
        ("id" = String, Path, description = "The job's id"),
        ("Prefer" = Option<String>, Header, description = "wait=SECONDS waits for the job's end, at most 60 seconds; Preference-Applied says how long"),
    ),
    responses(
        (status = 200, description = "Its status", body = JobView,
            headers(("ETag" = String), ("Preference-Applied" = String, description = "The wait that was granted"))),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn show_job(
    State(state): State<ApiState>,
    preferences: Preferences,
    PathValue(id): PathValue<String>,
) -> Result<Response, Problem> {
    let status = preferences.wait_for(&state, parse_job(&id)?).await?;
    Ok(preferences.answer(StatusCode::OK, status))
}

/// Stops a job and keeps its picture. A job that has ended already stays as it is.
#[utoipa::path(
    post, path = "/jobs/{id}/cancel", tag = "jobs",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "Its status afterwards", body = JobView),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn cancel_job(State(state): State<ApiState>, OwnJob(id): OwnJob) -> Result<Json<JobView>, Problem> {
    Ok(Json(state.coordinator.cancel(id).await?.into()))
}

/// Submits a job and says where it is. It is 200 when it has ended already, because that was waited for.
pub(super) async fn accepted(
    state: &ApiState,
    caller: &Caller,
    preferences: Preferences,
    request: JobRequest,
) -> Result<Response, Problem> {
    let id = state.coordinator.submit_of(request, caller, preferences.key.clone()).await.map_err(submission_problem)?;
    let job = preferences.wait_for(state, id).await?;
    let location = format!("/v1/jobs/{id}");
    let status = if job.state.is_final() { StatusCode::OK } else { StatusCode::ACCEPTED };
    Ok(([(header::LOCATION, location)], preferences.answer(status, job)).into_response())
}
