//! The farm's rules and what a coordinator stores, under a deterministic simulator: workers that die, hang, are cut off, return nonsense or
//! wrong bits, messages that are late, lost, repeated or overtake each other, coordinators that crash and come back, disks that are full,
//! users who pause, resume and cancel.
//!
//! A quarter of the schedules has a worker that lies. There every shard is checked, two honest workers are spared all faults, and the
//! coordinator does not crash: what it knows of who contributed what is in its memory only.
//!
//! Every schedule follows from its seed. `PHOTONFARM_SIMULATION_SEEDS=100000 cargo test --test farm simulation` runs more of them,
//! `PHOTONFARM_SIMULATION_SEED=17` that one alone, with a line an event.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::time::Duration;

use crate::seeds::{Faults, Schedules, run_seeds};
use crate::split_mix::Random;
use photonfarm::estimate::RadiusRule;
use photonfarm::farm::ids::{JobId, LeaseId, WorkerId};
use photonfarm::farm::job::{JobState, Priority, StopRule};
use photonfarm::farm::rules::check::{CheckShare, Digest};
use photonfarm::farm::rules::lease::{Lease, Work};
use photonfarm::farm::rules::plan::Plan;
use photonfarm::farm::rules::terms::{MergedTotals, PauseReason, Restored, Terms};
use photonfarm::farm::rules::{Answer, Event, Outcome, Rollback, Rules, RulesOptions};

/// Schedules of a usual run.
const SEEDS: u64 = 10_000;
/// Tallies that may come before their turn, all together.
const EARLY_BUDGET: u64 = 20;
const LEASE: Duration = Duration::from_secs(5);
/// Faults happen until then, seconds.
const FAULTS_UNTIL: f64 = 120.0;
/// Every job ends until then, seconds: long after the last fault.
const END: f64 = 1500.0;

/// Between 0 and `most` seconds.
fn seconds(random: &mut Random, most: f64) -> Duration {
    Duration::from_secs_f64(most * (random.below(1 << 20) as f64 / f64::from(1 << 20)))
}

/// What the disk holds of a job: all that outlives a coordinator.
#[derive(Clone)]
struct StoredJob {
    terms: Terms,
    state: JobState,
    pause: Option<PauseReason>,
    plan: Option<Plan>,
    merged: u64,
    checksum: u64,
}

/// A lie's digest and what it adds to a checksum.
const LIE: u64 = 1 << 40;
/// The job that users pause, resume and cancel.
const USERS_JOB: JobId = JobId::new(4);

/// What a coordinator holds of a job in memory.
#[derive(Clone, Default)]
struct Merging {
    plan: Option<Plan>,
    merged: u64,
    checksum: u64,
    /// Early shards, and whether they are lies.
    waiting: BTreeMap<u64, bool>,
}

struct Coordinator {
    rules: Rules,
    merging: BTreeMap<JobId, Merging>,
    /// Jobs that ended, until the disk has them.
    ended: BTreeMap<JobId, JobState>,
    life: u64,
}

struct HeldLease {
    lease: Lease,
    ready: Duration,
}

#[derive(Default)]
struct Worker {
    id: Option<WorkerId>,
    held: BTreeMap<LeaseId, HeldLease>,
    /// Rises when the process is killed: what was meant for the one before is lost.
    life: u64,
    is_alive: bool,
    /// It exists, but neither sends nor receives.
    cut_off_until: Duration,
    heartbeat: Duration,
}

#[derive(Clone, Debug)]
enum Request {
    Join,
    LeaseWanted(WorkerId),
    Heartbeat(WorkerId, Vec<LeaseId>),
    Result(Lease, Outcome),
}

#[derive(Clone, Debug)]
enum Message {
    ToCoordinator { worker: usize, life: u64, request: Request },
    ToWorker { worker: usize, life: u64, lease: Option<LeaseId>, answer: Answer },
    Wake { worker: usize },
    Tick { life: u64 },
    Snapshot { life: u64 },
    Fault,
    Restart,
}

