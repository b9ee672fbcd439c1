//! What becomes of results, of heartbeats, and of promises that are not kept.

use std::collections::BTreeMap;
use std::time::Duration;

use super::check::{Digest, GivenUp, Verdict};
use super::job::Job;
use super::lease::{Closed, Errand, Lease, Work, WorkIndex};
use super::roster::LastError;
use super::terms::PauseReason;
use super::{Answer, Notice, Outcome, Rollback, Rules, SILENT_LEASES};
use crate::farm::ids::{Fencing, JobId, LeaseId, WorkerId};
use crate::farm::job::JobState;

/// Nobody waits longer for a check than this many lease durations.
const CHECK_LEASES: u32 = 10;
/// Workers that may fail at an errand before it is given up.
const FAILURES_PER_ERRAND: usize = 3;

impl Rules {
    /// A worker delivers.
    pub(super) fn result(
        &mut self,
        now: Duration,
        worker: WorkerId,
        id: LeaseId,
        fencing: Fencing,
        outcome: &Outcome,
    ) -> Answer {
        self.record_contact(now, worker);
        let lease = match self.leases.get(id) {
            Some(lease) if lease.worker == worker && lease.fencing == fencing => *lease,
            Some(_) => return Answer::Fenced,
            None => {
                return match self.leases.closed(id) {
                    Some(Closed::Delivered | Closed::Superseded) => Answer::AlreadyMerged,
                    Some(Closed::Fenced | Closed::JobEnded) | None => Answer::Fenced,
                };
            }
        };
        match outcome {
            Outcome::Accepted(digest) => self.take(now, lease, *digest),
            Outcome::Refused(problem) | Outcome::Failed(problem) => {
                self.record_failure(now, lease, problem, matches!(outcome, Outcome::Failed(_)))
            }
        }
    }

    fn take(&mut self, now: Duration, lease: Lease, digest: Option<Digest>) -> Answer {
        self.leases.close(lease.id, Closed::Delivered);
        let others: Vec<LeaseId> = self.leases.of_work(lease.job, lease.work.index()).map(|other| other.id).collect();
        for other in others {
            self.leases.close(other, Closed::Superseded);
        }
        if let Some(worker) = self.roster.get_mut(lease.worker) {
            worker.succeeded(lease.job);
        }
        self.pending.changed.insert(lease.job);
        match (lease.work, digest) {
            (Work::Errand(errand), _) => drop(self.errands.remove(&(lease.job, errand))),
            (Work::Check(shard, _), Some(digest)) => return self.compare(now, &lease, shard, digest),
            (Work::Check(..), None) => return Answer::Compared,
            (work, digest) => {
                let name = self.roster.name(lease.worker);
                let Some(job) = self.jobs.get_mut(&lease.job) else { return Answer::Fenced };
                job.arrive(&work, name.clone(), now.saturating_sub(lease.issued));
                if let (Work::Shard(shard, _), Some(digest)) = (work, digest) {
                    job.checks.begin(now, shard, name, digest);
                    self.pending.work_appeared = true;
                }
            }
        }
        Answer::Take(lease)
    }

    /// A second worker, or a further one, traced a shard that was merged before.
    fn compare(&mut self, now: Duration, lease: &Lease, shard: u64, digest: Digest) -> Answer {
        let name = self.roster.name(lease.worker);
        let Some(job) = self.jobs.get_mut(&lease.job) else { return Answer::Compared };
        match job.checks.compare(now, shard, name, digest) {
            None | Some(Verdict::Verified) => {}
            Some(Verdict::Undecided) => {
                self.pending.notices.push(Notice::Mismatch { job: lease.job, shard });
            }
            Some(Verdict::Odd(workers)) => {
                workers.into_iter().for_each(|name| self.distrust(now, &name, lease.job, shard))
            }
            Some(Verdict::Hopeless) => {
                let problem = format!("no two workers agree on shard {shard}: their builds or machines differ");
                self.end(now, lease.job, JobState::Failed, Some(problem));
            }
        }
        // Shards may have waited for it, or the job's end.
        self.pending.work_appeared = true;
        self.end_if_complete(now, lease.job);
        Answer::Compared
    }

