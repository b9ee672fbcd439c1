//! Who traces what: a pure state machine. An [`Event`] and the time go in, [`Effects`] come out; nothing here waits, locks, or
//! knows clocks, threads and the network. So thousands of fault schedules run in a test in seconds.
//!
//! | file | what it decides |
//! |---|---|
//! | [`event`] | what can happen, and what can follow |
//! | [`plan`] | how a job is cut into shards |
//! | [`terms`], [`job`], `running_time`, `time_left` | what was agreed; what of one job is to be issued, has arrived, is merged |
//! | `granting` | which job's work a worker gets: fair shares, memory, stragglers |
//! | `results` | what becomes of results and of broken promises |
//! | [`check`] | which shards two workers trace, and whom to believe |
//! | [`lease`], [`roster`] | promises, and those who make them |

pub mod check;
pub(crate) mod event;
mod granting;
pub(crate) mod job;
pub mod lease;
pub mod plan;
mod results;
pub(crate) mod roster;
mod running_time;
pub mod terms;
mod time_left;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use check::CheckShare;
pub use event::{Answer, Effects, Event, Notice, Outcome, Rollback};
use job::Job;
use lease::{Closed, Errand, Lease, LeaseTable, WorkIndex};
use roster::Roster;
use terms::{MergedTotals, PauseReason};

use crate::farm::ids::{JobId, WorkerId};
use crate::farm::job::JobState;

/// A worker is forgotten after being silent for this many lease durations.
const SILENT_LEASES: u32 = 4;
/// A share of a lease duration without an event means that the coordinator itself was stopped.
const STALL_SHARE: u32 = 3;

/// For how long no worker may be there before jobs say so: those of a farm that starts are on their way.
const PATIENCE: Duration = Duration::from_secs(2);

/// Limits of the rules.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RulesOptions {
    /// How long a lease lives without a heartbeat.
    pub lease_duration: Duration,
    /// Bytes that all running jobs' states may take together.
    pub memory_budget: u64,
    /// Bytes of tallies that came before their turn, above which no job's shards are issued farther ahead.
    pub early_budget: u64,
    /// The share of shards that two workers trace.
    pub check_share: CheckShare,
    /// The first number of workers and leases, so that those of an earlier coordinator are not mistaken for this one's.
    pub first_id: u64,
}

/// An errand that somebody waits for.
#[derive(Clone, Copy, Debug, Default)]
struct WantedErrand {
    failures: usize,
}

/// The state machine.
#[derive(Debug)]
pub struct Rules {
    options: RulesOptions,
    jobs: BTreeMap<JobId, Job>,
    errands: BTreeMap<(JobId, Errand), WantedErrand>,
    roster: Roster,
    leases: LeaseTable,
    /// What the job that was served last had been served before, see [`Job::served`].
    served: u64,
    last_event: Duration,
    deserted_since: Option<Duration>,
    lacks_workers: bool,
    is_draining: bool,
    pending: Pending,
}

/// Effects that gather while an event is applied.
#[derive(Debug, Default)]
struct Pending {
    changed: BTreeSet<JobId>,
    ended: Vec<JobId>,
    rollbacks: Vec<Rollback>,
    notices: Vec<Notice>,
    work_appeared: bool,
}

impl Rules {
    /// Rules for a farm without jobs and workers.
    pub fn new(options: RulesOptions) -> Self {
        Self {
            options,
            jobs: BTreeMap::new(),
            errands: BTreeMap::new(),
            roster: Roster::new(options.first_id),
            leases: LeaseTable::new(options.first_id),
            served: 0,
            last_event: Duration::ZERO,
            deserted_since: None,
            lacks_workers: false,
            is_draining: false,
            pending: Pending::default(),
        }
    }

    /// Lets `event` happen at `now`, the time since start.
    pub fn apply(&mut self, now: Duration, event: Event) -> Effects {
        self.forgive_stall(now);
        let answer = self.answer(now, event);
        let Pending { changed, ended, rollbacks, notices, work_appeared } = std::mem::take(&mut self.pending);
        Effects { answer, changed, ended, rollbacks, notices, work_appeared }
    }

