//! What the coordinator does besides merging. `cargo bench --bench farm`; figures stand in `docs/RELIABILITY.md`.

use std::sync::Arc;
use std::time::Duration;

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use photonfarm::estimate::{Declaration, Estimate, RadiusRule, Region};
use photonfarm::farm::LocalFarm;
use photonfarm::farm::access::register::Register;
use photonfarm::farm::access::scope::{Role, Scope};
use photonfarm::farm::access::secret::SecretHash;
use photonfarm::farm::access::token::Token;
use photonfarm::farm::access::user::User;
use photonfarm::farm::access::worker_secret::WorkerSecrets;
use photonfarm::farm::ids::{JobId, WorkerId};
use photonfarm::farm::job::{Priority, StopRule};
use photonfarm::farm::rules::check::CheckShare;
use photonfarm::farm::rules::plan::Plan;
use photonfarm::farm::rules::terms::Terms;
use photonfarm::farm::rules::{Answer, Event, Outcome, Rules, RulesOptions};
use photonfarm::farm::snapshot::{FieldKey, Snapshot, SnapshotField};
use photonfarm::farm::wire::BUILD;
use photonfarm::farm::wire::messages::RegisterRequest;
use photonfarm::render::Guides;
use prost::Message;

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
const WORKERS: usize = 500;
const JOBS: u64 = 100;
const USERS: u64 = 1000;

fn main() {
    divan::main();
}

/// The state of a job of `sppm`.
fn snapshot() -> Snapshot {
    let region = Region { row_start: 0, row_end: HEIGHT };
    let first: Vec<f32> = (0..WIDTH * HEIGHT).map(|pixel| 1e-4 + 1e-9 * pixel as f32).collect();
    let declaration = Arc::new(Declaration::gathering(RadiusRule::Statistics, 2.0 / 3.0));
    let estimate = Estimate::new(WIDTH, HEIGHT, &[region], declaration, &first).expect("one radius per pixel");
    let field = SnapshotField { key: FieldKey { epoch: 0, region: 0 }, field: estimate.radius_field(region) };
    let plan = Plan::new(WIDTH, HEIGHT, 4_000_000, Some(1000), RadiusRule::Statistics);
    Snapshot { plan, estimate, merged: 0, next_look: 2, error: None, fields: vec![field], guides: Guides::default() }
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn encode_a_1920_by_1080_snapshot(bencher: Bencher<'_, '_>) {
    let snapshot = snapshot();
    let bytes = snapshot.encode().expect("a snapshot").len();
    bencher.counter(BytesCount::new(bytes)).bench_local(|| black_box(&snapshot).encode().expect("a snapshot"));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn decode_a_1920_by_1080_snapshot(bencher: Bencher<'_, '_>) {
    let bytes = snapshot().encode().expect("a snapshot");
    let count = BytesCount::new(bytes.len());
    bencher.counter(count).bench_local(|| Snapshot::decode(black_box(&bytes)).expect("just encoded"));
}

/// Rules with many workers and many jobs whose pilots are done.
fn busy_rules() -> (Rules, Vec<WorkerId>) {
    let mut rules = Rules::new(RulesOptions {
        lease_duration: Duration::from_secs(15),
        memory_budget: u64::MAX,
        early_budget: u64::MAX,
        check_share: CheckShare::new(0.01),
        first_id: 1,
    });
    let now = Duration::from_secs(1);
    let mut workers = Vec::new();
    for index in 0..WORKERS {
        let joined = rules.apply(now, Event::WorkerJoined { name: format!("w{index}"), threads: 1 });
        let Answer::Joined(worker) = joined.answer else { panic!("everybody may join") };
        workers.push(worker);
    }
    for job in (1..=JOBS).map(JobId::new) {
        let stop = StopRule { passes: Some(1 << 30), ..StopRule::default() };
        let terms = Terms { stop, priority: Priority::DEFAULT, memory: 1, chooses_method: false, notices: Vec::new() };
        rules.apply(now, Event::JobAdded { job, terms });
        let Answer::Granted(lease) = rules.apply(now, Event::LeaseWanted { worker: workers[0] }).answer else {
            panic!("every job has a pilot")
        };
        let (worker, id, fencing) = (lease.worker, lease.id, lease.fencing);
        rules.apply(now, Event::ResultCame { worker, lease: id, fencing, outcome: Outcome::Accepted(None) });
        let plan = Plan::new(64, 64, 1_000_000, Some(1 << 30), RadiusRule::Schedule);
        rules.apply(now, Event::PilotDone { job: lease.job, plan });
    }
    (rules, workers)
}

/// A lease is granted, a heartbeat heard, a result taken, for each of 500 workers with 100 jobs.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn serve_500_workers_once(bencher: Bencher<'_, '_>) {
    bencher.with_inputs(busy_rules).bench_local_values(|(mut rules, workers)| {
        let now = Duration::from_secs(2);
        for worker in workers {
            let Answer::Granted(lease) = rules.apply(now, Event::LeaseWanted { worker }).answer else {
                panic!("there is work for all")
            };
            rules.apply(now, Event::HeartbeatCame { worker, leases: vec![lease.id] });
            let (lease, fencing) = (lease.id, lease.fencing);
            rules.apply(now, Event::ResultCame { worker, lease, fencing, outcome: Outcome::Accepted(None) });
        }
        rules
    });
}

/// A farm with as many users as a large studio has, each with ten tokens.
fn register() -> Register {
    let name = |index: u64| format!("user{index}").parse().expect("a name");
    let users = (0..USERS).map(|index| User { name: name(index), role: Role::Artist, created: 0 }).collect();
    let token = |index: u64| Token {
        hash: SecretHash::of(&format!("token{index}")),
        user: Some(name(index % USERS)),
        label: String::new(),
        scope: Scope::Submit,
        created: 0,
        expires: None,
        parent: None,
    };
    Register::new(users, (0..10 * USERS).map(token).collect())
}

#[divan::bench]
fn know_a_user_among_1000(bencher: Bencher<'_, '_>) {
    let register = register();
    bencher.bench_local(|| register.caller(black_box(Some("token1234")), 1).is_ok());
}

#[divan::bench]
fn know_a_worker(bencher: Bencher<'_, '_>) {
    let secrets = WorkerSecrets::new().expect("randomness");
    let secret = secrets.issue(WorkerId::new(1 << 50), Some(SecretHash::of("join")));
    bencher.bench_local(|| secrets.check(black_box(&secret)).is_some());
}

/// What Prometheus asks for, of a coordinator with a thousand workers.
#[divan::bench(sample_count = 100, sample_size = 1)]
fn metrics_of_1000_workers(bencher: Bencher<'_, '_>) {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let farm = runtime.block_on(async {
        let farm = LocalFarm::builder().workers(0).start().await.expect("a farm");
        photonfarm::farm::tls::use_ring();
        let http = reqwest::Client::builder().no_proxy().build().expect("a client");
        for index in 0..1000 {
            let request = RegisterRequest {
                name: format!("w{index}"),
                threads: 16,
                build: BUILD.into(),
                features: String::new(),
            };
            let register = http.post(format!("{}/farm/v1/register", farm.url())).body(request.encode_to_vec());
            assert!(register.send().await.expect("an answer").status().is_success());
        }
        farm
    });
    bencher.bench_local(|| farm.client().metrics().expect("text").len());
}
