//! Requests to the provider. Nobody is followed to another address.

use std::pin::Pin;
use std::time::Duration;

use axum::body::{Body, to_bytes};
use hyper_util::client::legacy;
use hyper_util::rt::TokioExecutor;
use openidconnect::{AsyncHttpClient, HttpRequest, HttpResponse};
use tokio::time::timeout;

use crate::farm::dial::Dialer;

/// How long the provider may take for an answer.
const PATIENCE: Duration = Duration::from_secs(15);
/// Bytes of an answer at most.
const LONGEST: usize = 1 << 20;

/// Why the provider did not answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(super) struct NoAnswer(String);

/// Sends requests to the provider.
pub(super) struct Requests {
    http: legacy::Client<Dialer, Body>,
}

impl Requests {
    /// Trusts whom this system trusts.
    pub(super) fn new() -> Self {
        let dialer = Dialer::trusting_system("a provider with https cannot be asked");
        Self { http: legacy::Client::builder(TokioExecutor::new()).build(dialer) }
    }

    async fn send(&self, request: HttpRequest) -> Result<HttpResponse, NoAnswer> {
        let answered = async {
            let response =
                self.http.request(request.map(Body::from)).await.map_err(|problem| NoAnswer(in_full(&problem)))?;
            let (head, body) = response.into_parts();
            let body = to_bytes(Body::new(body), LONGEST).await.map_err(|problem| NoAnswer(in_full(&problem)))?;
            Ok(HttpResponse::from_parts(head, body.into()))
        };
        timeout(PATIENCE, answered)
            .await
            .unwrap_or_else(|_| Err(NoAnswer(format!("no answer within {} s", PATIENCE.as_secs()))))
    }
}

impl<'c> AsyncHttpClient<'c> for Requests {
    type Error = NoAnswer;
    type Future = Pin<Box<dyn Future<Output = Result<HttpResponse, NoAnswer>> + Send + 'c>>;

    fn call(&'c self, request: HttpRequest) -> Self::Future {
        Box::pin(self.send(request))
    }
}

/// An error with what caused it: the causes say what happened.
pub(super) fn in_full(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
