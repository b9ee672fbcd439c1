//! The farm's rules alone, with a clock and a network that the tests hold: who gets which work, and what becomes of it when workers
//! die, lie, come late or never.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use crate::split_mix::Random;
use photonfarm::estimate::RadiusRule;
use photonfarm::farm::ids::{JobId, LeaseId, WorkerId};
use photonfarm::farm::job::{JobState, Priority, StopRule};
use photonfarm::farm::rules::check::{CheckShare, Digest};
use photonfarm::farm::rules::lease::{Lease, Work, WorkIndex};
use photonfarm::farm::rules::plan::Plan;
use photonfarm::farm::rules::terms::{MergedTotals, Terms};
use photonfarm::farm::rules::{Answer, Effects, Event, Outcome, Rules, RulesOptions};

const LEASE: Duration = Duration::from_secs(10);

fn seconds(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

fn passes(passes: u32) -> StopRule {
    StopRule { passes: Some(passes), ..StopRule::default() }
}

fn id(number: u64) -> JobId {
    JobId::new(number)
}

fn terms(stop: StopRule) -> Terms {
    Terms { stop, priority: Priority::DEFAULT, memory: 1, chooses_method: false, notices: Vec::new() }
}

/// What a tally takes while it waits for its turn.
const TALLY_BYTES: u64 = 10;

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
        let early_bytes = self.waiting.len() as u64 * TALLY_BYTES;
        MergedTotals { shards, passes: done, early_bytes, ..MergedTotals::default() }
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

fn options() -> RulesOptions {
    RulesOptions {
        lease_duration: LEASE,
        memory_budget: 100,
        early_budget: u64::MAX,
        check_share: CheckShare::new(0.0),
        first_id: 1000,
    }
}

struct Farm {
    rules: Rules,
    now: Duration,
    merges: BTreeMap<JobId, Merge>,
    rule: RadiusRule,
    /// Nominal microseconds of a pass.
    cost: u64,
    last: Effects,
    /// Nominal microseconds of all work granted.
    granted: u64,
    /// What workers of [`work_for`] hold.
    held: BTreeMap<WorkerId, Vec<Lease>>,
}

impl Farm {
    fn new(rule: RadiusRule) -> Self {
        Self::with(rule, options())
    }

    fn with(rule: RadiusRule, options: RulesOptions) -> Self {
        let mut rules = Rules::new(options);
        let last = rules.apply(Duration::ZERO, Event::TimePassed);
        Self {
            rules,
            now: Duration::ZERO,
            merges: BTreeMap::new(),
            rule,
            cost: 300_000,
            last,
            granted: 0,
            held: BTreeMap::new(),
        }
    }

    fn apply(&mut self, event: Event) -> Answer {
        self.last = self.rules.apply(self.now, event);
        self.last.answer.clone()
    }

    fn add_job(&mut self, number: u64, stop: StopRule) {
        self.add_job_with(number, terms(stop));
    }

    fn add_job_with(&mut self, number: u64, terms: Terms) {
        assert_eq!(self.apply(Event::JobAdded { job: id(number), terms }), Answer::Done);
        self.merges.insert(id(number), Merge::default());
    }

    fn join(&mut self, name: &str) -> WorkerId {
        let Answer::Joined(worker) = self.apply(Event::WorkerJoined { name: name.to_owned(), threads: 1 }) else {
            panic!("everybody may join");
        };
        worker
    }

    /// In steps, as a coordinator's clock runs: one long step would look as if it had been stopped.
    fn pass_time(&mut self, mut step: f64) {
        while step > 0.0 {
            self.now += seconds(step.min(0.5));
            self.apply(Event::TimePassed);
            step -= 0.5;
        }
    }

    fn state(&self, job: u64) -> JobState {
        self.rules.job(id(job)).expect("a job").state
    }

    fn lease(&mut self, worker: WorkerId) -> Option<Lease> {
        let Answer::Granted(lease) = self.apply(Event::LeaseWanted { worker }) else { return None };
        self.granted += self.rules.job(lease.job).map_or(0, |job| job.cost(&lease.work));
        if let Work::Shard(index, planned) = lease.work {
            let merge = &self.merges[&lease.job];
            let plan = merge.plan.as_ref().expect("shards come after the pilot");
            assert_eq!(plan.shard(index), Some(planned));
            assert!(merge.order.len() as u64 >= plan.merged_before(index), "its radius field exists");
        }
        Some(lease)
    }

    fn heartbeat(&mut self, worker: WorkerId, leases: &[LeaseId]) -> Option<Vec<LeaseId>> {
        match self.apply(Event::HeartbeatCame { worker, leases: leases.to_vec() }) {
            Answer::Alive { cancelled } => Some(cancelled),
            _ => None,
        }
    }

    fn deliver(&mut self, lease: &Lease, outcome: &Outcome) -> Answer {
        let Lease { worker, id, fencing, .. } = *lease;
        let answer = self.apply(Event::ResultCame { worker, lease: id, fencing, outcome: outcome.clone() });
        if let Answer::Take(taken) = answer {
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
                let stop = self.rules.job(lease.job).expect("a job").terms.stop;
                let plan = Plan::new(64, 64, self.cost, stop.passes, self.rule);
                merge.plan = Some(plan.clone());
                self.apply(Event::PilotDone { job: lease.job, plan });
            }
            Work::Shard(index, _) => {
                merge.take(index);
                let totals = merge.totals();
                self.apply(Event::Merged { job: lease.job, totals });
            }
            other => panic!("{other:?} is not merged"),
        }
    }
}

