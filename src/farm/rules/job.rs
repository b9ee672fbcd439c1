//! One job: what is still to be issued, what has arrived, what is merged.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::check::Checks;
use super::lease::{Work, WorkIndex};
use super::plan::Plan;
use super::running_time::RunningTime;
use super::terms::{ErrorPoint, MergedTotals, PauseReason, Restored, Terms};
use crate::farm::ids::{Fencing, WorkerId};
use crate::farm::job::JobState;

/// Leases of the same work that may end with a worker's error message before the job fails.
const FAILURES_PER_WORK: usize = 3;
/// What work costs of which nothing is known yet, nominal microseconds of one core: as much as a full-grown shard.
pub(super) const UNKNOWN_COST: u64 = 1_000_000;
/// What the smallest work costs: asking for it and sending the result.
pub(super) const LEASE_COST: u64 = 10_000;
/// Workers that may be lost over the same work before it is issued to nobody else.
const LOSSES_PER_WORK: usize = 3;

/// How far a job had come when its first shard of this run was leased: its rate is measured from there.
#[derive(Clone, Copy, Debug)]
pub(super) struct RateStart {
    pub(super) passes: u32,
    pub(super) ran: Duration,
}

/// How far a job has come.
#[derive(Clone, Debug)]
pub struct Job {
    /// What it is doing.
    pub state: JobState,
    /// Why it failed.
    pub error: Option<String>,
    /// What was agreed; notices are added to it.
    pub terms: Terms,
    /// Why it pauses.
    pub pause: Option<PauseReason>,
    /// The cut; known after the pilot.
    pub plan: Option<Plan>,
    /// What is merged.
    pub totals: MergedTotals,
    /// The error as it was estimated from time to time.
    pub history: Vec<ErrorPoint>,
    /// Shards that are traced twice.
    pub checks: Checks,
    /// Whether a pilot or a shard was ever leased: it holds memory from then on.
    pub is_admitted: bool,
    /// Work granted so far over the job's share, nominal microseconds: who has least is next.
    pub served: u64,
    /// Part of it must be done again; until the adapter has restored the rest nothing is leased or taken.
    pub is_rolling_back: bool,
    ran: RunningTime,
    pub(super) rate_from: Option<RateStart>,
    /// Shards at which it ends; known after the pilot.
    limit: u64,
    next_index: u64,
    returned: BTreeSet<WorkIndex>,
    arrived: BTreeSet<u64>,
    fencing: BTreeMap<WorkIndex, Fencing>,
    failures: BTreeMap<WorkIndex, Vec<WorkerId>>,
    losses: BTreeMap<WorkIndex, BTreeSet<WorkerId>>,
    /// The first work of the merged state by the names of those who did it: who registers anew is the same.
    contributions: BTreeMap<String, WorkIndex>,
    seconds_are_over: bool,
    seconds_per_pass: Option<f64>,
}

impl Job {
    /// A job that waits for its first work.
    pub fn new(terms: Terms) -> Self {
        let first = if terms.chooses_method { WorkIndex::Choice } else { WorkIndex::Pilot };
        Self {
            state: JobState::Queued,
            error: None,
            terms,
            pause: None,
            plan: None,
            totals: MergedTotals::default(),
            history: Vec::new(),
            checks: Checks::default(),
            is_admitted: false,
            served: 0,
            is_rolling_back: false,
            ran: RunningTime::default(),
            rate_from: None,
            limit: 0,
            next_index: 0,
            returned: BTreeSet::from([first]),
            arrived: BTreeSet::new(),
            fencing: BTreeMap::new(),
            failures: BTreeMap::new(),
            losses: BTreeMap::new(),
            contributions: BTreeMap::new(),
            seconds_are_over: false,
            seconds_per_pass: None,
        }
    }

