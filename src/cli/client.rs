//! The API as the subcommands use it.

mod members;
mod picture;
mod sequences;
mod workers;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use clap::Args;
use reqwest::header::{HeaderMap, HeaderValue};
use reqwest::redirect::Policy;
use reqwest::{Method, Request, RequestBuilder, Response, StatusCode, Url, header};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub(super) use picture::Fetched;

use super::exit_code::CliError;
use super::frames::is_sequence;
use super::token_option::TokenOption;
use super::trust_options::TrustOptions;
use crate::api::job_control::{CloneRequest, JobPatch};
use crate::api::jobs::{JobSubmission, JobsQuery};
use crate::api::problem::Problem;
use crate::farm::SceneSummary;
use crate::farm::access::secret::Secret;
use crate::farm::dial::TlsSettings;
use crate::farm::job::{JobStatus, StopRule};
use crate::farm::tls;

/// How often in a row a broken stream of events is opened again.
const RECONNECTS: u32 = 10;
/// The pause before that.
const RECONNECT_PAUSE: Duration = Duration::from_secs(1);

/// How long a coordinator may take to say whether it leads, where several may.
const LOOK_PATIENCE: Duration = Duration::from_secs(3);

/// Which coordinator to speak to.
#[derive(Clone, Debug, Args)]
pub(super) struct CoordinatorOption {
    /// Address of the coordinator; of several that stand in for each other, separated by commas.
    #[arg(long, env = "PHOTONFARM_URL", default_value = "http://127.0.0.1:8080", value_name = "URL")]
    coordinator: String,
    #[command(flatten)]
    token: TokenOption,
    #[command(flatten)]
    trust: TrustOptions,
}

impl CoordinatorOption {
    pub(super) fn client(&self) -> Result<Client, CliError> {
        let tls = self.trust.settings(&self.coordinator)?;
        Client::new(&self.coordinator, self.token.read()?.as_ref(), tls)
    }
}

/// A connection to a coordinator.
#[derive(Clone, Debug)]
pub(super) struct Client {
    http: reqwest::Client,
    bases: Vec<Url>,
    /// Which of them answered last.
    current: Arc<AtomicUsize>,
    /// Whether it was seen to lead.
    is_found: Arc<AtomicBool>,
}

#[derive(Deserialize)]
struct UploadedScene {
    hash: String,
}

#[derive(Deserialize)]
struct JobList {
    jobs: Vec<JobStatus>,
}

#[derive(Deserialize)]
struct SceneList {
    scenes: Vec<SceneSummary>,
}

impl Client {
    pub(super) fn new(base: &str, token: Option<&Secret>, tls: Option<Arc<TlsSettings>>) -> Result<Self, CliError> {
        let bases = base.split(',').map(|base| address(base.trim())).collect::<Result<Vec<_>, _>>()?;
        tls::use_ring();
        // Coordinators stand in the same network; a proxy would only be in the way of live events.
        let builder = reqwest::Client::builder();
        let builder = match tls {
            Some(settings) => builder.tls_backend_preconfigured(Arc::unwrap_or_clone(settings)),
            // Plain HTTP: no certificates are looked for, which small systems do not have.
            None => builder.tls_certs_only([]),
        };
        let http = builder
            .no_proxy()
            // No coordinator sends anybody elsewhere, and the token is for this one.
            .redirect(Policy::none())
            .connect_timeout(Duration::from_secs(10))
            .default_headers(authorization(token)?)
            .build();
        let http = http.map_err(|error| CliError::Failed(format!("cannot start the HTTP client: {error}")))?;
        Ok(Self { http, bases, current: Arc::default(), is_found: Arc::default() })
    }

    /// Uploads a scene and tells its hash.
    pub(super) async fn upload_scene(&self, bytes: Vec<u8>) -> Result<String, CliError> {
        let request = self.request(Method::POST, "/v1/scenes").body(bytes);
        Ok(self.json::<UploadedScene>(request).await?.hash)
    }

    pub(super) async fn submit(&self, submission: &JobSubmission) -> Result<JobStatus, CliError> {
        self.send_json(Method::POST, "/v1/jobs", submission).await
    }

    pub(super) async fn job(&self, id: &str) -> Result<JobStatus, CliError> {
        self.json(self.request(Method::GET, &job_path(id, "")?)).await
    }

    pub(super) async fn jobs(&self, query: &JobsQuery) -> Result<Vec<JobStatus>, CliError> {
        Ok(self.json::<JobList>(self.request(Method::GET, "/v1/jobs").query(query)).await?.jobs)
    }

    pub(super) async fn clone_job(&self, id: &str, changes: &CloneRequest) -> Result<JobStatus, CliError> {
        self.send_json(Method::POST, &job_path(id, "/clone")?, changes).await
    }

    pub(super) async fn scenes(&self) -> Result<Vec<SceneSummary>, CliError> {
        Ok(self.json::<SceneList>(self.request(Method::GET, "/v1/scenes")).await?.scenes)
    }

