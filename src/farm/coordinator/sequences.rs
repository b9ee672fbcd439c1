//! What users ask of sequences: submit, pause, resume, cancel, delete, and how they are doing.

use std::sync::Arc;

use super::CoordinatorHandle;
use super::blocking::blocking;
use super::chores::Chore;
use super::jobs::fingerprint;
use super::request;
use super::sequence_control::Wish;
use super::sequence_record::{Halt, SequenceFacts, SequenceRecord};
use super::shared::Shared;
use crate::farm::access::caller::Caller;
use crate::farm::access::user::UserName;
use crate::farm::error::FarmError;
use crate::farm::ids::{JobId, SequenceId};
use crate::farm::job::{Idempotency, IdempotencyKey, JobRequest};
use crate::farm::locks::lock;
use crate::farm::sequence::{SequenceRequest, SequenceStatus, numbered};
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
        let (shared, owner) = (self.shared.clone(), caller.name().cloned());
        let submit = async move { shared.submit_sequence(request, owner, key).await };
        let id = self.shared.to_its_end(submit).await?;
        self.shared.record_deed(caller, &format!("sequence {id} was submitted"));
        Ok(id)
    }

    /// All sequences, oldest first.
    pub fn sequences(&self) -> Vec<SequenceStatus> {
        let records = self.shared.all_sequences();
        let is_there = |record: &&Arc<SequenceRecord>| lock(&record.facts).is_there();
        records.iter().filter(is_there).map(|record| self.shared.sequence_status(record)).collect()
    }

    /// How a sequence is doing.
    pub fn sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        Ok(self.shared.sequence_status(&*self.shared.sequence(id)?))
    }

    /// Issues no more work of a sequence; what is being traced is still merged.
    pub async fn pause_sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.shared.wish_of_sequence(id, Wish::Pause).await
    }

    /// Lets a paused sequence go on, or one that stopped because a frame could not become a job.
    pub async fn resume_sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.shared.wish_of_sequence(id, Wish::Resume).await
    }

    /// Stops a sequence and keeps its pictures. One that has ended stays as it is.
    pub async fn cancel_sequence(&self, id: SequenceId) -> Result<SequenceStatus, FarmError> {
        self.shared.wish_of_sequence(id, Wish::Cancel).await
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
        let (_checking, record) = loop {
            let turn = self.sequencing.take().await?;
            let known = idempotency.as_ref().map(|wanted| self.sequence_submitted_before(owner.as_ref(), wanted));
            let Some(known) = known.transpose()?.flatten() else {
                let record = self.new_sequence(SequenceFacts::new(request, moments, owner, idempotency))?;
                break (record.checking.take().await?, record);
            };
            drop(turn);
            // Its first frame may be looked at still, and then be refused.
            let _checked = known.checking.take().await?;
            if self.sequence(known.id).is_ok() {
                return Ok(known.id);
            }
        };
        match self.begin_sequence(&record).await {
            Ok(()) => Ok(record.id),
            Err(problem) => {
                lock(&self.sequences).remove(&record.id);
                // What was refused must not come back with the next start.
                self.leave_to_keeper(Chore::ForgetSequence(record.id));
                Err(problem)
            }
        }
    }

    /// A sequence that nobody is told of yet.
    fn new_sequence(&self, facts: SequenceFacts) -> Result<Arc<SequenceRecord>, FarmError> {
        let (id, unix) = self.next_id()?;
        let facts = SequenceFacts { submitted: unix.as_millis() as i64, ..facts };
        let record = Arc::new(SequenceRecord::new(SequenceId::new(id), facts));
        lock(&self.sequences).insert(record.id, record.clone());
        Ok(record)
    }

    async fn begin_sequence(self: &Arc<Self>, record: &SequenceRecord) -> Result<(), FarmError> {
        self.store.put_sequence(&record.row()).await?;
        self.make_frame(record).await?;
        lock(&record.facts).is_new = false;
        self.leave_to_keeper(Chore::Sequence(record.id));
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
    ) -> Result<Option<Arc<SequenceRecord>>, FarmError> {
        for record in self.all_sequences() {
            let facts = lock(&record.facts).clone();
            let Some(known) = facts.idempotency.as_ref().filter(|known| known.key == wanted.key) else { continue };
            if facts.owner.as_ref() != owner || facts.halt == Some(Halt::Deleted) {
                continue;
            }
            if known == wanted {
                return Ok(Some(record));
            }
            return Err(FarmError::BadRequest {
                problem: format!("sequence {} was submitted with the same key, and is another one", record.id),
                remedy: "choose a new Idempotency-Key for every sequence".to_owned(),
            });
        }
        Ok(None)
    }

    /// The sequence with this id, also one that is being deleted.
    pub(super) fn sequence_record(&self, id: SequenceId) -> Option<Arc<SequenceRecord>> {
        lock(&self.sequences).get(&id).cloned()
    }

    /// The sequence with this id.
    pub(super) fn sequence(&self, id: SequenceId) -> Result<Arc<SequenceRecord>, FarmError> {
        let is_there = |record: &Arc<SequenceRecord>| lock(&record.facts).is_there();
        self.sequence_record(id).filter(is_there).ok_or(FarmError::UnknownSequence(id))
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
            if let Some(record) = self.sequence_record(frame.sequence) {
                lock(&record.facts).add(frame.number, job.id);
            }
        }
        for record in self.all_sequences() {
            // One that was not answered was accepted if its first frame was.
            let is_refused = {
                let mut facts = lock(&record.facts);
                std::mem::replace(&mut facts.is_new, false) && facts.jobs.is_empty()
            };
            if is_refused {
                self.store.delete_sequence(record.id).await?;
                lock(&self.sequences).remove(&record.id);
            }
        }
        Ok(())
    }

    /// Whether a job is there that has not ended.
    pub(super) fn is_live(&self, job: JobId) -> bool {
        self.lock().rules.job(job).is_some_and(|job| !job.has_ended())
    }
}
