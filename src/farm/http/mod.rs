//! The workers' protocol over HTTP, to be mounted under `/farm/v1`.
//!
//! | request | answers |
//! |---|---|
//! | `POST register` | 200 with a secret; 401 and 403 without a token for workers, where there are users; 409 when the worker is of another build |
//! | `POST lease` | 200 with a lease, without one after some seconds, or saying that the worker is to leave |
//! | `POST heartbeat`, `POST release` | 200 |
//! | `POST leases/{lease}/{fencing}/result` | 200, also when it came before; 409 when the lease is not the worker's any more; 422 when refused |
//! | `GET scenes/{hash}` | 200; 404 |
//! | `GET jobs/{id}/radius/{epoch}/{region}` | 200, 304; 404 when it is not needed any more |
//!
//! Every request but the first shows the secret, as `Authorization: Bearer SECRET`; it says which worker speaks. A result answers 408 when its bytes
//! stop coming, 411 without a length, 413 when it is too long; it waits while others fill the memory that is meant for results, and bytes that
//! nobody waits for are not kept. A worker that the coordinator does not know (any more) gets 410 and registers again. Problems are plain text.

mod admission;
pub(crate) mod bearer;
mod delivery;
mod patient_stream;
mod problem;
mod receiving;
pub mod server;
pub(crate) mod visitor;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Extension, FromRequest, Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use prost::Message;
use tokio::time::{Instant, timeout_at};

use crate::farm::coordinator::{CoordinatorHandle, Delivery, Limits, Shared, blocking};
use crate::farm::error::FarmError;
use crate::farm::ids::{Fencing, JobId, LeaseId, WorkerId};
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::lease::{Lease, Work};
use crate::farm::rules::{Answer, Event};
use crate::farm::text::is_hidden;
use crate::farm::wire::lease::{LeasedWork, ShardTerms, WorkerLease};
use crate::farm::wire::messages::{
    HeartbeatRequest, HeartbeatResponse, LeaseResponse, RegisterRequest, RegisterResponse, ReleaseRequest,
};
use crate::farm::wire::{self, WireError};
use admission::{know_worker, refuse_strangers};
use bearer::bearer;
use problem::Problem;
use receiving::ResultRoom;

/// How long a worker waits for work before it is told that there is none.
const LEASE_WAIT: Duration = Duration::from_secs(10);
/// How often a waiting worker's turn is checked even if nothing happened: shards become overdue by time alone.
const LEASE_CHECK: Duration = Duration::from_millis(500);

/// Routes for workers: register, lease, heartbeat, result, release, scenes and radius fields.
pub fn router(coordinator: CoordinatorHandle) -> Router {
    let room = ResultRoom::new(coordinator.limits());
    let messages = DefaultBodyLimit::max(coordinator.limits().message_bytes);
    Router::new()
        .route("/lease", post(lease))
        .route("/heartbeat", post(heartbeat))
        .route("/release", post(release))
        .route("/leases/{lease}/{fencing}/result", post(result).layer(Extension(room)))
        .route("/scenes/{hash}", get(scene))
        .route("/jobs/{id}/radius/{epoch}/{region}", get(radius_field))
        .route("/jobs/{id}/guide", get(guides))
        .route_layer(from_fn_with_state(coordinator.clone(), know_worker))
        .route("/register", post(register))
        .layer(messages)
        .layer(from_fn_with_state(coordinator.clone(), refuse_strangers))
        .with_state(coordinator)
}

fn read<M: Message + Default>(body: Bytes) -> Result<M, Problem> {
    M::decode(body).map_err(|problem| WireError::Malformed(problem.to_string()).into())
}

fn written(message: &impl Message) -> Response {
    ([(header::CONTENT_TYPE, "application/x-protobuf")], message.encode_to_vec()).into_response()
}

