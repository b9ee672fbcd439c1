//! What users ask of sequences: submit, pause, resume, cancel, delete, and how they are doing.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::CoordinatorHandle;
use super::blocking::blocking;
use super::chores::Chore;
use super::jobs::fingerprint;
use super::request;
use super::sequence_record::{Halt, SequenceFacts, SequenceRecord};
use super::shared::Shared;
use crate::farm::access::caller::Caller;
use crate::farm::access::user::UserName;
use crate::farm::error::FarmError;
use crate::farm::ids::{JobId, SequenceId};
use crate::farm::job::{Idempotency, IdempotencyKey, JobRequest, JobState, JobStatus};
use crate::farm::locks::lock;
use crate::farm::rules::Event;
use crate::farm::rules::terms::PauseReason;
use crate::farm::sequence::{FrameJob, SequenceRequest, SequenceState, SequenceStatus, numbered};
use crate::farm::store::StoreError;
use crate::import::{UNNAMED, load_bytes};

impl CoordinatorHandle {
    /// Checks a request of a sequence and queues its first frame; the others follow, a few at a time.
    ///
    /// # Errors
    /// As for a job; frames that cannot be.
    pub async fn submit_sequence(
        &self,
        request: SequenceRequest,
        caller: &Caller,
        key: Option<IdempotencyKey>,
    ) -> Result<SequenceId, FarmError> {
        let id = self.shared.submit_sequence(request, caller.name().cloned(), key).await?;
        self.shared.record_deed(caller, &format!("sequence {id} was submitted"));
        Ok(id)
    }

    /// All sequences, oldest first.
    pub fn sequences(&self) -> Vec<SequenceStatus> {
        let records = self.shared.all_sequences();
        // One whose first frame is being checked may still be refused.
        let accepted = records.iter().filter(|record| !lock(&record.facts).is_new);
        accepted.map(|record| self.shared.sequence_status(record)).collect()
    }

    /// How a sequence is doing.
    pub fn sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        Ok(self.shared.sequence_status(&*self.shared.sequence(id)?))
    }

    /// Issues no more work of a sequence; what is being traced is still merged.
    pub async fn pause_sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.shared.pause_sequence(id).await
    }

    /// Lets a paused sequence go on, or one that stopped because a frame could not become a job.
    pub async fn resume_sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.shared.resume_sequence(id).await
    }

    /// Stops a sequence and keeps its pictures. One that has ended stays as it is.
    pub async fn cancel_sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.shared.cancel_sequence(id).await
    }

    /// Deletes a sequence with its jobs and pictures.
    pub async fn delete_sequence(&self, caller: &Caller, id: SequenceId) -> Result<(), FarmError> {
        self.shared.delete_sequence(id).await?;
        self.shared.record_deed(caller, &format!("sequence {id} was deleted"));
        Ok(())
    }
}

/// A sequence of which frames are to be made still.
pub(super) struct SequenceToMake {
    pub(super) id: SequenceId,
    /// Hash of the scene that its frames change.
    pub(super) scene: String,
}

impl Shared {
    /// Checks a request, and with it the first frame, which becomes a job.
    pub(super) async fn submit_sequence(
        self: &Arc<Self>,
        mut request: SequenceRequest,
        owner: Option<UserName>,
        key: Option<IdempotencyKey>,
    ) -> Result<SequenceId, FarmError> {
        request.frames.check(&request.changes)?;
        request.job.name = request.job.name.filter(|name| !name.is_empty());
        let name = request.job.name.as_deref().map(|name| numbered(name, request.frames.last));
        request::check_labels(&JobRequest { name, ..request.job.clone() }, &self.options.limits)?;
        let idempotency = key.map(|key| Idempotency { key, request: fingerprint(&request) });
        let moments = self.moments(&request, owner.as_ref()).await?;
        let record = {
            let _turn = self.sequencing.take().await?;
            if let Some(wanted) = &idempotency
                && let Some(known) = self.sequence_submitted_before(owner.as_ref(), wanted)?
            {
                return Ok(known);
            }
            let (id, unix) = self.next_id()?;
            let facts = SequenceFacts {
                request,
                moments,
                owner,
                submitted: unix.as_millis() as i64,
                made: 0,
                halt: None,
                problem: None,
                idempotency,
                jobs: BTreeMap::new(),
                live: Vec::new(),
                is_new: true,
            };
            let record = Arc::new(SequenceRecord::new(SequenceId::new(id), facts));
            lock(&self.sequences).insert(record.id, record.clone());
            record
        };
        if let Err(problem) = self.begin_sequence(&record).await {
            lock(&self.sequences).remove(&record.id);
            // What was refused must not come back with the next start.
            self.leave_to_keeper(Chore::ForgetSequence(record.id));
            return Err(problem);
        }
        Ok(record.id)
    }

