//! Bodies of results: as many at the same time as memory is meant for.

use std::sync::Arc;

use axum::body::{Body, Bytes, to_bytes};
use axum::http::{HeaderMap, StatusCode, header};
use futures_util::StreamExt;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::problem::Problem;
use super::server::fell_silent;
use crate::farm::coordinator::Limits;

/// Bytes that one permit stands for.
const PERMIT_BYTES: u64 = 1024;

/// Place for results that are being received.
#[derive(Clone)]
pub(super) struct ResultRoom {
    permits: Arc<Semaphore>,
    limit: u64,
}

/// A body, and the place that it takes for as long as it is held.
pub(super) struct Received {
    pub(super) body: Bytes,
    _place: OwnedSemaphorePermit,
}

/// Lets bytes that nobody waits for pass, so that the sender reads the answer; none is kept.
pub(super) async fn pass_over(body: Body) -> Result<(), Problem> {
    let mut chunks = body.into_data_stream();
    while let Some(chunk) = chunks.next().await {
        chunk.map_err(|problem| broken(&problem))?;
    }
    Ok(())
}

fn broken(problem: &axum::Error) -> Problem {
    let status = if fell_silent(problem) { StatusCode::REQUEST_TIMEOUT } else { StatusCode::BAD_REQUEST };
    Problem::new(status, problem.to_string())
}

impl ResultRoom {
    pub(super) fn new(limits: &Limits) -> Self {
        // One result must always find place.
        let room = limits.result_memory.max(limits.result_bytes).div_ceil(PERMIT_BYTES);
        Self { permits: Arc::new(Semaphore::new(room.min(u64::from(u32::MAX)) as usize)), limit: limits.result_bytes }
    }

    /// Waits for place and reads the body.
    ///
    /// # Errors
    /// No length is given, it is above the limit, or the bytes stop coming.
    pub(super) async fn receive(&self, headers: &HeaderMap, body: Body) -> Result<Received, Problem> {
        let length = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
        let length = length.ok_or_else(|| Problem::new(StatusCode::LENGTH_REQUIRED, "give Content-Length"))?;
        if length > self.limit {
            let text = format!("the result has {length} bytes; {} are taken", self.limit);
            return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, text));
        }
        let permits = length.div_ceil(PERMIT_BYTES) as u32;
        let place = self.permits.clone().acquire_many_owned(permits).await;
        let place = place.map_err(|problem| Problem::new(StatusCode::SERVICE_UNAVAILABLE, problem.to_string()))?;
        let body = to_bytes(body, length as usize).await.map_err(|problem| broken(&problem))?;
        Ok(Received { body, _place: place })
    }
}