fn accepted() -> Outcome {
    Outcome::Accepted(None)
}

/// A worker of a simulation: what it holds, and what is on its way.
#[derive(Default)]
struct SimulatedWorker {
    id: WorkerId,
    held: Vec<(Lease, Duration)>,
    is_alive: bool,
}

/// One step of one worker under faults.
fn step(farm: &mut Farm, worker: &mut SimulatedWorker, late: &mut Vec<Lease>, random: &mut Random) {
    if !worker.is_alive {
        if random.chance(5) {
            worker.id = farm.join("reborn");
            worker.is_alive = true;
        }
        return;
    }
    match random.below(100) {
        0 => {
            // It dies with what it holds; the coordinator hears of it or not. What it sent may still arrive.
            if random.chance(50) {
                farm.apply(Event::WorkerLeft { worker: worker.id });
            }
            late.extend(worker.held.drain(..).map(|(lease, _)| lease));
            worker.is_alive = false;
        }
        1 => {
            let leases = worker.held.drain(..).map(|(lease, _)| lease.id).collect();
            farm.apply(Event::LeasesReleased { worker: worker.id, leases });
        }
        2..30 => {
            let ids: Vec<LeaseId> = worker.held.iter().map(|(lease, _)| lease.id).collect();
            match farm.heartbeat(worker.id, &ids) {
                None => worker.is_alive = false,
                Some(cancelled) => worker.held.retain(|(lease, _)| !cancelled.contains(&lease.id)),
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
                farm.deliver(&lease, &accepted());
                late.push(lease);
            }
            _ => drop(farm.deliver(&lease, &accepted())),
        }
    }
}

fn simulate(seed: u64) -> BTreeMap<JobId, u64> {
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
            farm.deliver(&lease, &accepted());
        }
        if (1..=3).all(|job| farm.state(job) == JobState::Done) {
            let counts = farm.merges.values().map(|merge| merge.plan.as_ref().expect("done").shard_count());
            let merged = farm.merges.values().map(|merge| merge.order.len() as u64);
            assert!(merged.eq(counts), "seed {seed}: done means all shards");
            assert_eq!(farm.rules.leases().active().count(), 0, "seed {seed}: nothing is leased at the end");
            return farm.merges.iter().map(|(job, merge)| (*job, merge.checksum)).collect();
        }
    }
    panic!("seed {seed}: jobs did not end: {:?}", farm.rules);
}

#[test]
fn every_job_ends_with_every_shard_merged_once_in_order() {
    let expected = simulate(0);
    for seed in 1..2000 {
        assert_eq!(simulate(seed), expected, "seed {seed}");
    }
}

/// A farm with one worker and one job whose pilot is done.
fn running_farm(stop: StopRule) -> (Farm, WorkerId) {
    let mut farm = Farm::new(RadiusRule::Statistics);
    let worker = farm.join("one");
    farm.add_job(1, stop);
    let pilot = farm.lease(worker).expect("the pilot");
    assert_eq!(pilot.work, Work::Pilot);
    farm.pass_time(0.5);
    farm.deliver(&pilot, &accepted());
    (farm, worker)
}

