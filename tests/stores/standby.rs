//! Two coordinators on one PostgreSQL database and one S3-compatible store: one leads, the other takes over when that one is killed or hangs.
//!
//! `tools/with_postgres.sh tools/with_s3.sh cargo test --test stores`; without servers there is nothing to test on.

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::ONE_AT_A_TIME;
use crate::http_client::http_client;
use crate::records::{empty, open};
use photonfarm::estimate::picture_files::decode_exr;
use photonfarm::farm::LocalFarm;
use photonfarm::farm::job::{JobRequest, StopRule};
use photonfarm::farm::store::{RecordsLocation, StoreLocation};
use serde_json::{Value, json};
use tokio::time::sleep;

const PROGRAM: &str = env!("CARGO_BIN_EXE_photonfarm");
const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");
/// Photons of a pass: few, so that a pass takes milliseconds.
const PHOTONS: u32 = 2000;
/// How long anything may take before the test gives up.
const PATIENCE: Duration = Duration::from_secs(120);
/// How long nobody may lead.
const FAILOVER: Duration = Duration::from_secs(20);

/// A coordinator of its own process, with a folder of its own.
struct Coordinator {
    process: Child,
    url: String,
    http: reqwest::Client,
}

impl Coordinator {
    fn start(folder: &Path, port: u16, blobs: &str) -> Self {
        let database = std::env::var("PHOTONFARM_TEST_POSTGRES").expect("a database");
        let process = Command::new(PROGRAM)
            .args(["serve", "--listen", &format!("127.0.0.1:{port}"), "--snapshot-interval", "0.5", "--data"])
            .arg(folder)
            .args(["--database", &database, "--blobs", blobs])
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let http = http_client(Duration::from_secs(30));
        Self { process, url: format!("http://127.0.0.1:{port}"), http }
    }

    async fn get(&self, path: &str) -> Option<(u16, Vec<u8>)> {
        let response = self.http.get(format!("{}{path}", self.url)).send().await.ok()?;
        Some((response.status().as_u16(), response.bytes().await.ok()?.to_vec()))
    }

    async fn status(&self, path: &str) -> u16 {
        self.get(path).await.map_or(0, |(status, _)| status)
    }

    /// Waits until it leads; answers how long that took.
    async fn leads(&self) -> Duration {
        let start = Instant::now();
        while self.status("/readyz").await != 200 {
            assert!(start.elapsed() < PATIENCE, "{} never leads", self.url);
            sleep(Duration::from_millis(50)).await;
        }
        start.elapsed()
    }

    async fn stands_by(&self) {
        let start = Instant::now();
        while self.status("/healthz").await != 200 {
            assert!(start.elapsed() < PATIENCE, "{} does not answer", self.url);
            sleep(Duration::from_millis(50)).await;
        }
        assert_eq!(self.status("/readyz").await, 503);
        let (status, body) = self.get("/v1/jobs").await.expect("an answer");
        assert!(status == 503 && String::from_utf8_lossy(&body).contains("standing-by"));
    }

    fn signal(&self, signal: &str) {
        let id = self.process.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().expect("kill is there").success());
    }

    async fn submit(&self, passes: u32, seed: u64) -> String {
        let job = json!({ "scene_inline": SCENE, "method": "sppm", "parameters": { "photons_per_pass": PHOTONS },
            "seed": seed, "stop": { "passes": passes } });
        let request = self.http.post(format!("{}/v1/jobs", self.url)).header("Content-Type", "application/json");
        let response = request.body(job.to_string()).send().await.expect("an answer");
        assert_eq!(response.status(), 202);
        let job: Value = serde_json::from_slice(&response.bytes().await.expect("a body")).expect("JSON");
        job["id"].as_str().expect("an id").to_owned()
    }

    async fn job(&self, id: &str) -> Value {
        let (_, body) = self.get(&format!("/v1/jobs/{id}")).await.expect("an answer");
        serde_json::from_slice(&body).expect("JSON")
    }

    async fn passes(&self, id: &str, at_least: u64) {
        let start = Instant::now();
        while self.job(id).await["passes_done"].as_u64().unwrap_or_default() < at_least {
            assert!(start.elapsed() < PATIENCE, "job {id} does not go on");
            sleep(Duration::from_millis(50)).await;
        }
    }

    /// The picture's bits when the job is done.
    async fn bits(&self, id: &str) -> Vec<u32> {
        let start = Instant::now();
        while self.job(id).await["state"] != "done" {
            assert!(start.elapsed() < PATIENCE, "job {id} does not end");
            sleep(Duration::from_millis(50)).await;
        }
        let (_, bytes) = self.get(&format!("/v1/jobs/{id}/image.exr")).await.expect("an answer");
        let picture = decode_exr(&bytes).expect("an EXR");
        picture.radiance.iter().flatten().map(|value| value.to_bits()).collect()
    }
}

