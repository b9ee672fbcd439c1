//! What a coordinator answers that stands by while another one leads.

use std::time::Duration;

use axum::Router;
use axum::http::StatusCode;
use axum::middleware::map_response;
use axum::routing::get;

use super::problem::Problem;
use super::{security_headers, workers};

/// When to ask again.
const RETRY: Duration = Duration::from_secs(2);

/// It lives, and does nothing.
pub(crate) fn router() -> Router {
    Router::new()
        .route("/healthz", get(workers::health))
        .route("/version", get(workers::version))
        .fallback(async || standing_by())
        .layer(map_response(security_headers::add))
}

fn standing_by() -> Problem {
    Problem::new(StatusCode::SERVICE_UNAVAILABLE, "standing-by", "another coordinator leads, and this one stands by")
        .remedy("ask the other one, or give both addresses with --coordinator")
        .retry_after(RETRY)
}
