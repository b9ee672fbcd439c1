//! The farm's real HTTP code, from the worker's client to the coordinator's store, on a simulated network: connections that are cut in one
//! or both directions, held, slow; coordinators and workers that crash in the middle and come back.
//!
//! A seed fixes all that the network does; only how long the database takes is the machine's. `PHOTONFARM_NETWORK_SEED=17` runs that one
//! alone, with a line a fault; `PHOTONFARM_NETWORK_SEEDS=2000` runs more of them.

use std::error::Error;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::seeds::{Faults, Schedules, run_seeds};
use crate::split_mix::Random;
use axum::Router;
use axum::serve::Listener;
use photonfarm::farm::dial::Dialer;
use photonfarm::farm::ids::JobId;
use photonfarm::farm::job::{JobRequest, JobState, StopRule};
use photonfarm::farm::prepared_scenes::PreparedScenes;
use photonfarm::farm::store::{Store, StoreError, StoreLocation};
use photonfarm::farm::worker::{WorkerOptions, run_worker};
use photonfarm::farm::{CoordinatorHandle, CoordinatorOptions, LocalFarm, http};
use serde_json::json;
use tokio_util::sync::CancellationToken;
use turmoil::net::{TcpListener, TcpStream};

/// Schedules of a usual run.
const SEEDS: u64 = 200;
/// Faults happen until then, seconds of simulated time.
const FAULTS_UNTIL: f64 = 60.0;
/// Every job ends until then, seconds of simulated time, or at least within [`PATIENCE`].
const END: f64 = 900.0;
/// Simulated time runs ahead of a database whose disk is busy, so it has at least so much of the machine's.
const PATIENCE: Duration = Duration::from_secs(120);
/// After so many seconds a coordinator that gave up is started again.
const RESTART: f64 = 1.0;
const TICK: Duration = Duration::from_millis(10);
const LEASE: Duration = Duration::from_secs(4);
const PORT: u16 = 80;
const COORDINATOR: &str = "coordinator";

/// A closed white room with a lamp, 16 × 12 pixels.
const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, 0, 3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="16"/> <integer name="height" value="12"/> <rfilter type="box"/>
    </film>
  </sensor>
  <bsdf type="diffuse" id="plaster"><rgb name="reflectance" value="0.7, 0.6, 0.5"/></bsdf>
  <shape type="cube"><transform name="to_world"><scale value="4"/></transform> <ref id="plaster"/></shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="0.99"/></transform>
    <emitter type="area"><rgb name="radiance" value="3, 2.7, 2.2"/></emitter>
  </shape>
</scene>"#;

type Fallible<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Two jobs of different length, one whose radii depend on what was merged and one without radii.
fn requests(scene: &str) -> [JobRequest; 2] {
    let parameters = serde_json::Map::from_iter([("photons_per_pass".to_owned(), json!(300))]);
    let passes = |passes| StopRule { passes: Some(passes), ..StopRule::default() };
    let named = |name: &str, method: &str| {
        let request = JobRequest::of_scene(scene.to_owned());
        JobRequest { name: Some(name.to_owned()), method: Some(method.to_owned()), ..request }
    };
    let long = JobRequest { parameters, stop: passes(90), ..named("long", "sppm") };
    [long, JobRequest { stop: passes(20), ..named("short", "path") }]
}

/// Submits what was not accepted yet: a coordinator may have crashed before it answered.
async fn submit_all(coordinator: &CoordinatorHandle) -> Fallible<()> {
    let scene = coordinator.add_scene(SCENE.into()).await?.hash;
    for request in requests(&scene) {
        if !coordinator.jobs().iter().any(|job| job.name == request.name) {
            coordinator.submit(request).await?;
        }
    }
    Ok(())
}

/// The bits of all pictures, once every job is done.
async fn bits(coordinator: &CoordinatorHandle) -> Fallible<Vec<u32>> {
    let mut bits = Vec::new();
    for job in coordinator.jobs() {
        let id: JobId = job.id.parse()?;
        let mut status = coordinator.watch(id)?;
        let state = status.wait_for(|status| status.state.is_final()).await?.state;
        assert_eq!(state, JobState::Done, "job {id}");
        let (picture, _) = coordinator.picture(id).await?;
        bits.extend(picture.radiance.iter().flatten().map(|value| value.to_bits()));
    }
    Ok(bits)
}

/// What the coordinator made in the end.
type Made = Arc<Mutex<Option<Vec<u32>>>>;

