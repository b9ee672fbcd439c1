//! Leases: what to trace, and all that must be known to trace it.

use std::sync::Arc;

use super::WireError;
use super::messages;
use crate::estimate::{Declaration, Region, Shard};
use crate::farm::ids::{BadJobId, Fencing, JobId, LeaseId};
use crate::farm::rules::lease::Errand;
#[cfg(doc)]
use crate::farm::rules::lease::Work;
use crate::farm::rules::plan::PlannedShard;
use crate::method::{self, CheckedMethod};

/// What a worker must know of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct JobDescription {
    /// The job's id.
    pub id: JobId,
    /// Hash of its scene.
    pub scene: String,
    /// Its method; `None` before one was chosen.
    pub method: Option<CheckedMethod>,
    /// Its seed.
    pub seed: u64,
    /// The light groups that it keeps apart; empty where it keeps none.
    pub light_groups: Vec<String>,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
}

impl JobDescription {
    /// What its tallies hold; `None` before its method was chosen.
    pub fn declaration(&self) -> Option<Arc<Declaration>> {
        self.method.as_ref().map(|method| declaration(method, &self.light_groups))
    }
}

/// What tallies of a method hold where these light groups are kept apart.
pub fn declaration(method: &CheckedMethod, light_groups: &[String]) -> Arc<Declaration> {
    let plain = method::declaration(method);
    if light_groups.is_empty() { plain } else { Arc::new(Declaration::clone(&plain).with_light_groups(light_groups)) }
}

/// What trials of methods aim at.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoiceTerms {
    /// Method parameters of the request.
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// relMSE.
    pub error: f64,
}

/// A shard to trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShardTerms {
    /// The shard and its place in the plan.
    pub planned: PlannedShard,
    /// Rises when part of a job is done again.
    pub generation: u32,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum LeasedWork {
    /// See [`Work::Choice`].
    Choice(ChoiceTerms),
    /// See [`Work::Pilot`].
    Pilot,
    /// See [`Work::Shard`]; a check looks no different.
    Shard(ShardTerms),
    /// See [`Work::Errand`].
    Errand(Errand),
}

/// A lease as a worker reads it.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkerLease {
    /// Lease id.
    pub id: LeaseId,
    /// Fencing number.
    pub fencing: Fencing,
    /// The job.
    pub job: JobDescription,
    /// What is to be done.
    pub work: LeasedWork,
}

/// To the message.
pub fn encode_job(job: &JobDescription) -> messages::Job {
    let method = job.method.as_ref().map(|method| serde_json::to_string(method).unwrap_or_default());
    messages::Job {
        id: job.id.to_string(),
        scene: job.scene.clone(),
        method: method.unwrap_or_default(),
        seed: job.seed,
        light_groups: job.light_groups.clone(),
        width: job.width,
        height: job.height,
    }
}

/// To the message.
pub fn encode_lease(lease: &WorkerLease) -> messages::Lease {
    let work = match &lease.work {
        LeasedWork::Choice(terms) => messages::lease::Work::Choice(messages::ChoiceWork {
            parameters: serde_json::Value::Object(terms.parameters.clone()).to_string(),
            error: terms.error,
        }),
        LeasedWork::Pilot => messages::lease::Work::Pilot(messages::PilotWork {}),
        LeasedWork::Shard(terms) => messages::lease::Work::Shard(encode_shard(terms)),
        LeasedWork::Errand(Errand::FirstSurfaces) => {
            messages::lease::Work::FirstSurfaces(messages::FirstSurfacesWork {})
        }
        LeasedWork::Errand(Errand::Mattes) => messages::lease::Work::Mattes(messages::MattesWork {}),
    };
    let (id, fencing) = (lease.id.number(), lease.fencing.number());
    messages::Lease { id, fencing, job: Some(encode_job(&lease.job)), work: Some(work) }
}

fn encode_shard(terms: &ShardTerms) -> messages::ShardWork {
    let ShardTerms { planned, generation } = *terms;
    messages::ShardWork {
        first_pass: planned.shard.first_pass,
        passes: planned.shard.passes,
        row_start: planned.shard.region.row_start,
        row_end: planned.shard.region.row_end,
        field_epoch: planned.field_epoch,
        region: planned.region,
        generation,
    }
}

/// From the message.
pub fn decode_lease(message: messages::Lease) -> Result<WorkerLease, WireError> {
    let job = decode_job(message.job.ok_or(WireError::Missing("job"))?)?;
    let work = match message.work.ok_or(WireError::Missing("work"))? {
        messages::lease::Work::Choice(choice) => LeasedWork::Choice(decode_choice(&choice)?),
        messages::lease::Work::Pilot(_) => LeasedWork::Pilot,
        messages::lease::Work::Shard(shard) => LeasedWork::Shard(decode_shard(&shard, &job)?),
        messages::lease::Work::FirstSurfaces(_) => LeasedWork::Errand(Errand::FirstSurfaces),
        messages::lease::Work::Mattes(_) => LeasedWork::Errand(Errand::Mattes),
    };
    if job.method.is_none() && matches!(work, LeasedWork::Pilot | LeasedWork::Shard(_)) {
        return Err(WireError::Missing("method"));
    }
    Ok(WorkerLease { id: LeaseId::new(message.id), fencing: Fencing::new(message.fencing), job, work })
}

fn decode_choice(message: &messages::ChoiceWork) -> Result<ChoiceTerms, WireError> {
    let impossible = |field, problem| WireError::Impossible { field, problem };
    let parameters =
        serde_json::from_str(&message.parameters).map_err(|problem| impossible("parameters", problem.to_string()))?;
    if !(message.error.is_finite() && message.error > 0.0) {
        return Err(impossible("error", message.error.to_string()));
    }
    Ok(ChoiceTerms { parameters, error: message.error })
}

fn decode_job(message: messages::Job) -> Result<JobDescription, WireError> {
    let impossible = |field, problem| WireError::Impossible { field, problem };
    let method = Some(&message.method).filter(|text| !text.is_empty()).map(|text| serde_json::from_str(text));
    let method = method.transpose().map_err(|problem| impossible("method", problem.to_string()))?;
    let id = message.id.parse().map_err(|problem: BadJobId| impossible("job", problem.to_string()))?;
    let (width, height) = (message.width, message.height);
    if width == 0 || height == 0 {
        return Err(impossible("picture size", format!("{width} × {height}")));
    }
    let messages::Job { scene, seed, light_groups, .. } = message;
    Ok(JobDescription { id, scene, method, seed, light_groups, width, height })
}

fn decode_shard(message: &messages::ShardWork, job: &JobDescription) -> Result<ShardTerms, WireError> {
    let region = Region { row_start: message.row_start, row_end: message.row_end };
    if region.row_start >= region.row_end || region.row_end > job.height {
        let problem = format!("rows {}..{} of {}", region.row_start, region.row_end, job.height);
        return Err(WireError::Impossible { field: "region", problem });
    }
    if message.passes == 0
        || message.passes.checked_mul(2).and_then(|span| message.first_pass.checked_add(span)).is_none()
    {
        let problem = format!("{} from {}", message.passes, message.first_pass);
        return Err(WireError::Impossible { field: "passes", problem });
    }
    let planned = PlannedShard {
        shard: Shard { first_pass: message.first_pass, passes: message.passes, region },
        region: message.region,
        field_epoch: message.field_epoch,
    };
    Ok(ShardTerms { planned, generation: message.generation })
}
