//! A coordinator under many workers: how long they wait for answers, and what memory it takes. The workers are simulated: they speak the
//! protocol over HTTP, but wait instead of tracing, and deliver empty tallies.
//!
//! ```text
//! cargo run --release --example farm_load -- [WORKERS] [JOBS] [SECONDS]
//! ```

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use photonfarm::estimate::Tally;
use photonfarm::farm::LocalFarm;
use photonfarm::farm::ids::LeaseId;
use photonfarm::farm::job::{JobRequest, StopRule};
use photonfarm::farm::prepared_scenes::prepare_scene;
use photonfarm::farm::wire::BUILD;
use photonfarm::farm::wire::lease::{LeasedWork, WorkerLease, decode_lease};
use photonfarm::farm::wire::messages::result_request::Outcome;
use photonfarm::farm::wire::messages::{
    HeartbeatRequest, HeartbeatResponse, LeaseResponse, RegisterRequest, RegisterResponse, ResultRequest,
    ResultResponse,
};
use photonfarm::farm::wire::result::{encode_pilot, encode_tally};
use photonfarm::method;
use photonfarm::render::Renderer;
use photonfarm::scene::Scene;
use prost::Message;
use tokio::time::sleep;

type Fallible<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// What a shard takes.
const SHARD: Duration = Duration::from_secs(2);
/// Until then workers wait for the pilots of jobs rather than for answers.
const WARM_UP: Duration = Duration::from_secs(15);
const HEARTBEAT: Duration = Duration::from_secs(5);

/// Seconds that answers took, by request.
type Latencies = Arc<Mutex<BTreeMap<&'static str, Vec<f64>>>>;

#[derive(Clone)]
struct Client {
    http: reqwest::Client,
    base: String,
    secret: String,
    scene: Arc<Scene>,
    latencies: Latencies,
}

impl Client {
    async fn post<A: Message + Default>(&self, path: &'static str, message: &impl Message) -> Fallible<A> {
        self.post_to(path, path, message).await
    }

    async fn post_to<A: Message + Default>(
        &self,
        name: &'static str,
        path: &str,
        message: &impl Message,
    ) -> Fallible<A> {
        let start = Instant::now();
        let request = self.http.post(format!("{}/{path}", self.base)).bearer_auth(&self.secret);
        let response = request.body(message.encode_to_vec()).send().await?;
        let status = response.status();
        let body = response.bytes().await?;
        if !status.is_success() {
            return Err(format!("{path}: {status}").into());
        }
        let mut latencies = self.latencies.lock().map_err(|problem| problem.to_string())?;
        latencies.entry(name).or_default().push(start.elapsed().as_secs_f64());
        Ok(A::decode(body)?)
    }

    /// One simulated worker, until it is dropped.
    async fn work(mut self, index: usize) -> Fallible<()> {
        let name = format!("simulated-{index}");
        let request = RegisterRequest { name, threads: 1, build: BUILD.into(), features: String::new() };
        self.secret = self.post::<RegisterResponse>("register", &request).await?.secret;
        let held: Arc<Mutex<Vec<u64>>> = Arc::default();
        let beating = self.clone().beat(held.clone());
        let working = async {
            loop {
                let Some(lease) = self.post::<LeaseResponse>("lease", &()).await?.lease else {
                    continue;
                };
                held.lock().map_err(|problem| problem.to_string())?.push(lease.id);
                let (id, fencing) = (lease.id, lease.fencing);
                let outcome = Some(self.outcome(decode_lease(lease)?)?);
                sleep(SHARD).await;
                let path = format!("leases/{id}/{fencing}/result");
                self.post_to::<ResultResponse>("result", &path, &ResultRequest { outcome }).await?;
                held.lock().map_err(|problem| problem.to_string())?.retain(|held| *held != id);
            }
        };
        tokio::select! {
            ended = beating => ended,
            ended = working => ended,
        }
    }