    async fn begin_sequence(self: &Arc<Self>, record: &SequenceRecord) -> Result<(), FarmError> {
        self.store.put_sequence(&record.row()).await?;
        self.make_frame(record).await?;
        lock(&record.facts).is_new = false;
        Ok(())
    }

    /// What the first and the last frame of the whole sequence show.
    async fn moments(
        self: &Arc<Self>,
        request: &SequenceRequest,
        owner: Option<&UserName>,
    ) -> Result<Option<[f64; 2]>, FarmError> {
        // An archive takes much more memory than its bytes while it is unpacked.
        let slot = self.upload_slot(owner)?;
        let bytes = self.whole_scene_bytes(&request.job.scene).await?;
        let read = move || {
            let _slot = slot;
            Ok(load_bytes(UNNAMED, &bytes, &[])?.moves)
        };
        Ok(request.frames.moments(blocking(read).await?)?)
    }

    /// The sequence that the same user submitted with the same key.
    ///
    /// # Errors
    /// Something else was asked for then.
    fn sequence_submitted_before(
        &self,
        owner: Option<&UserName>,
        wanted: &Idempotency,
    ) -> Result<Option<SequenceId>, FarmError> {
        for record in lock(&self.sequences).values() {
            let facts = lock(&record.facts);
            let Some(known) = facts.idempotency.as_ref().filter(|known| known.key == wanted.key) else { continue };
            if facts.owner.as_ref() != owner {
                continue;
            }
            if known == wanted {
                return Ok(Some(record.id));
            }
            return Err(FarmError::BadRequest {
                problem: format!("sequence {} was submitted with the same key, and is another one", record.id),
                remedy: "choose a new Idempotency-Key for every sequence".to_owned(),
            });
        }
        Ok(None)
    }

    /// The sequence with this id.
    pub(super) fn sequence(&self, id: SequenceId) -> Result<Arc<SequenceRecord>, FarmError> {
        lock(&self.sequences).get(&id).cloned().ok_or(FarmError::UnknownSequence(id))
    }

    /// Those of which frames are to be made still.
    pub(super) fn sequences_to_make(&self) -> Vec<SequenceToMake> {
        let records = self.all_sequences();
        let to_make = records.iter().filter_map(|record| {
            let facts = lock(&record.facts);
            let scene = facts.request.job.scene.clone();
            facts.goes_on().then_some(SequenceToMake { id: record.id, scene })
        });
        to_make.collect()
    }

    /// All of them, oldest first.
    pub(super) fn all_sequences(&self) -> Vec<Arc<SequenceRecord>> {
        lock(&self.sequences).values().cloned().collect()
    }

    /// Takes the sequences of the store over, whose jobs are there already.
    pub(super) async fn take_over_sequences(&self) -> Result<(), StoreError> {
        for row in self.store.sequence_rows().await? {
            lock(&self.sequences).insert(row.id, Arc::new(SequenceRecord::read(&row)?));
        }
        let jobs: Vec<_> = self.lock().jobs.values().cloned().collect();
        for job in jobs {
            let Some(frame) = job.request().frame else { continue };
            if let Ok(record) = self.sequence(frame.sequence) {
                lock(&record.facts).add(frame.number, job.id);
            }
        }
        Ok(())
    }

    /// How a sequence is doing.
    pub(super) fn sequence_status(&self, record: &SequenceRecord) -> SequenceStatus {
        let facts = lock(&record.facts).clone();
        let state = self.lock();
        let jobs = facts.jobs.iter().filter_map(|(frame, id)| Some((*frame, state.jobs.get(id)?)));
        let jobs = jobs.map(|(frame, job)| (frame, state.status(job, &self.clock))).collect();
        status(record.id, facts, jobs)
    }

    /// Issues no more work of a sequence; no frame becomes a job.
    pub(super) async fn pause_sequence(self: &Arc<Self>, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.halt(id, SequenceState::Running, Some(Halt::Paused), |job| Event::JobPaused {
            job,
            reason: PauseReason::User,
        })
        .await
    }

