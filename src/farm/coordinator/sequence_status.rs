//! What users are told of sequences.

use super::sequence_record::{Halt, SequenceFacts, SequenceRecord};
use super::shared::Shared;
use crate::farm::ids::SequenceId;
use crate::farm::job::{JobState, JobStatus};
use crate::farm::locks::lock;
use crate::farm::sequence::{FrameJob, SequenceRequest, SequenceState, SequenceStatus};

impl Shared {
    /// How a sequence is doing.
    pub(super) fn sequence_status(&self, record: &SequenceRecord) -> SequenceStatus {
        let facts = lock(&record.facts).clone();
        let state = self.lock();
        let jobs = facts.jobs.iter().filter_map(|(frame, id)| Some((*frame, state.jobs.get(id)?)));
        let jobs = jobs.map(|(frame, job)| (frame, state.status(job, &self.clock))).collect();
        status(record.id, facts, jobs)
    }
}

fn status(id: SequenceId, facts: SequenceFacts, jobs: Vec<(u32, JobStatus)>) -> SequenceStatus {
    let SequenceRequest { job: request, frames, at_once, .. } = facts.request;
    let count = |state: JobState| jobs.iter().filter(|(_, job)| job.state == state).count() as u32;
    let (total, live) = (frames.count(), jobs.iter().filter(|(_, job)| !job.state.is_final()).count());
    let (done, failed) = (count(JobState::Done), count(JobState::Failed));
    let is_whole = facts.made == total;
    let state = match facts.halt {
        Some(Halt::Cancelled | Halt::Deleted) => SequenceState::Cancelled,
        _ if facts.problem.is_some() || (is_whole && live == 0 && failed > 0) => SequenceState::Failed,
        _ if is_whole && live == 0 && done == 0 && !jobs.is_empty() => SequenceState::Cancelled,
        _ if is_whole && live == 0 => SequenceState::Done,
        Some(Halt::Paused) => SequenceState::Paused,
        None => SequenceState::Running,
    };
    let first_error = || jobs.iter().find_map(|(frame, job)| Some(format!("frame {frame}: {}", job.error.as_ref()?)));
    let error = (state == SequenceState::Failed).then(|| facts.problem.or_else(first_error)).flatten();
    // What is no job any more was done once, too.
    let ended = f64::from(facts.made) - live as f64;
    let parts: f64 = jobs.iter().filter(|(_, job)| !job.state.is_final()).map(|(_, job)| share(job)).sum();
    let left = f64::from(total) - ended - parts;
    let seconds: f64 = jobs.iter().filter(|(_, job)| job.state == JobState::Done).map(|(_, job)| job.seconds).sum();
    let together = (at_once.get() as f64).min(left.ceil()).max(1.0);
    let seconds_left = (done > 0 && state.is_live()).then(|| seconds / f64::from(done) * left / together);
    let job = |(frame, job): (u32, JobStatus)| FrameJob {
        frame,
        job: job.id,
        state: job.state,
        passes_done: job.passes_done,
        passes_total: job.passes_total,
    };
    SequenceStatus {
        id: id.to_string(),
        state,
        error,
        waiting: facts.waiting.filter(|_| state == SequenceState::Running),
        owner: facts.owner,
        name: request.name,
        tags: request.tags,
        priority: request.priority,
        submitted: (facts.submitted / 1000) as u64,
        scene: request.scene,
        stop: request.stop,
        frames,
        at_once,
        frames_total: total,
        frames_done: done,
        frames_failed: failed,
        progress: (ended + parts) / f64::from(total),
        seconds_left,
        jobs: jobs.into_iter().map(job).collect(),
    }
}

/// How much of a job is done, 0 to 1, as far as its stop rule tells beforehand.
fn share(job: &JobStatus) -> f64 {
    let passes = job.passes_total.map(|total| f64::from(job.passes_done) / f64::from(total.max(1)));
    let seconds = job.stop.seconds.map(|total| job.seconds / total);
    passes.unwrap_or(0.0).max(seconds.unwrap_or(0.0)).min(1.0)
}
