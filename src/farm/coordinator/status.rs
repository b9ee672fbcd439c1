//! What users are told of jobs and workers.

use std::time::Duration;

use super::clock::Clock;
use super::shared::{JobFacts, JobRecord, State};
use crate::estimate::error::CONFIDENCE;
use crate::estimate::{self, ErrorEstimate, ProposalCount};
use crate::farm::ids::WorkerId;
use crate::farm::job::{Acceptance, EstimatedError, JobState, JobStatus, LastError, WorkerState, WorkerStatus};
use crate::farm::locks::lock;
use crate::farm::method_choice::AUTO;
use crate::farm::rules::roster::{self, WorkerRecord};
use crate::farm::rules::terms::MeasuredError;

/// What a job says for as long as no worker is there.
const NO_WORKER: &str = "No worker is connected: the job waits until one joins (photonfarm worker).";

impl State {
    /// How a job is doing now.
    pub(super) fn status(&self, job: &JobRecord, clock: &Clock) -> JobStatus {
        let facts = lock(&job.facts);
        let Some(progress) = self.rules.job(job.id) else {
            // It has ended: only what people call it changes.
            let labels = facts.status();
            let last = job.last_status();
            return JobStatus { name: labels.name, tags: labels.tags, priority: labels.priority, ..last };
        };
        let now = clock.now();
        let (seconds, totals) = (progress.seconds(now), &progress.totals);
        let mut workers: Vec<WorkerId> = self.rules.leases().of_job(job.id).map(|lease| lease.worker).collect();
        workers.sort_unstable();
        workers.dedup();
        let waits = !progress.has_ended() && progress.state != JobState::Paused;
        let deserted = self.rules.deserted_since().filter(|_| waits);
        let no_worker = (waits && self.rules.lacks_workers()).then(|| NO_WORKER.to_owned());
        JobStatus {
            state: progress.state,
            error: progress.error.clone(),
            paused: progress.pause.as_ref().map(ToString::to_string),
            waiting_for_workers_since: deserted.map(|since| clock.unix(since).as_secs()),
            waiting_for_memory: self.rules.waits_for_memory(job.id),
            passes_done: totals.passes,
            photons_emitted: totals.photons_emitted,
            photons_per_second: if seconds > 0.0 { totals.photons_emitted as f64 / seconds } else { 0.0 },
            seconds,
            seconds_left: progress.seconds_left(now).filter(|_| deserted.is_none()),
            workers: if deserted.is_some() { 0 } else { workers.len() as u32 },
            non_finite: totals.non_finite,
            acceptance: totals.acceptance.iter().map(acceptance).collect(),
            shards_verified: progress.checks.verified,
            shards_mismatched: progress.checks.mismatched,
            shards_unchecked: progress.checks.unchecked,
            estimated_error: totals.error.map(estimated_error),
            notices: progress.terms.notices.iter().cloned().chain(no_worker).collect(),
            picture_version: totals.shards,
            ..facts.status()
        }
    }

    /// All workers now.
    pub(super) fn workers(&self, clock: &Clock, silence: Duration) -> Vec<WorkerStatus> {
        self.rules.roster().iter().map(|(id, worker)| self.worker(id, worker, clock, silence)).collect()
    }

    fn worker(&self, id: WorkerId, worker: &WorkerRecord, clock: &Clock, silence: Duration) -> WorkerStatus {
        let now = clock.now();
        let leases = self.rules.leases().of_worker(id).count() as u32;
        let idle = now.saturating_sub(worker.last_heard);
        let set_aside = worker.set_aside(now).map(str::to_owned);
        let state = match (&set_aside, leases) {
            _ if idle >= silence => WorkerState::Silent,
            _ if worker.is_draining => WorkerState::Draining,
            (Some(_), _) => WorkerState::SetAside,
            (None, 0) => WorkerState::Idle,
            (None, _) => WorkerState::Working,
        };
        WorkerStatus {
            id: id.to_string(),
            name: worker.name.clone(),
            state,
            threads: worker.threads,
            shards_done: worker.shards_done,
            leases,
            idle_seconds: idle.as_secs_f64(),
            set_aside,
            last_error: worker.last_error.as_ref().map(|error| last_error(error, clock)),
        }
    }
}

fn last_error(error: &roster::LastError, clock: &Clock) -> LastError {
    LastError {
        job: error.job.to_string(),
        work: error.work.to_string(),
        problem: error.problem.clone(),
        time: clock.unix(error.at).as_secs(),
    }
}

fn estimated_error(measured: MeasuredError) -> EstimatedError {
    let ErrorEstimate { noise, bias, bound, .. } = measured.error;
    EstimatedError { passes: measured.passes, relmse: noise + bias, noise, bias, bound, confidence: CONFIDENCE }
}

impl JobFacts {
    /// The status of a job of which nothing is known but what was asked for.
    pub(super) fn status(&self) -> JobStatus {
        let Self { request, description, terms, owner, submitted, .. } = self;
        let (method, parameters) = match &description.method {
            Some(method) => (method.choice.name.clone(), method.choice.parameters.clone()),
            None => (AUTO.to_owned(), request.parameters.clone()),
        };
        JobStatus {
            id: description.id.to_string(),
            state: JobState::Queued,
            error: None,
            paused: None,
            waiting_for_workers_since: None,
            waiting_for_memory: false,
            owner: owner.clone(),
            name: request.name.clone(),
            frame: request.frame,
            tags: request.tags.clone(),
            priority: request.priority,
            submitted: *submitted,
            scene: description.scene.clone(),
            method,
            parameters,
            stop: terms.stop,
            cut: request.cut,
            seed: description.seed,
            light_groups: description.light_groups.clone(),
            width: description.width,
            height: description.height,
            passes_done: 0,
            passes_total: terms.stop.passes,
            photons_emitted: 0,
            photons_per_second: 0.0,
            seconds: 0.0,
            seconds_left: terms.stop.seconds,
            workers: 0,
            non_finite: 0,
            acceptance: Vec::new(),
            shards_verified: 0,
            shards_mismatched: 0,
            shards_unchecked: 0,
            estimated_error: None,
            notices: terms.notices.clone(),
            picture_version: 0,
        }
    }
}

fn acceptance(of: &estimate::Acceptance) -> Acceptance {
    let ProposalCount { proposed, accepted } = of.count;
    Acceptance { proposal: of.proposal.clone(), proposed, accepted }
}