    /// Lets a paused sequence go on, or one whose next frame could not become a job.
    pub(super) async fn resume_sequence(self: &Arc<Self>, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.halt(id, SequenceState::Paused, None, |job| Event::JobResumed { job }).await
    }

    /// Stops a sequence and keeps its pictures. One that has ended stays as it is.
    pub(super) async fn cancel_sequence(self: &Arc<Self>, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        let record = self.sequence(id)?;
        let status = self.sequence_status(&record);
        let is_stuck = lock(&record.facts).problem.is_some();
        if !status.state.is_live() && !is_stuck {
            return Ok(status);
        }
        self.halt(id, status.state, Some(Halt::Cancelled), |job| Event::JobCancelled { job }).await
    }

    /// Lets an event happen to all frames that have not ended, if the sequence is in a state for it.
    async fn halt(
        self: &Arc<Self>,
        id: SequenceId,
        expected: SequenceState,
        halt: Option<Halt>,
        event: impl Fn(JobId) -> Event,
    ) -> Result<SequenceStatus, FarmError> {
        let record = self.sequence(id)?;
        let _turn = record.turn.take().await?;
        let state = self.sequence_status(&record).state;
        let may_try_again = halt.is_none() && lock(&record.facts).problem.is_some();
        if state != expected && !may_try_again {
            return Err(FarmError::Conflict {
                problem: format!("sequence {id} is {}", state.name()),
                remedy: match state {
                    SequenceState::Paused => "resume it first".to_owned(),
                    SequenceState::Running => "pause or cancel it first".to_owned(),
                    _ => "submit it again".to_owned(),
                },
            });
        }
        let jobs = {
            let mut facts = lock(&record.facts);
            (facts.halt, facts.problem) = (halt, None);
            facts.jobs.values().copied().collect::<Vec<_>>()
        };
        for job in jobs.into_iter().filter(|job| self.is_live(*job)) {
            match self.control(job, event(job)).await {
                // It ended, was deleted, or is in that state already.
                Ok(_) | Err(FarmError::Conflict { .. } | FarmError::UnknownJob(_)) => {}
                Err(problem) => return Err(problem),
            }
        }
        self.leave_to_keeper(Chore::Sequence(id));
        self.stored_in_time().await?;
        Ok(self.sequence_status(&record))
    }

    /// Deletes a sequence with its jobs, their pictures, and the scenes that were made for them.
    pub(super) async fn delete_sequence(self: &Arc<Self>, id: SequenceId) -> Result<(), FarmError> {
        self.cancel_sequence(id).await?;
        let record = self.sequence(id)?;
        let _turn = record.turn.take().await?;
        let jobs: Vec<JobId> = lock(&record.facts).jobs.values().copied().collect();
        for job in jobs {
            let Ok(scene) = self.job(job).map(|job| job.description().scene) else { continue };
            match self.delete_job(job).await {
                Ok(()) | Err(FarmError::UnknownJob(_)) => {}
                Err(problem) => return Err(problem),
            }
            match self.delete_scene(&scene).await {
                // Other jobs have it, too.
                Ok(()) | Err(FarmError::Conflict { .. } | FarmError::UnknownScene(_)) => {}
                Err(problem) => return Err(problem),
            }
        }
        self.store.delete_sequence(id).await?;
        lock(&self.sequences).remove(&id);
        Ok(())
    }

    /// Whether a job is there that has not ended.
    pub(super) fn is_live(&self, job: JobId) -> bool {
        self.lock().rules.job(job).is_some_and(|job| !job.has_ended())
    }
}

fn status(id: SequenceId, facts: SequenceFacts, jobs: Vec<(u32, JobStatus)>) -> SequenceStatus {
    let SequenceRequest { job: request, frames, at_once, .. } = facts.request;
    let count = |state: JobState| jobs.iter().filter(|(_, job)| job.state == state).count() as u32;
    let (total, live) = (frames.count(), jobs.iter().filter(|(_, job)| !job.state.is_final()).count());
    let (done, failed) = (count(JobState::Done), count(JobState::Failed));
    let is_whole = facts.made == total;
    let state = match facts.halt {
        Some(Halt::Cancelled) => SequenceState::Cancelled,
        _ if facts.problem.is_some() || (is_whole && live == 0 && failed > 0) => SequenceState::Failed,
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
