//! The workers' protocol over HTTP, to be mounted under `/farm/v1`.
//!
//! | request | answers |
//! |---|---|
//! | `POST register` | 200; 409 when the worker is of another build |
//! | `POST lease` | 200 with a lease, or without one after some seconds |
//! | `POST heartbeat`, `POST release` | 200 |
//! | `POST result` | 200, also when it came before; 409 when the lease is not the worker's any more; 422 when refused |
//! | `GET scenes/{hash}` | 200; 404 |
//! | `GET jobs/{id}/radius/{epoch}/{region}` | 200, 304; 404 when it is not needed any more |
//!
//! A worker that the coordinator does not know (any more) gets 410 and registers again. Problems are plain text.

mod delivery;

use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Path, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use prost::Message;
use tokio::time::{Instant, timeout_at};

use crate::farm::coordinator::{CoordinatorHandle, lock};

use crate::farm::error::FarmError;
use crate::farm::rules::schedule::LeaseAnswer;
use crate::farm::wire::messages::{
    HeartbeatRequest, HeartbeatResponse, LeaseRequest, LeaseResponse, RegisterRequest, RegisterResponse,
    ReleaseRequest, ResultRequest,
};
use crate::farm::wire::{self, WireError};

/// How long a worker waits for work before it is told that there is none.
const LEASE_WAIT: Duration = Duration::from_secs(10);
/// How often a waiting worker's turn is checked even if nothing happened: shards become overdue by time alone.
const LEASE_CHECK: Duration = Duration::from_millis(500);
/// The largest result: a tally of the largest region, or the radii of the largest picture, compressed.
const RESULT_LIMIT: usize = 512 << 20;
/// The largest other message.
const MESSAGE_LIMIT: usize = 1 << 20;
/// The longest name of a worker, bytes.
const NAME_LIMIT: usize = 200;

/// A problem as the worker reads it.
pub(super) struct Problem {
    status: StatusCode,
    text: String,
}

impl Problem {
    pub(super) fn new(status: StatusCode, text: impl Into<String>) -> Self {
        Self { status, text: text.into() }
    }

    /// The worker must register first.
    pub(super) fn unknown_worker() -> Self {
        Self::new(StatusCode::GONE, "this worker is not registered; register again")
    }
}

