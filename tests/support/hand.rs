//! A worker made by hand, to send what a real one would not.

use std::time::Duration;

use photonfarm::farm::wire::messages::result_request::Outcome;
use photonfarm::farm::wire::messages::{Lease, LeaseResponse, RegisterRequest, RegisterResponse, ResultRequest};
use prost::Message;

use super::http_client::http_client;

/// A worker made by hand.
pub(crate) struct Hand {
    http: reqwest::Client,
    base: String,
    /// What it shows.
    pub(crate) secret: String,
}

impl Hand {
    /// Joins the coordinator at `url` as a worker of `build`, by a token where one is needed.
    pub(crate) async fn register(url: &str, token: Option<&str>, build: &str) -> Result<Self, u16> {
        let http = http_client(Duration::from_secs(120));
        let mut hand = Self { http, base: format!("{url}/farm/v1"), secret: token.unwrap_or_default().to_owned() };
        let request = RegisterRequest { name: "hand".into(), threads: 1, build: build.into(), features: String::new() };
        let (status, body) = hand.post("register", request.encode_to_vec()).await;
        if status != 200 {
            return Err(status);
        }
        hand.secret = RegisterResponse::decode(&body[..]).expect("a message").secret;
        Ok(hand)
    }

    pub(crate) async fn post(&self, path: &str, body: Vec<u8>) -> (u16, Vec<u8>) {
        let request = self.http.post(format!("{}/{path}", self.base)).bearer_auth(&self.secret);
        let response = request.body(body).send().await.expect("an answer");
        (response.status().as_u16(), response.bytes().await.expect("a body").to_vec())
    }

    pub(crate) async fn lease(&self) -> Lease {
        let (_, body) = self.post("lease", Vec::new()).await;
        LeaseResponse::decode(&body[..]).expect("a message").lease.expect("work")
    }

    /// Without an outcome the message holds something that nobody knows.
    pub(crate) async fn deliver(&self, lease: &Lease, outcome: Option<Outcome>) -> u16 {
        const UNKNOWN_FIELD: [u8; 2] = [15 << 3, 1];
        let mut message = ResultRequest { outcome }.encode_to_vec();
        if message.is_empty() {
            message.extend(UNKNOWN_FIELD);
        }
        self.send(lease, message).await
    }

    pub(crate) async fn send(&self, lease: &Lease, body: Vec<u8>) -> u16 {
        self.post(&Self::address(lease), body).await.0
    }

    /// Where the result of a lease goes, below the protocol's base.
    pub(crate) fn address(lease: &Lease) -> String {
        format!("leases/{}/{}/result", lease.id, lease.fencing)
    }
}
