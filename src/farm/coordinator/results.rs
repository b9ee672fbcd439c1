//! What becomes of a result: the rules decide, and what they take is merged before anything else of the job.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use super::shared::{JobRecord, Shared};
use crate::estimate::Tally;
use crate::estimate::picture_files::Mattes;
use crate::farm::ids::{Fencing, LeaseId, WorkerId};
use crate::farm::locks::{lock, panic_message};
use crate::farm::merging::Merging;
use crate::farm::rules::check::Digest;
#[cfg(doc)]
use crate::farm::rules::lease::Errand;
use crate::farm::rules::lease::{Lease, Work};
use crate::farm::rules::plan::Plan;
use crate::farm::rules::{Answer, Event, Outcome};
use crate::method::MethodChoice;
use crate::render::Pilot;
use crate::render::first_surface::FirstSurface;

/// A result that fits its work.
pub(in crate::farm) enum Payload {
    /// Of [`Work::Choice`].
    Choice {
        /// The method, with parameters that are not at their defaults.
        choice: MethodChoice,
        /// Why.
        reason: String,
    },
    /// Of [`Work::Pilot`].
    Pilot(Pilot),
    /// Of [`Work::Shard`].
    Tally(Tally),
    /// Of [`Errand::FirstSurfaces`].
    FirstSurfaces(Vec<FirstSurface>),
    /// Of [`Errand::Mattes`].
    Mattes(Mattes),
}

/// A delivery, as the protocol reads it.
#[derive(Clone, Copy, Debug)]
pub(in crate::farm) struct Delivery {
    /// Who delivers.
    pub worker: WorkerId,
    /// What for.
    pub lease: LeaseId,
    /// The lease's fencing number.
    pub fencing: Fencing,
}

/// What the worker is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::farm) enum Delivered {
    /// Its result is merged, compared, or its failure recorded.
    Taken,
    /// It came before.
    AlreadyMerged,
    /// The lease is not the worker's any more.
    Fenced,
}

impl Shared {
    /// Tells the rules what came.
    pub(in crate::farm) fn record_result(&self, delivery: Delivery, outcome: Outcome) -> Answer {
        let Delivery { worker, lease, fencing } = delivery;
        self.apply(Event::ResultCame { worker, lease, fencing, outcome })
    }

    /// Merges a result, if the rules take it. Blocks while it does.
    pub(in crate::farm) fn take_result(
        &self,
        job: &JobRecord,
        delivery: Delivery,
        payload: Payload,
        digest: Option<Digest>,
    ) -> Delivered {
        let start = Instant::now();
        let delivered = self.take_result_in_turn(job, delivery, payload, digest);
        self.counters.merging_took(start.elapsed());
        delivered
    }

    fn take_result_in_turn(
        &self,
        job: &JobRecord,
        delivery: Delivery,
        payload: Payload,
        digest: Option<Digest>,
    ) -> Delivered {
        let mut merging = lock(&job.merging);
        let lease = match self.record_result(delivery, Outcome::Accepted(digest)) {
            Answer::Take(lease) => lease,
            Answer::AlreadyMerged => return Delivered::AlreadyMerged,
            Answer::Fenced => return Delivered::Fenced,
            _ => return Delivered::Taken,
        };
        let merged = catch_unwind(AssertUnwindSafe(|| self.merge(job, &mut merging, lease, payload)));
        let problem = match merged {
            Ok(Ok(())) => return Delivered::Taken,
            Ok(Err(problem)) => problem,
            Err(panic) => {
                // Half a merge is no state to go on from or to look at.
                *merging = None;
                format!("a fault of the coordinator: {}", panic_message(panic.as_ref()))
            }
        };
        tracing::error!(job = %job.id, problem, "a result cannot be merged");
        self.apply(Event::JobFailed { job: job.id, problem });
        Delivered::Taken
    }

    fn merge(
        &self,
        job: &JobRecord,
        merging: &mut Option<Merging>,
        lease: Lease,
        payload: Payload,
    ) -> Result<(), String> {
        match (payload, lease.work) {
            (Payload::Choice { choice, reason }, _) => {
                self.choose(job, choice, reason).map_err(|problem| problem.to_string())
            }
            (Payload::FirstSurfaces(seen), _) => {
                self.surfaces_seen.insert(&job.description().scene, seen.into());
                Ok(())
            }
            (Payload::Mattes(mattes), _) => {
                self.mattes_seen.insert(&job.description().scene, mattes.into());
                Ok(())
            }
            (Payload::Pilot(pilot), _) => {
                *merging = Some(self.begin(job, &pilot)?);
                lock(&job.facts).last_snapshot = Some(self.clock.now());
                Ok(())
            }
            (Payload::Tally(tally), Work::Shard(index, _)) => {
                let merging = merging.as_mut().ok_or("a tally came before the pilot")?;
                if let Some(hook) = &self.options.faults.before_merge {
                    hook(job.id, index);
                }
                let before = merging.totals();
                merging.add(index, tally)?;
                let totals = merging.totals();
                let photons = totals.photons_emitted.saturating_sub(before.photons_emitted);
                self.counters.merged(photons, totals.shards.saturating_sub(before.shards));
                self.apply(Event::Merged { job: job.id, totals });
                Ok(())
            }
            (Payload::Tally(..), _) => Err("a tally came for other work".to_owned()),
        }
    }

    fn begin(&self, job: &JobRecord, pilot: &Pilot) -> Result<Merging, String> {
        let (description, stop, cut) = {
            let facts = lock(&job.facts);
            (facts.description.clone(), facts.terms.stop, facts.request.cut)
        };
        let declaration = description.declaration().ok_or("a pilot came before the method was chosen")?;
        let (width, height) = (description.width, description.height);
        let plan = Plan::new(width, height, pilot.cost_per_pass(), stop.passes, declaration.radius_rule).with_cut(cut);
        let merging =
            Merging::new(plan.clone(), pilot, stop.error, declaration).map_err(|problem| problem.to_string())?;
        tracing::info!(job = %job.id, cost_per_pass = pilot.cost_per_pass(), ?plan, "pilot done");
        self.apply(Event::PilotDone { job: job.id, plan });
        Ok(merging)
    }
}