    async fn beat(self, held: Arc<Mutex<Vec<u64>>>) -> Fallible<()> {
        loop {
            sleep(HEARTBEAT).await;
            let leases = held.lock().map_err(|problem| problem.to_string())?.clone();
            self.post::<HeartbeatResponse>("heartbeat", &HeartbeatRequest { leases }).await?;
        }
    }

    fn outcome(&self, lease: WorkerLease) -> Fallible<Outcome> {
        let method = lease.job.method.ok_or("no method")?;
        Ok(match lease.work {
            LeasedWork::Shard(terms) => {
                let declaration = method::declaration(&method);
                Outcome::Tally(encode_tally(&Tally::zero(terms.planned.shard, lease.job.width, &declaration)))
            }
            LeasedWork::Pilot => {
                let pilot =
                    Renderer::new(self.scene.clone(), &method, lease.job.seed)?.pilot(&AtomicBool::new(false))?;
                Outcome::Pilot(encode_pilot(&pilot))
            }
            LeasedWork::Choice(_) | LeasedWork::Errand(_) => {
                return Err(format!("lease {:?}", LeaseId::new(0)).into());
            }
        })
    }
}

/// Resident memory of this process, MiB: coordinator and simulated workers.
fn resident() -> Fallible<f64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|line| line.starts_with("VmRSS")).ok_or("no VmRSS")?;
    Ok(line.split_whitespace().nth(1).ok_or("no number")?.parse::<f64>()? / 1024.0)
}

#[tokio::main]
async fn main() -> Fallible<()> {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<usize>());
    let workers = arguments.next().unwrap_or(Ok(500))?;
    let jobs = arguments.next().unwrap_or(Ok(100))?;
    let seconds = arguments.next().unwrap_or(Ok(60))? as u64;
    photonfarm::farm::tls::use_ring();

    let text = std::fs::read_to_string("scenes/cornell-diffuse/scene.xml")?;
    let bytes = text.replace(r#"name="size" value="512""#, r#"name="size" value="64""#).into_bytes();
    let farm = LocalFarm::builder().workers(0).start().await?;
    let scene = farm.client().add_scene(bytes.clone()).await?.hash;
    println!("{:.0} MiB before", resident()?);
    for seed in 0..jobs {
        let stop = StopRule { passes: Some(1 << 30), ..StopRule::default() };
        let request =
            JobRequest { method: Some("path".into()), stop, seed: seed as u64, ..JobRequest::of_scene(scene.clone()) };
        farm.client().submit(request).await?;
    }
    let client = Client {
        http: reqwest::Client::builder().no_proxy().build()?,
        base: format!("{}/farm/v1", farm.url()),
        secret: String::new(),
        scene: Arc::new(prepare_scene(&bytes)?),
        latencies: Latencies::default(),
    };
    let mut running = tokio::task::JoinSet::new();
    for index in 0..workers {
        running.spawn(client.clone().work(index));
    }
    let measure = async {
        sleep(WARM_UP).await;
        if let Ok(mut latencies) = client.latencies.lock() {
            latencies.clear();
        }
        sleep(Duration::from_secs(seconds)).await;
    };
    tokio::select! {
        () = measure => {}
        Some(ended) = running.join_next() => ended??,
    }
    println!("{:.0} MiB with {jobs} running jobs and {workers} workers", resident()?);
    let latencies = std::mem::take(&mut *client.latencies.lock().map_err(|problem| problem.to_string())?);
    for (request, mut seconds) in latencies {
        seconds.sort_by(f64::total_cmp);
        let quantile = |share: f64| 1000.0 * seconds[(share * (seconds.len() - 1) as f64) as usize];
        println!(
            "{request:10} {:6} answers, p50 {:6.1} ms, p99 {:6.1} ms, longest {:6.1} ms",
            seconds.len(),
            quantile(0.5),
            quantile(0.99),
            quantile(1.0)
        );
    }
    let silent = farm.client().journal(0, None, 1000).await?.iter().filter(|row| row.text.contains("silent")).count();
    println!("{silent} workers were thought silent");
    running.shutdown().await;
    farm.stop().await;
    Ok(())
}