struct World {
    random: Random,
    now: Duration,
    sequence: u64,
    queue: BinaryHeap<Reverse<(Duration, u64)>>,
    messages: BTreeMap<u64, Message>,
    coordinator: Option<Coordinator>,
    disk: BTreeMap<JobId, StoredJob>,
    is_full: bool,
    workers: Vec<Worker>,
    /// Whether the first worker lies; the next two are then spared all faults.
    has_liar: bool,
    /// What was merged of the user's job when its cancellation was answered.
    cancelled: Option<(u64, u64)>,
    rule: RadiusRule,
    next_life: u64,
    is_traced: bool,
    faults: Faults,
}

/// What a shard adds to a job's checksum: as with pictures, the order counts.
fn fold(checksum: u64, index: u64, is_lie: bool) -> u64 {
    checksum.wrapping_mul(0x100_0000_01b3).wrapping_add(index + 1 + if is_lie { LIE } else { 0 })
}

fn digest(index: u64, is_lie: bool) -> Digest {
    let mut bytes = [is_lie as u8; 32];
    bytes[..8].copy_from_slice(&index.to_le_bytes());
    Digest(bytes)
}

impl World {
    fn new(seed: u64, is_traced: bool) -> Self {
        let mut random = Random(seed);
        let rule = if random.chance(50) { RadiusRule::Statistics } else { RadiusRule::Schedule };
        let has_liar = random.chance(25);
        let count = if has_liar { 3 } else { 1 } + random.below(5);
        let workers = (0..count).map(|_| Worker { is_alive: true, ..Worker::default() }).collect();
        let mut world = Self {
            random,
            now: Duration::ZERO,
            sequence: 0,
            queue: BinaryHeap::new(),
            messages: BTreeMap::new(),
            coordinator: None,
            disk: BTreeMap::new(),
            is_full: false,
            workers,
            has_liar,
            cancelled: None,
            rule,
            next_life: 1,
            is_traced,
            faults: Faults::new(),
        };
        world.start_coordinator();
        for (index, passes) in [160, 1, 25, 30].into_iter().enumerate() {
            world.submit(JobId::new(index as u64 + 1), passes);
        }
        for worker in 0..world.workers.len() {
            world.send(0.5, Message::Wake { worker });
        }
        world.send(1.0, Message::Fault);
        world
    }

    /// Lets a message arrive after up to `most` seconds.
    fn send(&mut self, most: f64, message: Message) {
        let time = self.now + seconds(&mut self.random, most) + Duration::from_millis(1);
        self.sequence += 1;
        self.queue.push(Reverse((time, self.sequence)));
        self.messages.insert(self.sequence, message);
    }

    /// Sends over the network: late, twice, or not at all.
    fn send_by_network(&mut self, worker: usize, message: Message) {
        if self.workers[worker].cut_off_until > self.now {
            return;
        }
        let is_bad = self.now.as_secs_f64() < FAULTS_UNTIL;
        if is_bad && self.random.chance(4) {
            *self.faults.entry("messages lost").or_default() += 1;
            return;
        }
        if is_bad && self.random.chance(4) {
            *self.faults.entry("messages repeated").or_default() += 1;
            self.send(3.0, message.clone());
        }
        let late = if is_bad && self.random.chance(5) { 4.0 } else { 0.05 };
        self.send(late, message);
    }

    fn submit(&mut self, job: JobId, passes: u32) {
        let stop = StopRule { passes: Some(passes), ..StopRule::default() };
        let priority = Priority::try_from(50 + 50 * self.random.below(4) as u16).expect("a priority");
        let terms = Terms { stop, priority, memory: 30, chooses_method: false, notices: Vec::new() };
        // It is durable before it is accepted.
        let stored = StoredJob {
            terms: terms.clone(),
            state: JobState::Queued,
            pause: None,
            plan: None,
            merged: 0,
            checksum: 0,
        };
        self.disk.insert(job, stored);
        if let Some(coordinator) = &mut self.coordinator {
            coordinator.merging.insert(job, Merging::default());
        }
        self.apply(Event::JobAdded { job, terms });
    }