impl Drop for Coordinator {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Workers that know both addresses; they end when this is dropped.
struct Workers(Vec<Child>);

impl Workers {
    fn start(addresses: &str) -> Self {
        let worker = |index: usize| {
            let name = format!("worker-{index}");
            let arguments = ["worker", "--coordinator", addresses, "--threads", "1", "--name", &name];
            Command::new(PROGRAM).args(arguments).stderr(Stdio::null()).spawn().expect("the program starts")
        };
        Self((1..=2).map(worker).collect())
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        for worker in &mut self.0 {
            // It may have ended already.
            let _ = worker.kill();
            let _ = worker.wait();
        }
    }
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a port").port()
}

/// What a quiet farm makes of the same job.
async fn quiet_bits(passes: u32, seed: u64) -> Vec<u32> {
    let farm = LocalFarm::builder().workers(2).start().await.expect("a farm");
    let scene = farm.client().add_scene(SCENE.as_bytes().to_vec()).await.expect("a scene").hash;
    let stop = StopRule { passes: Some(passes), ..StopRule::default() };
    let mut request = JobRequest { stop, seed, method: Some("sppm".to_owned()), ..JobRequest::of_scene(scene) };
    request.parameters.insert("photons_per_pass".to_owned(), PHOTONS.into());
    let job = farm.client().submit(request).await.expect("a job");
    let mut status = farm.client().watch(job).expect("it is there");
    status.wait_for(|status| status.state.is_final()).await.expect("it ends");
    let (picture, _) = farm.client().picture(job).await.expect("a picture");
    picture.radiance.iter().flatten().map(|value| value.to_bits()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_standby_takes_over_and_no_bit_changes() {
    let _turn = ONE_AT_A_TIME.lock().await;
    let environment = |name: &str| std::env::var(name).ok();
    let (Some(database), Some(bucket)) = (environment("PHOTONFARM_TEST_POSTGRES"), environment("PHOTONFARM_TEST_S3"))
    else {
        println!("PHOTONFARM_TEST_POSTGRES or PHOTONFARM_TEST_S3 is not set: no standby is tested");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    // Other tests leave users and scenes that no coordinator would write.
    let records = RecordsLocation::Postgres(database);
    let store = open(&StoreLocation { records, ..StoreLocation::folder(folder.path().join("emptied")) }).await;
    empty(&store).await;
    store.close().await;
    let blobs = format!("{bucket}/standby-{}", std::process::id());
    let places = ["a", "b"].map(|name| folder.path().join(name));
    let ports = [free_port(), free_port()];
    let mut first = Coordinator::start(&places[0], ports[0], &blobs);
    first.leads().await;
    let mut second = Coordinator::start(&places[1], ports[1], &blobs);
    second.stands_by().await;
    let _workers = Workers::start(&format!("{},{}", first.url, second.url));
    let passes = [3000, 2000];
    let jobs = [first.submit(passes[0], 1).await, first.submit(passes[1], 2).await];
    first.passes(&jobs[0], 200).await;

    // The leader is killed under load.
    first.process.kill().expect("it runs");
    first.process.wait().expect("it ends");
    let without_leader = second.leads().await;
    println!("nobody led for {:.1} s after a kill", without_leader.as_secs_f64());
    assert!(without_leader < FAILOVER, "{without_leader:?}");
    second.passes(&jobs[0], 600).await;

    // The leader hangs, and wakes up when somebody else leads.
    let first = Coordinator::start(&places[0], ports[0], &blobs);
    first.stands_by().await;
    second.signal("-STOP");
    let without_leader = first.leads().await;
    println!("nobody led for {:.1} s after a hang", without_leader.as_secs_f64());
    assert!(without_leader < FAILOVER, "{without_leader:?}");
    second.signal("-CONT");
    let said: Vec<String> =
        BufReader::new(second.process.stderr.take().expect("a pipe")).lines().map_while(Result::ok).collect();
    assert_eq!(second.process.wait().expect("it ends").code(), Some(1));
    assert!(said.iter().any(|line| line.contains("another coordinator leads")), "{said:?}");

    for (job, (passes, seed)) in jobs.iter().zip(passes.into_iter().zip([1, 2])) {
        assert!(first.bits(job).await == quiet_bits(passes, seed).await, "job {job} has other bits");
    }

    // Who leaves in order hands over at once.
    let second = Coordinator::start(&places[1], ports[1], &blobs);
    second.stands_by().await;
    first.signal("-TERM");
    let without_leader = second.leads().await;
    assert!(without_leader < FAILOVER, "{without_leader:?}");
    println!("nobody led for {:.1} s after an orderly end", without_leader.as_secs_f64());
    assert_eq!(second.job(&jobs[0]).await["state"], "done");
}
