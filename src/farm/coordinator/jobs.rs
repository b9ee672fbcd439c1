//! Jobs: submitted, changed, stopped.

use std::sync::Arc;

use super::request::{self, ResolvedMethod};
use super::scenes::SceneRecord;
use super::shared::{JobFacts, JobRecord, Shared, blocking};
use crate::evaluation::DEFAULT_ERROR;
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::{JobRequest, JobStatus, Priority};
use crate::farm::locks::lock;
use crate::farm::method_choice::check_trials;
use crate::farm::rules::terms::Terms;
use crate::farm::rules::{Answer, Event};
use crate::farm::wire::lease::{ChoiceTerms, JobDescription};

/// What of a job may change at any time. What is `None` stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobChanges {
    /// What people call it; an empty one is none.
    pub name: Option<String>,
    /// Words to find it by.
    pub tags: Option<Vec<String>>,
    /// Its share of the farm.
    pub priority: Option<Priority>,
}

impl Shared {
    pub(super) async fn submit(&self, request: JobRequest) -> Result<JobId, FarmError> {
        request::check_labels(&request)?;
        let scene = self.scene(&request.scene)?;
        let (description, terms) = self.agree(&request, &scene)?;
        let mut state = self.lock();
        if state.is_closed {
            return Err(FarmError::ShuttingDown);
        }
        let limits = &self.options.limits;
        if state.rules.jobs().count() >= limits.live_jobs {
            let problem = format!("{} jobs wait or run already", limits.live_jobs);
            return Err(FarmError::Busy { problem, retry_after: limits.retry_after() });
        }
        let unix = self.clock.unix(self.clock.now());
        let id = JobId::after(state.jobs.keys().next_back().copied(), unix.as_millis() as u64);
        let description = JobDescription { id, ..description };
        let facts =
            JobFacts { request, description, terms: terms.clone(), submitted: unix.as_secs(), history: Vec::new() };
        let status = facts.status();
        state.jobs.insert(id, Arc::new(JobRecord::new(id, facts, status)));
        drop(state);
        self.apply(Event::JobAdded { job: id, terms });
        Ok(id)
    }

    /// What a request comes to, before anything is traced.
    fn agree(&self, request: &JobRequest, scene: &SceneRecord) -> Result<(JobDescription, Terms), FarmError> {
        let (width, height) = (scene.summary.width, scene.summary.height);
        let pixels = u64::from(width) * u64::from(height);
        let memory = pixels * STATE_BYTES_PER_PIXEL;
        let limit = self.options.limits.job_memory;
        if memory > limit {
            return Err(FarmError::TooLarge { what: "the memory in bytes that the job needs", found: memory, limit });
        }
        let chooses_method = request::asks_for_auto(request);
        let mut notices = scene.summary.notices.clone();
        let (method, stop) = if chooses_method {
            request::check_stop(request.stop)?;
            check_trials(&request.parameters, scene.integrator.as_ref(), pixels)?;
            (None, request.stop)
        } else {
            let integrator = scene.integrator.as_ref();
            let resolved = request::resolve_method(request, integrator, pixels, scene.traits)?;
            notices.extend(resolved.notices);
            let stop = request::resolve_stop(request.stop, &resolved.method)?;
            (Some(resolved.method), stop)
        };
        let (scene, seed) = (request.scene.clone(), request.seed);
        let description = JobDescription { id: JobId::new(0), scene, method, seed, width, height };
        Ok((description, Terms { stop, priority: request.priority, memory, chooses_method, notices }))
    }

    /// What the trials of a job aim at.
    pub(in crate::farm) fn choice_terms(&self, job: &JobRecord) -> ChoiceTerms {
        let request = job.request();
        ChoiceTerms { parameters: request.parameters, error: request.stop.error.unwrap_or(DEFAULT_ERROR) }
    }

    /// The trials of a job chose `method`.
    pub(super) fn choose(&self, job: &JobRecord, method: String, reason: String) -> Result<(), FarmError> {
        let request = JobRequest { method: Some(method), ..job.request() };
        let scene = self.scene(&request.scene)?;
        let pixels = u64::from(scene.summary.width) * u64::from(scene.summary.height);
        let resolved = request::resolve_method(&request, scene.integrator.as_ref(), pixels, scene.traits)?;
        let ResolvedMethod { method, notices } = resolved;
        let stop = request::resolve_stop(request.stop, &method)?;
        let terms = {
            let mut facts = lock(&job.facts);
            facts.description.method = Some(method);
            facts.terms.stop = stop;
            facts.terms.chooses_method = false;
            facts.terms.clone()
        };
        let reasons = std::iter::once(reason).chain(notices).collect();
        self.apply(Event::MethodChosen { job: job.id, terms, reasons });
        Ok(())
    }

    /// Lets a user's event happen between two merges, so that what the answer says is what stays.
    pub(super) async fn control(self: &Arc<Self>, id: JobId, event: Event) -> Result<JobStatus, FarmError> {
        let (shared, job) = (self.clone(), self.job(id)?);
        let is_cancel = matches!(event, Event::JobCancelled { .. });
        blocking(move || {
            let _merging = lock(&job.merging);
            let answer = shared.apply(event);
            let status = shared.lock().status(&job, &shared.clock);
            match answer {
                Answer::Done => Ok(status),
                // Who cancels wants it not to run, and it does not.
                _ if is_cancel => Ok(status),
                _ => Err(FarmError::Conflict {
                    problem: format!("job {id} is {}", status.state.name()),
                    remedy: "look at its state first".to_owned(),
                }),
            }
        })
        .await
    }

    pub(super) async fn change_job(self: &Arc<Self>, id: JobId, changes: JobChanges) -> Result<JobStatus, FarmError> {
        let job = self.job(id)?;
        {
            let mut facts = lock(&job.facts);
            let mut request = facts.request.clone();
            if let Some(name) = changes.name {
                request.name = Some(name).filter(|name| !name.is_empty());
            }
            request.tags = changes.tags.unwrap_or(request.tags);
            request.priority = changes.priority.unwrap_or(request.priority);
            request::check_labels(&request)?;
            facts.terms.priority = request.priority;
            facts.request = request;
        }
        let priority = lock(&job.facts).terms.priority;
        self.apply(Event::PriorityChanged { job: id, priority });
        let status = self.lock().status(&job, &self.clock);
        job.status.send_replace(status.clone());
        Ok(status)
    }
}

/// Bytes of memory a pixel: the estimate of two twins, the radius fields of three epochs, and room for a snapshot.
const STATE_BYTES_PER_PIXEL: u64 = 128 + 3 * 4 + 64;
