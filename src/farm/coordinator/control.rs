//! What users do to jobs that are there: pause, resume, cancel, rename, extend, delete. Each is stored before it is answered.

use std::sync::Arc;

use super::blocking::blocking;
use super::chores::Chore;
use super::jobs::JobChanges;
use super::request;
use super::shared::{JobInTurn, JobRecord, Shared};
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::{JobState, JobStatus, StopRule};
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::rules::{Answer, Event};
use crate::farm::snapshot::Snapshot;
use crate::farm::store::jobs::Snapshots;

impl Shared {
    /// Lets a user's event happen between two merges, so that what the answer says is what stays.
    pub(super) async fn control(self: &Arc<Self>, id: JobId, event: Event) -> Result<JobStatus, FarmError> {
        let in_turn = self.job_in_turn(id).await?;
        let status = self.happen(&in_turn, event).await?;
        self.leave_to_keeper(Chore::Record(id));
        self.stored_in_time().await?;
        Ok(status)
    }

    /// The same, not stored yet.
    async fn happen(self: &Arc<Self>, in_turn: &JobInTurn, event: Event) -> Result<JobStatus, FarmError> {
        let (shared, job, id) = (self.clone(), in_turn.job.clone(), in_turn.job.id);
        let is_cancel = matches!(event, Event::JobCancelled { .. });
        blocking(move || {
            let _merging = lock(&job.merging);
            let is_done = shared.apply(event) == Answer::Done;
            let status = shared.lock().status(&job, &shared.clock);
            // Who cancels wants it not to run, and it does not.
            if is_done || is_cancel { Ok(status) } else { Err(wrong_state(id, status.state)) }
        })
        .await
    }

    pub(super) async fn change_job(
        self: &Arc<Self>,
        id: JobId,
        changes: JobChanges,
        is_meant: impl FnOnce(&JobStatus) -> bool,
    ) -> Result<JobStatus, FarmError> {
        let in_turn = self.job_in_turn(id).await?;
        let job = &in_turn.job;
        if !is_meant(&self.lock().status(job, &self.clock)) {
            return Err(FarmError::ChangedSince(id));
        }
        {
            let mut facts = lock(&job.facts);
            let mut request = facts.request.clone();
            if let Some(name) = changes.name {
                request.name = Some(name).filter(|name| !name.is_empty());
            }
            request.tags = changes.tags.unwrap_or(request.tags);
            request.priority = changes.priority.unwrap_or(request.priority);
            request::check_labels(&request, &self.options.limits)?;
            facts.terms.priority = request.priority;
            facts.request = request;
        }
        let priority = lock(&job.facts).terms.priority;
        self.apply(Event::PriorityChanged { job: id, priority });
        let status = self.lock().status(job, &self.clock);
        self.publish(job, status.clone());
        self.leave_to_keeper(Chore::Record(id));
        self.stored_in_time().await?;
        Ok(status)
    }

    /// Lets an ended job go on to a later end.
    pub(super) async fn extend(self: &Arc<Self>, id: JobId, stop: StopRule) -> Result<JobStatus, FarmError> {
        request::check_stop(stop, &self.options.limits)?;
        let in_turn = self.job_in_turn(id).await?;
        let job = &in_turn.job;
        let status = self.lock().status(job, &self.clock);
        if !status.state.is_final() {
            return Err(wrong_state(id, status.state));
        }
        // Extensions and new jobs come one after the other, so that none passes a limit beside another.
        let _turn = self.catalogue.take().await?;
        self.check_room(&self.lock())?;
        let pixels = u64::from(status.width) * u64::from(status.height);
        self.check_user_jobs(&self.lock(), job.owner().as_ref(), pixels, stop)?;
        check_longer(&status, stop)?;
        let description = lock(&job.facts).description.clone();
        if let Some((method, scene)) = description.method.zip(self.scene(&description.scene).ok()) {
            request::check_finds_light(stop, &method, scene.traits)?;
        }
        // What is being stored of its end is stored first.
        self.stored_in_time().await?;
        let merging = self.state_to_extend(job, stop).await?;
        let (old, kept) = {
            let mut facts = lock(&job.facts);
            facts.terms.stop = stop;
            facts.request.stop = stop;
            facts.ended = None;
            let old = facts.snapshots.clone();
            let newest = old.resume.clone().or_else(|| old.newest.clone());
            facts.snapshots = Snapshots { newest, ..Snapshots::default() };
            (old, facts.snapshots.clone())
        };
        self.viewed.remove(id);
        self.go_on(job, Some(merging));
        self.leave_to_keeper(Chore::Record(id));
        self.stored_in_time().await?;
        self.delete_unless_kept(&old, &kept).await?;
        Ok(self.lock().status(job, &self.clock))
    }

