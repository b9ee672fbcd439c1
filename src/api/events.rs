//! A job's status as it changes, as server-sent events.

use std::convert::Infallible;
use std::time::Duration;

use axum::extract::State;
use axum::response::Sse;
use axum::response::sse::{Event, KeepAlive};
use futures_util::stream::{self, Stream};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

use super::ApiState;
use super::extract::{PathValue, parse_job};
use super::jobs::JobView;
use super::problem::Problem;
use crate::farm::job::JobStatus;

/// The least time between two events of a stream: about five a second.
const EVENT_INTERVAL: Duration = Duration::from_millis(200);
/// How often a silent stream says that it lives, so that proxies do not cut it.
const KEEP_ALIVE_INTERVAL: Duration = Duration::from_secs(15);

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
pub async fn job_events(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, Problem> {
    let receiver = state.coordinator.watch(parse_job(&id)?)?;
    let keep_alive = KeepAlive::new().interval(KEEP_ALIVE_INTERVAL);
    Ok(Sse::new(status_events(receiver, state.shutdown)).keep_alive(keep_alive))
}

/// Where a stream stands.
enum Progress {
    Start,
    Following,
    Ended,
}

fn status_events(
    receiver: watch::Receiver<JobStatus>,
    shutdown: CancellationToken,
) -> impl Stream<Item = Result<Event, Infallible>> {
    stream::unfold((receiver, shutdown, Progress::Start), |(mut receiver, shutdown, progress)| async move {
        match progress {
            Progress::Ended => return None,
            Progress::Start => {}
            Progress::Following => {
                let next = async {
                    tokio::time::sleep(EVENT_INTERVAL).await;
                    receiver.changed().await.ok()
                };
                shutdown.run_until_cancelled(next).await??;
            }
        }
        let status = receiver.borrow_and_update().clone();
        let progress = if status.state.is_final() { Progress::Ended } else { Progress::Following };
        // A status is plain data with string keys; it always has a JSON form.
        let event = Event::default().event("status").json_data(JobView::from(status)).ok()?;
        Some((Ok(event), (receiver, shutdown, progress)))
    })
}