/// Tallies that come before their turn take memory. Where they take more than they may, only what is next is traced, and the job still ends.
#[test]
fn early_tallies_take_no_more_memory_than_they_may() {
    let options = RulesOptions { early_budget: 3 * TALLY_BYTES, ..options() };
    for rule in [RadiusRule::Statistics, RadiusRule::Schedule] {
        let mut farm = Farm::with(rule, options);
        let workers: Vec<WorkerId> = (0..10).map(|index| farm.join(&format!("w{index}"))).collect();
        farm.add_job(1, passes(200));
        let pilot = farm.lease(workers[0]).expect("the pilot");
        farm.deliver(&pilot, &accepted());
        let slow = farm.lease(workers[0]).expect("the first shard");
        let mut early = 0;
        while let Some(lease) = farm.lease(workers[1]) {
            farm.deliver(&lease, &accepted());
            early += 1;
            assert!(early <= 3, "{rule:?}: more came early than there is room for");
        }
        assert_eq!(early, 3, "{rule:?}");
        assert_eq!(farm.deliver(&slow, &accepted()), Answer::Take(slow));
        work_for(&mut farm, &workers, 400);
        assert_eq!(farm.state(1), JobState::Done, "{rule:?}");
    }
}

/// Where more jobs run than a worker's caches hold, workers change jobs seldom, and all jobs still get the same share.
#[test]
fn workers_stay_with_a_job_while_its_share_allows() {
    let changes = |jobs: u64| {
        let mut farm = Farm::new(RadiusRule::Schedule);
        farm.cost = 1_000_000;
        let workers: Vec<WorkerId> = (0..jobs).map(|index| farm.join(&format!("w{index}"))).collect();
        for job in 1..=jobs {
            farm.add_job(job, passes(1 << 20));
            let pilot = farm.lease(workers[0]).expect("a pilot");
            farm.deliver(&pilot, &accepted());
        }
        let mut last = BTreeMap::new();
        let (mut changes, mut shards) = (0, BTreeMap::<JobId, u64>::new());
        for round in 0..40 * workers.len() {
            // Workers are not equally fast, or each would be where it was by chance.
            let worker = workers[(round * round + round / 3) % workers.len()];
            let lease = farm.lease(worker).expect("work");
            farm.deliver(&lease, &accepted());
            changes += u32::from(last.insert(worker, lease.job).is_some_and(|before| before != lease.job));
            *shards.entry(lease.job).or_default() += 1;
        }
        let (least, most) = (shards.values().min().copied(), shards.values().max().copied());
        assert!(most.zip(least).is_some_and(|(most, least)| most - least <= 3), "unequal shares: {shards:?}");
        f64::from(changes) / (40 * workers.len()) as f64
    };
    let (few, many) = (changes(2), changes(12));
    assert!(few > 0.4, "two jobs fit into a worker's caches: it takes whichever is next ({few})");
    assert!(many < 0.6, "a worker changed its job in {many} of its shards");
}

/// What is said to wait is what further workers get, and no more.
#[test]
fn work_that_waits_is_counted() {
    for passes_wanted in [1, 8, 100, 5000] {
        let (mut farm, _) = running_farm(passes(passes_wanted));
        farm.add_job(2, passes(3));
        let waiting = farm.rules.work_waiting();
        let mut granted = 0;
        for index in 0..=waiting {
            let worker = farm.join(&format!("further {index}"));
            granted += u64::from(farm.lease(worker).is_some());
        }
        assert!(waiting > 1 && granted == waiting, "{waiting} said to wait, {granted} granted");
        assert_eq!(farm.rules.work_waiting(), 0);
    }
}

#[test]
fn an_expired_lease_is_fenced_and_its_work_leased_again() {
    let (mut farm, worker) = running_farm(passes(8));
    let first = farm.lease(worker).expect("work");
    farm.pass_time(10.5);
    let second_worker = farm.join("two");
    let second = farm.lease(second_worker).expect("the expired shard");
    assert_eq!(second.work, first.work);
    assert!(second.fencing > first.fencing);
    assert_eq!(farm.deliver(&first, &accepted()), Answer::Fenced);
    assert_eq!(farm.deliver(&second, &accepted()), Answer::Take(second));
    assert_eq!(farm.deliver(&second, &accepted()), Answer::AlreadyMerged);
}

#[test]
fn a_heartbeat_keeps_a_lease_and_reports_lost_ones() {
    let (mut farm, worker) = running_farm(passes(8));
    let lease = farm.lease(worker).expect("work");
    for _ in 0..10 {
        farm.pass_time(5.0);
        let cancelled = farm.heartbeat(worker, &[lease.id, LeaseId::new(7)]).expect("a known worker");
        assert_eq!(cancelled, [LeaseId::new(7)]);
    }
    assert!(matches!(farm.deliver(&lease, &accepted()), Answer::Take(taken) if taken.id == lease.id));
    assert!(farm.heartbeat(WorkerId::new(1), &[]).is_none());
}

