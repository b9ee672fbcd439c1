//! Who may speak the workers' protocol: those that joined, each with the secret that it got then.

use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::Response;

use super::bearer::bearer;
use super::problem::Problem;
use super::visitor;
use crate::farm::coordinator::CoordinatorHandle;

/// Nobody's web page works on pictures here.
pub(super) async fn refuse_strangers(
    State(coordinator): State<CoordinatorHandle>,
    request: Request,
    next: Next,
) -> Result<Response, Problem> {
    visitor::check(request.method(), request.uri(), request.headers(), coordinator.host_names())
        .map_err(|stranger| Problem::new(StatusCode::FORBIDDEN, format!("{stranger}; {}", stranger.remedy())))?;
    Ok(next.run(request).await)
}

/// Says which worker sent a request, as an extension of the type [`WorkerId`](crate::farm::ids::WorkerId).
pub(super) async fn know_worker(
    State(coordinator): State<CoordinatorHandle>,
    mut request: Request,
    next: Next,
) -> Result<Response, Problem> {
    let secret = bearer(request.headers()).unwrap_or_default();
    let worker = coordinator.shared.worker_with(secret).ok_or_else(Problem::unknown_worker)?;
    request.extensions_mut().insert(worker);
    Ok(next.run(request).await)
}
