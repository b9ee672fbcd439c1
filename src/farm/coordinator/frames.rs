//! Makes jobs of the frames of sequences, one after the other, so that a few of each are there at a time: a farm that renders a film still has
//! room for a still.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Weak};
use std::time::Duration;

use tokio::time::{Instant, sleep};
use tokio_util::sync::CancellationToken;

use super::chores::Chore;
use super::sequence_record::{Halt, SequenceFacts, SequenceRecord};
use super::shared::Shared;
use crate::farm::access::user::UserName;
use crate::farm::error::FarmError;
use crate::farm::events::EVENTS;
use crate::farm::job::{FrameOfSequence, JobRequest};
use crate::farm::locks::lock;
use crate::farm::sequence::numbered;

/// How often somebody looks whether a frame is due.
const LOOK: Duration = Duration::from_millis(200);
/// The pause before a frame is tried again that the farm has no room for.
const RETRY: Duration = Duration::from_secs(5);
/// The pause between two looks for sequences without jobs.
const SWEEP: Duration = Duration::from_secs(10);

/// So often a frame is tried whose scene somebody deletes before it is a job's.
const ATTEMPTS: u32 = 5;

/// Makes frames until the coordinator is stopped or dropped. A sequence whose scene takes long to prepare holds up no other.
pub(super) async fn keep_making_frames(shared: Weak<Shared>, stopped: CancellationToken) {
    let mut sweep = Instant::now();
    while stopped.run_until_cancelled(sleep(LOOK)).await.is_some() {
        let Some(shared) = shared.upgrade() else { return };
        for record in shared.all_sequences() {
            if shared.is_frame_due(&record) && !record.is_being_made.swap(true, Ordering::AcqRel) {
                let maker = shared.clone();
                shared.busy.spawn(async move {
                    maker.make_due_frames(&record).await;
                    record.is_being_made.store(false, Ordering::Release);
                });
            }
        }
        if sweep <= Instant::now() {
            sweep = Instant::now() + SWEEP;
            shared.forget_empty_sequences();
            shared.go_on_deleting().await;
        }
    }
}

/// Whether a frame that was refused may be taken later.
fn may_pass(problem: &FarmError) -> bool {
    matches!(problem, FarmError::Busy { .. } | FarmError::Store { .. } | FarmError::ShuttingDown)
}

impl Shared {
    fn is_frame_due(&self, record: &SequenceRecord) -> bool {
        let is_closed = self.lock().is_closed;
        let mut facts = lock(&record.facts);
        let is_waiting = facts.retry_at.is_some_and(|until| until > Instant::now());
        if is_closed || is_waiting || facts.halt.is_some() || !facts.is_there() || facts.problem.is_some() {
            return false;
        }
        facts.live.retain(|job| self.is_live(*job));
        facts.next().is_some() && facts.live.len() < facts.request.at_once.get()
    }

    async fn make_due_frames(self: &Arc<Self>, record: &SequenceRecord) {
        while self.is_frame_due(record) {
            let made = self.make_frame(record).await;
            let mut facts = lock(&record.facts);
            (facts.waiting, facts.retry_at) = (None, None);
            match made {
                Ok(()) => {}
                Err(problem) if may_pass(&problem) => {
                    facts.waiting = Some(problem.to_string());
                    facts.retry_at = Some(Instant::now() + RETRY);
                }
                Err(problem) => {
                    drop(facts);
                    self.stop_making(record, &problem);
                }
            }
        }
    }

    /// Makes a job of a sequence's next frame, unless somebody stopped the sequence meanwhile.
    pub(super) async fn make_frame(self: &Arc<Self>, record: &SequenceRecord) -> Result<(), FarmError> {
        let base = lock(&record.facts).request.job.scene.clone();
        for _ in 0..ATTEMPTS {
            match self.try_to_make_frame(record).await {
                // Somebody deleted it meanwhile.
                Err(FarmError::UnknownScene(lost)) if lost != base => {}
                made => return made,
            }
        }
        Err(self.busy("somebody deletes the scene of the next frame again and again".to_owned()))
    }