#[test]
fn a_straggler_is_issued_twice_and_the_first_result_wins() {
    let (mut farm, slow) = running_farm(passes(2));
    let quick = farm.join("quick");
    let first = farm.lease(quick).expect("work");
    let stuck = farm.lease(slow).expect("work");
    farm.pass_time(1.0);
    farm.deliver(&first, &accepted());
    assert_eq!(farm.lease(quick), None, "not overdue yet");
    farm.pass_time(2.0);
    let copy = farm.lease(quick).expect("the overdue shard");
    assert_eq!(copy.work, stuck.work);
    farm.deliver(&copy, &accepted());
    assert_eq!(farm.state(1), JobState::Done);
    assert_eq!(farm.deliver(&stuck, &accepted()), Answer::AlreadyMerged);
}

#[test]
fn a_failing_worker_is_set_aside_for_a_growing_time() {
    let (mut farm, worker) = running_farm(passes(100));
    let mut pauses = Vec::new();
    for _ in 0..3 {
        while let Some(lease) = farm.lease(worker) {
            farm.deliver(&lease, &Outcome::Refused("wrong size".into()));
        }
        let (_, record) = farm.rules.roster().iter().next().expect("a worker");
        assert!(record.set_aside(farm.now).is_some_and(|reason| reason.contains("wrong size")));
        let mut pause = 0;
        while farm.rules.roster().iter().any(|(_, worker)| worker.set_aside(farm.now).is_some()) {
            farm.pass_time(1.0);
            farm.heartbeat(worker, &[]);
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
        let worker = farm.join("w");
        let pilot = farm.lease(worker).expect("the pilot");
        let pilot = if pilot.job == id(1) { pilot } else { farm.lease(worker).expect("the other pilot") };
        farm.deliver(&pilot, &Outcome::Failed("no light".into()));
    }
    assert_eq!(farm.state(1), JobState::Failed);
    assert_eq!(farm.rules.job(id(1)).expect("a job").error.as_deref(), Some("no light"));
    assert_ne!(farm.state(2), JobState::Failed, "other jobs are not disturbed");
}

#[test]
fn seconds_end_a_job_with_what_has_arrived() {
    let (mut farm, worker) = running_farm(StopRule { seconds: Some(20.0), ..StopRule::default() });
    let mut leases = Vec::new();
    for _ in 0..3 {
        leases.push(farm.lease(worker).expect("work"));
    }
    farm.deliver(&leases[0], &accepted());
    for _ in 0..4 {
        farm.pass_time(4.9);
        farm.heartbeat(worker, &[leases[1].id, leases[2].id]);
    }
    assert_eq!(farm.state(1), JobState::Done);
    assert_eq!(farm.merges[&id(1)].order, [0]);
    assert_eq!(farm.deliver(&leases[1], &accepted()), Answer::Fenced);
}

#[test]
fn a_job_without_a_pass_when_its_time_is_over_waits_for_one() {
    let (mut farm, worker) = running_farm(StopRule { seconds: Some(1.0), ..StopRule::default() });
    let leases = [farm.lease(worker).expect("work"), farm.lease(worker).expect("work")];
    farm.pass_time(2.0);
    assert_eq!(farm.state(1), JobState::Running);
    assert_eq!(farm.rules.job(id(1)).expect("a job").terms.notices.len(), 1);
    let cancelled = farm.heartbeat(worker, &leases.map(|lease| lease.id)).expect("known");
    assert_eq!(cancelled, [leases[1].id], "only the first shard is still wanted");
    farm.deliver(&leases[0], &accepted());
    assert_eq!(farm.state(1), JobState::Done);
}

#[test]
fn jobs_take_turns_and_a_cancelled_one_frees_its_workers() {
    let mut farm = Farm::new(RadiusRule::Statistics);
    farm.add_job(1, passes(500));
    farm.add_job(2, passes(500));
    let mut granted = [0, 0, 0];
    let worker = farm.join("one");
    for _ in 0..100 {
        let lease = farm.lease(worker).expect("work");
        granted[lease.job.number() as usize] += 1;
        farm.deliver(&lease, &accepted());
    }
    assert_eq!(granted, [0, 50, 50]);
    let lease = farm.lease(worker).expect("work");
    farm.apply(Event::JobCancelled { job: lease.job });
    let cancelled = farm.heartbeat(worker, &[lease.id]).expect("known");
    assert_eq!(cancelled, [lease.id]);
    assert_eq!(farm.state(lease.job.number()), JobState::Cancelled);
    assert!(farm.lease(worker).is_some_and(|other| other.job != lease.job));
}

#[test]
fn a_draining_coordinator_leases_nothing_but_takes_results() {
    let (mut farm, worker) = running_farm(passes(8));
    let lease = farm.lease(worker).expect("work");
    farm.apply(Event::DrainBegan);
    assert_eq!(farm.apply(Event::LeaseWanted { worker }), Answer::Draining);
    assert_eq!(farm.deliver(&lease, &accepted()), Answer::Take(lease));
}

/// It delivers what it holds, is given nothing more, and leaves; others do the rest.
#[test]
fn a_worker_that_is_drained_leaves_with_empty_hands() {
    let (mut farm, worker) = running_farm(passes(8));
    let lease = farm.lease(worker).expect("work");
    assert_eq!(farm.apply(Event::WorkerDrained { worker }), Answer::Done);
    assert!(farm.rules.deserted_since().is_some(), "nobody is left who takes work");
    assert_eq!(farm.apply(Event::LeaseWanted { worker }), Answer::NoWork);
    farm.pass_time(3.0);
    assert!(farm.rules.lacks_workers());
    assert_eq!(farm.deliver(&lease, &accepted()), Answer::Take(lease));
    assert_eq!(farm.apply(Event::LeaseWanted { worker }), Answer::Leave);
    let other = farm.join("other");
    assert!(farm.rules.deserted_since().is_none() && !farm.rules.lacks_workers());
    assert!(farm.lease(other).is_some());
    farm.apply(Event::WorkerLeft { worker });
    assert_eq!(farm.apply(Event::WorkerDrained { worker }), Answer::UnknownWorker);
}

/// Whoever follows a job hears that no worker is there when that is worth telling, not with the next change.
#[test]
fn jobs_are_told_anew_when_no_worker_came() {
    let mut farm = Farm::new(RadiusRule::Statistics);
    farm.add_job(1, passes(8));
    let mut told = Vec::new();
    for _ in 0..10 {
        farm.pass_time(0.5);
        if farm.last.changed.contains(&id(1)) {
            told.push((farm.now, farm.rules.lacks_workers()));
        }
    }
    assert_eq!(told, [(seconds(2.0), true)]);
}

/// Gives one worker after the other what it asks for, and delivers it, oldest first, as a worker that prefetches does. Answers how many shards
/// of each job were merged.
fn work_for(farm: &mut Farm, workers: &[WorkerId], rounds: usize) -> BTreeMap<JobId, usize> {
    for _ in 0..rounds {
        for worker in workers {
            farm.pass_time(0.01);
            let mut leases = farm.held.remove(worker).unwrap_or_default();
            while leases.len() < 2
                && let Some(lease) = farm.lease(*worker)
            {
                leases.push(lease);
            }
            if !leases.is_empty() {
                let lease = leases.remove(0);
                farm.deliver(&lease, &accepted());
            }
            farm.held.insert(*worker, leases);
        }
    }
    farm.merges.iter().map(|(id, merge)| (*id, merge.order.len())).collect()
}

/// The case of a short job beside a long one: busy workers always hold something, so the last shards of the short job must not be kept
/// for idle ones.
#[test]
fn a_short_job_ends_beside_a_long_one() {
    for workers in [1, 4, 16] {
        for cost in [1_000, 30_000, 3_000_000] {
            let mut farm = Farm::new(RadiusRule::Statistics);
            farm.cost = cost;
            let workers: Vec<WorkerId> = (0..workers).map(|index| farm.join(&index.to_string())).collect();
            farm.add_job(1, passes(1_000_000));
            work_for(&mut farm, &workers, 50);
            farm.add_job(2, passes(10));
            for round in 0.. {
                work_for(&mut farm, &workers, 1);
                if farm.state(2) == JobState::Done {
                    break;
                }
                // A pilot and ten shards, each granted at latest after one of the other job, two leases a worker ahead.
                assert!(round < 30, "{} workers, {:?}", workers.len(), farm.rules.job(id(2)));
            }
        }
    }
}

/// Two jobs of equal priority get equal work done, one of three times the priority three times as much.
#[test]
fn jobs_share_the_farm_by_priority() {
    for workers in [1, 3, 8] {
        let mut farm = Farm::new(RadiusRule::Schedule);
        let workers: Vec<WorkerId> = (0..workers).map(|index| farm.join(&index.to_string())).collect();
        for (number, priority) in [(1, 100), (2, 100), (3, 300)] {
            let priority = Priority::try_from(priority).expect("a priority");
            farm.add_job_with(number, Terms { priority, ..terms(passes(1_000_000)) });
        }
        let rounds = 4000 / workers.len();
        let merged = work_for(&mut farm, &workers, rounds);
        let done = |job: u64| {
            let shards = merged[&id(job)] as u64;
            f64::from(
                farm.merges[&id(job)].plan.as_ref().and_then(|plan| plan.shard(shards)).expect("more").shard.first_pass,
            )
        };
        assert!((done(1) / done(2) - 1.0).abs() < 0.02, "{merged:?}");
        assert!((done(3) / done(1) - 3.0).abs() < 0.1, "{merged:?}");
    }
}

/// Whatever jobs come and go: one that could be worked on all the time is served as much as any other such one.
#[test]
fn nobody_starves_in_random_mixes_of_jobs_workers_and_arrivals() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let rule = if seed % 2 == 0 { RadiusRule::Statistics } else { RadiusRule::Schedule };
        let mut farm = Farm::new(rule);
        let workers: Vec<WorkerId> = (0..1 + random.below(8)).map(|index| farm.join(&index.to_string())).collect();
        let mut begun: BTreeMap<u64, u64> = BTreeMap::new();
        let mut next = 1;
        for _ in 0..400 {
            if begun.len() < 12 && random.chance(10) {
                farm.cost = 1 << random.below(22);
                farm.add_job(next, passes(1 + random.below(40) as u32 * random.below(40) as u32));
                begun.insert(next, farm.granted);
                next += 1;
            }
            work_for(&mut farm, &workers, 1);
            begun.retain(|job, _| farm.state(*job) != JobState::Done);
            for (job, since) in &begun {
                // Each of twelve jobs may be behind by a second's work and by its largest shard, of 4.2 s here.
                let is_served = farm.rules.job(id(*job)).is_some_and(|job| job.state != JobState::Queued);
                let waited = farm.granted - since;
                assert!(
                    is_served || waited < 12 * (1_000_000 + 4_200_000),
                    "seed {seed}: job {job} waits for {waited}"
                );
            }
        }
        for _ in 0..20_000 {
            if (1..next).all(|job| farm.state(job) == JobState::Done) {
                break;
            }
            work_for(&mut farm, &workers, 1);
        }
        assert!((1..next).all(|job| farm.state(job) == JobState::Done), "seed {seed}");
    }
}

