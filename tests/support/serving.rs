//! Coordinators and workers as processes of their own.

use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use tokio::time::{Instant, sleep};

use super::http_client::http_client;

const PROGRAM: &str = env!("CARGO_BIN_EXE_photonfarm");
const PATIENCE: Duration = Duration::from_secs(120);

/// Waits until `holds` answers true.
pub(crate) async fn wait_for(what: &str, holds: impl AsyncFn() -> bool) {
    let start = Instant::now();
    while !holds().await {
        assert!(start.elapsed() < PATIENCE, "no {what} in time");
        sleep(Duration::from_millis(20)).await;
    }
}

/// A coordinator that can be killed and started again on the same store and port.
pub(crate) struct Coordinator {
    process: Child,
    data: PathBuf,
    port: u16,
    workers: usize,
    http: reqwest::Client,
}

impl Coordinator {
    pub(crate) async fn start(data: &Path, workers: usize) -> Self {
        let port = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a port").port();
        let http = http_client(Duration::from_secs(60));
        let process = serve(data, port, workers);
        let coordinator = Self { process, data: data.to_owned(), port, workers, http };
        coordinator.wait_until_it_answers().await;
        coordinator
    }

    pub(crate) fn url(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    /// As the system's `kill -9` does it.
    pub(crate) fn kill(&mut self) {
        self.process.kill().expect("it runs");
        self.process.wait().expect("it ends");
    }

    /// As Ctrl-C does it; answers what it said.
    pub(crate) fn interrupt(&mut self) -> String {
        let id = self.process.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill is there").success());
        let mut said = String::new();
        self.process.stderr.take().expect("a pipe").read_to_string(&mut said).expect("text");
        self.process.wait().expect("it ends");
        said
    }

    pub(crate) async fn restart(&mut self) {
        self.process = serve(&self.data, self.port, self.workers);
        self.wait_until_it_answers().await;
    }

    async fn wait_until_it_answers(&self) {
        let ask = async || self.http.get(format!("{}/healthz", self.url())).send().await.is_ok();
        wait_for("coordinator", ask).await;
    }

    pub(crate) async fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        let request = self.http.post(format!("{}{path}", self.url())).header("Content-Type", "application/json");
        let response = request.body(body.to_string()).send().await.expect("an answer");
        let status = response.status().as_u16();
        (status, serde_json::from_slice(&response.bytes().await.expect("a body")).unwrap_or_default())
    }

    pub(crate) async fn delete(&self, path: &str) -> u16 {
        self.http.delete(format!("{}{path}", self.url())).send().await.expect("an answer").status().as_u16()
    }

    pub(crate) async fn submit(&self, job: &Value) -> String {
        let (status, job) = self.post("/v1/jobs", job).await;
        assert_eq!(status, 202, "{job}");
        job["id"].as_str().expect("an id").to_owned()
    }

    async fn get(&self, path: &str) -> Vec<u8> {
        let response = self.http.get(format!("{}{path}", self.url())).send().await.expect("an answer");
        assert!(response.status().is_success(), "{path}: {}", response.status());
        response.bytes().await.expect("a body").to_vec()
    }

    pub(crate) async fn job(&self, id: &str) -> Value {
        serde_json::from_slice(&self.get(&format!("/v1/jobs/{id}")).await).expect("JSON")
    }

    pub(crate) async fn sequence(&self, id: &str) -> Value {
        serde_json::from_slice(&self.get(&format!("/v1/sequences/{id}")).await).expect("JSON")
    }

    pub(crate) async fn jobs(&self) -> Vec<Value> {
        let list: Value = serde_json::from_slice(&self.get("/v1/jobs").await).expect("JSON");
        list["jobs"].as_array().expect("a list").clone()
    }

    /// The pixels of the picture so far. The file's header is left out: it names the job.
    pub(crate) async fn picture(&self, id: &str) -> Vec<u8> {
        let bytes = self.get(&format!("/v1/jobs/{id}/image.exr")).await;
        let picture = photonfarm::estimate::picture_files::decode_exr(&bytes).expect("an EXR");
        picture.radiance.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
    }

    pub(crate) async fn picture_when_done(&self, id: &str) -> Vec<u8> {
        let is_done = async || {
            let job = self.job(id).await;
            assert!(job["state"] != "failed" && job["state"] != "cancelled", "{job}");
            job["state"] == "done"
        };
        wait_for("end", is_done).await;
        self.picture(id).await
    }
}

impl Drop for Coordinator {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn serve(data: &Path, port: u16, workers: usize) -> Child {
    Command::new(PROGRAM)
        .args(["serve", "--listen", &format!("127.0.0.1:{port}"), "--snapshot-interval", "0.2", "--threads", "1"])
        .args(["--workers", &workers.to_string(), "--data"])
        .arg(data)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

/// A worker that can be killed.
pub(crate) struct WorkerProcess(Child);

impl WorkerProcess {
    pub(crate) fn start(coordinator: &Coordinator, name: &str) -> Self {
        let url = coordinator.url();
        let arguments = ["worker", "--coordinator", &url, "--threads", "1", "--name", name];
        Self(Command::new(PROGRAM).args(arguments).stderr(Stdio::null()).spawn().expect("the program starts"))
    }

    pub(crate) fn kill(mut self) {
        self.0.kill().expect("it runs");
    }
}

impl Drop for WorkerProcess {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