    /// The last state of an ended job that the longer job passes through, too.
    async fn state_to_extend(&self, job: &Arc<JobRecord>, stop: StopRule) -> Result<Merging, FarmError> {
        let merging = self.last_shared_state(job, stop).await?;
        if !merging.is_of_longer_jobs() {
            let passes = merging.plan.passes_after(merging.merged());
            let problem = format!("job {} has half of the passes up to {passes} already", job.id);
            return Err(FarmError::BadRequest { problem, remedy: format!("extend it to at least {passes} passes") });
        }
        Ok(merging)
    }

    async fn last_shared_state(&self, job: &Arc<JobRecord>, stop: StopRule) -> Result<Merging, FarmError> {
        let record = job.clone();
        let in_memory = blocking(move || {
            let merging = lock(&record.merging);
            let Some(merging) = merging.as_ref() else { return Ok(None) };
            let snapshot = match merging.resume_snapshot() {
                Some(bytes) => Snapshot::decode(bytes).map_err(|problem| FarmError::Internal(problem.to_string()))?,
                None => merging.snapshot(),
            };
            Ok(Some(Merging::restore(snapshot, &stop)))
        });
        if let Some(merging) = in_memory.await? {
            return Ok(merging);
        }
        let Snapshots { newest, resume, .. } = lock(&job.facts).snapshots.clone();
        let Some(name) = resume.or(newest) else {
            let problem = format!("nothing is stored of job {}", job.id);
            return Err(FarmError::Conflict { problem, remedy: "clone it".to_owned() });
        };
        let bytes = self.store.blobs().get(&name).await?;
        blocking(move || {
            let snapshot = Snapshot::decode(&bytes).map_err(|problem| FarmError::Internal(problem.to_string()))?;
            Ok(Merging::restore(snapshot, &stop))
        })
        .await
    }

    /// Deletes a job; one that runs is cancelled first.
    pub(super) async fn delete_job(self: &Arc<Self>, id: JobId) -> Result<(), FarmError> {
        let in_turn = self.job_in_turn(id).await?;
        // That it was cancelled is not stored first: a full disk must not be in the way of deleting what fills it.
        self.happen(&in_turn, Event::JobCancelled { job: id }).await?;
        // Its last state may be on its way to the store. One that takes nothing is not waited for any longer.
        if let Err(problem) = self.stored_in_time().await {
            tracing::debug!(job = %id, %problem, "a job is deleted while the store does not work");
        }
        Ok(self.erase(&in_turn.job).await?)
    }
}

fn wrong_state(id: JobId, state: JobState) -> FarmError {
    FarmError::Conflict {
        problem: format!("job {id} is {}", state.name()),
        remedy: match state {
            JobState::Paused => "resume it first".to_owned(),
            state if state.is_final() => "an ended job can be extended or cloned".to_owned(),
            _ => "wait until it has ended, or cancel it".to_owned(),
        },
    }
}

/// Refuses an end that is behind the job already.
fn check_longer(status: &JobStatus, stop: StopRule) -> Result<(), FarmError> {
    let is_behind = |what: &str| FarmError::BadRequest {
        problem: format!("job {} has {what} already", status.id),
        remedy: "give a later end".to_owned(),
    };
    if stop.is_empty() {
        let problem = "no end is given".to_owned();
        return Err(FarmError::BadRequest { problem, remedy: "give passes, seconds or error".to_owned() });
    }
    if stop.passes.is_some_and(|passes| passes <= status.passes_done) {
        return Err(is_behind(&format!("{} passes", status.passes_done)));
    }
    if stop.seconds.is_some_and(|seconds| seconds <= status.seconds) {
        return Err(is_behind(&format!("run for {:.1} s", status.seconds)));
    }
    let bound = status.estimated_error.map(|error| error.bound);
    if stop.error.zip(bound).is_some_and(|(wanted, bound)| bound <= wanted) {
        return Err(is_behind("so small an error"));
    }
    Ok(())
}