async fn register(
    State(coordinator): State<CoordinatorHandle>,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Problem> {
    // Who may not join is told so before a byte is kept.
    let admitted = coordinator.caller(bearer(&headers)).and_then(|caller| caller.token_to_join());
    let token = admitted.map_err(|denied| Problem::denied(&denied))?;
    let body = Bytes::from_request(request, &()).await;
    let request: RegisterRequest = read(body.map_err(|problem| Problem::new(problem.status(), problem.body_text()))?)?;
    if request.build != wire::BUILD {
        let text = format!(
            "this worker is build {}, the coordinator is build {}; run the same program on both sides",
            request.build,
            wire::BUILD
        );
        return Err(Problem::new(StatusCode::CONFLICT, text));
    }
    let Limits { name_bytes: longest, worker_threads: most, .. } = *coordinator.limits();
    let is_name = (1..=longest).contains(&request.name.len()) && !request.name.chars().any(is_hidden);
    if !is_name || !(1..=most).contains(&request.threads) {
        let text =
            format!("a worker has a name of 1 to {longest} bytes without control characters, and 1 to {most} threads");
        return Err(Problem::new(StatusCode::BAD_REQUEST, text));
    }
    let shared = &coordinator.shared;
    tracing::debug!(name = request.name, features = request.features, "worker registers");
    let joined = shared.apply(Event::WorkerJoined { name: request.name, threads: request.threads });
    let Answer::Joined(worker) = joined else { return Err(Problem::unknown_worker()) };
    let lease_milliseconds = shared.options.lease_duration.as_millis() as u32;
    let secret = shared.worker_secrets.issue(worker, token);
    Ok(written(&RegisterResponse { worker: worker.number(), lease_milliseconds, secret }))
}

async fn lease(
    State(coordinator): State<CoordinatorHandle>,
    Extension(worker): Extension<WorkerId>,
) -> Result<Response, Problem> {
    let shared = &coordinator.shared;
    let mut work = shared.work.subscribe();
    let deadline = Instant::now() + LEASE_WAIT;
    loop {
        work.mark_unchanged();
        match shared.apply(Event::LeaseWanted { worker }) {
            Answer::UnknownWorker => return Err(Problem::unknown_worker()),
            Answer::Draining => return Ok(written(&LeaseResponse { drain: true, ..LeaseResponse::default() })),
            Answer::Leave => return Ok(written(&LeaseResponse { leave: true, ..LeaseResponse::default() })),
            Answer::Granted(lease) => {
                let lease = wire::lease::encode_lease(&granted(shared, &lease)?);
                return Ok(written(&LeaseResponse { lease: Some(lease), ..LeaseResponse::default() }));
            }
            _ if Instant::now() >= deadline => return Ok(written(&LeaseResponse::default())),
            _ => {
                let check = Instant::now() + LEASE_CHECK;
                let _ = timeout_at(check.min(deadline), work.changed()).await;
            }
        }
    }
}

/// A lease as the worker reads it.
fn granted(shared: &Arc<Shared>, lease: &Lease) -> Result<WorkerLease, FarmError> {
    let job = shared.job(lease.job)?;
    let work = match lease.work {
        Work::Choice => LeasedWork::Choice(shared.choice_terms(&job)),
        Work::Pilot => LeasedWork::Pilot,
        Work::Shard(_, planned) | Work::Check(_, planned) => {
            LeasedWork::Shard(ShardTerms { planned, generation: job.generation.load(Ordering::Relaxed) })
        }
        Work::Errand(errand) => LeasedWork::Errand(errand),
    };
    Ok(WorkerLease { id: lease.id, fencing: lease.fencing, job: job.description(), work })
}

async fn heartbeat(
    State(coordinator): State<CoordinatorHandle>,
    Extension(worker): Extension<WorkerId>,
    body: Bytes,
) -> Result<Response, Problem> {
    let request: HeartbeatRequest = read(body)?;
    let leases = request.leases.into_iter().map(LeaseId::new).collect();
    match coordinator.shared.apply(Event::HeartbeatCame { worker, leases }) {
        Answer::Alive { cancelled } => {
            let cancelled = cancelled.into_iter().map(LeaseId::number).collect();
            Ok(written(&HeartbeatResponse { cancelled }))
        }
        _ => Err(Problem::unknown_worker()),
    }
}

async fn release(
    State(coordinator): State<CoordinatorHandle>,
    Extension(worker): Extension<WorkerId>,
    body: Bytes,
) -> Result<StatusCode, Problem> {
    let request: ReleaseRequest = read(body)?;
    let leases = request.leases.into_iter().map(LeaseId::new).collect();
    coordinator.shared.apply(Event::LeasesReleased { worker, leases });
    if request.leaving {
        coordinator.shared.apply(Event::WorkerLeft { worker });
    }
    Ok(StatusCode::OK)
}

async fn result(
    State(coordinator): State<CoordinatorHandle>,
    Extension(room): Extension<ResultRoom>,
    Extension(worker): Extension<WorkerId>,
    Path((lease, fencing)): Path<(u64, u64)>,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, Problem> {
    let delivery = Delivery { worker, lease: LeaseId::new(lease), fencing: Fencing::new(fencing) };
    let shared = coordinator.shared.clone();
    let Some(most) = delivery::awaited_bytes(&shared, delivery)? else {
        receiving::pass_over(body).await?;
        return Ok(written(&delivery::turn_away(&shared, delivery)?));
    };
    // A worker whose token is revoked keeps no lease alive, so what it sends is not awaited soon.
    let is_awaited = || delivery::is_awaited(&shared, delivery);
    let received = room.receive(delivery.lease, most, &headers, body, is_awaited).await?;
    coordinator.count_received(received.body.len() as u64);
    // The merge goes on when the worker hangs up: its result was taken.
    let shared = coordinator.shared.clone();
    let deliver = move || {
        let response = read(received.body.clone()).and_then(|request| delivery::deliver(&shared, delivery, request));
        drop(received);
        response
    };
    let delivered = coordinator.shared.busy.spawn_blocking(deliver);
    let response = delivered.await.map_err(|problem| {
        tracing::error!(%problem, "a result could not be merged");
        Problem::new(StatusCode::INTERNAL_SERVER_ERROR, problem.to_string())
    })?;
    Ok(written(&response?))
}

async fn scene(State(coordinator): State<CoordinatorHandle>, Path(hash): Path<String>) -> Result<Response, Problem> {
    let bytes = coordinator.scene_bytes(&hash).await?;
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response())
}

async fn radius_field(
    State(coordinator): State<CoordinatorHandle>,
    Path((id, epoch, region)): Path<(JobId, u32, u32)>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let job = coordinator.shared.job(id)?;
    let tag = format!("\"{id}-{}-{epoch}-{region}\"", job.generation.load(Ordering::Relaxed));
    if headers.get(header::IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes()) {
        return Ok(StatusCode::NOT_MODIFIED.into_response());
    }
    let message =
        blocking(move || Ok(lock(&job.merging).as_ref().and_then(|merging| merging.field_message(epoch, region))));
    let missing = || Problem::new(StatusCode::NOT_FOUND, format!("no radii of epoch {epoch}, region {region}"));
    let message = message.await?.ok_or_else(missing)?;
    let mut response = Bytes::from_owner(message).into_response();
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/x-protobuf"));
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    Ok(response)
}

async fn guides(State(coordinator): State<CoordinatorHandle>, Path(id): Path<JobId>) -> Result<Response, Problem> {
    let job = coordinator.shared.job(id)?;
    let message = blocking(move || Ok(lock(&job.merging).as_ref().map(Merging::guides_message)));
    let missing = || Problem::new(StatusCode::NOT_FOUND, "the job has no pilot yet".to_owned());
    let message = message.await?.ok_or_else(missing)?;
    Ok(([(header::CONTENT_TYPE, "application/x-protobuf")], message).into_response())
}
