//! Requests to the coordinator, and pauses between attempts.

use std::collections::hash_map::DefaultHasher;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::body::{Body, to_bytes};
use axum::http::header::InvalidHeaderValue;
use axum::http::{HeaderValue, Method, Request, StatusCode, Uri, header};
use bytes::Bytes;
use hyper_util::client::legacy;
use hyper_util::rt::{TokioExecutor, TokioTimer};
use prost::Message;
use tokio::time::{Instant, timeout};

use super::error::WorkerError;
use crate::farm::access::secret::Secret;
use crate::farm::dial::Dialer;
use crate::farm::events::EVENTS;
use crate::farm::locks::lock;

/// For scenes, radius fields and results.
pub(super) const TRANSFER_TIMEOUT: Duration = Duration::from_secs(300);
const SHORTEST_PAUSE: Duration = Duration::from_millis(200);
/// Doublings of the shortest pause (0.2 s · 2⁶ ≈ 13 s).
const PAUSE_DOUBLINGS: u32 = 6;

/// A request that brought no answer to use.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum CallError {
    /// The coordinator cannot be reached or does not answer properly: try again later.
    #[error("the coordinator does not answer: {0}")]
    Unreachable(String),
    /// The coordinator forgot this worker.
    #[error("the coordinator does not know this worker")]
    Forgotten,
    /// The coordinator says no.
    #[error("the coordinator answered {0}: {1}")]
    Status(StatusCode, String),
}

impl CallError {
    /// Whether the same request may succeed later.
    pub(super) fn is_temporary(&self) -> bool {
        match self {
            Self::Unreachable(_) => true,
            Self::Forgotten => false,
            Self::Status(status, _) => {
                status.is_server_error()
                    || [StatusCode::TOO_MANY_REQUESTS, StatusCode::REQUEST_TIMEOUT].contains(status)
            }
        }
    }
}

/// Where the coordinator may be: one of several leads, the others stand by.
struct Addresses {
    all: Vec<String>,
    current: AtomicUsize,
}

impl Addresses {
    fn parse(text: &str) -> Result<Self, WorkerError> {
        let all: Result<Vec<String>, WorkerError> = text.split(',').map(str::trim).map(address).collect();
        Ok(Self { all: all?, current: AtomicUsize::new(0) })
    }

    fn current(&self) -> usize {
        self.current.load(Ordering::Relaxed)
    }

    fn get(&self, index: usize) -> &str {
        // `parse` answers at least one: splitting does.
        self.all.get(index % self.all.len().max(1)).map_or("", String::as_str)
    }

    /// Nobody leads at that address. Of several requests that find so, one goes on to the next.
    fn leave(&self, index: usize) {
        let _ = self.current.compare_exchange(index, index.wrapping_add(1), Ordering::Relaxed, Ordering::Relaxed);
    }
}

impl fmt::Display for Addresses {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.all.join(" or "))
    }
}

fn address(text: &str) -> Result<String, WorkerError> {
    let bad = |problem: String| WorkerError::BadAddress { address: text.to_owned(), problem };
    let uri: Uri = text.parse().map_err(|problem: axum::http::uri::InvalidUri| bad(problem.to_string()))?;
    if !matches!(uri.scheme_str(), Some("http" | "https")) || uri.host().is_none_or(str::is_empty) {
        return Err(bad("it does not begin with http:// or https:// and a host".to_owned()));
    }
    Ok(text.trim_end_matches('/').to_owned())
}

/// The coordinator's worker protocol.
#[derive(Clone)]
pub(super) struct Client {
    http: legacy::Client<Dialer, Body>,
    addresses: Arc<Addresses>,
    /// What it shows: the token by which it joins, then its own secret.
    authorization: Option<HeaderValue>,
    outage: Arc<Mutex<Option<Instant>>>,
}

impl Client {
    /// A client for the coordinator at one of the `addresses`, separated by commas, that has joined nothing yet.
    pub(super) fn new(addresses: &str, dialer: Dialer, token: Option<&Secret>) -> Result<Self, WorkerError> {
        let addresses = Arc::new(Addresses::parse(addresses)?);
        let http = legacy::Client::builder(TokioExecutor::new()).pool_timer(TokioTimer::new()).build(dialer);
        let authorization = token.map(|token| authorization(token.reveal())).transpose();
        let authorization = authorization.map_err(|problem| WorkerError::Start(problem.to_string()))?;
        Ok(Self { http, addresses, authorization, outage: Arc::default() })
    }

    /// The same client, as the worker that joined and was given `secret`.
    pub(super) fn joined(&self, secret: &str) -> Result<Self, WorkerError> {
        let authorization = authorization(secret).map_err(|problem| WorkerError::Refused(problem.to_string()))?;
        Ok(Self { authorization: Some(authorization), ..self.clone() })
    }