    fn start_coordinator(&mut self) {
        let life = self.next_life;
        self.next_life += 1;
        let rules = Rules::new(RulesOptions {
            lease_duration: LEASE,
            memory_budget: 70,
            early_budget: EARLY_BUDGET,
            check_share: CheckShare::new(if self.has_liar { 1.0 } else { 0.2 }),
            first_id: life << 40,
        });
        self.coordinator = Some(Coordinator { rules, merging: BTreeMap::new(), ended: BTreeMap::new(), life });
        for (job, stored) in self.disk.clone() {
            if stored.state.is_final() {
                continue;
            }
            self.go_on(job, &stored);
        }
        self.send(0.2, Message::Tick { life });
        self.send(3.0, Message::Snapshot { life });
    }

    /// Lets a job go on from what the disk holds of it.
    fn go_on(&mut self, job: JobId, stored: &StoredJob) {
        let StoredJob { terms, plan, merged, checksum, pause, .. } = stored.clone();
        let totals = totals(plan.as_ref(), merged);
        if let Some(coordinator) = &mut self.coordinator {
            let merging = Merging { plan: plan.clone(), merged, checksum, waiting: BTreeMap::new() };
            coordinator.merging.insert(job, merging);
        }
        let is_begun = plan.is_some();
        let restored = Restored { plan, totals: totals.clone(), pause, ..Restored::default() };
        self.apply(Event::JobRestored { job, terms, restored: Box::new(restored) });
        if is_begun {
            self.apply(Event::Merged { job, totals });
        }
    }

    /// Lets an event happen, and does what a coordinator does with its effects.
    fn apply(&mut self, event: Event) -> Answer {
        let now = self.now;
        let Some(coordinator) = &mut self.coordinator else { return Answer::NoWork };
        let effects = coordinator.rules.apply(now, event);
        for job in &effects.ended {
            let state = coordinator.rules.job(*job).map_or(JobState::Done, |job| job.state);
            coordinator.rules.apply(now, Event::JobForgotten { job: *job });
            coordinator.ended.insert(*job, state);
        }
        if !effects.ended.is_empty() && !self.is_full {
            self.snapshot();
        }
        for rollback in effects.rollbacks {
            self.roll_back(rollback);
        }
        effects.answer
    }

    /// What a job merged from `keep` on is not to be trusted: it goes on from the disk, or from its beginning.
    fn roll_back(&mut self, rollback: Rollback) {
        let Rollback { job, keep } = rollback;
        *self.faults.entry("rollbacks").or_default() += 1;
        let pause = self.coordinator.as_ref().and_then(|coordinator| coordinator.rules.job(job)?.pause.clone());
        let stored = self.disk.get_mut(&job).expect("it was stored when it was accepted");
        if keep.is_none_or(|most| stored.merged > most) {
            (stored.plan, stored.merged, stored.checksum) = (None, 0, 0);
        }
        let stored = StoredJob { pause, ..stored.clone() };
        self.go_on(job, &stored);
    }

    /// Stores the states of all jobs, or pauses them when there is no room.
    fn snapshot(&mut self) {
        let Some(coordinator) = &mut self.coordinator else { return };
        if self.is_full {
            let running = coordinator.rules.jobs().filter(|(_, job)| job.state != JobState::Paused);
            let running: Vec<JobId> = running.map(|(id, _)| id).collect();
            for job in running {
                self.apply(Event::JobPaused { job, reason: PauseReason::Store { problem: "full".into() } });
            }
            return;
        }
        let mut resumed = Vec::new();
        for (job, merging) in &coordinator.merging {
            let stored = self.disk.get_mut(job).expect("it was stored when it was accepted");
            if let Some(state) = coordinator.ended.remove(job) {
                stored.state = state;
            } else if let Some(live) = coordinator.rules.job(*job) {
                if live.is_rolling_back {
                    continue;
                }
                stored.pause = live.pause.clone().filter(|reason| !matches!(reason, PauseReason::Store { .. }));
                resumed.extend((live.pause != stored.pause).then_some(*job));
            } else {
                continue;
            }
            (stored.plan, stored.merged, stored.checksum) = (merging.plan.clone(), merging.merged, merging.checksum);
        }
        for job in resumed {
            self.apply(Event::JobResumed { job });
        }
    }