async fn run_coordinator(folder: PathBuf, made: Made) -> Fallible<()> {
    let store = Store::open(&StoreLocation::folder(&folder)).await?;
    let options = CoordinatorOptions {
        lease_duration: LEASE,
        snapshot_interval: Duration::from_secs(2),
        check_share: 0.1,
        ..CoordinatorOptions::default()
    };
    let coordinator = CoordinatorHandle::start(options, store).await?;
    let listener = Simulated(TcpListener::bind((Ipv4Addr::UNSPECIFIED, PORT)).await?);
    let application = Router::new().nest("/farm/v1", http::router(coordinator.clone()));
    let work = async {
        submit_all(&coordinator).await?;
        *made.lock().expect("no panic") = Some(bits(&coordinator).await?);
        std::future::pending::<Fallible<()>>().await
    };
    tokio::select! {
        ended = axum::serve(listener, application) => Ok(ended?),
        ended = work => ended,
    }
}

/// Whether the database had no connection to give in time: simulated time does not wait for a busy disk.
fn is_starved(problem: &(dyn Error + 'static)) -> bool {
    let mut cause = Some(problem);
    while let Some(error) = cause {
        let is_timeout = |error: &sqlx::Error| matches!(error, sqlx::Error::PoolTimedOut);
        let found = match error.downcast_ref::<StoreError>() {
            Some(StoreError::Open { problem, .. }) => *problem == sqlx::Error::PoolTimedOut.to_string(),
            Some(StoreError::Records(error)) => is_timeout(error),
            _ => error.downcast_ref::<sqlx::Error>().is_some_and(is_timeout),
        };
        if found {
            return true;
        }
        cause = error.source();
    }
    false
}

/// Turmoil's listener as axum wants one.
struct Simulated(TcpListener);

impl Listener for Simulated {
    type Io = TcpStream;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (TcpStream, SocketAddr) {
        self.0.accept().await.expect("simulated connections can be accepted")
    }

    fn local_addr(&self) -> std::io::Result<SocketAddr> {
        self.0.local_addr()
    }
}

async fn run_simulated_worker(name: String) -> turmoil::Result {
    let options = WorkerOptions {
        coordinator: format!("http://{COORDINATOR}"),
        name,
        threads: 1,
        token: None,
        scenes: PreparedScenes::new(1),
        dialer: Dialer::new(|_| TcpStream::connect((COORDINATOR, PORT))),
    };
    Ok(run_worker(options, CancellationToken::new()).await?)
}

/// What ends a fault.
#[derive(Clone, Debug)]
enum Remedy {
    Start(String),
    Repair(String),
    Release(String),
    SpeedUp(String),
}

struct Network<'a> {
    sim: turmoil::Sim<'a>,
    random: Random,
    workers: Vec<String>,
    /// When which fault ends, seconds.
    remedies: Vec<(f64, Remedy)>,
    faults: Faults,
    is_told: bool,
}

impl Network<'_> {
    fn now(&self) -> f64 {
        self.sim.elapsed().as_secs_f64()
    }

    /// Something bad happens; it ends after some seconds.
    fn fault(&mut self) {
        let worker = self.workers[self.random.below(self.workers.len() as u64) as usize].clone();
        let end = self.now() + 0.2 + self.random.below(1 << 10) as f64 / 100.0;
        let (name, remedy) = match self.random.below(8) {
            0 => {
                self.sim.crash(COORDINATOR);
                ("coordinators crashed", Remedy::Start(COORDINATOR.to_owned()))
            }
            1 | 2 => {
                self.sim.crash(worker.as_str());
                ("workers crashed", Remedy::Start(worker))
            }
            3 => {
                self.sim.partition(worker.as_str(), COORDINATOR);
                ("workers cut off", Remedy::Repair(worker))
            }
            4 | 5 if self.random.chance(50) => {
                self.sim.partition_oneway(worker.as_str(), COORDINATOR);
                ("requests lost", Remedy::Repair(worker))
            }
            4 | 5 => {
                self.sim.partition_oneway(COORDINATOR, worker.as_str());
                ("answers lost", Remedy::Repair(worker))
            }
            6 => {
                self.sim.hold(worker.as_str(), COORDINATOR);
                ("messages held", Remedy::Release(worker))
            }
            _ => {
                self.sim.set_link_max_message_latency(worker.as_str(), COORDINATOR, Duration::from_secs(3));
                ("links slow", Remedy::SpeedUp(worker))
            }
        };
        if self.is_told {
            println!("{:8.2} {name}, until {end:.2}: {remedy:?}", self.now());
        }
        *self.faults.entry(name).or_default() += 1;
        self.remedies.push((end, remedy));
    }

    /// Ends the faults whose time has come; a coordinator that gave up by itself is started again soon.
    fn heal(&mut self) {
        let now = self.now();
        let is_start = |remedy: &Remedy| matches!(remedy, Remedy::Start(host) if host == COORDINATOR);
        if !self.sim.is_host_running(COORDINATOR) && !self.remedies.iter().any(|(_, remedy)| is_start(remedy)) {
            self.remedies.push((now + RESTART, Remedy::Start(COORDINATOR.to_owned())));
        }
        let (over, rest) = std::mem::take(&mut self.remedies).into_iter().partition(|(end, _)| *end <= now);
        self.remedies = rest;
        let over: Vec<(f64, Remedy)> = over;
        for (_, remedy) in over {
            match remedy {
                Remedy::Start(host) if self.sim.is_host_running(host.as_str()) => {}
                Remedy::Start(host) => self.sim.bounce(host.as_str()),
                Remedy::Repair(worker) => self.sim.repair(worker.as_str(), COORDINATOR),
                Remedy::Release(worker) => self.sim.release(worker.as_str(), COORDINATOR),
                Remedy::SpeedUp(worker) => {
                    self.sim.set_link_max_message_latency(worker.as_str(), COORDINATOR, LATENCY);
                }
            }
        }
    }
}