    /// A job that goes on from what was stored.
    pub fn restored(terms: Terms, restored: Restored) -> Self {
        let Restored { plan, totals, history, ran, pause } = restored;
        let mut job = Self::new(terms);
        job.ran.before = ran;
        (job.next_index, job.totals, job.history) = (totals.shards, totals, history);
        if let Some(plan) = plan {
            job.returned.clear();
            job.limit = plan.shard_count();
            job.plan = Some(plan);
        }
        if let Some(pause) = pause {
            (job.state, job.pause) = (JobState::Paused, Some(pause));
        }
        job
    }

    /// Whether nothing will change any more.
    pub fn has_ended(&self) -> bool {
        self.state.is_final()
    }

    /// The next work to issue: what came back first, then what was never issued and is allowed now. Work that `worker`
    /// failed at is left to others if there are any (`has_others`). Where no tally `may_come_early`, the next shard waits for all before it.
    pub fn next_work(&self, worker: WorkerId, has_others: impl Fn() -> bool, may_come_early: bool) -> Option<Work> {
        let failed_here = |index: &WorkIndex| self.failures.get(index).is_some_and(|by| by.contains(&worker));
        if let Some(index) = self.returned.iter().find(|index| !(failed_here(index) && has_others())) {
            return self.work(*index);
        }
        let plan = self.plan.as_ref()?;
        let allowed = self.next_index < self.limit
            && self.totals.shards >= plan.merged_before(self.next_index)
            && (may_come_early || self.totals.shards == self.next_index)
            && !self.waits_for_check(plan);
        if allowed { self.work(WorkIndex::Shard(self.next_index)) } else { None }
    }

    /// Whether a check must be done before the next shard is issued.
    fn waits_for_check(&self, plan: &Plan) -> bool {
        self.checks.oldest().is_some_and(|shard| shard < plan.first_checkable(plan.epoch_of(self.next_index)))
    }

    /// Whether all its shards are merged. It ends when its checks are done.
    pub fn is_complete(&self) -> bool {
        self.plan.is_some() && self.totals.shards >= self.limit
    }

    /// The work at a place.
    pub fn work(&self, index: WorkIndex) -> Option<Work> {
        let planned = |index: u64| self.plan.as_ref()?.shard(index);
        Some(match index {
            WorkIndex::Choice => Work::Choice,
            WorkIndex::Pilot => Work::Pilot,
            WorkIndex::Shard(index) => Work::Shard(index, planned(index)?),
            WorkIndex::Check(index) => Work::Check(index, planned(index)?),
            WorkIndex::Errand(errand) => Work::Errand(errand),
        })
    }

    /// Nominal microseconds of one core that work costs, its lease included.
    pub fn cost(&self, work: &Work) -> u64 {
        match (&self.plan, work.passes()) {
            (Some(plan), Some(passes)) => plan.cost_per_pass.saturating_mul(u64::from(passes)).max(LEASE_COST),
            _ => UNKNOWN_COST,
        }
    }

    /// Whether somebody could be given work now.
    pub fn has_work(&self) -> bool {
        self.next_work(WorkerId::default(), || false, true).is_some()
    }

    /// Pieces of work that workers could be given now.
    pub fn waiting(&self) -> u64 {
        let returned = self.returned.len() as u64;
        let Some(plan) = self.plan.as_ref().filter(|plan| !self.waits_for_check(plan)) else { return returned };
        // Later shards wait for more to be merged, never for less.
        let (mut first, mut end) = (self.next_index, self.limit.max(self.next_index));
        while first < end {
            let middle = first + (end - first) / 2;
            if self.totals.shards >= plan.merged_before(middle) { first = middle + 1 } else { end = middle }
        }
        returned + (first - self.next_index)
    }

    /// Shards that were never issued; `u64::MAX` before the pilot is done.
    pub fn unissued(&self) -> u64 {
        if self.plan.is_some() { self.limit.saturating_sub(self.next_index) } else { u64::MAX }
    }