/// A job whose state does not fit beside others waits, but not for ever; nobody overtakes it.
#[test]
fn memory_is_given_in_the_order_of_arrival() {
    let mut farm = Farm::new(RadiusRule::Statistics);
    let worker = farm.join("one");
    for (number, memory) in [(1, 60), (2, 60), (3, 10)] {
        farm.add_job_with(number, Terms { memory, ..terms(passes(20)) });
    }
    let mut order = Vec::new();
    for _ in 0..1000 {
        work_for(&mut farm, &[worker], 1);
        for job in 1..=3 {
            if farm.state(job) != JobState::Queued && !order.contains(&job) {
                order.push(job);
                let running: u64 = (1..=3).filter(|job| farm.state(*job) == JobState::Running).count() as u64;
                assert!(running < 3, "60 + 60 does not fit into 100");
            }
        }
    }
    assert_eq!(order, [1, 2, 3]);
    assert!((1..=3).all(|job| farm.state(job) == JobState::Done));
}

/// A shard over which workers are lost is issued to three of them, not to all.
#[test]
fn a_shard_that_costs_three_workers_pauses_its_job() {
    let (mut farm, _) = running_farm(passes(100));
    farm.add_job(2, passes(1_000_000));
    let mut victims = 0;
    while farm.state(1) != JobState::Paused {
        let worker = farm.join(&format!("victim {victims}"));
        victims += 1;
        assert!(victims < 10, "nobody stops it");
        // It traces shard 0 of job 1 first, and takes others with it that are innocent.
        while let Some(lease) = farm.lease(worker) {
            if lease.job == id(1) && lease.work.index() == WorkIndex::Shard(0) {
                break;
            }
            farm.deliver(&lease, &if lease.work == Work::Pilot { accepted() } else { Outcome::Refused("x".into()) });
        }
        farm.pass_time(11.0);
    }
    let job = farm.rules.job(id(1)).expect("a job");
    assert!(job.pause.as_ref().expect("a reason").to_string().contains("shard 0"), "{:?}", job.pause);
    assert!(victims >= 3);
    farm.apply(Event::JobResumed { job: id(1) });
    assert_ne!(farm.state(1), JobState::Paused);
}

