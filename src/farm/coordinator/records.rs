//! Jobs as they are stored, and back.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::shared::{JobFacts, JobRecord, Shared};
use crate::farm::access::user::UserName;
use crate::farm::job::{Idempotency, JobRequest, JobStatus, StopRule};
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::Event;
use crate::farm::rules::terms::{ErrorPoint, PauseReason, Restored, Terms};
use crate::farm::snapshot::Snapshot;
use crate::farm::store::jobs::JobRow;
use crate::farm::store::{BlobName, StoreError};
use crate::farm::wire::lease::JobDescription;
use crate::method::CheckedMethod;

/// Everything of a job that has no column of its own.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredJob {
    request: JobRequest,
    method: Option<CheckedMethod>,
    stop: StopRule,
    memory: u64,
    chooses_method: bool,
    notices: Vec<String>,
    pause: Option<PauseReason>,
    /// Seconds.
    ran: f64,
    history: Vec<ErrorPoint>,
    #[serde(default)]
    owner: Option<UserName>,
    #[serde(default)]
    idempotency: Option<Idempotency>,
    /// As it was told last.
    status: JobStatus,
}

impl Shared {
    /// A job as it is now, to be stored.
    pub(super) fn row(&self, job: &JobRecord) -> JobRow {
        let state = self.lock();
        let status = state.status(job, &self.clock);
        let now = self.clock.now();
        let progress = state.rules.job(job.id);
        let facts = lock(&job.facts);
        let stored = StoredJob {
            request: facts.request.clone(),
            method: facts.description.method.clone(),
            stop: facts.terms.stop,
            memory: facts.terms.memory,
            chooses_method: facts.terms.chooses_method,
            notices: progress.map_or_else(|| facts.terms.notices.clone(), |job| job.terms.notices.clone()),
            pause: progress.and_then(|job| job.pause.clone()),
            ran: progress.map_or(status.seconds, |job| job.seconds(now)),
            history: progress.map_or_else(|| facts.history.clone(), |job| job.history.clone()),
            owner: facts.owner.clone(),
            idempotency: facts.idempotency.clone(),
            status,
        };
        JobRow {
            id: job.id,
            state: stored.status.state,
            scene: facts.description.scene.clone(),
            created: (facts.submitted * 1000) as i64,
            ended: facts.ended,
            // Plain data with string keys always has a JSON form.
            record: serde_json::to_string(&stored).unwrap_or_default(),
            snapshots: facts.snapshots.clone(),
        }
    }

    /// Takes stored jobs over: ended ones as they are; the others go on.
    pub(super) async fn take_over(self: &Arc<Self>, rows: Vec<JobRow>) -> Result<(), StoreError> {
        let mut live = Vec::new();
        for row in rows {
            let job = Arc::new(read(&row)?);
            if !row.state.is_final() {
                live.push(job.clone());
            }
            self.lock().jobs.insert(row.id, job);
        }
        for job in live {
            self.restore(&job).await?;
        }
        Ok(())
    }

    /// A stored state of a job, to go on from or to look at.
    pub(super) async fn load(&self, job: &JobRecord, name: &BlobName) -> Result<Merging, StoreError> {
        let bytes = self.store.blobs().get(name).await?;
        let stop = lock(&job.facts).terms.stop;
        let decoded = tokio::task::spawn_blocking(move || {
            Snapshot::decode(&bytes).map(|snapshot| Merging::restore(snapshot, &stop))
        });
        let bad = |problem: String| StoreError::BadRecord { what: name.to_string(), problem };
        decoded.await.map_err(|problem| bad(problem.to_string()))?.map_err(|problem| bad(problem.to_string()))
    }

    /// Lets a job run on from `merging`, or from its beginning.
    pub(super) fn go_on(&self, job: &JobRecord, merging: Option<Merging>) {
        self.replace_state(job, &mut lock(&job.merging), merging);
    }

    /// The same for a job that runs: what rules and memory hold of it is replaced.
    pub(super) fn replace_state(&self, job: &JobRecord, place: &mut Option<Merging>, merging: Option<Merging>) {
        let (terms, mut history, ran, pause) = {
            let facts = lock(&job.facts);
            (facts.terms.clone(), facts.history.clone(), facts.ran, facts.pause.clone())
        };
        let totals = merging.as_ref().map(Merging::totals).unwrap_or_default();
        history.retain(|point| point.measured.passes <= totals.passes);
        let plan = merging.as_ref().map(|merging| merging.plan.clone());
        let is_begun = plan.is_some();
        let ran = if is_begun { ran } else { Duration::ZERO };
        let restored = Restored { plan, totals: totals.clone(), history, ran, pause };
        *place = merging;
        job.generation.fetch_add(1, Ordering::Relaxed);
        self.apply(Event::JobRestored { job: job.id, terms, restored: Box::new(restored) });
        if is_begun {
            // It may be complete already.
            self.apply(Event::Merged { job: job.id, totals });
        }
    }
}

fn read(row: &JobRow) -> Result<JobRecord, StoreError> {
    let bad = |problem: serde_json::Error| StoreError::BadRecord {
        what: format!("job {}", row.id),
        problem: problem.to_string(),
    };
    let stored: StoredJob = serde_json::from_str(&row.record).map_err(bad)?;
    let StoredJob {
        request,
        method,
        stop,
        memory,
        chooses_method,
        notices,
        pause,
        ran,
        history,
        owner,
        idempotency,
        status,
    } = stored;
    let JobStatus { width, height, seed, .. } = status;
    let (scene, light_groups) = (row.scene.clone(), status.light_groups.clone());
    let description = JobDescription { id: row.id, scene, method, seed, light_groups, width, height };
    let terms = Terms { stop, priority: request.priority, memory, chooses_method, notices };
    let facts = JobFacts {
        request,
        description,
        terms,
        owner,
        idempotency,
        submitted: status.submitted,
        history,
        last_snapshot: None,
        snapshots: row.snapshots.clone(),
        ran: Duration::try_from_secs_f64(ran).unwrap_or_default(),
        ended: row.ended,
        // What could not be stored then may be stored now.
        pause: pause.filter(|reason| !matches!(reason, PauseReason::Store { .. })),
    };
    Ok(JobRecord::new(row.id, facts, status))
}