    /// Asks an address that answers with 200 when all is well.
    pub(super) async fn check(&self, path: &str) -> Result<(), CliError> {
        accepted(self.send(self.request(Method::GET, path)).await?).await?;
        Ok(())
    }

    /// Does something to a job that needs no more than its name (`/cancel`, `/pause`, `/resume`).
    pub(super) async fn control(&self, id: &str, what: &str) -> Result<JobStatus, CliError> {
        self.json(self.request(Method::POST, &job_path(id, what)?)).await
    }

    pub(super) async fn extend(&self, id: &str, stop: &StopRule) -> Result<JobStatus, CliError> {
        self.send_json(Method::POST, &job_path(id, "/extend")?, stop).await
    }

    pub(super) async fn change(&self, id: &str, patch: &JobPatch) -> Result<JobStatus, CliError> {
        self.send_json(Method::PATCH, &job_path(id, "")?, patch).await
    }

    pub(super) async fn delete_job(&self, id: &str) -> Result<(), CliError> {
        accepted(self.send(self.request(Method::DELETE, &job_path(id, "")?)).await?).await?;
        Ok(())
    }

    pub(super) async fn delete_scene(&self, hash: &str) -> Result<(), CliError> {
        let path = format!("/v1/scenes/{}", checked_name(hash, "a scene's hash; `photonfarm scenes`")?);
        accepted(self.send(self.request(Method::DELETE, &path)).await?).await?;
        Ok(())
    }

    /// Follows a job until it has ended; `show` sees every status on the way. Short outages are waited out.
    pub(super) async fn follow(&self, id: &str, mut show: impl FnMut(&JobStatus)) -> Result<JobStatus, CliError> {
        // An address where nobody was ever heard is an error at once.
        let mut failures = RECONNECTS;
        loop {
            let stream = self.follow_stream(id, |status| {
                failures = 0;
                show(status);
            });
            match stream.await {
                Ok(Some(status)) => return Ok(status),
                Ok(None) if failures >= RECONNECTS => {
                    let text = format!("{} ends the events of job {id} too early; try again", self.base());
                    return Err(CliError::Unreachable(text));
                }
                Err(CliError::Unreachable(_)) if failures < RECONNECTS => {}
                Err(error) => return Err(error),
                Ok(None) => {}
            }
            failures += 1;
            self.is_found.store(false, Ordering::Relaxed);
            tokio::time::sleep(RECONNECT_PAUSE).await;
        }
    }

