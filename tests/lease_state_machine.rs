//! The schedule under thousands of fault schedules: whatever workers and the network do, every job ends, every shard is
//! taken exactly once, and merges go strictly in order.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use photonfarm::estimate::RadiusRule;
use photonfarm::farm::job::{JobState, StopRule};
use photonfarm::farm::rules::lease::{Lease, Work};
use photonfarm::farm::rules::plan::Plan;
use photonfarm::farm::rules::progress::MergedTotals;
use photonfarm::farm::rules::schedule::{LeaseAnswer, Outcome, ResultAnswer, Schedule};

const LEASE: Duration = Duration::from_secs(10);

/// SplitMix64: small, seeded, good enough to choose faults.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

fn seconds(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

fn passes(passes: u32) -> StopRule {
    StopRule { passes: Some(passes), seconds: None, error: None }
}

/// What the adapter keeps of a job: the merge order, and a checksum that depends on it.
#[derive(Default)]
struct Merge {
    plan: Option<Plan>,
    waiting: BTreeSet<u64>,
    order: Vec<u64>,
    checksum: u64,
}

impl Merge {
    fn totals(&self) -> MergedTotals {
        let shards = self.order.len() as u64;
        let plan = self.plan.as_ref().expect("a pilot came first");
        let done = plan.shard(shards).map_or(plan.passes, |next| next.shard.first_pass);
        MergedTotals { shards, passes: done, ..MergedTotals::default() }
    }

    fn take(&mut self, index: u64) {
        assert!(self.waiting.insert(index), "shard {index} taken twice");
        assert!(!self.order.contains(&index), "shard {index} merged twice");
        while self.waiting.remove(&(self.order.len() as u64)) {
            let next = self.order.len() as u64;
            self.checksum = self.checksum.wrapping_mul(31).wrapping_add(next + 1);
            self.order.push(next);
        }
    }
}

struct Farm {
    schedule: Schedule,
    now: Duration,
    merges: BTreeMap<u64, Merge>,
    rule: RadiusRule,
}

impl Farm {
    fn new(rule: RadiusRule) -> Self {
        Self { schedule: Schedule::new(LEASE, 1000), now: Duration::ZERO, merges: BTreeMap::new(), rule }
    }

    fn add_job(&mut self, number: u64, stop: StopRule) {
        self.schedule.add_job(number, stop, Vec::new());
        self.merges.insert(number, Merge::default());
    }

    fn pass_time(&mut self, step: f64) {
        self.now += seconds(step);
        self.schedule.tick(self.now);
    }

    fn state(&self, job: u64) -> JobState {
        self.schedule.job(job).expect("a job").state
    }

    fn lease(&mut self, worker: u64) -> Option<Lease> {
        let LeaseAnswer::Granted(lease) = self.schedule.lease(self.now, worker) else { return None };
        if let Work::Shard(index, planned) = lease.work {
            let merge = &self.merges[&lease.job];
            let plan = merge.plan.as_ref().expect("shards come after the pilot");
            assert_eq!(plan.shard(index), Some(planned));
            assert!(merge.order.len() as u64 >= plan.merged_before(index), "its radius field exists");
        }
        Some(lease)
    }

    fn deliver(&mut self, lease: &Lease, outcome: &Outcome) -> ResultAnswer {
        let answer = self.schedule.result(self.now, lease.worker, lease.id, lease.fencing, outcome);
        if let ResultAnswer::Take(taken) = answer {
            assert_eq!(taken.id, lease.id);
            self.merge(&taken);
        }
        answer
    }

    fn merge(&mut self, lease: &Lease) {
        let merge = self.merges.get_mut(&lease.job).expect("a job");
        match lease.work {
            Work::Pilot => {
                assert!(merge.plan.is_none(), "two pilots");
                let stop = self.schedule.job(lease.job).expect("a job").stop;
                let plan = Plan::new(64, 64, 300_000, stop.passes, self.rule);
                merge.plan = Some(plan.clone());
                self.schedule.pilot_done(self.now, lease.job, plan);
            }
            Work::Shard(index, _) => {
                merge.take(index);
                let totals = merge.totals();
                self.schedule.merged(self.now, lease.job, totals);
            }
        }
    }
}

/// A worker of a simulation: what it holds, and what is on its way.
#[derive(Default)]
struct SimulatedWorker {
    id: u64,
    held: Vec<(Lease, Duration)>,
    is_alive: bool,
}

/// One step of one worker under faults.
fn step(farm: &mut Farm, worker: &mut SimulatedWorker, late: &mut Vec<Lease>, random: &mut Random) {
    if !worker.is_alive {
        if random.chance(5) {
            worker.id = farm.schedule.register(farm.now, "reborn", 1);
            worker.is_alive = true;
        }
        return;
    }
    match random.below(100) {
        0 => {
            // It dies with what it holds; the coordinator hears of it or not. What it sent may still arrive.
            if random.chance(50) {
                farm.schedule.worker_gone(worker.id);
            }
            late.extend(worker.held.drain(..).map(|(lease, _)| lease));
            worker.is_alive = false;
        }
        1 => {
            let ids: Vec<u64> = worker.held.drain(..).map(|(lease, _)| lease.id).collect();
            farm.schedule.release(farm.now, worker.id, &ids);
        }
        2..30 => {
            let ids: Vec<u64> = worker.held.iter().map(|(lease, _)| lease.id).collect();
            match farm.schedule.heartbeat(farm.now, worker.id, &ids) {
                None => worker.is_alive = false,
                Some(answer) => worker.held.retain(|(lease, _)| !answer.cancelled.contains(&lease.id)),
            }
        }
        30..60 => {
            if let Some(lease) = farm.lease(worker.id) {
                let ready = farm.now + seconds(0.2 + random.below(30) as f64 / 10.0);
                worker.held.push((lease, ready));
            }
        }
        _ => deliver_ready(farm, worker, late, random),
    }
}

fn deliver_ready(farm: &mut Farm, worker: &mut SimulatedWorker, late: &mut Vec<Lease>, random: &mut Random) {
    let now = farm.now;
    let (ready, rest) = worker.held.drain(..).partition(|(_, ready)| *ready <= now);
    worker.held = rest;
    let ready: Vec<(Lease, Duration)> = ready;
    for (lease, _) in ready {
        match random.below(100) {
            0..5 => drop(farm.deliver(&lease, &Outcome::Refused("pixel 3 is not a number".into()))),
            5..15 => late.push(lease),
            15..25 => {
                farm.deliver(&lease, &Outcome::Accepted);
                late.push(lease);
            }
            _ => drop(farm.deliver(&lease, &Outcome::Accepted)),
        }
    }
}

fn simulate(seed: u64) -> BTreeMap<u64, u64> {
    let mut random = Random(seed);
    let rule = if seed.is_multiple_of(2) { RadiusRule::Statistics } else { RadiusRule::Schedule };
    let mut farm = Farm::new(rule);
    farm.add_job(1, passes(90));
    farm.add_job(2, passes(1));
    farm.add_job(3, passes(40));
    let mut workers: Vec<SimulatedWorker> = (0..1 + random.below(6)).map(|_| SimulatedWorker::default()).collect();
    let mut late: Vec<Lease> = Vec::new();
    for _ in 0..200_000 {
        farm.pass_time(random.below(100) as f64 / 1000.0);
        let index = random.below(workers.len() as u64) as usize;
        step(&mut farm, &mut workers[index], &mut late, &mut random);
        if !late.is_empty() && random.chance(20) {
            let lease = late.swap_remove(random.below(late.len() as u64) as usize);
            farm.deliver(&lease, &Outcome::Accepted);
        }
        if (1..=3).all(|job| farm.state(job) == JobState::Done) {
            let counts = farm.merges.values().map(|merge| merge.plan.as_ref().expect("done").shard_count());
            let merged = farm.merges.values().map(|merge| merge.order.len() as u64);
            assert!(merged.eq(counts), "seed {seed}: done means all shards");
            assert_eq!(farm.schedule.leases().active().count(), 0, "seed {seed}: nothing is leased at the end");
            return farm.merges.iter().map(|(job, merge)| (*job, merge.checksum)).collect();
        }
    }
    panic!("seed {seed}: jobs did not end: {:?}", farm.schedule);
}

#[test]
fn every_job_ends_with_every_shard_merged_once_in_order() {
    let expected = simulate(0);
    for seed in 1..2000 {
        assert_eq!(simulate(seed), expected, "seed {seed}");
    }
}

/// A farm with one worker and one job whose pilot is done.
fn running_farm(stop: StopRule) -> (Farm, u64) {
    let mut farm = Farm::new(RadiusRule::Statistics);
    let worker = farm.schedule.register(farm.now, "one", 1);
    farm.add_job(1, stop);
    let pilot = farm.lease(worker).expect("the pilot");
    assert_eq!(pilot.work, Work::Pilot);
    farm.pass_time(0.5);
    farm.deliver(&pilot, &Outcome::Accepted);
    (farm, worker)
}

#[test]
fn an_expired_lease_is_fenced_and_its_work_leased_again() {
    let (mut farm, worker) = running_farm(passes(8));
    let first = farm.lease(worker).expect("work");
    farm.pass_time(10.5);
    let second_worker = farm.schedule.register(farm.now, "two", 1);
    let second = farm.lease(second_worker).expect("the expired shard");
    assert_eq!(second.work, first.work);
    assert!(second.fencing > first.fencing);
    assert_eq!(farm.deliver(&first, &Outcome::Accepted), ResultAnswer::Fenced);
    assert_eq!(farm.deliver(&second, &Outcome::Accepted), ResultAnswer::Take(second));
    assert_eq!(farm.deliver(&second, &Outcome::Accepted), ResultAnswer::AlreadyMerged);
}

#[test]
fn a_heartbeat_keeps_a_lease_and_reports_lost_ones() {
    let (mut farm, worker) = running_farm(passes(8));
    let lease = farm.lease(worker).expect("work");
    for _ in 0..10 {
        farm.pass_time(5.0);
        let answer = farm.schedule.heartbeat(farm.now, worker, &[lease.id, 7]).expect("a known worker");
        assert_eq!(answer.cancelled, [7]);
    }
    assert!(matches!(farm.deliver(&lease, &Outcome::Accepted), ResultAnswer::Take(taken) if taken.id == lease.id));
    assert!(farm.schedule.heartbeat(farm.now, 1, &[]).is_none());
}

#[test]
fn a_straggler_is_issued_twice_and_the_first_result_wins() {
    let (mut farm, slow) = running_farm(passes(2));
    let quick = farm.schedule.register(farm.now, "quick", 1);
    let first = farm.lease(quick).expect("work");
    let stuck = farm.lease(slow).expect("work");
    farm.pass_time(1.0);
    farm.deliver(&first, &Outcome::Accepted);
    assert_eq!(farm.lease(quick), None, "not overdue yet");
    farm.pass_time(2.0);
    let copy = farm.lease(quick).expect("the overdue shard");
    assert_eq!(copy.work, stuck.work);
    farm.deliver(&copy, &Outcome::Accepted);
    assert_eq!(farm.state(1), JobState::Done);
    assert_eq!(farm.deliver(&stuck, &Outcome::Accepted), ResultAnswer::AlreadyMerged);
}

#[test]
fn a_failing_worker_is_set_aside_for_a_growing_time() {
    let (mut farm, worker) = running_farm(passes(100));
    let mut pauses = Vec::new();
    for _ in 0..3 {
        while let Some(lease) = farm.lease(worker) {
            farm.deliver(&lease, &Outcome::Refused("wrong size".into()));
        }
        let (_, record) = farm.schedule.roster().iter().next().expect("a worker");
        assert!(record.set_aside(farm.now).is_some_and(|reason| reason.contains("wrong size")));
        let mut pause = 0;
        while farm.schedule.roster().iter().any(|(_, worker)| worker.set_aside(farm.now).is_some()) {
            farm.pass_time(1.0);
            farm.schedule.heartbeat(farm.now, worker, &[]);
            pause += 1;
        }
        pauses.push(pause);
    }
    assert_eq!(pauses, [5, 10, 20]);
    assert_eq!(farm.state(1), JobState::Running, "refused results are the worker's fault, not the job's");
}

#[test]
fn a_job_whose_pilot_fails_three_times_fails_with_the_message() {
    let mut farm = Farm::new(RadiusRule::Statistics);
    farm.add_job(1, passes(8));
    farm.add_job(2, passes(1));
    for _ in 0..3 {
        let worker = farm.schedule.register(farm.now, "w", 1);
        let pilot = farm.lease(worker).expect("the pilot");
        let pilot = if pilot.job == 1 { pilot } else { farm.lease(worker).expect("the other pilot") };
        farm.deliver(&pilot, &Outcome::Failed("no light".into()));
    }
    assert_eq!(farm.state(1), JobState::Failed);
    assert_eq!(farm.schedule.job(1).expect("a job").error.as_deref(), Some("no light"));
    assert_ne!(farm.state(2), JobState::Failed, "other jobs are not disturbed");
}

#[test]
fn seconds_end_a_job_with_what_has_arrived() {
    let (mut farm, worker) = running_farm(StopRule { passes: None, seconds: Some(20.0), error: None });
    let mut leases = Vec::new();
    for _ in 0..3 {
        leases.push(farm.lease(worker).expect("work"));
    }
    farm.deliver(&leases[0], &Outcome::Accepted);
    for _ in 0..4 {
        farm.pass_time(4.9);
        farm.schedule.heartbeat(farm.now, worker, &[leases[1].id, leases[2].id]);
    }
    assert_eq!(farm.state(1), JobState::Done);
    assert_eq!(farm.merges[&1].order, [0]);
    assert_eq!(farm.deliver(&leases[1], &Outcome::Accepted), ResultAnswer::Fenced);
}

#[test]
fn a_job_without_a_pass_when_its_time_is_over_waits_for_one() {
    let (mut farm, worker) = running_farm(StopRule { passes: None, seconds: Some(1.0), error: None });
    let leases = [farm.lease(worker).expect("work"), farm.lease(worker).expect("work")];
    farm.pass_time(2.0);
    assert_eq!(farm.state(1), JobState::Running);
    assert_eq!(farm.schedule.job(1).expect("a job").notices.len(), 1);
    let answer = farm.schedule.heartbeat(farm.now, worker, &leases.map(|lease| lease.id)).expect("known");
    assert_eq!(answer.cancelled, [leases[1].id], "only the first shard is still wanted");
    farm.deliver(&leases[0], &Outcome::Accepted);
    assert_eq!(farm.state(1), JobState::Done);
}

#[test]
fn jobs_take_turns_and_a_cancelled_one_frees_its_workers() {
    let mut farm = Farm::new(RadiusRule::Statistics);
    farm.add_job(1, passes(500));
    farm.add_job(2, passes(500));
    let mut granted = [0, 0, 0];
    let worker = farm.schedule.register(farm.now, "one", 1);
    for _ in 0..100 {
        let lease = farm.lease(worker).expect("work");
        granted[lease.job as usize] += 1;
        farm.deliver(&lease, &Outcome::Accepted);
    }
    assert_eq!(granted, [0, 50, 50]);
    let lease = farm.lease(worker).expect("work");
    farm.schedule.cancel(farm.now, lease.job);
    let answer = farm.schedule.heartbeat(farm.now, worker, &[lease.id]).expect("known");
    assert_eq!(answer.cancelled, [lease.id]);
    assert_eq!(farm.state(lease.job), JobState::Cancelled);
    assert!(farm.lease(worker).is_some_and(|other| other.job != lease.job));
}

#[test]
fn a_draining_coordinator_leases_nothing_but_takes_results() {
    let (mut farm, worker) = running_farm(passes(8));
    let lease = farm.lease(worker).expect("work");
    farm.schedule.drain();
    assert_eq!(farm.schedule.lease(farm.now, worker), LeaseAnswer::Drain);
    assert_eq!(farm.deliver(&lease, &Outcome::Accepted), ResultAnswer::Take(lease));
}