/// A coordinator that was stopped, or starved of processor time, could not hear heartbeats: no lease is lost by that.
#[test]
fn a_stall_of_the_coordinator_costs_no_leases() {
    let (mut farm, worker) = running_farm(passes(100));
    let lease = farm.lease(worker).expect("work");
    farm.now += seconds(500.0);
    farm.apply(Event::TimePassed);
    assert_eq!(farm.heartbeat(worker, &[lease.id]), Some(Vec::new()));
    assert!(matches!(farm.deliver(&lease, &accepted()), Answer::Take(taken) if taken.id == lease.id));
}

#[test]
fn a_farm_without_workers_says_since_when() {
    let (mut farm, worker) = running_farm(passes(100));
    assert_eq!(farm.rules.deserted_since(), None);
    let lease = farm.lease(worker).expect("work");
    farm.pass_time(30.0);
    let since = farm.rules.deserted_since().expect("nobody is there");
    assert!(since > seconds(9.0) && since < seconds(11.5), "{since:?}");
    assert_eq!(farm.heartbeat(worker, &[lease.id]), Some(vec![lease.id]), "it was only cut off");
    assert_eq!(farm.rules.deserted_since(), None);
    farm.apply(Event::WorkerLeft { worker });
    assert!(farm.rules.deserted_since().is_some());
}