    fn answer(&mut self, now: Duration, event: Event) -> Answer {
        match event {
            Event::JobAdded { job, terms } => self.insert(job, Job::new(terms)),
            Event::JobRestored { job, terms, restored } => self.insert(job, Job::restored(terms, *restored)),
            Event::MethodChosen { job, terms, reasons } => self.with_job(job, |rules, job| {
                job.method_chosen(terms, reasons);
                rules.work_appeared = true;
            }),
            Event::PilotDone { job, plan } => self.with_job(job, |rules, job| {
                granting::charge_pilot(job, &plan);
                job.pilot_done(plan);
                rules.work_appeared = true;
            }),
            Event::Merged { job, totals } => self.merged(now, job, totals),
            Event::JobFailed { job, problem } => self.end(now, job, JobState::Failed, Some(problem)),
            Event::JobCancelled { job } => self.end(now, job, JobState::Cancelled, None),
            Event::JobPaused { job, reason } => self.pause(now, job, reason),
            Event::JobResumed { job } => self.resume(now, job),
            Event::PriorityChanged { job, priority } => self.with_job(job, |_, job| job.terms.priority = priority),
            Event::JobForgotten { job } => self.forget(job),
            Event::JobErased { job } => self.erase(job),
            Event::ErrandWanted { job, errand } => {
                self.errands.entry((job, errand)).or_default();
                self.pending.work_appeared = true;
                Answer::Done
            }
            Event::WorkerJoined { name, threads } => self.join(now, name, threads),
            Event::LeaseWanted { worker } => self.grant(now, worker),
            Event::HeartbeatCame { worker, leases } => self.keep_alive(now, worker, &leases),
            Event::LeasesReleased { worker, leases } => self.release(now, worker, &leases),
            Event::WorkerDrained { worker } => self.drain(now, worker),
            Event::WorkerLeft { worker } => self.leave(now, worker),
            Event::ResultCame { worker, lease, fencing, outcome } => self.result(now, worker, lease, fencing, &outcome),
            Event::TimePassed => self.pass_time(now),
            Event::DrainBegan => {
                self.is_draining = true;
                self.pending.work_appeared = true;
                Answer::Done
            }
        }
    }

    /// How a job is doing, until it is forgotten.
    pub fn job(&self, id: JobId) -> Option<&Job> {
        self.jobs.get(&id)
    }

    /// All jobs that are not forgotten.
    pub fn jobs(&self) -> impl Iterator<Item = (JobId, &Job)> {
        self.jobs.iter().map(|(id, job)| (*id, job))
    }

    /// Pieces of work that workers could be given now, checks left aside.
    pub fn work_waiting(&self) -> u64 {
        self.jobs.values().filter(|job| job.takes_workers()).map(Job::waiting).sum::<u64>() + self.errands.len() as u64
    }

    /// The workers.
    pub fn roster(&self) -> &Roster {
        &self.roster
    }

    /// The leases.
    pub fn leases(&self) -> &LeaseTable {
        &self.leases
    }

    /// Since when no worker is there that could take work.
    pub fn deserted_since(&self) -> Option<Duration> {
        self.deserted_since
    }

    /// Whether no worker is there for so long that jobs say so.
    pub fn lacks_workers(&self) -> bool {
        self.lacks_workers
    }

    /// Whether the outcome of a lease must come with a digest.
    pub fn wants_digest(&self, lease: &Lease) -> bool {
        match lease.work.index() {
            WorkIndex::Check(_) => true,
            WorkIndex::Shard(index) => self.roster.count() > 1 && self.options.check_share.takes(lease.job, index),
            _ => false,
        }
    }

    /// Changes a job that has not ended.
    fn with_job(&mut self, id: JobId, change: impl FnOnce(&mut Pending, &mut Job)) -> Answer {
        let Some(job) = self.jobs.get_mut(&id) else { return Answer::UnknownJob };
        if job.has_ended() {
            return Answer::NotPossible(job.state);
        }
        change(&mut self.pending, job);
        self.pending.changed.insert(id);
        self.close_useless(id);
        Answer::Done
    }

    fn insert(&mut self, id: JobId, mut job: Job) -> Answer {
        // What was leased of an earlier state of the job does not fit this one.
        self.close_all(id, Closed::Fenced);
        job.served = self.served;
        if let Some(before) = self.jobs.get(&id) {
            job.remember(before);
        }
        self.jobs.insert(id, job);
        self.pending.changed.insert(id);
        self.pending.work_appeared = true;
        Answer::Done
    }

    fn merged(&mut self, now: Duration, id: JobId, totals: MergedTotals) -> Answer {
        let answer = self.with_job(id, |pending, job| {
            let had_work = job.has_work();
            job.merged(totals, now);
            pending.work_appeared |= !had_work && job.has_work();
        });
        self.end_if_complete(now, id);
        answer
    }

    fn end(&mut self, now: Duration, id: JobId, state: JobState, problem: Option<String>) -> Answer {
        let answer = self.with_job(id, |_, job| {
            job.error = problem;
            job.end(state, now);
        });
        if answer == Answer::Done {
            self.record_end(id);
        }
        answer
    }