    /// A worker returned wrong bits: it gets no work for long, and what it contributed to any job is done again.
    fn distrust(&mut self, now: Duration, name: &str, job: JobId, shard: u64) {
        let reason = format!("its shard {shard} of job {job} has other bits than two other workers'");
        let odd = self.roster.distrust(now, name, &reason);
        let pause = super::roster::WRONG_BITS_PAUSE;
        self.pending.notices.push(Notice::SetAside { name: name.to_owned(), job: None, pause, reason });
        odd.into_iter().for_each(|worker| self.fence_all_of(worker));
        let contributed: Vec<Rollback> = self
            .jobs
            .iter()
            .filter(|(_, job)| !job.has_ended())
            .filter_map(|(id, job)| {
                let keep = match job.first_contribution(name)? {
                    WorkIndex::Shard(first) => Some(first),
                    _ => None,
                };
                Some(Rollback { job: *id, keep })
            })
            .collect();
        for rollback in contributed {
            self.close_all(rollback.job, Closed::Fenced);
            if let Some(job) = self.jobs.get_mut(&rollback.job) {
                job.is_rolling_back = true;
            }
            self.pending.rollbacks.push(rollback);
        }
    }

    fn record_failure(&mut self, now: Duration, lease: Lease, problem: &str, is_own_word: bool) -> Answer {
        let (name, work) = (self.roster.name(lease.worker), lease.work.index());
        if let Some(worker) = self.roster.get_mut(lease.worker) {
            worker.last_error = Some(LastError { job: lease.job, work, problem: problem.to_owned(), at: now });
            // A worker's own error message may well be the scene's fault; a result that does not fit is the worker's.
            let (pause, job) = if is_own_word {
                (worker.failed(lease.job, now, problem), Some(lease.job))
            } else {
                (worker.refused(now, problem), None)
            };
            if let Some(pause) = pause {
                let (name, reason) = (name.clone(), problem.to_owned());
                self.pending.notices.push(Notice::SetAside { name, job, pause, reason });
            }
        }
        self.pending.notices.push(Notice::BadResult { name, job: lease.job, work, problem: problem.to_owned() });
        if let WorkIndex::Errand(errand) = work {
            self.fail_errand(lease.job, errand);
        } else if let Some(job) = self.jobs.get_mut(&lease.job).filter(|job| is_own_word && !job.has_ended()) {
            job.fail_work(work, lease.worker, problem, now);
        }
        self.fence(lease.id);
        self.record_end(lease.job);
        Answer::Recorded
    }

    fn fail_errand(&mut self, job: JobId, errand: Errand) {
        let Some(wanted) = self.errands.get_mut(&(job, errand)) else { return };
        wanted.failures += 1;
        if wanted.failures >= FAILURES_PER_ERRAND {
            self.errands.remove(&(job, errand));
        }
    }

    /// Whether somebody still waits for, or works on, what the job's scene shows first.
    pub fn has_errand(&self, job: JobId, errand: Errand) -> bool {
        self.errands.contains_key(&(job, errand))
    }

    pub(super) fn keep_alive(&mut self, now: Duration, worker: WorkerId, leases: &[LeaseId]) -> Answer {
        if !self.record_contact(now, worker) {
            return Answer::UnknownWorker;
        }
        let is_own = |rules: &Self, id| rules.leases.get(id).is_some_and(|lease| lease.worker == worker);
        let (kept, cancelled): (Vec<LeaseId>, Vec<LeaseId>) = leases.iter().partition(|id| is_own(self, **id));
        for id in kept {
            self.leases.extend(id, now + self.options.lease_duration);
        }
        Answer::Alive { cancelled }
    }

    pub(super) fn release(&mut self, now: Duration, worker: WorkerId, leases: &[LeaseId]) -> Answer {
        self.record_contact(now, worker);
        for id in leases {
            if self.leases.get(*id).is_some_and(|lease| lease.worker == worker) {
                self.fence(*id);
            }
        }
        Answer::Done
    }

    /// Leases expire, seconds run out, silent workers are forgotten.
    pub(super) fn pass_time(&mut self, now: Duration) -> Answer {
        self.expire(now);
        let over: Vec<JobId> =
            self.jobs.iter().filter(|(_, job)| job.seconds_run_out(now)).map(|(id, _)| *id).collect();
        for id in over {
            self.with_job(id, |_, job| job.stop_by_seconds());
            self.end_if_complete(now, id);
        }
        for worker in self.roster.silent(now, self.options.lease_duration * SILENT_LEASES) {
            self.fence_all_of(worker);
            if let Some(record) = self.roster.remove(now, worker) {
                self.pending.notices.push(Notice::Forgotten { worker, name: record.name });
            }
        }
        self.look_for_workers(now);
        self.give_up_checks(now);
        Answer::Done
    }

