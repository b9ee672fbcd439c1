//! What happens to a result: it is decoded and judged without locks, taken or refused by the schedule, and merged.

use axum::http::StatusCode;

use super::Problem;
use crate::estimate::Tally;
use crate::farm::coordinator::{JobRecord, Shared, lock};
use crate::farm::merging::Merging;
use crate::farm::rules::lease::{Lease, Work};
use crate::farm::rules::schedule::{Outcome, ResultAnswer};
use crate::farm::wire::messages::result_request::Outcome as Delivered;
use crate::farm::wire::messages::{self, ResultRequest, ResultResponse};
use crate::farm::wire::{WireError, result};
use crate::method;
use crate::render::Pilot;

/// A result that fits its work.
enum Payload {
    Pilot(Pilot),
    Tally(Tally, messages::Tally),
}

/// Takes a worker's result. Blocks while it decodes and merges.
pub(super) fn deliver(shared: &Shared, request: ResultRequest) -> Result<ResultResponse, Problem> {
    let (worker, id, fencing) = (request.worker, request.lease, request.fencing);
    let lease = shared.lock().schedule.leases().get(id).copied();
    let record = |outcome: &Outcome| shared.change(|schedule, now| schedule.result(now, worker, id, fencing, outcome));
    let Some(lease) = lease else {
        // The lease has ended; the schedule knows whether well or badly, whatever the result holds.
        return answer(record(&Outcome::Accepted));
    };
    let job = shared.job(&format!("job-{}", lease.job))?;
    if let Some(Delivered::Failure(problem)) = &request.outcome {
        return answer(record(&Outcome::Failed(shorten(problem))));
    }
    match payload(&job, &lease, request.outcome) {
        Ok(payload) => take(shared, &job, payload, || record(&Outcome::Accepted)),
        Err(problem) => match record(&Outcome::Refused(problem.to_string())) {
            ResultAnswer::Noted => Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, problem.to_string())),
            other => answer(other),
        },
    }
}

fn payload(job: &JobRecord, lease: &Lease, outcome: Option<Delivered>) -> Result<Payload, WireError> {
    let (width, height) = (job.description.width, job.description.height);
    let declaration = method::declaration(&job.description.method)
        .map_err(|problem| WireError::Impossible { field: "method", problem: problem.to_string() })?;
    match (lease.work, outcome.ok_or(WireError::Missing("outcome"))?) {
        (Work::Pilot, Delivered::Pilot(message)) => {
            Ok(Payload::Pilot(result::decode_pilot(&message, width as usize * height as usize, &declaration)?))
        }
        (Work::Shard(_, planned), Delivered::Tally(message)) => {
            let tally = result::decode_checked_tally(&message, planned.shard, width, &declaration)?;
            Ok(Payload::Tally(tally, message))
        }
        _ => Err(WireError::Impossible { field: "outcome", problem: "it is of another kind than the lease".into() }),
    }
}

/// Lets the schedule decide under the merge state's lock, so that what it takes is merged before anything else of the job.
fn take(
    shared: &Shared,
    job: &JobRecord,
    payload: Payload,
    decide: impl FnOnce() -> ResultAnswer,
) -> Result<ResultResponse, Problem> {
    let mut merging = lock(&job.merging);
    let decided = decide();
    let ResultAnswer::Take(lease) = decided else { return answer(decided) };
    let merged = match (payload, merging.as_mut(), lease.work) {
        (Payload::Pilot(pilot), _, _) => begin(shared, job, &pilot).map(|begun| *merging = Some(begun)),
        (Payload::Tally(tally, message), Some(merging), Work::Shard(index, _)) => {
            let merged = merging.add(index, &tally, message);
            let totals = merging.totals();
            shared.change(|schedule, now| schedule.merged(now, job.number, totals));
            merged
        }
        _ => Err("a tally came before the pilot".to_owned()),
    };
    if let Err(problem) = merged {
        tracing::error!(job = job.description.id, problem, "a result cannot be merged");
        shared.change(|schedule, now| schedule.fail(now, job.number, &problem));
    }
    Ok(ResultResponse { already_merged: false })
}

fn begin(shared: &Shared, job: &JobRecord, pilot: &Pilot) -> Result<Merging, String> {
    let declaration = method::declaration(&job.description.method).map_err(|problem| problem.to_string())?;
    let (width, height) = (job.description.width, job.description.height);
    let merging = Merging::new(width, height, pilot, &job.stop, declaration).map_err(|problem| problem.to_string())?;
    let plan = merging.plan.clone();
    tracing::info!(job = job.description.id, cost_per_pass = pilot.cost_per_pass(), ?plan, "pilot done");
    shared.change(|schedule, now| schedule.pilot_done(now, job.number, plan));
    Ok(merging)
}

fn answer(answer: ResultAnswer) -> Result<ResultResponse, Problem> {
    match answer {
        ResultAnswer::Take(_) | ResultAnswer::Noted => Ok(ResultResponse { already_merged: false }),
        ResultAnswer::AlreadyMerged => Ok(ResultResponse { already_merged: true }),
        ResultAnswer::Fenced => Err(Problem::new(StatusCode::CONFLICT, "this lease is not this worker's any more")),
    }
}

/// A worker's message is shown to users: its first thousand characters are enough.
fn shorten(problem: &str) -> String {
    problem.chars().take(1000).collect()
}