    /// Records that work is leased at `now`; answers its fencing number.
    pub fn issue(&mut self, work: &Work, now: Duration) -> Fencing {
        let index = work.index();
        if !self.returned.remove(&index) && index == WorkIndex::Shard(self.next_index) {
            self.next_index += 1;
        }
        self.is_admitted |= index != WorkIndex::Choice;
        self.ran.start(now);
        if matches!(index, WorkIndex::Shard(_)) {
            self.rate_from.get_or_insert(RateStart { passes: self.totals.passes, ran: self.ran.total(now) });
        }
        if matches!(self.state, JobState::Queued | JobState::Choosing) {
            self.state = if index == WorkIndex::Choice { JobState::Choosing } else { JobState::Running };
        }
        let fencing = self.fencing.entry(index).or_default();
        *fencing = fencing.next();
        *fencing
    }

    /// Puts work back that nobody holds any more.
    pub fn give_back(&mut self, index: WorkIndex) {
        let is_needed = match index {
            WorkIndex::Choice => self.terms.chooses_method,
            WorkIndex::Pilot => self.plan.is_none(),
            WorkIndex::Shard(shard) => {
                shard >= self.totals.shards && shard < self.limit && !self.arrived.contains(&shard)
            }
            // Whoever asks for a check next finds it among those that nobody holds.
            WorkIndex::Check(_) | WorkIndex::Errand(_) => false,
        };
        if is_needed && !self.has_ended() {
            self.returned.insert(index);
        }
    }

    /// Records that the result of `worker` was taken, for work that was leased `took` ago.
    pub fn arrive(&mut self, work: &Work, worker: String, took: Duration) {
        let index = work.index();
        self.returned.remove(&index);
        self.fencing.remove(&index);
        self.failures.remove(&index);
        self.losses.remove(&index);
        let first = self.contributions.entry(worker).or_insert(index);
        *first = (*first).min(index);
        if let Work::Shard(shard, planned) = work {
            self.arrived.insert(*shard);
            let seconds = took.as_secs_f64() / f64::from(planned.shard.passes);
            let mean = self.seconds_per_pass.map_or(seconds, |mean| mean + 0.1 * (seconds - mean));
            self.seconds_per_pass = Some(mean);
        }
    }

    /// The first work that `worker` contributed to the merged state.
    pub fn first_contribution(&self, worker: &str) -> Option<WorkIndex> {
        self.contributions.get(worker).copied()
    }

    /// Part of the job is done again: what is known of checks, and of who contributed to what stays merged, stays known.
    pub fn remember(&mut self, before: &Self) {
        let kept = WorkIndex::Shard(self.totals.shards);
        let stays = |index: &WorkIndex| self.plan.is_some() && *index < kept;
        self.contributions = before
            .contributions
            .iter()
            .filter(|(_, index)| stays(index))
            .map(|(name, index)| (name.clone(), *index))
            .collect();
        self.checks = before.checks.counts();
    }

    /// How long work of this size usually takes from lease to result; `None` while nothing is known.
    pub fn typical_duration(&self, work: &Work) -> Option<Duration> {
        let seconds = self.seconds_per_pass? * f64::from(work.passes()?);
        Duration::try_from_secs_f64(seconds).ok()
    }

    /// The method was chosen: the pilot comes next.
    pub fn method_chosen(&mut self, terms: Terms, reasons: Vec<String>) {
        self.terms = Terms { chooses_method: false, ..terms };
        self.terms.notices.extend(reasons);
        self.returned = BTreeSet::from([WorkIndex::Pilot]);
        if self.state == JobState::Choosing {
            self.state = JobState::Running;
        }
    }

    /// The pilot is done. The job may end at once when its seconds are over already.
    pub fn pilot_done(&mut self, plan: Plan) {
        self.limit = plan.shard_count();
        self.plan = Some(plan);
        if self.seconds_are_over {
            self.cut_short();
        }
    }

