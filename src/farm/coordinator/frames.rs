//! Makes jobs of the frames of sequences, one after the other, so that a few of each are there at a time: a farm that renders a film still has
//! room for a still.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};
use std::time::Duration;

use tokio::time::{Instant, sleep};
use tokio_util::sync::CancellationToken;

use super::chores::Chore;
use super::sequence_record::SequenceRecord;
use super::shared::Shared;
use crate::farm::error::FarmError;
use crate::farm::events::EVENTS;
use crate::farm::ids::SequenceId;
use crate::farm::job::{FrameOfSequence, JobRequest};
use crate::farm::locks::lock;
use crate::farm::sequence::numbered;

/// How often somebody looks whether a frame is due.
const LOOK: Duration = Duration::from_millis(200);
/// The pause before a frame is tried again that the farm has no room for.
const RETRY: Duration = Duration::from_secs(5);
/// The pause between two looks for sequences without jobs.
const SWEEP: Duration = Duration::from_secs(10);

/// Makes frames until the coordinator is stopped or dropped.
pub(super) async fn keep_making_frames(shared: Weak<Shared>, stopped: CancellationToken) {
    let (mut waiting, mut sweep) = (BTreeMap::<SequenceId, Instant>::new(), Instant::now());
    while stopped.run_until_cancelled(sleep(LOOK)).await.is_some() {
        let Some(shared) = shared.upgrade() else { return };
        waiting.retain(|_, until| *until > Instant::now());
        for record in shared.all_sequences() {
            if waiting.contains_key(&record.id) || shared.lock().is_closed || !shared.is_frame_due(&record) {
                continue;
            }
            match shared.make_frame(&record).await {
                Ok(()) => {}
                Err(problem) if may_pass(&problem) => {
                    tracing::debug!(sequence = %record.id, %problem, "a frame waits");
                    waiting.insert(record.id, Instant::now() + RETRY);
                }
                Err(problem) => shared.stop_making(&record, &problem),
            }
        }
        if sweep <= Instant::now() {
            sweep = Instant::now() + SWEEP;
            shared.forget_empty_sequences();
        }
    }
}

/// Whether a frame that was refused may be taken later.
fn may_pass(problem: &FarmError) -> bool {
    matches!(problem, FarmError::Busy { .. } | FarmError::Store { .. } | FarmError::ShuttingDown)
}

impl Shared {
    fn is_frame_due(&self, record: &SequenceRecord) -> bool {
        let mut facts = lock(&record.facts);
        if facts.is_new || facts.halt.is_some() || facts.problem.is_some() || facts.next().is_none() {
            return false;
        }
        facts.live.retain(|job| self.is_live(*job));
        facts.live.len() < facts.request.at_once.get()
    }

    /// Makes a job of a sequence's next frame, unless somebody stopped the sequence meanwhile.
    pub(super) async fn make_frame(self: &Arc<Self>, record: &SequenceRecord) -> Result<(), FarmError> {
        let (request, owner, next) = {
            let facts = lock(&record.facts);
            (facts.request.clone(), facts.owner.clone(), facts.next())
        };
        let Some(frame) = next else { return Ok(()) };
        // Preparing a scene takes its time; users do not wait for it.
        let changed = self.changed_scene(&request.job.scene, frame.changes.clone().over(request.changes)).await?;
        let scene = self.upload_all(&changed, owner.clone()).await?.finish().await?.hash;
        let _turn = record.turn.take().await?;
        if lock(&record.facts).halt.is_some() {
            return Ok(());
        }
        let job = JobRequest {
            scene,
            name: request.job.name.as_deref().map(|name| numbered(name, frame.number)),
            seed: request.job.seed.wrapping_add(frame.seed),
            frame: Some(FrameOfSequence { sequence: record.id, number: frame.number }),
            ..request.job
        };
        let job = self.submit(job, owner, None).await?;
        lock(&record.facts).add(frame.number, job);
        self.leave_to_keeper(Chore::Sequence(record.id));
        Ok(())
    }

    /// A frame that cannot be a job ends the sequence, until a user resumes it.
    fn stop_making(&self, record: &SequenceRecord, problem: &FarmError) {
        {
            let mut facts = lock(&record.facts);
            let Some(frame) = facts.next() else { return };
            facts.problem = Some(format!("frame {}: {problem}", frame.number));
        }
        tracing::warn!(target: EVENTS, "sequence {} stops: {problem}", record.id);
        self.leave_to_keeper(Chore::Sequence(record.id));
    }

    /// A sequence goes with the last of its jobs, once no frame is left to be made.
    fn forget_empty_sequences(&self) {
        let is_empty = |record: &Arc<SequenceRecord>| {
            let mut facts = lock(&record.facts);
            let state = self.lock();
            facts.jobs.retain(|_, job| state.jobs.contains_key(job));
            facts.jobs.is_empty() && !facts.is_new && !facts.goes_on()
        };
        for record in self.all_sequences().iter().filter(|record| is_empty(record)) {
            lock(&self.sequences).remove(&record.id);
            self.leave_to_keeper(Chore::ForgetSequence(record.id));
        }
    }
}