    /// Reads one stream of events; `None` when it broke off before the job's end.
    async fn follow_stream(&self, id: &str, mut show: impl FnMut(&JobStatus)) -> Result<Option<JobStatus>, CliError> {
        let response = self.send(self.request(Method::GET, &job_path(id, "/events")?)).await?;
        let mut response = accepted(response).await?;
        let mut received = Vec::new();
        while let Ok(Some(chunk)) = response.chunk().await {
            received.extend_from_slice(&chunk);
            while let Some(end) = received.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = received.drain(..=end).collect();
                let Some(data) = line.strip_prefix(b"data:") else { continue };
                let status: JobStatus = serde_json::from_slice(data).map_err(|error| self.not_a_coordinator(&error))?;
                show(&status);
                if status.state.is_final() {
                    return Ok(Some(status));
                }
            }
        }
        Ok(None)
    }

    fn request(&self, method: Method, path: &str) -> RequestBuilder {
        let address = self.base().join(path).map_or_else(|problem| problem.to_string(), String::from);
        self.http.request(method, address)
    }

    /// Where somebody answered last.
    fn base(&self) -> &Url {
        // There is at least one: splitting a text gives one.
        &self.bases[self.current.load(Ordering::Relaxed) % self.bases.len()]
    }

    /// Looks which of several leads: one that hangs takes connections and never answers.
    async fn find_leader(&self) {
        if self.bases.len() == 1 || self.is_found.load(Ordering::Relaxed) {
            return;
        }
        for (index, base) in self.bases.iter().enumerate() {
            let Ok(address) = base.join("/readyz") else { continue };
            let answer = self.http.get(address).timeout(LOOK_PATIENCE).send().await;
            if answer.is_ok_and(|answer| answer.status().is_success()) {
                self.current.store(index, Ordering::Relaxed);
                self.is_found.store(true, Ordering::Relaxed);
                return;
            }
        }
    }

    /// Sends a request to the one that leads; where several may, each is asked once.
    async fn send(&self, request: RequestBuilder) -> Result<Response, CliError> {
        let before = self.current.load(Ordering::Relaxed);
        self.find_leader().await;
        let mut request = request.build().map_err(|error| self.unreachable(&error))?;
        if before != self.current.load(Ordering::Relaxed) {
            request = self.for_current(request);
        }
        let mut left = self.bases.len();
        loop {
            left -= 1;
            let again = if left > 0 { request.try_clone() } else { None };
            let answer = self.http.execute(request).await;
            let is_elsewhere =
                answer.as_ref().map_or(true, |answer| answer.status() == StatusCode::SERVICE_UNAVAILABLE);
            match again.filter(|_| is_elsewhere) {
                None => return answer.map_err(|error| self.unreachable(&error)),
                Some(next) => {
                    self.is_found.store(false, Ordering::Relaxed);
                    self.current.fetch_add(1, Ordering::Relaxed);
                    request = self.for_current(next);
                }
            }
        }
    }

    /// The same request for the address that is tried now.
    fn for_current(&self, mut request: Request) -> Request {
        let mut address = self.base().clone();
        address.set_path(request.url().path());
        address.set_query(request.url().query());
        *request.url_mut() = address;
        request
    }

    async fn send_json<T: DeserializeOwned>(
        &self,
        method: Method,
        path: &str,
        body: &impl Serialize,
    ) -> Result<T, CliError> {
        let body = serde_json::to_vec(body).map_err(CliError::failed)?;
        self.json(self.request(method, path).header(header::CONTENT_TYPE, "application/json").body(body)).await
    }

    async fn json<T: DeserializeOwned>(&self, request: RequestBuilder) -> Result<T, CliError> {
        let response = accepted(self.send(request).await?).await?;
        let bytes = response.bytes().await.map_err(|error| self.unreachable(&error))?;
        serde_json::from_slice(&bytes).map_err(|error| self.not_a_coordinator(&error))
    }

    fn unreachable(&self, error: &reqwest::Error) -> CliError {
        let mut cause: &dyn std::error::Error = error;
        while let Some(deeper) = cause.source() {
            cause = deeper;
        }
        let (base, cause) = (self.base(), cause.to_string());
        let advice = match cause.as_str() {
            cause if cause.contains("ApplicationVerificationFailure") => {
                "its certificate is not the one that --fingerprint names; compare with what the coordinator printed"
            }
            cause if cause.contains("invalid peer certificate") => {
                "its certificate is not trusted here; give the fingerprint that it printed with --fingerprint, or --authorities"
            }
            cause if cause.contains("invalid HTTP version") => {
                "it encrypts; write https://, and give its --fingerprint"
            }
            _ => "start one with `photonfarm serve`, or give its address with --coordinator or PHOTONFARM_URL",
        };
        CliError::Unreachable(format!("no coordinator answers at {base} ({cause}); {advice}"))
    }

    fn not_a_coordinator(&self, error: &serde_json::Error) -> CliError {
        CliError::Unreachable(format!(
            "{} does not answer as a coordinator of this version ({error}); check the address and the versions",
            self.base()
        ))
    }
}

fn address(text: &str) -> Result<Url, CliError> {
    let is_plain = |url: &Url| url.has_host() && url.username().is_empty() && url.password().is_none();
    let address = Url::parse(text).ok().filter(|url| matches!(url.scheme(), "http" | "https") && is_plain(url));
    address.ok_or_else(|| {
        let remedy = "write http://HOST:PORT or https://HOST:PORT";
        // What stands before an @ may be a password.
        let shown = text.rsplit('@').next().unwrap_or_default();
        CliError::Usage(format!("\"{shown}\" is not the address of a coordinator; {remedy}"))
    })
}

/// What every request shows. It is left out wherever headers are printed.
fn authorization(token: Option<&Secret>) -> Result<HeaderMap, CliError> {
    let mut headers = HeaderMap::new();
    if let Some(token) = token {
        let mut value = HeaderValue::try_from(format!("Bearer {}", token.reveal())).map_err(CliError::failed)?;
        value.set_sensitive(true);
        headers.insert(header::AUTHORIZATION, value);
    }
    Ok(headers)
}

/// The address of a job.
fn job_path(id: &str, rest: &str) -> Result<String, CliError> {
    if is_sequence(id) {
        let text =
            format!("{id} is a sequence, and a job is meant; `photonfarm jobs --sequence {id}` lists its frames");
        return Err(CliError::Usage(text));
    }
    Ok(format!("/v1/jobs/{}{rest}", checked_name(id, "a job's id; `photonfarm jobs`")?))
}

/// A name that can hold nothing that leads elsewhere.
fn checked_name<'a>(name: &'a str, what: &str) -> Result<&'a str, CliError> {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    if name.is_empty() || !name.bytes().all(is_plain) || name.contains("..") {
        return Err(CliError::Usage(format!("\"{name}\" is not {what} lists them")));
    }
    Ok(name)
}

/// The response if it is a success, else the problem that it tells.
async fn accepted(response: Response) -> Result<Response, Problem> {
    let status = response.status();
    if status.is_success() {
        return Ok(response);
    }
    let body = response.bytes().await.unwrap_or_default();
    Err(serde_json::from_slice(&body).unwrap_or_else(|_| unknown_answer(status)))
}

fn unknown_answer(status: StatusCode) -> Problem {
    Problem::new(status, "unknown-answer", format!("the coordinator answers {status}"))
        .remedy("check that its address is that of a photonfarm coordinator")
}
