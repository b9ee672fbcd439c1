//! Leases: what to trace, and all that must be known to trace it.

use super::WireError;
use super::messages;
use crate::estimate::{Region, Shard};
use crate::farm::rules::lease::Work;
use crate::farm::rules::plan::PlannedShard;
use crate::method::CheckedMethod;

/// What a worker must know of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct JobDescription {
    /// The job's id.
    pub id: String,
    /// Hash of its scene.
    pub scene: String,
    /// Its method.
    pub method: CheckedMethod,
    /// Its seed.
    pub seed: u64,
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
}

/// A lease as a worker reads it.
#[derive(Clone, Debug, PartialEq)]
pub struct LeasedWork {
    /// Lease id.
    pub id: u64,
    /// Fencing number.
    pub fencing: u64,
    /// The job.
    pub job: JobDescription,
    /// The first radii, or a shard.
    pub work: Option<PlannedShard>,
}

/// To the message. `shard` is what a shard lease traces.
pub fn encode_job(job: &JobDescription) -> messages::Job {
    messages::Job {
        id: job.id.clone(),
        scene: job.scene.clone(),
        method: serde_json::to_string(&job.method).unwrap_or_default(),
        seed: job.seed,
        width: job.width,
        height: job.height,
    }
}

/// To the message.
pub fn encode_lease(id: u64, fencing: u64, job: &JobDescription, work: Work) -> messages::Lease {
    let work = match work {
        Work::Pilot => messages::lease::Work::Pilot(messages::PilotWork {}),
        Work::Shard(_, planned) => messages::lease::Work::Shard(encode_shard(&planned)),
    };
    messages::Lease { id, fencing, job: Some(encode_job(job)), work: Some(work) }
}

fn encode_shard(planned: &PlannedShard) -> messages::ShardWork {
    messages::ShardWork {
        first_pass: planned.shard.first_pass,
        passes: planned.shard.passes,
        row_start: planned.shard.region.row_start,
        row_end: planned.shard.region.row_end,
        field_epoch: planned.field_epoch,
        region: planned.region,
    }
}

/// From the message.
pub fn decode_lease(message: messages::Lease) -> Result<LeasedWork, WireError> {
    let job = decode_job(message.job.ok_or(WireError::Missing("job"))?)?;
    let work = match message.work.ok_or(WireError::Missing("work"))? {
        messages::lease::Work::Pilot(_) => None,
        messages::lease::Work::Shard(shard) => Some(decode_shard(&shard, &job)?),
    };
    Ok(LeasedWork { id: message.id, fencing: message.fencing, job, work })
}

fn decode_job(message: messages::Job) -> Result<JobDescription, WireError> {
    let method = serde_json::from_str(&message.method)
        .map_err(|problem| WireError::Impossible { field: "method", problem: problem.to_string() })?;
    let (width, height) = (message.width, message.height);
    if width == 0 || height == 0 {
        return Err(WireError::Impossible { field: "picture size", problem: format!("{width} × {height}") });
    }
    Ok(JobDescription { id: message.id, scene: message.scene, method, seed: message.seed, width, height })
}

fn decode_shard(message: &messages::ShardWork, job: &JobDescription) -> Result<PlannedShard, WireError> {
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
    Ok(PlannedShard {
        shard: Shard { first_pass: message.first_pass, passes: message.passes, region },
        region: message.region,
        field_epoch: message.field_epoch,
    })
}