    /// Shards were merged.
    pub fn merged(&mut self, totals: MergedTotals, now: Duration) {
        if let Some(measured) = totals.error.filter(|_| totals.error != self.totals.error) {
            self.history.push(ErrorPoint { seconds: self.seconds(now), measured });
        }
        self.arrived = self.arrived.split_off(&totals.shards);
        if totals.good_enough {
            self.limit = self.limit.min(totals.shards);
        }
        self.totals = totals;
    }

    /// Whether the stop rule's seconds ran out just now.
    pub fn seconds_run_out(&self, now: Duration) -> bool {
        let over = self.terms.stop.seconds.is_some_and(|seconds| self.seconds(now) >= seconds);
        over && !self.seconds_are_over && !self.has_ended()
    }

    /// Ends the job with what has arrived without a gap, or with the first shards when nothing has.
    pub fn stop_by_seconds(&mut self) {
        self.seconds_are_over = true;
        if self.plan.is_none() {
            self.terms.notices.push("The time was over before the first pass; waiting for one.".to_owned());
            return;
        }
        if self.cut_short() {
            self.terms.notices.push("The time was over before the first pass was merged; waiting for it.".to_owned());
        }
    }

    /// The shard index at which the job ends; work from there on is of no use.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// Moves the end as near as possible; answers whether even that has not arrived yet.
    fn cut_short(&mut self) -> bool {
        let covered = self.plan.as_ref().map_or(0, Plan::shards_until_covered);
        let mut arrived = self.totals.shards;
        while self.arrived.contains(&arrived) {
            arrived += 1;
        }
        let end = arrived.max(covered);
        self.limit = self.limit.min(self.plan.as_ref().map_or(end, |plan| plan.end_without_gap(end)));
        let limit = self.limit;
        self.returned.retain(|index| !matches!(index, WorkIndex::Shard(shard) if *shard >= limit));
        arrived < covered
    }

    /// Records a worker's error message; ends the job when the same work failed too often.
    pub fn fail_work(&mut self, index: WorkIndex, worker: WorkerId, problem: &str, now: Duration) {
        let failures = self.failures.entry(index).or_default();
        failures.push(worker);
        if failures.len() >= FAILURES_PER_WORK {
            self.error = Some(problem.to_owned());
            self.end(JobState::Failed, now);
        }
    }

    /// Records that `worker` fell silent while it traced some work; answers whether that happened too often.
    pub fn lose_worker(&mut self, index: WorkIndex, worker: WorkerId) -> bool {
        let losses = self.losses.entry(index).or_default();
        losses.insert(worker);
        losses.len() >= LOSSES_PER_WORK
    }

    /// A worker that was thought lost is back.
    pub fn found_worker(&mut self, worker: WorkerId) {
        self.losses.retain(|_, lost| {
            lost.remove(&worker);
            !lost.is_empty()
        });
    }

    /// Stops issuing work.
    pub fn pause(&mut self, reason: PauseReason, now: Duration) {
        self.ran.stop(now);
        (self.state, self.pause) = (JobState::Paused, Some(reason));
    }

    /// Issues work again.
    pub fn resume(&mut self) {
        (self.state, self.pause) = (JobState::Queued, None);
        self.losses.clear();
        // The time in which it paused is not part of its rate.
        self.rate_from = None;
    }

    /// Ends the job in `state`.
    pub fn end(&mut self, state: JobState, now: Duration) {
        self.ran.stop(now);
        (self.state, self.pause) = (state, None);
        self.returned.clear();
        self.arrived.clear();
    }

    /// For how long it has been running: since the first lease, without pauses.
    pub fn ran(&self, now: Duration) -> Duration {
        self.ran.total(now)
    }

    /// [`Job::ran`] in seconds.
    pub fn seconds(&self, now: Duration) -> f64 {
        self.ran(now).as_secs_f64()
    }
}