    /// A user does something to a job. It is answered when the disk has it.
    fn act_as_user(&mut self) -> &'static str {
        let job = USERS_JOB;
        let (name, event) = match self.random.below(8) {
            0 => ("cancelled by a user", Event::JobCancelled { job }),
            1..4 => ("paused by a user", Event::JobPaused { job, reason: PauseReason::User }),
            _ => ("resumed by a user", Event::JobResumed { job }),
        };
        let is_cancel = matches!(event, Event::JobCancelled { .. });
        let is_done = self.apply(event) == Answer::Done;
        if is_done && !self.is_full {
            self.snapshot();
            if is_cancel {
                let stored = &self.disk[&job];
                assert_eq!(stored.state, JobState::Cancelled);
                self.cancelled = Some((stored.merged, stored.checksum));
            }
        }
        name
    }

    fn step(&mut self) -> bool {
        let Some(Reverse((time, sequence))) = self.queue.pop() else { return false };
        self.now = self.now.max(time);
        let message = self.messages.remove(&sequence).expect("every place has a message");
        if self.is_traced {
            println!("{:9.3} {message:?}", self.now.as_secs_f64());
        }
        match message {
            Message::ToCoordinator { worker, life, request } => self.coordinate(worker, life, request),
            Message::ToWorker { worker, life, lease, answer } => self.answered(worker, life, lease, answer),
            Message::Wake { worker } => self.wake(worker),
            Message::Tick { life } if self.is_life(life) => {
                self.apply(Event::TimePassed);
                self.send(0.4, Message::Tick { life });
            }
            Message::Snapshot { life } if self.is_life(life) => {
                self.snapshot();
                self.send(6.0, Message::Snapshot { life });
            }
            Message::Tick { .. } | Message::Snapshot { .. } => {}
            Message::Fault => self.fault(),
            Message::Restart => self.start_coordinator(),
        }
        true
    }

    fn is_life(&self, life: u64) -> bool {
        self.coordinator.as_ref().is_some_and(|coordinator| coordinator.life == life)
    }

    fn fault(&mut self) {
        if self.now.as_secs_f64() > FAULTS_UNTIL {
            self.heal();
            return;
        }
        self.send(12.0, Message::Fault);
        let worker = self.random.below(self.workers.len() as u64) as usize;
        let is_spared = self.has_liar && (1..3).contains(&worker);
        let name = match self.random.below(8) {
            0 if self.coordinator.is_some() && !self.has_liar => {
                self.coordinator = None;
                self.send(8.0, Message::Restart);
                "coordinators crashed"
            }
            1 | 2 if !is_spared => {
                let Worker { life, is_alive, .. } = &self.workers[worker];
                let (life, is_alive) = (life + 1, !is_alive);
                self.workers[worker] = Worker { life, is_alive, ..Worker::default() };
                if is_alive { "workers started" } else { "workers killed" }
            }
            3 if !is_spared => {
                self.workers[worker].cut_off_until = self.now + seconds(&mut self.random, 20.0);
                "workers cut off"
            }
            5 | 6 => self.act_as_user(),
            4 => {
                self.is_full = !self.is_full;
                if self.is_full { "disks full" } else { "disks with room again" }
            }
            _ => {
                // The coordinator's process is stopped for a while: nothing is heard, not even time.
                self.now += seconds(&mut self.random, 10.0);
                "coordinators stalled"
            }
        };
        *self.faults.entry(name).or_default() += 1;
    }

    /// From now on all is well, and every job must end.
    fn heal(&mut self) {
        self.is_full = false;
        for worker in &mut self.workers {
            if !worker.is_alive {
                *worker = Worker { life: worker.life + 1, is_alive: true, ..Worker::default() };
            }
        }
        let parked: Vec<JobId> = self
            .coordinator
            .iter()
            .flat_map(|coordinator| coordinator.rules.jobs())
            .filter(|(_, job)| job.state == JobState::Paused)
            .map(|(id, _)| id)
            .collect();
        for job in parked {
            self.apply(Event::JobResumed { job });
        }
        // Jobs may still be parked by workers that were lost before, and a coordinator may still be down.
        self.send(30.0, Message::Fault);
    }

    fn wake(&mut self, worker: usize) {
        self.send(0.6, Message::Wake { worker });
        if !self.workers[worker].is_alive {
            return;
        }
        let life = self.workers[worker].life;
        for request in self.requests(worker) {
            self.send_by_network(worker, Message::ToCoordinator { worker, life, request });
        }
    }

    fn requests(&mut self, worker: usize) -> Vec<Request> {
        let now = self.now;
        let lies = self.has_liar && worker == 0 && now.as_secs_f64() < FAULTS_UNTIL;
        let Worker { id, held, heartbeat, .. } = &mut self.workers[worker];
        let Some(id) = *id else { return vec![Request::Join] };
        let mut requests: Vec<Request> = Vec::new();
        if *heartbeat <= now {
            *heartbeat = now + LEASE / 3;
            requests.push(Request::Heartbeat(id, held.keys().copied().collect()));
        }
        if held.len() < 2 {
            requests.push(Request::LeaseWanted(id));
        }
        // Until the coordinator has said yes or no, a result is sent again and again.
        let ready: Vec<Lease> = held.values().filter(|held| held.ready <= now).map(|held| held.lease).collect();
        for lease in ready {
            let outcome = match lease.work {
                _ if now.as_secs_f64() < FAULTS_UNTIL && self.random.chance(2) => {
                    Outcome::Refused("nonsense".to_owned())
                }
                Work::Shard(index, _) | Work::Check(index, _) => {
                    Outcome::Accepted(Some(digest(index, lies && self.random.chance(30))))
                }
                _ => Outcome::Accepted(None),
            };
            requests.push(Request::Result(lease, outcome));
        }
        requests
    }

    fn coordinate(&mut self, worker: usize, life: u64, request: Request) {
        if self.coordinator.is_none() {
            return;
        }
        let lease = if let Request::Result(lease, _) = &request { Some(lease.id) } else { None };
        let answer = match request {
            Request::Join => self.apply(Event::WorkerJoined { name: format!("w{worker}"), threads: 1 }),
            Request::LeaseWanted(worker) => self.grant(worker),
            Request::Heartbeat(worker, leases) => self.apply(Event::HeartbeatCame { worker, leases }),
            Request::Result(lease, outcome) => self.take(&lease, outcome),
        };
        self.send_by_network(worker, Message::ToWorker { worker, life, lease, answer });
    }

    /// Whoever gets a shard can have its radii.
    fn grant(&mut self, worker: WorkerId) -> Answer {
        let answer = self.apply(Event::LeaseWanted { worker });
        if let Answer::Granted(Lease { job, work: Work::Shard(_, planned) | Work::Check(_, planned), .. }) = &answer {
            let Merging { plan, merged, .. } = self.merging(*job);
            let plan = plan.as_ref().expect("shards come after the pilot");
            let kept = plan.first_field_kept(plan.epoch_of(*merged));
            assert!(planned.field_epoch >= kept, "the radii of epoch {} are gone", planned.field_epoch);
        }
        answer
    }

    /// As a coordinator takes a result: the rules decide, and what they take is merged in order.
    fn take(&mut self, lease: &Lease, outcome: Outcome) -> Answer {
        let Lease { worker, id, fencing, .. } = *lease;
        let Some(coordinator) = &self.coordinator else { return Answer::NoWork };
        let is_lie = matches!(&outcome, Outcome::Accepted(Some(Digest(bytes))) if bytes[31] == 1);
        let outcome = match outcome {
            Outcome::Accepted(_) if !coordinator.rules.wants_digest(lease) => Outcome::Accepted(None),
            outcome => outcome,
        };
        *self.faults.entry("lies").or_default() += u64::from(is_lie);
        let answer = self.apply(Event::ResultCame { worker, lease: id, fencing, outcome });
        let Answer::Take(taken) = &answer else { return answer };
        assert_eq!(taken.id, lease.id);
        let (job, rule) = (taken.job, self.rule);
        match taken.work {
            Work::Pilot => {
                let stop = self.disk[&job].terms.stop;
                let plan = Plan::new(64, 64, 300_000, stop.passes, rule);
                let merging = self.merging(job);
                assert!(merging.plan.is_none(), "two pilots");
                merging.plan = Some(plan.clone());
                self.apply(Event::PilotDone { job, plan });
            }
            Work::Shard(index, _) => {
                let merging = self.merging(job);
                let is_new = index >= merging.merged && merging.waiting.insert(index, is_lie).is_none();
                assert!(is_new, "shard {index} is taken twice");
                while let Some(is_lie) = merging.waiting.remove(&merging.merged) {
                    merging.checksum = fold(merging.checksum, merging.merged, is_lie);
                    merging.merged += 1;
                }
                let early_bytes = merging.waiting.len() as u64;
                let totals = MergedTotals { early_bytes, ..totals(merging.plan.as_ref(), merging.merged) };
                self.apply(Event::Merged { job, totals });
            }
            other => panic!("{other:?} is not merged"),
        }
        answer
    }

    fn merging(&mut self, job: JobId) -> &mut Merging {
        self.coordinator.as_mut().expect("it lives").merging.get_mut(&job).expect("a job")
    }

    fn answered(&mut self, worker: usize, life: u64, lease: Option<LeaseId>, answer: Answer) {
        let ready = self.now + seconds(&mut self.random, 2.0);
        let to = &mut self.workers[worker];
        if !to.is_alive || to.life != life || to.cut_off_until > self.now {
            return;
        }
        match answer {
            Answer::Joined(id) if to.id.is_none() => to.id = Some(id),
            Answer::Granted(lease) if to.id == Some(lease.worker) => {
                to.held.insert(lease.id, HeldLease { lease, ready });
            }
            Answer::UnknownWorker => (to.id, to.held) = (None, BTreeMap::new()),
            Answer::Alive { cancelled } => to.held.retain(|id, _| !cancelled.contains(id)),
            Answer::Take(_) | Answer::AlreadyMerged | Answer::Fenced | Answer::Recorded | Answer::Compared => {
                to.held.retain(|id, _| Some(*id) != lease);
            }
            _ => {}
        }
    }

    fn all_have_ended(&self) -> bool {
        self.disk.values().all(|job| job.state.is_final())
    }
}