#[test]
fn a_paused_job_gets_no_work_and_goes_on_when_resumed() {
    let (mut farm, worker) = running_farm(passes(20));
    let lease = farm.lease(worker).expect("work");
    let reason = photonfarm::farm::rules::terms::PauseReason::User;
    assert_eq!(farm.apply(Event::JobPaused { job: id(1), reason: reason.clone() }), Answer::Done);
    assert_eq!(farm.apply(Event::JobPaused { job: id(1), reason }), Answer::NotPossible(JobState::Paused));
    assert_eq!(farm.deliver(&lease, &accepted()), Answer::Take(lease), "what was traced is not lost");
    assert_eq!(farm.lease(worker), None);
    assert_eq!(farm.apply(Event::JobResumed { job: id(1) }), Answer::Done);
    assert_eq!(farm.apply(Event::JobResumed { job: id(1) }), Answer::NotPossible(farm.state(1)));
    work_for(&mut farm, &[worker], 100);
    assert_eq!(farm.state(1), JobState::Done);
}

/// Traces what it is given; a liar's shards have other bits.
fn digest_of(lease: &Lease, lies: bool) -> Digest {
    let (Work::Shard(index, _) | Work::Check(index, _)) = lease.work else { return Digest([0; 32]) };
    Digest([index as u8 ^ if lies { lease.worker.number() as u8 } else { 0 }; 32])
}

fn checking_farm(share: f64) -> Farm {
    Farm::with(RadiusRule::Statistics, RulesOptions { check_share: CheckShare::new(share), ..options() })
}

#[test]
fn checked_shards_are_traced_by_another_worker_and_compared() {
    let mut farm = checking_farm(1.0);
    let workers = [farm.join("one"), farm.join("two")];
    farm.add_job(1, passes(40));
    for _ in 0..200 {
        for worker in workers {
            let Some(lease) = farm.lease(worker) else { continue };
            let digest = farm.rules.wants_digest(&lease).then(|| digest_of(&lease, false));
            let answer = farm.deliver(&lease, &Outcome::Accepted(digest));
            let is_check = matches!(lease.work, Work::Check(..));
            assert_eq!(answer == Answer::Compared, is_check, "{lease:?}");
        }
    }
    let job = farm.rules.job(id(1)).expect("a job");
    assert_eq!(job.state, JobState::Done);
    assert_eq!((job.checks.verified, job.checks.mismatched), (job.totals.shards, 0));
}

/// Lets `worker` do all that it is given, honestly, `rounds` times.
fn work_honestly(farm: &mut Farm, worker: WorkerId, rounds: usize) {
    for _ in 0..rounds {
        let Some(lease) = farm.lease(worker) else { return };
        let digest = farm.rules.wants_digest(&lease).then(|| digest_of(&lease, false));
        farm.deliver(&lease, &Outcome::Accepted(digest));
    }
}

