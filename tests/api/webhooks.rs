//! Webhooks over real HTTP: signed, sent again until they are taken, also by the next coordinator.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::http_client::http_client;
use axum::Router;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::routing::post;
use photonfarm::api;
use photonfarm::farm::LocalFarm;
use photonfarm::farm::store::{Store, StoreLocation};
use photonfarm::farm::webhooks::signature::{key_of, signature};
use serde_json::{Value, json};
use tokio::net::TcpListener;

const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");
const PATIENCE: Duration = Duration::from_secs(60);

/// A message as it arrived.
#[derive(Clone, Debug)]
struct Arrived {
    id: String,
    seconds: i64,
    signature: String,
    body: String,
}

/// A program that is told of jobs, and takes a message at its second attempt.
#[derive(Clone, Default)]
struct Receiver(Arc<Mutex<Vec<Arrived>>>);

impl Receiver {
    /// Listens; answers its address.
    async fn listen(&self, listener: TcpListener) -> String {
        let url = format!("http://{}/told", listener.local_addr().expect("bound"));
        let application = Router::new().route("/told", post(take)).with_state(self.clone());
        tokio::spawn(async move { axum::serve(listener, application).await });
        url
    }

    fn arrived(&self) -> Vec<Arrived> {
        self.0.lock().expect("nobody panicked").clone()
    }

    async fn wait_for(&self, count: usize) -> Vec<Arrived> {
        let waiting = async {
            while self.arrived().len() < count {
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        };
        tokio::time::timeout(PATIENCE, waiting).await.expect("they arrive");
        self.arrived()
    }
}

async fn take(State(receiver): State<Receiver>, headers: HeaderMap, body: String) -> StatusCode {
    let header = |name: &str| headers[name].to_str().expect("text").to_owned();
    let message = Arrived {
        id: header("webhook-id"),
        seconds: header("webhook-timestamp").parse().expect("seconds"),
        signature: header("webhook-signature"),
        body,
    };
    let mut arrived = receiver.0.lock().expect("nobody panicked");
    let is_first = arrived.iter().all(|known| known.id != message.id);
    arrived.push(message);
    if is_first { StatusCode::INTERNAL_SERVER_ERROR } else { StatusCode::OK }
}

async fn farm(store: Store) -> LocalFarm {
    let routes = |coordinator, shutdown| api::router(api::ApiState { coordinator, shutdown });
    LocalFarm::builder().store(store).routes(routes).start().await.expect("a farm")
}

async fn send(farm: &LocalFarm, path: &str, body: Value) -> (u16, Value) {
    let request =
        http_client(PATIENCE).post(format!("{}{path}", farm.url())).header("Content-Type", "application/json");
    let response = request.body(body.to_string()).send().await.expect("an answer");
    let status = response.status().as_u16();
    (status, serde_json::from_slice(&response.bytes().await.expect("a body")).unwrap_or_default())
}

async fn submit(farm: &LocalFarm, passes: u32) -> String {
    let job = json!({ "scene_inline": SCENE, "method": "path", "stop": { "passes": passes } });
    let (status, job) = send(farm, "/v1/jobs", job).await;
    assert_eq!(status, 202, "{job}");
    job["id"].as_str().expect("an id").to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn messages_are_signed_and_sent_until_they_are_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    let location = StoreLocation::folder(folder.path());
    let first = farm(Store::open(&location).await.expect("a store")).await;
    let receiver = Receiver::default();
    let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
    let later = TcpListener::bind("127.0.0.1:0").await.expect("a port");
    let url = receiver.listen(listener).await;
    let (status, added) = send(&first, "/v1/webhooks", json!({ "url": url })).await;
    assert_eq!(status, 201, "{added}");
    let key = key_of(added["key"].as_str().expect("a key")).expect("as the standard writes it");
    assert_eq!(send(&first, "/v1/webhooks", json!({ "url": "ftp://host" })).await.0, 422);

    let job = submit(&first, 1).await;
    let arrived = receiver.wait_for(2).await;
    assert_eq!(arrived[0].id, arrived[1].id, "the same message again, because it was not taken");
    for message in &arrived {
        let expected = signature(&key, &message.id, message.seconds, &message.body);
        assert_eq!(message.signature, expected);
        assert_ne!(signature(b"another key", &message.id, message.seconds, &message.body), expected);
    }
    let said: Value = serde_json::from_str(&arrived[0].body).expect("JSON");
    assert_eq!((said["type"].as_str(), said["data"]["id"].as_str()), (Some("job.done"), Some(job.as_str())));
    assert!(said["timestamp"].as_str().expect("a time").ends_with('Z'), "{said}");

    // Who was deleted is told nothing any more.
    let path = format!("/v1/webhooks/{}", added["id"].as_str().expect("an id"));
    let deleted = http_client(PATIENCE).delete(format!("{}{path}", first.url())).send().await.expect("an answer");
    assert_eq!(deleted.status(), 204);

    // Nobody takes it before the coordinator stops; the next one sends it.
    let address = later.local_addr().expect("bound");
    drop(later);
    send(&first, "/v1/webhooks", json!({ "url": format!("http://{address}/told") })).await;
    let job = submit(&first, 1).await;
    let mut status = first.client().watch(job.parse().expect("an id")).expect("it is there");
    status.wait_for(|status| status.state.is_final()).await.expect("it ends");
    first.stop().await;
    let late = Receiver::default();
    late.listen(TcpListener::bind(address).await.expect("the port is free")).await;
    let _second = farm(Store::open(&location).await.expect("a store")).await;
    let arrived = late.wait_for(1).await;
    assert!(arrived[0].body.contains(&job), "{arrived:?}");
    assert!(receiver.arrived().iter().all(|message| !message.body.contains(&job)), "it was deleted before");
}
