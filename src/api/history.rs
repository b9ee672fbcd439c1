//! A job's own error estimate over time, as numbers: what `chart.svg` draws.

use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use super::ApiState;
use super::extract::{PathValue, parse_job};
use super::images::{etag, unchanged};
use super::json_answer::Json;
use super::problem::Problem;
use crate::farm::rules::terms::ErrorPoint;

/// How a job's error fell.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct History {
    /// Oldest first; empty while nothing was estimated.
    pub points: Vec<HistoryPoint>,
}

/// An estimate and when it was made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct HistoryPoint {
    /// Seconds that the job had been running.
    pub seconds: f64,
    /// Passes merged then.
    pub passes: u32,
    /// The estimate: noise and bias together.
    pub relmse: f64,
    /// Its part by noise.
    pub noise: f64,
    /// Its part by the bias of density estimates.
    pub bias: f64,
    /// relMSE was below this with 95 % confidence.
    pub bound: f64,
}

impl From<ErrorPoint> for HistoryPoint {
    fn from(ErrorPoint { seconds, measured }: ErrorPoint) -> Self {
        let error = measured.error;
        let relmse = error.noise + error.bias;
        Self { seconds, passes: measured.passes, relmse, noise: error.noise, bias: error.bias, bound: error.bound }
    }
}

/// The job's own error estimate over time.
#[utoipa::path(
    get, path = "/jobs/{id}/history", tag = "jobs",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "All estimates so far", body = History, headers(("ETag" = String))),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn history(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let id = parse_job(&id)?;
    let status = state.coordinator.job(id)?;
    if let Some(unchanged) = unchanged(&status, "history", &headers) {
        return Ok(unchanged);
    }
    let points = state.coordinator.error_history(id)?.into_iter().map(HistoryPoint::from).collect();
    let keeping = [(header::ETAG, etag(&status, "history")), (header::CACHE_CONTROL, "private, no-cache".to_owned())];
    Ok((keeping, Json(History { points })).into_response())
}