#[test]
fn a_job_is_done_when_its_checks_are() {
    let mut farm = checking_farm(1.0);
    let [fast, slow] = [farm.join("fast"), farm.join("slow")];
    farm.add_job(1, passes(12));
    work_honestly(&mut farm, fast, 100);
    let job = farm.rules.job(id(1)).expect("a job");
    assert!(job.is_complete() && job.checks.verified == 0, "all is merged, nothing is checked");
    assert_eq!(job.state, JobState::Running);
    work_honestly(&mut farm, slow, 100);
    let job = farm.rules.job(id(1)).expect("a job");
    assert_eq!((job.state, job.checks.verified, job.checks.unchecked), (JobState::Done, 12, 0));
}

#[test]
fn checks_that_nobody_can_do_hold_nothing_up() {
    let mut farm = checking_farm(1.0);
    let [stays, leaves] = [farm.join("stays"), farm.join("leaves")];
    farm.add_job(1, passes(12));
    work_honestly(&mut farm, stays, 100);
    assert_eq!(farm.state(1), JobState::Running);
    farm.apply(Event::WorkerLeft { worker: leaves });
    farm.pass_time(0.5);
    let job = farm.rules.job(id(1)).expect("a job");
    assert_eq!((job.state, job.checks.verified, job.checks.unchecked), (JobState::Done, 0, 12));
    // One that is there but does nothing is not waited for either.
    let idle = farm.join("idle");
    farm.add_job(2, passes(12));
    work_honestly(&mut farm, stays, 100);
    for _ in 0..11 {
        assert_eq!(farm.state(2), JobState::Running);
        farm.heartbeat(idle, &[]);
        farm.pass_time(9.0);
        farm.heartbeat(stays, &[]);
    }
    farm.heartbeat(idle, &[]);
    farm.pass_time(9.0);
    assert_eq!(farm.state(2), JobState::Done);
}

/// Radii that a check needs are kept until it is done, and no longer than needed.
#[test]
fn no_shard_is_issued_that_would_cost_a_check_its_radii() {
    let mut farm = checking_farm(1.0);
    let [fast, slow] = [farm.join("fast"), farm.join("slow")];
    farm.add_job(1, passes(400));
    work_honestly(&mut farm, fast, 1000);
    let job = farm.rules.job(id(1)).expect("a job");
    let plan = job.plan.clone().expect("a plan");
    assert_eq!(plan.epoch_of(job.totals.shards), 2, "two epochs are merged, the third waits for checks of the first");
    assert_eq!(plan.first_field_kept(2), 0, "whose radii are still there");
    for _ in 0..100 {
        work_honestly(&mut farm, slow, 10);
        work_honestly(&mut farm, fast, 10);
    }
    let job = farm.rules.job(id(1)).expect("a job");
    assert_eq!((job.state, job.checks.verified, job.checks.unchecked), (JobState::Done, plan.shard_count(), 0));
}

/// A worker that returns other bits than two others is set aside, and what was merged from it is done again.
#[test]
fn a_liar_is_found_out_and_its_shards_are_done_again() {
    let mut farm = checking_farm(0.3);
    let liar = farm.join("liar");
    let honest = [farm.join("honest one"), farm.join("honest two")];
    farm.add_job(1, passes(400));
    let mut rollback = None;
    for round in 0..200 {
        for worker in [liar, honest[0], honest[1]] {
            // The pilot and the first shards are honest work.
            if worker == liar && round < 5 {
                continue;
            }
            let Some(lease) = farm.lease(worker) else { continue };
            let digest = farm
                .rules
                .wants_digest(&lease)
                .then(|| digest_of(&lease, worker == liar && matches!(lease.work, Work::Shard(..))));
            farm.deliver(&lease, &Outcome::Accepted(digest));
            if let Some(found) = farm.last.rollbacks.first() {
                rollback = rollback.or(Some(*found));
            }
        }
        if rollback.is_some() {
            break;
        }
    }
    let rollback = rollback.expect("the liar is found out");
    assert_eq!(rollback.job, id(1));
    let keep = rollback.keep.expect("the pilot was honest");
    assert!(keep > 0 && keep < farm.merges[&id(1)].order.len() as u64, "{keep}");
    let record = farm.rules.roster().get(liar).expect("it is still there");
    assert!(record.set_aside(farm.now).is_some_and(|reason| reason.contains("other bits")));
    assert_eq!(farm.lease(honest[0]), None, "nothing is leased until the job is restored");
}