    /// Sends a message and reads the answer as one.
    pub(super) async fn post<A: Message + Default>(
        &self,
        path: &str,
        message: Bytes,
        patience: Duration,
    ) -> Result<A, CallError> {
        let body = self.observed(self.call(Method::POST, path, message.into(), patience).await)?;
        A::decode(body).map_err(|problem| CallError::Unreachable(problem.to_string()))
    }

    /// Reads a resource.
    pub(super) async fn get(&self, path: &str, patience: Duration) -> Result<Bytes, CallError> {
        self.observed(self.call(Method::GET, path, Body::empty(), patience).await)
    }

    async fn call(&self, method: Method, path: &str, body: Body, patience: Duration) -> Result<Bytes, CallError> {
        let tried = self.addresses.current();
        let answer = self.call_at(self.addresses.get(tried), method, path, body, patience).await;
        if matches!(answer, Err(CallError::Unreachable(_) | CallError::Status(StatusCode::SERVICE_UNAVAILABLE, _))) {
            self.addresses.leave(tried);
        }
        answer
    }

    async fn call_at(
        &self,
        address: &str,
        method: Method,
        path: &str,
        body: Body,
        patience: Duration,
    ) -> Result<Bytes, CallError> {
        let request = Request::builder().method(method).uri(format!("{address}/farm/v1/{path}")).body(body);
        let mut request = request.map_err(|problem| CallError::Unreachable(problem.to_string()))?;
        if let Some(authorization) = &self.authorization {
            request.headers_mut().insert(header::AUTHORIZATION, authorization.clone());
        }
        let answer = async {
            let response = self.http.request(request).await.map_err(|problem| unreachable_by(&problem))?;
            let status = response.status();
            let body = to_bytes(Body::new(response.into_body()), usize::MAX).await;
            Ok((status, body.map_err(|problem| unreachable_by(&problem))?))
        };
        let late = |_| CallError::Unreachable(format!("no answer within {} s", patience.as_secs()));
        let (status, body) = timeout(patience, answer).await.map_err(late)??;
        match status {
            StatusCode::GONE => Err(CallError::Forgotten),
            status if status.is_success() => Ok(body),
            status => Err(CallError::Status(status, String::from_utf8_lossy(&body).chars().take(1000).collect())),
        }
    }

    /// Logs the beginning and the end of an outage, one line each, however many requests it costs.
    fn observed(&self, result: Result<Bytes, CallError>) -> Result<Bytes, CallError> {
        let mut outage = lock(&self.outage);
        match &result {
            Err(CallError::Unreachable(problem)) if outage.is_none() => {
                *outage = Some(Instant::now());
                let advice = if problem.contains("invalid peer certificate") {
                    "give its fingerprint with --fingerprint, or --authorities; "
                } else {
                    ""
                };
                let addresses = &self.addresses;
                tracing::warn!(target: EVENTS, "coordinator {addresses} does not answer ({problem}); {advice}trying again");
            }
            // One that stands by does not end the outage.
            Err(CallError::Unreachable(_) | CallError::Status(StatusCode::SERVICE_UNAVAILABLE, _)) => {}
            _ => {
                if let Some(since) = outage.take() {
                    let seconds = since.elapsed().as_secs_f64();
                    tracing::info!(target: EVENTS, "coordinator {} answers again after {seconds:.0} s", self.addresses);
                }
            }
        }
        result
    }
}

/// A secret as a header, which is left out wherever headers are printed.
fn authorization(secret: &str) -> Result<HeaderValue, InvalidHeaderValue> {
    let mut value = HeaderValue::try_from(format!("Bearer {secret}"))?;
    value.set_sensitive(true);
    Ok(value)
}

/// The innermost cause says what happened ("connection refused"); the outer ones only that something did.
fn unreachable_by(problem: &(dyn std::error::Error + 'static)) -> CallError {
    let mut cause = problem;
    while let Some(inner) = cause.source() {
        cause = inner;
    }
    CallError::Unreachable(cause.to_string())
}

/// Pauses between attempts: they double, and differ between workers so that a farm does not return as one.
#[derive(Clone, Debug)]
pub(super) struct Backoff {
    name: String,
    attempt: u32,
}

impl Backoff {
    /// No attempt has failed yet.
    pub(super) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), attempt: 0 }
    }

    /// The last attempt succeeded.
    pub(super) fn reset(&mut self) {
        self.attempt = 0;
    }

    /// The pause after another failed attempt: 50–100 % of the doubled time.
    pub(super) fn next_pause(&mut self) -> Duration {
        let longest = SHORTEST_PAUSE * (1 << self.attempt.min(PAUSE_DOUBLINGS));
        self.attempt = self.attempt.saturating_add(1);
        let mut hasher = DefaultHasher::new();
        (&self.name, self.attempt).hash(&mut hasher);
        longest.mul_f64(0.5 + 0.5 * (hasher.finish() >> 11) as f64 / (1u64 << 53) as f64)
    }
}
