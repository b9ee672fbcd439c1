//! What happens to a result: it is decoded and judged without locks, then the coordinator takes it or does not.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use axum::http::StatusCode;
use prost::Message;

use super::problem::Problem;
use crate::estimate::Declaration;
use crate::farm::coordinator::{Delivered, Delivery, JobRecord, Payload, Shared};
use crate::farm::rules::check::Digest;
use crate::farm::rules::lease::{Errand, Lease, Work};
use crate::farm::rules::{Answer, Outcome};
use crate::farm::text::is_hidden;
use crate::farm::wire::lease::JobDescription;
use crate::farm::wire::messages::result_request::Outcome as Sent;
use crate::farm::wire::messages::{self, ResultRequest, ResultResponse};
use crate::farm::wire::{WireError, first_surfaces, mattes, result};
use crate::method::{MOST_GUIDE_VALUES, MethodChoice};

/// Whether the worker that delivers has the lease, so that its result is worth the memory that it takes.
pub(super) fn is_awaited(shared: &Shared, delivery: Delivery) -> bool {
    let Delivery { worker, lease, fencing } = delivery;
    let state = shared.lock();
    state.rules.leases().get(lease).is_some_and(|lease| lease.worker == worker && lease.fencing == fencing)
}

/// How many bytes the result of an awaited delivery may have: all its planes without compression, and a little. `None` when it is not awaited.
pub(super) fn awaited_bytes(shared: &Shared, delivery: Delivery) -> Result<Option<u64>, Problem> {
    /// Names, counts and the lengths of chunks.
    const FURTHER: u64 = 1 << 16;
    /// Bytes a pixel of pilots and first surfaces at most: sixteen numbers.
    const PIXEL: u64 = 64;
    if !is_awaited(shared, delivery) {
        return Ok(None);
    }
    let Some(lease) = shared.lock().rules.leases().get(delivery.lease).copied() else { return Ok(None) };
    let job = shared.job(lease.job)?.description();
    let pixels = u64::from(job.width) * u64::from(job.height);
    let bytes = match lease.work {
        Work::Choice => 0,
        Work::Pilot => PIXEL * pixels + (MOST_GUIDE_VALUES * size_of::<f32>()) as u64,
        Work::Errand(Errand::FirstSurfaces) => PIXEL * pixels,
        Work::Errand(Errand::Mattes) => mattes::MOST_PIXEL_BYTES as u64 * pixels + mattes::MOST_NAME_BYTES as u64,
        Work::Shard(_, planned) | Work::Check(_, planned) => {
            let numbers: usize = declaration(&job)?.planes.iter().map(|plane| plane.channels).sum();
            planned.shard.region.pixel_count(job.width) as u64 * numbers as u64 * size_of::<f32>() as u64
        }
    };
    // Numbers that do not compress grow by a part in 255.
    Ok(Some(bytes + bytes / 128 + FURTHER))
}

/// Answers a worker whose lease has ended; the rules know whether well or badly, whatever the result holds.
pub(super) fn turn_away(shared: &Shared, delivery: Delivery) -> Result<ResultResponse, Problem> {
    if is_awaited(shared, delivery) {
        return Err(fenced());
    }
    answer(shared.record_result(delivery, Outcome::Accepted(None)))
}

/// Takes a worker's result. Blocks while it decodes and merges.
pub(super) fn deliver(shared: &Shared, delivery: Delivery, request: ResultRequest) -> Result<ResultResponse, Problem> {
    let lease = shared.lock().rules.leases().get(delivery.lease).copied();
    let Some(lease) = lease else { return turn_away(shared, delivery) };
    let job = shared.job(lease.job)?;
    if let Some(Sent::Failure(problem)) = &request.outcome {
        return answer(shared.record_result(delivery, Outcome::Failed(shorten(problem))));
    }
    let digest = shared.lock().rules.wants_digest(&lease).then(|| digest(request.outcome.as_ref()));
    match decode(&job, &lease, request.outcome) {
        Ok(payload) => match shared.take_result(&job, delivery, payload, digest) {
            Delivered::Taken => Ok(ResultResponse { already_merged: false }),
            Delivered::AlreadyMerged => Ok(ResultResponse { already_merged: true }),
            Delivered::Fenced => Err(fenced()),
        },
        Err(problem) => match shared.record_result(delivery, Outcome::Refused(problem.to_string())) {
            Answer::Recorded => Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, problem.to_string())),
            other => answer(other),
        },
    }
}

