//! Jobs as they change, as server-sent events. The stream of all jobs numbers what it says, and tells what was missed when it is opened again with
//! `Last-Event-ID`; that of one job begins with how it is.

use std::convert::Infallible;
use std::time::Duration;

use axum::Extension;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName};
use axum::response::Sse;
use axum::response::sse::{Event, KeepAlive};
use futures_util::stream::{self, Stream, StreamExt};
use serde::Serialize;
use tokio::sync::watch;
use utoipa::ToSchema;

use super::ApiState;
use super::extract::{PathValue, parse_job};
use super::jobs::JobView;
use super::problem::Problem;
use crate::farm::access::caller::Caller;
use crate::farm::http::bearer::text;
use crate::farm::job::{Changes, JobStatus};

/// The least time between two events of a job, and between two looks at all jobs: about five a second.
const EVENT_INTERVAL: Duration = Duration::from_millis(200);
/// How often a silent stream says that it lives, so that proxies do not cut it.
const KEEP_ALIVE_INTERVAL: Duration = Duration::from_secs(15);

type Events<S> = Sse<axum::response::sse::KeepAliveStream<S>>;

fn keep_alive() -> KeepAlive {
    KeepAlive::new().interval(KEEP_ALIVE_INTERVAL)
}

/// Streams `status` events with the job's status, at once and on every change, at most about five a second. The stream
/// ends with the job's final state.
#[utoipa::path(
    get, path = "/jobs/{id}/events", tag = "jobs",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "Events named status, each with a JobView", body = JobView,
            content_type = "text/event-stream"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn job_events(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    PathValue(id): PathValue<String>,
) -> Result<Events<impl Stream<Item = Result<Event, Infallible>>>, Problem> {
    let receiver = state.coordinator.watch(parse_job(&id)?)?;
    let following = Following { receiver, state, caller, progress: Progress::Start };
    Ok(Sse::new(status_events(following)).keep_alive(keep_alive()))
}

/// Where a stream of one job stands.
enum Progress {
    Start,
    Following,
    Ended,
}

struct Following {
    receiver: watch::Receiver<JobStatus>,
    state: ApiState,
    caller: Caller,
    progress: Progress,
}

fn status_events(following: Following) -> impl Stream<Item = Result<Event, Infallible>> {
    stream::unfold(following, |mut following| async move {
        match following.progress {
            Progress::Ended => return None,
            Progress::Start => {}
            Progress::Following => {
                let next = async {
                    tokio::time::sleep(EVENT_INTERVAL).await;
                    following.receiver.changed().await.ok()
                };
                following.state.shutdown.run_until_cancelled(next).await??;
            }
        }
        if !following.state.coordinator.knows(&following.caller) {
            return None;
        }
        let status = following.receiver.borrow_and_update().clone();
        following.progress = if status.state.is_final() { Progress::Ended } else { Progress::Following };
        // A status is plain data with string keys; it always has a JSON form.
        let event = Event::default().event("status").json_data(JobView::from(status)).ok()?;
        Some((Ok(event), following))
    })
}

/// What an event of the stream of all jobs holds; its name says which of these.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub(crate) enum FarmEvent {
    /// `status`: a job as it is now.
    Status(Box<JobView>),
    /// `deleted`: a job that is gone.
    Deleted(DeletedJob),
    /// `reset`: what was known before is to be forgotten.
    Reset(Reset),
}

/// A job that was deleted.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(crate) struct DeletedJob {
    /// Its id.
    pub id: String,
}

/// Nothing but that what was known before is to be forgotten.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(crate) struct Reset {}

impl FarmEvent {
    fn name(&self) -> &'static str {
        match self {
            Self::Status(_) => "status",
            Self::Deleted(_) => "deleted",
            Self::Reset(_) => "reset",
        }
    }
}

/// Streams all jobs: first each that there is, then each that changes, as `status` events; `deleted` events, each with an id; and `reset` when too
/// much was missed, and what was known before is to be forgotten. With `Last-Event-ID` it begins with what was missed.
#[utoipa::path(
    get, path = "/events", tag = "jobs",
    params(("Last-Event-ID" = Option<String>, Header, description = "The id of the last event that was received")),
    responses((status = 200, description = "Events named status, deleted and reset, each with what that says", body = FarmEvent,
        content_type = "text/event-stream"))
)]
pub(crate) async fn all_events(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    headers: HeaderMap,
) -> Events<impl Stream<Item = Result<Event, Infallible>>> {
    let last = text(&headers, HeaderName::from_static("last-event-id"));
    let run = state.coordinator.run();
    // Numbers of an earlier run say nothing.
    let seen = last.and_then(|id| id.split_once('-')).filter(|(earlier, _)| *earlier == run.to_string());
    let seen = seen.and_then(|(_, number)| number.parse().ok());
    let newest = state.coordinator.watch_changes();
    let is_lost = last.is_some() && seen.is_none();
    let watching = Watching { newest, state, caller, run, seen: seen.unwrap_or(0), is_first: true, is_lost };
    Sse::new(change_events(watching).flat_map(stream::iter)).keep_alive(keep_alive())
}

/// Where a stream of all jobs stands.
struct Watching {
    newest: watch::Receiver<u64>,
    state: ApiState,
    caller: Caller,
    run: u64,
    seen: u64,
    is_first: bool,
    /// Whether the client knows something that is not known here.
    is_lost: bool,
}

fn change_events(watching: Watching) -> impl Stream<Item = Vec<Result<Event, Infallible>>> {
    stream::unfold(watching, |mut watching| async move {
        if !watching.is_first {
            let next = async {
                tokio::time::sleep(EVENT_INTERVAL).await;
                watching.newest.changed().await.ok()
            };
            watching.state.shutdown.run_until_cancelled(next).await??;
        }
        if !watching.state.coordinator.knows(&watching.caller) {
            return None;
        }
        watching.newest.mark_unchanged();
        let changes = watching.state.coordinator.changes(watching.seen);
        let is_reset = changes.is_reset || watching.is_lost;
        (watching.is_first, watching.is_lost, watching.seen) = (false, false, changes.newest);
        let id = format!("{}-{}", watching.run, changes.newest);
        Some((events(changes, is_reset, &id), watching))
    })
}

/// Only the last event of a batch has an id: whoever receives a part of it gets the whole batch again.
fn events(changes: Changes, is_reset: bool, id: &str) -> Vec<Result<Event, Infallible>> {
    let reset = is_reset.then_some(FarmEvent::Reset(Reset {}));
    let deleted = changes.deleted.into_iter().map(|job| FarmEvent::Deleted(DeletedJob { id: job.to_string() }));
    let statuses = changes.jobs.into_iter().map(|job| FarmEvent::Status(Box::new(job.into())));
    let written = |event: FarmEvent| Event::default().event(event.name()).json_data(event).ok();
    let mut events: Vec<Event> = reset.into_iter().chain(deleted).chain(statuses).filter_map(written).collect();
    if let Some(last) = events.pop() {
        events.push(last.id(id));
    }
    events.into_iter().map(Ok).collect()
}