impl From<FarmError> for Problem {
    fn from(error: FarmError) -> Self {
        let status = match error {
            FarmError::UnknownScene(_) | FarmError::UnknownJob(_) | FarmError::NoPictureYet(_) => StatusCode::NOT_FOUND,
            FarmError::TooLarge { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            FarmError::ShuttingDown => StatusCode::SERVICE_UNAVAILABLE,
            FarmError::Internal(_) => StatusCode::INTERNAL_SERVER_ERROR,
            _ => StatusCode::BAD_REQUEST,
        };
        Self::new(status, error.to_string())
    }
}

impl From<WireError> for Problem {
    fn from(error: WireError) -> Self {
        Self::new(StatusCode::BAD_REQUEST, error.to_string())
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        (self.status, self.text).into_response()
    }
}

/// Routes for workers: register, lease, heartbeat, result, release, scenes and radius fields.
pub fn router(coordinator: CoordinatorHandle) -> Router {
    Router::new()
        .route("/register", post(register))
        .route("/lease", post(lease))
        .route("/heartbeat", post(heartbeat))
        .route("/release", post(release))
        .route("/result", post(result).layer(DefaultBodyLimit::max(RESULT_LIMIT)))
        .route("/scenes/{hash}", get(scene))
        .route("/jobs/{id}/radius/{epoch}/{region}", get(radius_field))
        .layer(DefaultBodyLimit::max(MESSAGE_LIMIT))
        .with_state(coordinator)
}

fn read<M: Message + Default>(body: Bytes) -> Result<M, Problem> {
    M::decode(body).map_err(|problem| WireError::Malformed(problem.to_string()).into())
}

fn written(message: &impl Message) -> Response {
    ([(header::CONTENT_TYPE, "application/x-protobuf")], message.encode_to_vec()).into_response()
}

async fn register(State(coordinator): State<CoordinatorHandle>, body: Bytes) -> Result<Response, Problem> {
    let request: RegisterRequest = read(body)?;
    if request.build != wire::BUILD {
        let text = format!(
            "this worker is build {}, the coordinator is build {}; run the same program on both sides",
            request.build,
            wire::BUILD
        );
        return Err(Problem::new(StatusCode::CONFLICT, text));
    }
    if request.name.len() > NAME_LIMIT || request.threads == 0 {
        let text = format!("a worker has a name of at most {NAME_LIMIT} bytes and at least one thread");
        return Err(Problem::new(StatusCode::BAD_REQUEST, text));
    }
    let shared = &coordinator.shared;
    let worker = shared.change(|schedule, now| schedule.register(now, &request.name, request.threads));
    tracing::info!(
        worker,
        name = request.name,
        threads = request.threads,
        features = request.features,
        "worker registered"
    );
    let lease_milliseconds = shared.options.lease_duration.as_millis() as u32;
    Ok(written(&RegisterResponse { worker, lease_milliseconds }))
}

async fn lease(State(coordinator): State<CoordinatorHandle>, body: Bytes) -> Result<Response, Problem> {
    let request: LeaseRequest = read(body)?;
    let shared = &coordinator.shared;
    let mut work = shared.work.subscribe();
    let deadline = Instant::now() + LEASE_WAIT;
    loop {
        work.mark_unchanged();
        match shared.change(|schedule, now| schedule.lease(now, request.worker)) {
            LeaseAnswer::UnknownWorker => return Err(Problem::unknown_worker()),
            LeaseAnswer::Drain => return Ok(written(&LeaseResponse { lease: None, drain: true })),
            LeaseAnswer::Granted(lease) => {
                let id = format!("job-{}", lease.job);
                let job = shared.job(&id)?;
                let lease = wire::lease::encode_lease(lease.id, lease.fencing, &job.description, lease.work);
                return Ok(written(&LeaseResponse { lease: Some(lease), drain: false }));
            }
            LeaseAnswer::Nothing if Instant::now() >= deadline => {
                return Ok(written(&LeaseResponse { lease: None, drain: false }));
            }
            LeaseAnswer::Nothing => {
                let check = Instant::now() + LEASE_CHECK;
                let _ = timeout_at(check.min(deadline), work.changed()).await;
            }
        }
    }
}

async fn heartbeat(State(coordinator): State<CoordinatorHandle>, body: Bytes) -> Result<Response, Problem> {
    let request: HeartbeatRequest = read(body)?;
    let answer = coordinator.shared.change(|schedule, now| schedule.heartbeat(now, request.worker, &request.leases));
    let answer = answer.ok_or_else(Problem::unknown_worker)?;
    Ok(written(&HeartbeatResponse { cancelled: answer.cancelled, drain: answer.drain }))
}

async fn release(State(coordinator): State<CoordinatorHandle>, body: Bytes) -> Result<StatusCode, Problem> {
    let request: ReleaseRequest = read(body)?;
    coordinator.shared.change(|schedule, now| {
        schedule.release(now, request.worker, &request.leases);
        if request.leaving {
            schedule.worker_gone(request.worker);
        }
    });
    if request.leaving {
        tracing::info!(worker = request.worker, "worker left");
    }
    Ok(StatusCode::OK)
}

async fn result(State(coordinator): State<CoordinatorHandle>, body: Bytes) -> Result<Response, Problem> {
    let request: ResultRequest = read(body)?;
    // The merge goes on when the worker hangs up: its result was taken.
    let shared = coordinator.shared.clone();
    let delivered = coordinator.shared.busy.spawn_blocking(move || delivery::deliver(&shared, request));
    let response = delivered.await.map_err(|problem| {
        tracing::error!(%problem, "a result could not be merged");
        Problem::new(StatusCode::INTERNAL_SERVER_ERROR, problem.to_string())
    })?;
    Ok(written(&response?))
}

async fn scene(State(coordinator): State<CoordinatorHandle>, Path(hash): Path<String>) -> Result<Response, Problem> {
    let bytes = coordinator.scene_bytes(&hash)?;
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], Bytes::from_owner(bytes)).into_response())
}

async fn radius_field(
    State(coordinator): State<CoordinatorHandle>,
    Path((id, epoch, region)): Path<(String, u32, u32)>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let job = coordinator.shared.job(&id)?;
    let tag = format!("\"{id}-{epoch}-{region}\"");
    if headers.get(header::IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes()) {
        return Ok(StatusCode::NOT_MODIFIED.into_response());
    }
    let message = crate::farm::coordinator::blocking(move || {
        Ok(lock(&job.merging).as_ref().and_then(|merging| merging.field_message(epoch, region)))
    });
    let missing = || Problem::new(StatusCode::NOT_FOUND, format!("no radii of epoch {epoch}, region {region}"));
    let message = message.await?.ok_or_else(missing)?;
    let mut response = Bytes::from_owner(message).into_response();
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/x-protobuf"));
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    Ok(response)
}
