//! Bodies of results: as many at the same time as memory is meant for, and none that falls silent.

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::http::{HeaderMap, StatusCode, header};
use bytes::{Bytes, BytesMut};
use futures_util::StreamExt;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

use super::problem::Problem;
use crate::farm::coordinator::Limits;

/// Bytes that one permit stands for.
const PERMIT_BYTES: u64 = 1024;

/// Place for results that are being received.
#[derive(Clone)]
pub(super) struct ResultRoom {
    permits: Arc<Semaphore>,
    limit: u64,
    silence: Duration,
}

/// A body, and the place that it takes for as long as it is held.
pub(super) struct Received {
    pub(super) body: Bytes,
    _place: OwnedSemaphorePermit,
}

impl ResultRoom {
    pub(super) fn new(limits: &Limits) -> Self {
        // One result must always find place.
        let room = limits.result_memory.max(limits.result_bytes).div_ceil(PERMIT_BYTES);
        Self {
            permits: Arc::new(Semaphore::new(room.min(u64::from(u32::MAX)) as usize)),
            limit: limits.result_bytes,
            silence: Duration::from_secs(limits.upload_silence),
        }
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
        let mut received = BytesMut::with_capacity(length as usize);
        let mut chunks = body.into_data_stream();
        loop {
            match timeout(self.silence, chunks.next()).await {
                Ok(None) => return Ok(Received { body: received.freeze(), _place: place }),
                Ok(Some(Ok(bytes))) => received.extend_from_slice(&bytes),
                Ok(Some(Err(problem))) => return Err(Problem::new(StatusCode::BAD_REQUEST, problem.to_string())),
                Err(_) => {
                    let text = format!("no byte came for {} s", self.silence.as_secs());
                    return Err(Problem::new(StatusCode::REQUEST_TIMEOUT, text));
                }
            }
        }
    }
}
