//! One job's progress: what is still to be issued, what has arrived, what is merged.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::lease::{Work, WorkIndex};
use super::plan::Plan;
use crate::estimate::ErrorEstimate;
use crate::farm::job::{JobState, StopRule};

/// Leases of the same work that may end with a worker's error message before the job fails.
const FAILURES_PER_WORK: usize = 3;

/// The error of a picture, and when it was estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredError {
    /// Passes merged then.
    pub passes: u32,
    /// What they tell.
    pub error: ErrorEstimate,
}

/// A job's error at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorAtTime {
    /// Wall-clock seconds since the first lease.
    pub seconds: f64,
    /// The error, and the passes merged then.
    pub measured: MeasuredError,
}

/// What the merged shards add up to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MergedTotals {
    /// Shards merged.
    pub shards: u64,
    /// Passes merged in every region.
    pub passes: u32,
    /// Photons emitted in them.
    pub photons_emitted: u64,
    /// Contributions dropped because they were not finite.
    pub non_finite: u64,
    /// The last estimate of the error.
    pub error: Option<MeasuredError>,
    /// The error is as small as the stop rule asks for: nothing more will be merged.
    pub good_enough: bool,
}

/// How far a job has come.
#[derive(Clone, Debug)]
pub struct JobProgress {
    /// What it is doing.
    pub state: JobState,
    /// Why it failed.
    pub error: Option<String>,
    /// Things the user should know, one sentence each.
    pub notices: Vec<String>,
    /// When to stop.
    pub stop: StopRule,
    /// The cut; known after the pilot.
    pub plan: Option<Plan>,
    /// What is merged.
    pub totals: MergedTotals,
    /// The error as it was estimated from time to time.
    pub history: Vec<ErrorAtTime>,
    /// When the first lease was given.
    pub first_lease: Option<Duration>,
    /// When the pilot was done.
    pub tracing_since: Option<Duration>,
    /// When it ended.
    pub ended: Option<Duration>,
    /// Shards at which it ends; known after the pilot.
    limit: u64,
    next_index: u64,
    returned: BTreeSet<WorkIndex>,
    arrived: BTreeSet<u64>,
    fencing: BTreeMap<WorkIndex, u64>,
    failures: BTreeMap<WorkIndex, Vec<u64>>,
    seconds_are_over: bool,
    seconds_per_pass: Option<f64>,
}

impl JobProgress {
    /// A job that waits for its pilot.
    pub fn new(stop: StopRule, notices: Vec<String>) -> Self {
        Self {
            state: JobState::Queued,
            error: None,
            notices,
            stop,
            plan: None,
            totals: MergedTotals::default(),
            history: Vec::new(),
            first_lease: None,
            tracing_since: None,
            ended: None,
            limit: 0,
            next_index: 0,
            returned: BTreeSet::from([None]),
            arrived: BTreeSet::new(),
            fencing: BTreeMap::new(),
            failures: BTreeMap::new(),
            seconds_are_over: false,
            seconds_per_pass: None,
        }
    }

    /// Whether nothing will change any more.
    pub fn has_ended(&self) -> bool {
        matches!(self.state, JobState::Done | JobState::Failed | JobState::Cancelled)
    }

    /// The next work to issue: what came back first, then what was never issued and is allowed now. Work that `worker`
    /// failed at is left to others if there are any (`others`).
    pub fn next_work(&self, worker: u64, others: bool) -> Option<Work> {
        let failed_here = |index: &WorkIndex| self.failures.get(index).is_some_and(|by| by.contains(&worker));
        if let Some(index) = self.returned.iter().find(|index| !(others && failed_here(index))) {
            return self.work(*index);
        }
        let plan = self.plan.as_ref()?;
        let allowed = self.next_index < self.limit && self.totals.shards >= plan.merged_before(self.next_index);
        if allowed { self.work(Some(self.next_index)) } else { None }
    }

    fn work(&self, index: WorkIndex) -> Option<Work> {
        match index {
            None => Some(Work::Pilot),
            Some(index) => Some(Work::Shard(index, self.plan.as_ref()?.shard(index)?)),
        }
    }

    /// Shards that were never issued; `u64::MAX` before the pilot is done.
    pub fn unissued(&self) -> u64 {
        if self.plan.is_some() { self.limit.saturating_sub(self.next_index) } else { u64::MAX }
    }

    /// Notes that work is leased at `now`; answers its fencing number.
    pub fn issue(&mut self, work: &Work, now: Duration) -> u64 {
        let index = work.index();
        if !self.returned.remove(&index) && index == Some(self.next_index) {
            self.next_index += 1;
        }
        if self.first_lease.is_none() {
            self.first_lease = Some(now);
            self.state = JobState::Running;
        }
        let fencing = self.fencing.entry(index).or_insert(0);
        *fencing += 1;
        *fencing
    }

