//! What users are told of jobs and workers.

use std::time::Duration;

use super::{JobRecord, State};
use crate::estimate::ErrorEstimate;
use crate::estimate::error::CONFIDENCE;
use crate::farm::job::{EstimatedError, JobState, JobStatus, StopRule, WorkerStatus};
use crate::farm::rules::progress::MeasuredError;
use crate::farm::rules::roster::WorkerRecord;
use crate::farm::wire::lease::JobDescription;

impl State {
    /// How a job is doing at `now`.
    pub(super) fn status(&self, job: &JobRecord, now: Duration) -> JobStatus {
        let status = job.description.status(job.stop);
        let Some(progress) = self.schedule.job(job.number) else { return status };
        let seconds = progress.seconds(now);
        let totals = progress.totals;
        let mut workers: Vec<u64> = self.schedule.leases().of_job(job.number).map(|lease| lease.worker).collect();
        workers.sort_unstable();
        workers.dedup();
        JobStatus {
            state: progress.state,
            error: progress.error.clone(),
            passes_done: totals.passes,
            photons_emitted: totals.photons_emitted,
            photons_per_second: if seconds > 0.0 { totals.photons_emitted as f64 / seconds } else { 0.0 },
            seconds,
            seconds_left: progress.seconds_left(now),
            workers: workers.len() as u32,
            non_finite: totals.non_finite,
            estimated_error: totals.error.map(estimated_error),
            notices: progress.notices.clone(),
            picture_version: totals.shards,
            ..status
        }
    }

    /// All workers at `now`.
    pub(super) fn workers(&self, now: Duration) -> Vec<WorkerStatus> {
        let status = |(id, worker): (u64, &WorkerRecord)| WorkerStatus {
            id: id.to_string(),
            name: worker.name.clone(),
            threads: worker.threads,
            shards_done: worker.shards_done,
            leases: self.schedule.leases().of_worker(id).count() as u32,
            idle_seconds: now.saturating_sub(worker.last_heard).as_secs_f64(),
            set_aside: worker.set_aside(now).map(str::to_owned),
        };
        self.schedule.roster().iter().map(status).collect()
    }
}

fn estimated_error(measured: MeasuredError) -> EstimatedError {
    let ErrorEstimate { noise, bias, bound, .. } = measured.error;
    EstimatedError { passes: measured.passes, relmse: noise + bias, noise, bias, bound, confidence: CONFIDENCE }
}

impl JobDescription {
    /// The status of a job of which nothing is known but what was asked for.
    pub(super) fn status(&self, stop: StopRule) -> JobStatus {
        JobStatus {
            id: self.id.clone(),
            state: JobState::Queued,
            error: None,
            scene: self.scene.clone(),
            method: self.method.choice.name.clone(),
            parameters: self.method.choice.parameters.clone(),
            stop,
            seed: self.seed,
            width: self.width,
            height: self.height,
            passes_done: 0,
            passes_total: stop.passes,
            photons_emitted: 0,
            photons_per_second: 0.0,
            seconds: 0.0,
            seconds_left: stop.seconds,
            workers: 0,
            non_finite: 0,
            estimated_error: None,
            notices: Vec::new(),
            picture_version: 0,
        }
    }
}