    /// Checks that nobody can do hold nothing up.
    fn give_up_checks(&mut self, now: Duration) {
        let waits = |job: &Job| job.checks.oldest().is_some() && job.takes_workers();
        let waiting: Vec<JobId> = self.jobs.iter().filter(|(_, job)| waits(job)).map(|(id, _)| *id).collect();
        for id in waiting {
            let workers = self.roster.takers(id, now, self.options.lease_duration);
            let Some(job) = self.jobs.get_mut(&id) else { continue };
            let given_up = job.checks.give_up(now, self.options.lease_duration * CHECK_LEASES, &workers);
            self.pending.work_appeared |= !given_up.is_empty();
            for GivenUp { shard, .. } in given_up.into_iter().filter(|check| check.is_disputed) {
                self.pending.notices.push(Notice::Disputed { job: id, shard });
            }
            self.end_if_complete(now, id);
        }
    }

    fn expire(&mut self, now: Duration) {
        let expired: Vec<Lease> = self.leases.active().filter(|lease| lease.deadline <= now).copied().collect();
        let silent = self.roster.silent(now, self.options.lease_duration);
        let mut counts: BTreeMap<WorkerId, usize> = BTreeMap::new();
        for lease in expired {
            *counts.entry(lease.worker).or_default() += 1;
            let was_traced = self.leases.of_worker(lease.worker).next().is_some_and(|oldest| oldest.id == lease.id);
            // Only what it was tracing can have ended a worker, not what it had prefetched.
            if was_traced && counts[&lease.worker] == 1 && silent.contains(&lease.worker) {
                self.lose(now, &lease);
            }
            self.fence(lease.id);
        }
        for worker in silent {
            let Some(record) = self.roster.get_mut(worker).filter(|record| !record.is_silent) else { continue };
            record.is_silent = true;
            let (name, leases) = (record.name.clone(), counts.get(&worker).copied().unwrap_or(0));
            self.pending.notices.push(Notice::Silent { worker, name, leases });
        }
    }

    /// A worker fell silent over some work. Work that costs too many workers is issued to nobody until its user says so.
    fn lose(&mut self, now: Duration, lease: &Lease) {
        let index = lease.work.index();
        if let WorkIndex::Errand(errand) = index {
            return self.fail_errand(lease.job, errand);
        }
        let Some(job) = self.jobs.get_mut(&lease.job).filter(|job| !job.has_ended()) else { return };
        if job.lose_worker(index, lease.worker) && job.state != JobState::Paused {
            self.pause(now, lease.job, PauseReason::WorkersLost { work: index.to_string() });
        }
    }

    /// Ends a lease whose work goes to someone else, unless a second lease of the same work lives.
    pub(super) fn fence(&mut self, id: LeaseId) {
        let Some(lease) = self.leases.close(id, Closed::Fenced) else { return };
        let is_held = self.leases.of_work(lease.job, lease.work.index()).next().is_some();
        if let Some(job) = self.jobs.get_mut(&lease.job).filter(|_| !is_held) {
            job.give_back(lease.work.index());
        }
        self.pending.changed.insert(lease.job);
        self.pending.work_appeared = true;
    }

    /// The same for all that a worker holds.
    pub(super) fn fence_all_of(&mut self, worker: WorkerId) {
        let held: Vec<LeaseId> = self.leases.of_worker(worker).map(|lease| lease.id).collect();
        held.into_iter().for_each(|id| self.fence(id));
    }

    /// Ends leases of no use any more, after a job has changed its end or ended.
    pub(super) fn close_useless(&mut self, id: JobId) {
        let Some(job) = self.jobs.get(&id) else { return };
        let (ended, limit, has_plan) = (job.has_ended(), job.limit(), job.plan.is_some());
        self.close(id, Closed::JobEnded, |work| match work {
            WorkIndex::Shard(index) => ended || (has_plan && index >= limit),
            WorkIndex::Errand(_) => false,
            WorkIndex::Choice | WorkIndex::Pilot | WorkIndex::Check(_) => ended,
        });
    }

    /// Ends all leases of a job but errands.
    pub(super) fn close_all(&mut self, id: JobId, reason: Closed) {
        self.close(id, reason, |work| !matches!(work, WorkIndex::Errand(_)));
    }

    /// Ends the leases of a job whose work `is_over`; nobody else gets it.
    pub(super) fn close(&mut self, id: JobId, reason: Closed, is_over: impl Fn(WorkIndex) -> bool) {
        let over = self.leases.of_job(id).filter(|lease| is_over(lease.work.index()));
        let over: Vec<LeaseId> = over.map(|lease| lease.id).collect();
        for lease in over {
            self.leases.close(lease, reason);
        }
    }
}