    /// Puts work back that nobody holds any more.
    pub fn give_back(&mut self, index: WorkIndex) {
        let is_needed = match index {
            None => self.plan.is_none(),
            Some(index) => index >= self.totals.shards && index < self.limit && !self.arrived.contains(&index),
        };
        if is_needed && !self.has_ended() {
            self.returned.insert(index);
        }
    }

    /// Notes that a result was taken which was leased `took` ago.
    pub fn arrive(&mut self, work: &Work, took: Duration) {
        self.returned.remove(&work.index());
        self.fencing.remove(&work.index());
        self.failures.remove(&work.index());
        if let Some(index) = work.index() {
            self.arrived.insert(index);
            let seconds = took.as_secs_f64() / f64::from(work.passes());
            let mean = self.seconds_per_pass.map_or(seconds, |mean| mean + 0.1 * (seconds - mean));
            self.seconds_per_pass = Some(mean);
        }
    }

    /// How long work of this size usually takes from lease to result; `None` while nothing is known.
    pub fn typical_duration(&self, work: &Work) -> Option<Duration> {
        let seconds = self.seconds_per_pass? * f64::from(work.passes());
        matches!(work, Work::Shard(..)).then(|| Duration::try_from_secs_f64(seconds).ok()).flatten()
    }

    /// The pilot is done. The job may end at once when its seconds are over already.
    pub fn pilot_done(&mut self, plan: Plan, now: Duration) {
        self.limit = plan.shard_count();
        self.plan = Some(plan);
        self.tracing_since = Some(now);
        if self.seconds_are_over {
            self.cut_short();
        }
    }

    /// Shards were merged.
    pub fn merged(&mut self, totals: MergedTotals, now: Duration) {
        if let Some(measured) = totals.error.filter(|_| totals.error != self.totals.error) {
            self.history.push(ErrorAtTime { seconds: self.seconds(now), measured });
        }
        self.totals = totals;
        self.arrived = self.arrived.split_off(&totals.shards);
        if totals.good_enough {
            self.limit = self.limit.min(totals.shards);
        }
        if self.plan.is_some() && totals.shards >= self.limit && !self.has_ended() {
            self.end(JobState::Done, now);
        }
    }

    /// Whether the stop rule's seconds ran out just now.
    pub fn seconds_run_out(&self, now: Duration) -> bool {
        let elapsed = self.first_lease.map_or(0.0, |first| now.saturating_sub(first).as_secs_f64());
        let over = self.stop.seconds.is_some_and(|seconds| elapsed >= seconds);
        over && !self.seconds_are_over && !self.has_ended()
    }

    /// Ends the job with what has arrived without a gap, or with the first shards when nothing has.
    pub fn stop_by_seconds(&mut self, now: Duration) {
        self.seconds_are_over = true;
        if self.plan.is_none() {
            self.notices.push("The time was over before the first pass; waiting for one.".to_owned());
            return;
        }
        if self.cut_short() {
            self.notices.push("The time was over before the first pass was merged; waiting for it.".to_owned());
        }
        self.merged(self.totals, now);
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
        self.returned.retain(|index| index.is_none_or(|index| index < limit));
        arrived < covered
    }

    /// Notes a worker's error message; ends the job when the same work failed too often.
    pub fn fail_work(&mut self, index: WorkIndex, worker: u64, problem: &str, now: Duration) {
        let failures = self.failures.entry(index).or_default();
        failures.push(worker);
        if failures.len() >= FAILURES_PER_WORK {
            self.error = Some(problem.to_owned());
            self.end(JobState::Failed, now);
        }
    }

    /// Ends the job in `state`.
    pub fn end(&mut self, state: JobState, now: Duration) {
        self.state = state;
        self.ended = Some(now);
        self.returned.clear();
        self.arrived.clear();
    }

    /// Seconds since the first lease.
    pub fn seconds(&self, now: Duration) -> f64 {
        let end = self.ended.unwrap_or(now);
        self.first_lease.map_or(0.0, |first| end.saturating_sub(first).as_secs_f64())
    }

    /// Estimated seconds left: by passes, by the stop rule's seconds, or the smaller of both.
    pub fn seconds_left(&self, now: Duration) -> Option<f64> {
        if self.has_ended() {
            return None;
        }
        let by_seconds = self.stop.seconds.map(|seconds| (seconds - self.seconds(now)).max(0.0));
        let total = self.plan.as_ref().filter(|_| self.stop.passes.is_some()).map(|plan| plan.passes);
        let tracing = self.tracing_since.map(|since| now.saturating_sub(since).as_secs_f64());
        let by_passes = match (total, tracing) {
            (Some(total), Some(tracing)) if self.totals.passes > 0 => {
                Some(tracing / f64::from(self.totals.passes) * f64::from(total - self.totals.passes.min(total)))
            }
            _ => None,
        };
        match (by_seconds, by_passes) {
            (Some(seconds), Some(passes)) => Some(f64::min(seconds, passes)),
            (left, None) | (None, left) => left,
        }
    }
}
