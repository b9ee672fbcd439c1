//! What the workers' protocol lets in: those that joined, each for itself, and results that are awaited.

use crate::hand::Hand;
use photonfarm::farm::access::caller::Caller;
use photonfarm::farm::access::scope::{Role, Scope};
use photonfarm::farm::coordinator::tokens::TokenRequest;
use photonfarm::farm::ids::JobId;
use photonfarm::farm::job::{JobRequest, StopRule};
use photonfarm::farm::wire::BUILD;
use photonfarm::farm::{CoordinatorOptions, Limits, LocalFarm};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

const SCENE: &[u8] = include_bytes!("../references/furnace-closed/scene.xml");

async fn farm(limits: Limits) -> LocalFarm {
    let options = CoordinatorOptions { limits, ..CoordinatorOptions::default() };
    LocalFarm::builder().workers(0).options(options).start().await.expect("a farm")
}

async fn submit(farm: &LocalFarm) -> JobId {
    let scene = farm.client().add_scene(SCENE.to_vec()).await.expect("a scene").hash;
    let stop = StopRule { passes: Some(1000), ..StopRule::default() };
    farm.client().submit(JobRequest { stop, ..JobRequest::of_scene(scene) }).await.expect("a job")
}

/// A token by which workers join, on a farm with an admin.
async fn worker_token(farm: &LocalFarm) -> String {
    farm.client().add_user(&Caller::Anyone, "anna".parse().expect("a name"), Role::Admin).await.expect("added");
    let wanted = TokenRequest { user: None, label: String::new(), scope: Some(Scope::Worker), days: None };
    farm.client().issue_token(&Caller::Anyone, wanted).await.expect("a token").secret.reveal().to_owned()
}

/// The first line of the answer to a result that does not come whole.
async fn answer_to_unfinished(farm: &LocalFarm, path: &str, secret: &str, head: &str) -> String {
    let mut stream = TcpStream::connect(farm.address()).await.expect("a connection");
    let request =
        format!("POST /farm/v1/{path} HTTP/1.1\r\nHost: local\r\nAuthorization: Bearer {secret}\r\n{head}\r\n\r\nabc");
    stream.write_all(request.as_bytes()).await.expect("sent");
    let mut answer = vec![0; "HTTP/1.1 200".len()];
    stream.read_exact(&mut answer).await.expect("an answer");
    String::from_utf8_lossy(&answer).into_owned()
}

/// A worker's result has a length that is looked at before a byte of it is kept, and does not fall silent.
#[tokio::test(flavor = "multi_thread")]
async fn results_that_are_too_long_or_fall_silent_are_refused() {
    let farm = farm(Limits { result_bytes: 1000, result_memory: 1000, silence: 1, ..Limits::default() }).await;
    submit(&farm).await;
    submit(&farm).await;
    let hand = Hand::register(&farm.url(), None, BUILD).await.expect("a place");
    let (one, other) = (Hand::address(&hand.lease().await), Hand::address(&hand.lease().await));
    let answered = async |path: &str, head: &str| answer_to_unfinished(&farm, path, &hand.secret, head).await;
    assert_eq!(answered(&one, "Content-Length: 1001").await, "HTTP/1.1 413");
    assert_eq!(answered(&one, "Transfer-Encoding: chunked").await, "HTTP/1.1 411");
    // The silent one holds all the place that there is; the next waits for it.
    let (silent, next) = tokio::join!(answered(&one, "Content-Length: 1000"), answered(&other, "Content-Length: 900"));
    assert_eq!((silent.as_str(), next.as_str()), ("HTTP/1.1 408", "HTTP/1.1 408"));
}

/// Whoever has no lease holds no memory: others deliver meanwhile.
#[tokio::test(flavor = "multi_thread")]
async fn results_that_nobody_awaits_take_no_place() {
    let farm = farm(Limits { result_bytes: 1000, result_memory: 1000, silence: 20, ..Limits::default() }).await;
    submit(&farm).await;
    let hand = Hand::register(&farm.url(), None, BUILD).await.expect("a place");
    let other = Hand::register(&farm.url(), None, BUILD).await.expect("a place");
    let lease = hand.lease().await;
    let stolen = Hand::address(&lease);
    let head = "Content-Length: 1000";
    let slow = answer_to_unfinished(&farm, &stolen, &other.secret, head);
    let never = answer_to_unfinished(&farm, "leases/7/7/result", &hand.secret, head);
    tokio::select! {
        answer = slow => panic!("answered before its end: {answer}"),
        answer = never => panic!("answered before its end: {answer}"),
        status = async {
            tokio::time::sleep(std::time::Duration::from_millis(500)).await;
            hand.deliver(&lease, None).await
        } => assert_eq!(status, 422, "an empty result is read, and refused"),
    }
    assert_eq!(other.deliver(&lease, None).await, 409);
}

/// Where there are users, workers join by a token for workers, and stay as long as it is valid.
#[tokio::test(flavor = "multi_thread")]
async fn workers_join_by_token_and_leave_with_it() {
    let farm = farm(Limits::default()).await;
    let early = Hand::register(&farm.url(), None, BUILD).await.expect("nobody is asked yet");
    let token = worker_token(&farm).await;
    assert_eq!(early.post("heartbeat", Vec::new()).await.0, 410, "it joined without a token");
    assert_eq!(Hand::register(&farm.url(), None, BUILD).await.err(), Some(401));
    assert_eq!(Hand::register(&farm.url(), Some("guess"), BUILD).await.err(), Some(401));
    let admin = farm.client().issue_token(
        &Caller::Anyone,
        TokenRequest { user: "anna".parse().ok(), label: String::new(), scope: None, days: None },
    );
    let admin = admin.await.expect("a token");
    assert_eq!(Hand::register(&farm.url(), Some(admin.secret.reveal()), BUILD).await.err(), Some(403));
    let hand = Hand::register(&farm.url(), Some(&token), BUILD).await.expect("a place");
    assert_eq!(hand.post("heartbeat", Vec::new()).await.0, 200);
    let joined = farm.client().tokens(&Caller::Anyone).into_iter().find(|token| token.scope == Scope::Worker);
    farm.client().revoke_token(&Caller::Anyone, &joined.expect("it is listed").id).await.expect("revoked");
    assert_eq!(hand.post("heartbeat", Vec::new()).await.0, 410, "its token is revoked");
    assert_eq!(Hand::register(&farm.url(), Some(&token), BUILD).await.err(), Some(401));
}

/// A lease's result comes once at a time, and is no longer than it can be: nobody fills the place that others need.
#[tokio::test(flavor = "multi_thread")]
async fn a_lease_takes_no_more_place_than_its_result_needs() {
    let farm = farm(Limits::default()).await;
    submit(&farm).await;
    let hand = Hand::register(&farm.url(), None, BUILD).await.expect("a place");
    let lease = hand.lease().await;
    let path = Hand::address(&lease);
    let answer = answer_to_unfinished(&farm, &path, &hand.secret, "Content-Length: 500000000").await;
    assert_eq!(answer, "HTTP/1.1 413");
    let slow = answer_to_unfinished(&farm, &path, &hand.secret, "Content-Length: 1000");
    tokio::select! {
        answer = slow => panic!("answered before its end: {answer}"),
        status = async {
            tokio::time::sleep(std::time::Duration::from_millis(300)).await;
            hand.deliver(&lease, None).await
        } => assert_eq!(status, 503, "the same result is on its way"),
    }
    // Nobody listens to the slow one any more.
    tokio::time::sleep(std::time::Duration::from_millis(300)).await;
    assert_eq!(hand.deliver(&lease, None).await, 422);
}
