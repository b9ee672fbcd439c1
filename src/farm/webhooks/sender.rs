//! The requests by which messages are sent.

use std::time::Duration;

use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use hyper_util::client::legacy;
use hyper_util::rt::TokioExecutor;
use tokio::time::timeout;

use super::signature::signature;
use super::webhook::{Message, Webhook};
use crate::farm::dial::Dialer;

/// How long a receiver may take.
const PATIENCE: Duration = Duration::from_secs(15);

/// What became of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Sent {
    /// It was taken.
    Taken,
    /// Nobody wants messages there any more.
    Gone,
    /// It was not taken; in words.
    Failed(String),
}

/// Sends messages. Nobody is followed to another address.
pub(crate) struct Sender {
    http: legacy::Client<Dialer, Body>,
}

impl Sender {
    /// Trusts whom this system trusts.
    pub(crate) fn new() -> Self {
        let dialer = Dialer::trusting_system("webhooks with https cannot be sent");
        Self { http: legacy::Client::builder(TokioExecutor::new()).build(dialer) }
    }

    /// Sends a message at `seconds` since 1970.
    pub(crate) async fn send(&self, webhook: &Webhook, message: &Message, seconds: i64) -> Sent {
        let request = Request::post(&webhook.url)
            .header(header::CONTENT_TYPE, "application/json")
            .header(header::USER_AGENT, concat!("photonfarm/", env!("CARGO_PKG_VERSION")))
            .header("webhook-id", &message.id)
            .header("webhook-timestamp", seconds.to_string())
            .header("webhook-signature", signature(&webhook.key, &message.id, seconds, &message.body))
            .body(Body::from(message.body.clone()));
        let request = match request {
            Ok(request) => request,
            Err(problem) => return Sent::Failed(problem.to_string()),
        };
        match timeout(PATIENCE, self.http.request(request)).await {
            Ok(Ok(answer)) if answer.status().is_success() => Sent::Taken,
            Ok(Ok(answer)) if answer.status() == StatusCode::GONE => Sent::Gone,
            Ok(Ok(answer)) => Sent::Failed(format!("it answers {}", answer.status())),
            Ok(Err(problem)) => Sent::Failed(problem.to_string()),
            Err(_) => Sent::Failed(format!("it did not answer within {} s", PATIENCE.as_secs())),
        }
    }
}

impl Default for Sender {
    fn default() -> Self {
        Self::new()
    }
}