fn totals(plan: Option<&Plan>, merged: u64) -> MergedTotals {
    let passes = plan.map_or(0, |plan| plan.shard(merged).map_or(plan.passes, |next| next.shard.first_pass));
    MergedTotals { shards: merged, passes, ..MergedTotals::default() }
}

/// Runs a schedule to its end and checks what must hold; answers the faults that it met.
fn simulate(seed: u64, is_traced: bool) -> Faults {
    let mut world = World::new(seed, is_traced);
    while world.now.as_secs_f64() < END && world.step() {
        if world.now.as_secs_f64() > FAULTS_UNTIL && world.all_have_ended() {
            break;
        }
    }
    for (job, stored) in &world.disk {
        let state = world.coordinator.as_ref().map(|coordinator| coordinator.rules.job(*job));
        assert!(stored.state.is_final(), "seed {seed}: job {job} did not end: {state:?}");
        let expected = (0..stored.merged).fold(0, |sum, index| fold(sum, index, false));
        if stored.state == JobState::Cancelled {
            // Who cancels keeps what is there, checked or not.
            let said = world.cancelled.filter(|_| *job == USERS_JOB);
            assert!(said.is_none_or(|said| said == (stored.merged, stored.checksum)), "seed {seed}: job {job} changed");
            continue;
        }
        assert_eq!(stored.state, JobState::Done, "seed {seed}: job {job}");
        let plan = stored.plan.as_ref().expect("its pilot was done");
        assert_eq!(stored.merged, plan.shard_count(), "seed {seed}: job {job} lacks shards");
        assert_eq!(stored.checksum, expected, "seed {seed}: job {job} holds lies, or shards twice or in another order");
    }
    world.faults
}

#[test]
fn no_schedule_of_faults_loses_or_repeats_a_shard() {
    let Some(Schedules { seeds, faults }) = run_seeds("PHOTONFARM_SIMULATION_SEED", SEEDS, simulate) else { return };
    assert!(faults.len() == 14 && faults.values().all(|count| *count > seeds / 50), "{faults:?}");
}