/// The longest way of a message where nothing is wrong.
const LATENCY: Duration = Duration::from_millis(600);

/// Runs a schedule until all jobs are done; answers their bits and the faults that were met.
fn simulate(seed: u64, is_told: bool, folder: &Path) -> (Vec<u32>, Faults) {
    let mut random = Random(seed);
    let made = Made::default();
    let mut builder = turmoil::Builder::new();
    builder.rng_seed(seed).tick_duration(TICK).simulation_duration(Duration::MAX);
    builder.min_message_latency(TICK).max_message_latency(LATENCY).tcp_capacity(1 << 10);
    let mut sim = builder.build();
    let seen = made.clone();
    let folder = folder.to_owned();
    // A task of its own: what it holds when it crashes is dropped inside its runtime.
    sim.host(COORDINATOR, move || {
        let coordinator = run_coordinator(folder.clone(), seen.clone());
        async {
            match tokio::spawn(coordinator).await? {
                // Whoever keeps a coordinator running starts it again: see `heal`.
                Err(problem) if is_starved(problem.as_ref()) => Ok(()),
                ended => ended.map_err(|problem| problem.to_string().into()),
            }
        }
    });
    let workers: Vec<String> = (0..1 + random.below(4)).map(|index| format!("worker-{index}")).collect();
    for name in workers.clone() {
        sim.host(name.clone(), move || run_simulated_worker(name.clone()));
    }
    let mut network =
        Network { sim, random, workers: workers.clone(), remedies: Vec::new(), faults: Faults::new(), is_told };
    let (mut next_fault, begun) = (1.0, Instant::now());
    while network.now() < END || begun.elapsed() < PATIENCE {
        if network.now() > END {
            std::thread::sleep(TICK);
        }
        if network.now() >= next_fault && network.now() < FAULTS_UNTIL {
            network.fault();
            next_fault = network.now() + network.random.below(1 << 10) as f64 / 200.0;
        }
        network.heal();
        network.sim.step().unwrap_or_else(|problem| panic!("seed {seed}: {problem}"));
        if let Some(bits) = made.lock().expect("no panic").take() {
            if is_told {
                println!("{:8.2} all jobs are done", network.now());
            }
            return (bits, network.faults);
        }
    }
    panic!("seed {seed}: the jobs do not end");
}

/// What a farm makes to which nothing happens, over real connections.
fn undisturbed() -> Vec<u32> {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    runtime.block_on(async {
        let farm = LocalFarm::builder().start().await.expect("a free port");
        submit_all(farm.client()).await.expect("good jobs");
        let bits = bits(farm.client()).await.expect("pictures");
        farm.stop().await;
        bits
    })
}

#[test]
fn no_fault_of_the_network_loses_a_job_or_changes_a_bit() {
    let expected = undisturbed();
    let folder = tempfile::tempdir().expect("a folder");
    let run = |seed: u64, is_told: bool| {
        let (bits, faults) = simulate(seed, is_told, &folder.path().join(seed.to_string()));
        assert!(bits == expected, "seed {seed}: other bits than over a quiet network");
        faults
    };
    let Some(Schedules { seeds, faults }) = run_seeds("PHOTONFARM_NETWORK_SEED", SEEDS, run) else { return };
    assert_eq!(faults.len(), 7, "{seeds} schedules meet every kind of fault: {faults:?}");
}
