//! What users do to sequences as a whole: pause, resume, cancel, delete. What they ask for is stored first and then done to its end, also when they
//! hang up; whoever asks for the same again has the rest done that a fault left.

use std::future::Future;
use std::sync::Arc;

use super::chores::Chore;
use super::sequence_record::{Halt, SequenceRecord};
use super::shared::Shared;
use crate::farm::error::FarmError;
use crate::farm::ids::{JobId, SequenceId};
use crate::farm::job::JobState;
use crate::farm::locks::lock;
use crate::farm::rules::Event;
use crate::farm::rules::terms::PauseReason;
use crate::farm::sequence::{SequenceState, SequenceStatus};

/// What a user wants of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wish {
    Pause,
    Resume,
    Cancel,
}

impl Wish {
    /// Whether there is something to do. `is_stuck` is a sequence whose next frame could not become a job.
    fn fits(self, status: &SequenceStatus, is_stuck: bool) -> bool {
        let mut live = status.jobs.iter().map(|job| job.state).filter(|state| !state.is_final());
        match self {
            Self::Pause => {
                let is_half = status.state == SequenceState::Paused && live.any(|state| state != JobState::Paused);
                status.state == SequenceState::Running || is_half
            }
            Self::Resume => {
                is_stuck || status.state == SequenceState::Paused || live.any(|state| state == JobState::Paused)
            }
            Self::Cancel => is_stuck || status.state.is_live() || live.next().is_some(),
        }
    }

    const fn halt(self) -> Option<Halt> {
        match self {
            Self::Pause => Some(Halt::Paused),
            Self::Resume => None,
            Self::Cancel => Some(Halt::Cancelled),
        }
    }

    const fn event(self, job: JobId) -> Event {
        match self {
            Self::Pause => Event::JobPaused { job, reason: PauseReason::User },
            Self::Resume => Event::JobResumed { job },
            Self::Cancel => Event::JobCancelled { job },
        }
    }
}

impl Shared {
    /// Does what a user asked for to its end, also when they hang up.
    pub(super) async fn to_its_end<T: Send + 'static>(
        &self,
        work: impl Future<Output = Result<T, FarmError>> + Send + 'static,
    ) -> Result<T, FarmError> {
        self.busy.spawn(work).await.map_err(|problem| FarmError::Internal(problem.to_string()))?
    }

    /// Does to a sequence what a user wants. One that is to be cancelled and has ended stays as it is.
    pub(super) async fn wish_of_sequence(
        self: &Arc<Self>,
        id: SequenceId,
        wish: Wish,
    ) -> Result<SequenceStatus, FarmError> {
        let shared = self.clone();
        self.to_its_end(async move { shared.fulfil(id, wish).await }).await
    }

    async fn fulfil(self: &Arc<Self>, id: SequenceId, wish: Wish) -> Result<SequenceStatus, FarmError> {
        let record = self.sequence(id)?;
        let _turn = record.turn.take().await?;
        let status = self.sequence_status(&record);
        let jobs: Vec<JobId> = {
            let mut facts = lock(&record.facts);
            let is_cancelled = facts.halt == Some(Halt::Cancelled);
            let is_stuck = facts.problem.is_some() && !is_cancelled;
            if !wish.fits(&status, is_stuck) || (is_cancelled && wish != Wish::Cancel) {
                drop(facts);
                return if wish == Wish::Cancel { Ok(status) } else { Err(wrong_state(id, status.state, is_stuck)) };
            }
            (facts.halt, facts.problem) = (wish.halt(), None);
            facts.jobs.values().copied().collect()
        };
        self.leave_to_keeper(Chore::Sequence(id));
        self.stored_in_time().await?;
        let mut fault = None;
        for job in jobs.into_iter().filter(|job| self.is_live(*job)) {
            match self.control(job, wish.event(job)).await {
                // It ended, was deleted, or is in that state already.
                Ok(_) | Err(FarmError::Conflict { .. } | FarmError::UnknownJob(_)) => {}
                Err(problem) => fault = Some(problem),
            }
        }
        fault.map_or_else(|| Ok(self.sequence_status(&record)), Err)
    }

    /// Deletes a sequence with its jobs, their pictures, and the scenes that were made for them. Once that is stored it happens, whoever hangs up,
    /// and also after a kill.
    pub(super) async fn delete_sequence(self: &Arc<Self>, id: SequenceId) -> Result<(), FarmError> {
        let shared = self.clone();
        self.to_its_end(async move { shared.mark_and_erase(id).await }).await
    }

    async fn mark_and_erase(self: &Arc<Self>, id: SequenceId) -> Result<(), FarmError> {
        let record = self.sequence(id)?;
        let _turn = record.turn.take().await?;
        // Somebody may have deleted it meanwhile.
        let record = self.sequence(id)?;
        lock(&record.facts).halt = Some(Halt::Deleted);
        self.leave_to_keeper(Chore::Sequence(id));
        // A full disk must not be in the way of deleting what fills it.
        if let Err(problem) = self.stored_in_time().await {
            tracing::debug!(sequence = %id, %problem, "a sequence is deleted while the store does not work");
        }
        self.erase_sequence(&record).await
    }

    /// Nothing of a sequence stays. Who calls has its turn.
    pub(super) async fn erase_sequence(self: &Arc<Self>, record: &SequenceRecord) -> Result<(), FarmError> {
        let (jobs, owner) = {
            let facts = lock(&record.facts);
            (facts.jobs.values().copied().collect::<Vec<_>>(), facts.owner.clone())
        };
        for job in jobs {
            let Ok(scene) = self.job(job).map(|job| job.description().scene) else { continue };
            match self.delete_job(job).await {
                Ok(()) | Err(FarmError::UnknownJob(_)) => {}
                Err(problem) => return Err(problem),
            }
            // Somebody else may have made the same changes before.
            if self.scene(&scene).is_ok_and(|scene| scene.summary.owner != owner) {
                continue;
            }
            match self.delete_scene(&scene).await {
                // Other jobs have it, too.
                Ok(()) | Err(FarmError::Conflict { .. } | FarmError::UnknownScene(_)) => {}
                Err(problem) => return Err(problem),
            }
        }
        self.store.delete_sequence(record.id).await?;
        lock(&self.sequences).remove(&record.id);
        Ok(())
    }
}

fn wrong_state(id: SequenceId, state: SequenceState, is_stuck: bool) -> FarmError {
    let (is, remedy) = match state {
        SequenceState::Paused => ("paused already", "resume it to let it go on"),
        SequenceState::Running => ("running already", "pause it to stop it for a while"),
        SequenceState::Failed if is_stuck => ("failed", "resume it, which tries its next frame again"),
        state => (state.name(), "submit it again"),
    };
    FarmError::Conflict { problem: format!("sequence {id} is {is}"), remedy: remedy.to_owned() }
}
