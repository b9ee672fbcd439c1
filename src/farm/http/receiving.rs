//! Bodies of results: as many at the same time as memory is meant for.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, StatusCode, header};
use bytes::BytesMut;
use futures_util::StreamExt;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::problem::Problem;
use super::server::fell_silent;
use crate::farm::coordinator::Limits;
use crate::farm::ids::LeaseId;
use crate::farm::locks::lock;

/// Bytes that one permit stands for.
const PERMIT_BYTES: u64 = 1024;

/// Place for results that are being received.
#[derive(Clone)]
pub(super) struct ResultRoom {
    permits: Arc<Semaphore>,
    limit: u64,
    on_the_way: Arc<Mutex<BTreeSet<LeaseId>>>,
}

/// A result that is being received; no second one of the same lease is, meanwhile.
struct OnTheWay<'a> {
    all: &'a Mutex<BTreeSet<LeaseId>>,
    lease: LeaseId,
}

impl<'a> OnTheWay<'a> {
    fn begin(all: &'a Mutex<BTreeSet<LeaseId>>, lease: LeaseId) -> Option<Self> {
        let is_first = lock(all).insert(lease);
        // Made only then: what is dropped takes the lease out.
        if is_first { Some(Self { all, lease }) } else { None }
    }
}

impl Drop for OnTheWay<'_> {
    fn drop(&mut self) {
        lock(self.all).remove(&self.lease);
    }
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
        let permits = Arc::new(Semaphore::new(room.min(u64::from(u32::MAX)) as usize));
        Self { permits, limit: limits.result_bytes, on_the_way: Arc::default() }
    }

    /// Waits for place and reads the body of a lease's result, of at most `most` bytes, as long as it `is_awaited`.
    ///
    /// # Errors
    /// No length is given, it is above a limit, the bytes stop coming, nobody waits for them any more, or they are on their way already.
    pub(super) async fn receive(
        &self,
        lease: LeaseId,
        most: u64,
        headers: &HeaderMap,
        body: Body,
        is_awaited: impl Fn() -> bool,
    ) -> Result<Received, Problem> {
        let length = headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
        let length = length.ok_or_else(|| Problem::new(StatusCode::LENGTH_REQUIRED, "give Content-Length"))?;
        let limit = self.limit.min(most);
        if length > limit {
            let text = format!("the result has {length} bytes; {limit} are taken");
            return Err(Problem::new(StatusCode::PAYLOAD_TOO_LARGE, text));
        }
        let Some(_only) = OnTheWay::begin(&self.on_the_way, lease) else {
            return Err(Problem::new(StatusCode::SERVICE_UNAVAILABLE, "this result is on its way already"));
        };
        let permits = length.div_ceil(PERMIT_BYTES) as u32;
        let place = self.permits.clone().acquire_many_owned(permits).await;
        let place = place.map_err(|problem| Problem::new(StatusCode::SERVICE_UNAVAILABLE, problem.to_string()))?;
        let (mut chunks, mut received) = (body.into_data_stream(), BytesMut::with_capacity(length as usize));
        while let Some(chunk) = chunks.next().await {
            received.extend_from_slice(&chunk.map_err(|problem| broken(&problem))?);
            if !is_awaited() {
                return Err(Problem::new(StatusCode::CONFLICT, "this lease ended while its result came"));
            }
        }
        Ok(Received { body: received.freeze(), _place: place })
    }
}