/// Decodes and checks. A fault in here is the result's, not the job's.
fn decode(job: &JobRecord, lease: &Lease, outcome: Option<Sent>) -> Result<Payload, WireError> {
    catch_unwind(AssertUnwindSafe(|| payload(job, lease, outcome)))
        .unwrap_or_else(|_| Err(WireError::Malformed("it cannot even be refused properly".to_owned())))
}

fn payload(job: &JobRecord, lease: &Lease, outcome: Option<Sent>) -> Result<Payload, WireError> {
    let description = job.description();
    let (width, pixels) = (description.width, description.width as usize * description.height as usize);
    match (lease.work, outcome.ok_or(WireError::Missing("outcome"))?) {
        (Work::Choice, Sent::Choice(messages::Choice { method, reason, parameters })) => {
            let parameters = match parameters.as_str() {
                "" => serde_json::Map::new(),
                text => serde_json::from_str(text)
                    .map_err(|_| WireError::Malformed("parameters are no JSON object".to_owned()))?,
            };
            Ok(Payload::Choice { choice: MethodChoice { name: method, parameters }, reason: shorten(&reason) })
        }
        (Work::Pilot, Sent::Pilot(message)) => {
            Ok(Payload::Pilot(result::decode_pilot(&message, pixels, &*declaration(&description)?)?))
        }
        (Work::Shard(_, planned) | Work::Check(_, planned), Sent::Tally(message)) => {
            let declaration = declaration(&description)?;
            let tally = result::decode_checked_tally(&message, planned.shard, width, &declaration)?;
            Ok(Payload::Tally(tally))
        }
        (Work::Errand(Errand::FirstSurfaces), Sent::FirstSurfaces(message)) => {
            Ok(Payload::FirstSurfaces(first_surfaces::decode(&message, pixels)?))
        }
        (Work::Errand(Errand::Mattes), Sent::Mattes(message)) => Ok(Payload::Mattes(mattes::decode(message, pixels)?)),
        _ => Err(WireError::Impossible { field: "outcome", problem: "it is of another kind than the lease".into() }),
    }
}

/// What the tallies of a job hold.
fn declaration(job: &JobDescription) -> Result<Arc<Declaration>, WireError> {
    job.declaration().ok_or(WireError::Missing("method"))
}

/// All bits of a tally. Equal builds compress alike, so the message says as much as the numbers.
fn digest(outcome: Option<&Sent>) -> Digest {
    let bytes = match outcome {
        Some(Sent::Tally(tally)) => tally.encode_to_vec(),
        _ => Vec::new(),
    };
    Digest(*blake3::hash(&bytes).as_bytes())
}

fn answer(answer: Answer) -> Result<ResultResponse, Problem> {
    match answer {
        Answer::AlreadyMerged => Ok(ResultResponse { already_merged: true }),
        Answer::Fenced => Err(fenced()),
        _ => Ok(ResultResponse { already_merged: false }),
    }
}

fn fenced() -> Problem {
    Problem::new(StatusCode::CONFLICT, "this lease is not this worker's any more")
}

/// A worker's message is shown to users: its first thousand characters are enough.
fn shorten(problem: &str) -> String {
    // Nothing in it may move a terminal's cursor or begin a line of a log.
    problem.chars().take(1000).map(|letter| if is_hidden(letter) { ' ' } else { letter }).collect()
}