    async fn try_to_make_frame(self: &Arc<Self>, record: &SequenceRecord) -> Result<(), FarmError> {
        let (SequenceFacts { request, owner, .. }, next) = {
            let facts = lock(&record.facts);
            (facts.clone(), facts.next())
        };
        let Some(frame) = next else { return Ok(()) };
        let changes = frame.changes.clone().over(request.changes.clone());
        let changed = self.changed_scene(&request.job.scene, changes).await?;
        let is_new = self.scene(blake3::hash(&changed).to_hex().as_str()).is_err();
        // Preparing a scene takes its time; users do not wait for it.
        let scene = self.upload_all(&changed, owner.clone()).await?.finish().await?.hash;
        let job = JobRequest {
            scene: scene.clone(),
            name: request.job.name.as_deref().map(|name| numbered(name, frame.number)),
            seed: request.job.seed.wrapping_add(frame.seed),
            frame: Some(FrameOfSequence { sequence: record.id, number: frame.number }),
            ..request.job
        };
        let made = self.make_job(record, job, owner).await;
        if is_new && !matches!(made, Ok(true)) {
            // Nobody asked for this scene but a frame that is no job.
            if let Err(problem) = self.delete_scene(&scene).await {
                tracing::debug!(scene, %problem, "the scene of a frame stays");
            }
        }
        made.map(drop)
    }

    /// Submits the job of a frame; false when somebody stopped the sequence meanwhile.
    async fn make_job(
        self: &Arc<Self>,
        record: &SequenceRecord,
        job: JobRequest,
        owner: Option<UserName>,
    ) -> Result<bool, FarmError> {
        let _turn = record.turn.take().await?;
        let Some(frame) = job.frame.filter(|_| lock(&record.facts).halt.is_none()) else { return Ok(false) };
        let id = self.submit(job, owner, None).await?;
        lock(&record.facts).add(frame.number, id);
        self.leave_to_keeper(Chore::Sequence(record.id));
        Ok(true)
    }

    /// A frame that cannot be a job ends the sequence, until a user resumes it.
    fn stop_making(&self, record: &SequenceRecord, problem: &FarmError) {
        {
            let mut facts = lock(&record.facts);
            let Some(frame) = facts.next().filter(|_| facts.halt != Some(Halt::Cancelled)) else { return };
            facts.problem = Some(format!("frame {}: {problem}", frame.number));
        }
        tracing::warn!(target: EVENTS, "sequence {} stops: {problem}", record.id);
        self.leave_to_keeper(Chore::Sequence(record.id));
    }

    /// Goes on with deletions that a fault or a kill broke off.
    async fn go_on_deleting(self: &Arc<Self>) {
        for record in self.all_sequences() {
            if lock(&record.facts).halt != Some(Halt::Deleted) {
                continue;
            }
            // Whoever deletes it has its turn.
            let Some(_turn) = record.turn.take_now() else { continue };
            if let Err(problem) = self.erase_sequence(&record).await {
                tracing::debug!(sequence = %record.id, %problem, "a sequence is not deleted yet");
            }
        }
    }

    /// A sequence goes with the last of its jobs, once no frame is left to be made.
    fn forget_empty_sequences(&self) {
        let is_empty = |record: &Arc<SequenceRecord>| {
            let mut facts = lock(&record.facts);
            let state = self.lock();
            facts.jobs.retain(|_, job| state.jobs.contains_key(job));
            let goes_on = facts.goes_on() && facts.problem.is_none();
            facts.jobs.is_empty() && facts.is_there() && !goes_on
        };
        for record in self.all_sequences().iter().filter(|record| is_empty(record)) {
            lock(&self.sequences).remove(&record.id);
            self.leave_to_keeper(Chore::ForgetSequence(record.id));
        }
    }
}
