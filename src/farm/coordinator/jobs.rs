//! Jobs: submitted, changed, stopped.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use super::chores::Chore;
use super::request::{self, ResolvedMethod};
use super::scene_record::SceneRecord;
use super::shared::{JobFacts, JobRecord, Shared, State};
use crate::estimate::{Declaration, Estimate, RadiusRule, Region};
use crate::evaluation::DEFAULT_ERROR;
use crate::farm::access::user::UserName;
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::{Changes, Idempotency, IdempotencyKey, JobRequest, JobStatus, Priority};
use crate::farm::locks::lock;
use crate::farm::method_choice::check_trials;
use crate::farm::rules::Event;
use crate::farm::rules::terms::Terms;
use crate::farm::wire::lease::{ChoiceTerms, JobDescription, declaration};
use crate::method::{CheckedMethod, MethodChoice};

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
    pub(super) async fn submit(
        &self,
        mut request: JobRequest,
        owner: Option<UserName>,
        key: Option<IdempotencyKey>,
    ) -> Result<JobId, FarmError> {
        request.name = request.name.filter(|name| !name.is_empty());
        request::check_labels(&request, &self.options.limits)?;
        let idempotency = key.map(|key| Idempotency { key, request: fingerprint(&request) });
        let _turn = self.catalogue.take().await?;
        if let Some(known) =
            idempotency.as_ref().map(|wanted| self.submitted_before(owner.as_ref(), wanted)).transpose()?.flatten()
        {
            return Ok(known);
        }
        let scene = self.scene(&request.scene)?;
        let (description, terms) = self.agree(&request, &scene)?;
        self.check_places(&description, self.scene_bytes(&request.scene)).await?;
        let pixels = u64::from(description.width) * u64::from(description.height);
        self.check_user_jobs(&self.lock(), owner.as_ref(), pixels, terms.stop)?;
        let (id, unix) = self.next_id()?;
        let description = JobDescription { id, ..description };
        let facts = JobFacts { owner, idempotency, ..JobFacts::new(request, description, terms.clone(), unix) };
        let status = facts.status();
        let job = Arc::new(JobRecord::new(id, facts, status));
        // It is durable before it is accepted. Whether a store that does not answer has it, nobody knows: what was refused must not
        // come back with the next start.
        if let Err(problem) = self.store.insert_job(&self.row(&job)).await {
            self.leave_to_keeper(Chore::Refused(id));
            return Err(problem.into());
        }
        self.lock().jobs.insert(id, job);
        self.apply(Event::JobAdded { job: id, terms });
        Ok(id)
    }

    /// The job that the same user submitted with the same key.
    ///
    /// # Errors
    /// Something else was asked for then.
    fn submitted_before(&self, owner: Option<&UserName>, wanted: &Idempotency) -> Result<Option<JobId>, FarmError> {
        let state = self.lock();
        let has_key = |facts: &JobFacts| {
            facts.owner.as_ref() == owner && facts.idempotency.as_ref().is_some_and(|known| known.key == wanted.key)
        };
        let Some(job) = state.jobs.values().find(|job| has_key(&lock(&job.facts))) else { return Ok(None) };
        if lock(&job.facts).idempotency.as_ref() == Some(wanted) {
            return Ok(Some(job.id));
        }
        Err(FarmError::BadRequest {
            problem: format!("job {} was submitted with the same key, and is another one", job.id),
            remedy: "choose a new Idempotency-Key for every job".to_owned(),
        })
    }

    /// What would become of a request. Nothing is kept or traced.
    pub(super) async fn validate(
        self: &Arc<Self>,
        request: JobRequest,
        scene: Option<Vec<u8>>,
    ) -> Result<JobStatus, FarmError> {
        request::check_labels(&request, &self.options.limits)?;
        let known = match &scene {
            None => self.scene(&request.scene)?,
            Some(bytes) => self.upload_all(bytes, None).await?.check().await?,
        };
        let (description, terms) = self.agree(&request, &known)?;
        let description = JobDescription { scene: known.summary.hash.clone(), ..description };
        let bytes = async {
            match scene {
                None => self.scene_bytes(&request.scene).await,
                Some(bytes) => Ok(bytes.into()),
            }
        };
        self.check_places(&description, bytes).await?;
        Ok(JobFacts::new(request, description, terms, Duration::ZERO).status())
    }

    /// What changed after change number `seen`.
    pub(super) fn changes(&self, seen: u64) -> Changes {
        let state = self.lock();
        let (newest, deleted) = self.feed.deleted_since(seen);
        let is_reset = deleted.is_none();
        let seen = if is_reset { 0 } else { seen };
        let is_new = |job: &&Arc<JobRecord>| job.changed.load(Ordering::Relaxed) > seen || seen == 0;
        let jobs = state.jobs.values().filter(is_new).map(|job| state.status(job, &self.clock)).collect();
        // Whoever knows nothing yet knows nothing of them.
        let deleted = deleted.filter(|_| seen > 0).unwrap_or_default().into_iter().map(|deleted| deleted.job).collect();
        Changes { newest, is_reset, jobs, deleted }
    }

    /// The id of the next job, if one is taken at all, and the time since 1970.
    pub(super) fn next_id(&self) -> Result<(JobId, Duration), FarmError> {
        let mut state = self.lock();
        self.check_room(&state)?;
        let unix = self.clock.unix(self.clock.now());
        let id = JobId::after(state.last_job, unix.as_millis() as u64);
        state.last_job = Some(id);
        Ok((id, unix))
    }

    /// Whether one more job may be live.
    pub(super) fn check_room(&self, state: &State) -> Result<(), FarmError> {
        if state.is_closed {
            return Err(FarmError::ShuttingDown);
        }
        let limits = &self.options.limits;
        if state.rules.jobs().count() >= limits.live_jobs {
            let problem = format!("{} jobs wait or run already", limits.live_jobs);
            return Err(FarmError::Busy { problem, retry_after: limits.retry_after() });
        }
        Ok(())
    }

    /// What a request comes to, before anything is traced.
    fn agree(&self, request: &JobRequest, scene: &SceneRecord) -> Result<(JobDescription, Terms), FarmError> {
        let (width, height) = (scene.summary.width, scene.summary.height);
        let pixels = u64::from(width) * u64::from(height);
        request::check_cut(request.cut)?;
        let chooses_method = request::asks_for_auto(request);
        let mut notices = scene.summary.notices.clone();
        let (method, stop) = if chooses_method {
            request::check_stop(request.stop, &self.options.limits)?;
            check_trials(&request.parameters, scene.integrator.as_ref(), pixels)?;
            (None, request.stop)
        } else {
            let integrator = scene.integrator.as_ref();
            let resolved = request::resolve_method(request, integrator, pixels, scene.traits)?;
            notices.extend(resolved.notices);
            let stop = request::resolve_stop(request.stop, &resolved.method, &self.options.limits)?;
            request::check_finds_light(stop, &resolved.method, scene.traits)?;
            (Some(resolved.method), stop)
        };
        let light_groups = request::resolve_light_groups(request, &scene.summary.light_groups, method.as_ref())?;
        let memory = pixels * bytes_per_pixel(method.as_ref(), &light_groups)?;
        let limit = self.options.limits.job_memory;
        if memory > limit {
            return Err(FarmError::TooLarge { what: "the memory in bytes that the job needs", found: memory, limit });
        }
        let (scene, seed) = (request.scene.clone(), request.seed);
        let description = JobDescription { id: JobId::new(0), scene, method, seed, light_groups, width, height };
        Ok((description, Terms { stop, priority: request.priority, memory, chooses_method, notices }))
    }

    /// What the trials of a job aim at.
    pub(in crate::farm) fn choice_terms(&self, job: &JobRecord) -> ChoiceTerms {
        let request = job.request();
        ChoiceTerms { parameters: request.parameters, error: request.stop.error.unwrap_or(DEFAULT_ERROR) }
    }

    /// The trials of a job made a choice; what its user gave stays as it is.
    pub(super) fn choose(&self, job: &JobRecord, choice: MethodChoice, reason: String) -> Result<(), FarmError> {
        let MethodChoice { name, mut parameters } = choice;
        let mut request = JobRequest { method: Some(name), ..job.request() };
        parameters.append(&mut request.parameters);
        request.parameters = parameters;
        let scene = self.scene(&request.scene)?;
        let pixels = u64::from(scene.summary.width) * u64::from(scene.summary.height);
        let resolved = request::resolve_method(&request, scene.integrator.as_ref(), pixels, scene.traits)?;
        let ResolvedMethod { method, notices } = resolved;
        let stop = request::resolve_stop(request.stop, &method, &self.options.limits)?;
        let light_groups = request::resolve_light_groups(&request, &scene.summary.light_groups, Some(&method))?;
        let memory = pixels * bytes_per_pixel(Some(&method), &light_groups)?;
        let terms = {
            let mut facts = lock(&job.facts);
            facts.description.method = Some(method);
            facts.terms.stop = stop;
            facts.terms.chooses_method = false;
            facts.terms.memory = memory;
            facts.terms.clone()
        };
        let reasons = std::iter::once(reason).chain(notices).collect();
        self.apply(Event::MethodChosen { job: job.id, terms, reasons });
        self.leave_to_keeper(Chore::Record(job.id));
        Ok(())
    }
}

/// By what a request is known again.
pub(super) fn fingerprint(request: &impl serde::Serialize) -> String {
    // Plain data with string keys always has a JSON form.
    blake3::hash(&serde_json::to_vec(request).unwrap_or_default()).to_hex().to_string()
}

/// Bytes of memory a pixel that a running job needs: its estimate, a copy of it for snapshots, and radius fields of five epochs. As much as any
/// method needs while none is chosen.
fn bytes_per_pixel(method: Option<&CheckedMethod>, light_groups: &[String]) -> Result<u64, FarmError> {
    const FIELDS: u64 = 5 * size_of::<f32>() as u64;
    let declaration = match method {
        Some(method) => declaration(method, light_groups),
        None => Arc::new(Declaration::gathering(RadiusRule::Statistics, 1.0).with_light_groups(light_groups)),
    };
    let (fields, first): (u64, &[f32]) = if declaration.has_radii() { (FIELDS, &[1.0]) } else { (0, &[]) };
    let pixel = Estimate::new(1, 1, &[Region { row_start: 0, row_end: 1 }], declaration, first);
    let pixel = pixel.map_err(|problem| FarmError::Internal(problem.to_string()))?;
    Ok(2 * pixel.bytes_per_pixel() as u64 + fields)
}