    /// A job is done when all its shards are merged and no check is left to do.
    fn end_if_complete(&mut self, now: Duration, id: JobId) {
        let is_done = |job: &Job| job.is_complete() && job.checks.oldest().is_none() && !job.is_rolling_back;
        if self.jobs.get(&id).is_some_and(|job| !job.has_ended() && is_done(job)) {
            self.end(now, id, JobState::Done, None);
        }
    }

    /// After an event by which a job may have ended.
    fn record_end(&mut self, id: JobId) {
        let Some(job) = self.jobs.get(&id).filter(|job| job.has_ended()) else { return };
        if !self.pending.ended.contains(&id) {
            let (state, reason) = (job.state, job.error.clone());
            self.pending.ended.push(id);
            self.pending.notices.push(Notice::State { job: id, state, reason });
            // Its memory may be what another job waits for.
            self.pending.work_appeared = true;
            self.close_useless(id);
        }
    }

    fn pause(&mut self, now: Duration, id: JobId, reason: PauseReason) -> Answer {
        match self.jobs.get(&id).map(|job| job.state) {
            Some(JobState::Paused) => Answer::NotPossible(JobState::Paused),
            _ => self.with_job(id, |pending, job| {
                let text = Some(reason.to_string());
                job.pause(reason, now);
                pending.notices.push(Notice::State { job: id, state: JobState::Paused, reason: text });
            }),
        }
    }

    fn resume(&mut self, now: Duration, id: JobId) -> Answer {
        match self.jobs.get(&id).map(|job| job.state) {
            None => Answer::UnknownJob,
            Some(JobState::Paused) => {
                let served = self.served;
                self.with_job(id, |pending, job| {
                    job.resume();
                    job.checks.wait_anew(now);
                    job.served = job.served.max(served);
                    pending.work_appeared = true;
                    pending.notices.push(Notice::State { job: id, state: job.state, reason: Some("resumed".into()) });
                })
            }
            Some(state) => Answer::NotPossible(state),
        }
    }

    fn forget(&mut self, id: JobId) -> Answer {
        self.close_all(id, Closed::JobEnded);
        self.roster.forget_job(id);
        self.pending.work_appeared = true;
        if self.jobs.remove(&id).is_some() { Answer::Done } else { Answer::UnknownJob }
    }

    fn erase(&mut self, id: JobId) -> Answer {
        self.errands.retain(|(job, _), _| *job != id);
        self.close(id, Closed::JobEnded, |work| matches!(work, WorkIndex::Errand(_)));
        self.forget(id)
    }

    fn join(&mut self, now: Duration, name: String, threads: u32) -> Answer {
        let worker = self.roster.join(now, &name, threads);
        self.pending.notices.push(Notice::Joined { worker, name, threads });
        self.look_for_workers(now);
        Answer::Joined(worker)
    }

    fn leave(&mut self, now: Duration, worker: WorkerId) -> Answer {
        self.fence_all_of(worker);
        let Some(record) = self.roster.remove(now, worker) else { return Answer::UnknownWorker };
        self.pending.notices.push(Notice::Left { worker, name: record.name });
        self.look_for_workers(now);
        Answer::Done
    }

    fn drain(&mut self, now: Duration, worker: WorkerId) -> Answer {
        let Some(record) = self.roster.get_mut(worker) else { return Answer::UnknownWorker };
        record.is_draining = true;
        // It may wait for work, and hears now that there will be none.
        self.pending.work_appeared = true;
        self.look_for_workers(now);
        Answer::Done
    }

    /// Notices when the last worker is gone or the first one comes, and when that is worth telling.
    fn look_for_workers(&mut self, now: Duration) {
        let is_deserted = self.roster.is_deserted(now, self.options.lease_duration);
        if is_deserted != self.deserted_since.is_some() {
            self.deserted_since = is_deserted.then_some(now);
            self.pending.changed.extend(self.jobs.keys());
        }
        let lacks_workers = self.deserted_since.is_some_and(|since| now.saturating_sub(since) >= PATIENCE);
        if lacks_workers != self.lacks_workers {
            self.lacks_workers = lacks_workers;
            self.pending.changed.extend(self.jobs.keys());
        }
    }

    /// When nothing happened for long, not even time, the coordinator was stopped, and heartbeats could not arrive: deadlines move
    /// by that time, so that one stop does not end all leases at once.
    fn forgive_stall(&mut self, now: Duration) {
        let stalled = now.saturating_sub(self.last_event);
        if stalled >= self.options.lease_duration / STALL_SHARE && self.last_event > Duration::ZERO {
            self.leases.postpone(stalled);
            self.roster.postpone(stalled);
            self.jobs.values_mut().for_each(|job| job.checks.wait_anew(now));
        }
        self.last_event = self.last_event.max(now);
    }
}
