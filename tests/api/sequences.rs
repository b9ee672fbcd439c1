//! Sequences through the API: what is refused and why, what is repeated, and how frames become jobs.

use std::time::{Duration, Instant};

use photonfarm::farm::FarmError;
use photonfarm::farm::store::{Store, StoreLocation};
use reqwest::Method;
use serde_json::{Value, json};

use crate::programs::{Farm, header};

const STILL: &str = include_str!("../references/furnace-closed/scene.xml");
/// A lamp on its way, in front of two cameras.
const LAMP: &str = "<scene version='3.0.0'><integrator type='path'/>
    <sensor type='perspective' id='left'><film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/></film></sensor>
    <sensor type='perspective' id='right'><transform name='to_world'><translate x='1'/></transform></sensor>
    <shape type='sphere'><emitter type='area'/><animation name='to_world'>
        <transform time='0'><translate z='4'/></transform><transform time='1'><translate z='8'/></transform></animation></shape></scene>";

fn sequence(scene: &str, frames: Value) -> Value {
    json!({ "job": { "scene_inline": scene, "name": "lamp", "stop": { "passes": 2 } }, "frames": frames })
}

#[tokio::test(flavor = "multi_thread")]
async fn sequences_that_cannot_be_are_refused_and_leave_nothing() {
    let farm = Farm::in_memory(0).await;
    let submit = async |body: Value| farm.json(Method::POST, "/v1/sequences", &[], Some(body)).await;
    let frames = |first: u32, last: u32| json!({ "first": first, "last": last });
    let with = |name: &str, value: Value| {
        let mut frames = frames(1, 3);
        frames[name] = value;
        frames
    };
    let wrong = [
        (sequence(LAMP, frames(3, 1)), "the last frame, 1, is before the first one, 3"),
        (sequence(LAMP, frames(0, 100_000)), "more than 100000"),
        (sequence(LAMP, with("whole", json!([2, 9]))), "leave the sequence of 2 to 9"),
        (sequence(LAMP, with("camera_path", json!(["left"]))), "has one camera"),
        (sequence(LAMP, with("camera_path", json!(["left", "front"]))), "there is no camera \"front\""),
        (sequence(STILL, frames(1, 3)), "nothing in the scene moves"),
    ];
    for (body, expected) in wrong {
        let (status, problem) = submit(body).await;
        let detail = problem["detail"].as_str().unwrap_or_default();
        assert!(status == 422 && detail.contains(expected), "{expected}: {status} {problem}");
        assert!(problem["remedy"].is_string(), "{problem}");
    }
    let mut moment = sequence(LAMP, frames(1, 3));
    moment["job"]["scene_changes"] = json!({ "time": 0.5 });
    assert!(submit(moment).await.1["detail"].as_str().is_some_and(|detail| detail.contains("many moments")));
    let mut all = sequence(LAMP, frames(1, 3));
    all["at_once"] = json!(0);
    assert_eq!(submit(all).await.0, 422);
    assert_eq!(farm.jobs().await, 0);
    let (_, list) = farm.json(Method::GET, "/v1/sequences", &[], None).await;
    assert_eq!(list, json!({ "sequences": [] }));
    for path in ["/v1/sequences/seq-0000000z", "/v1/sequences/0000000z", "/v1/jobs?sequence=z"] {
        let (status, problem) = farm.json(Method::GET, path, &[], None).await;
        assert_eq!((status, &problem["type"]), (404, &json!("urn:photonfarm:problem:unknown-sequence")), "{path}");
    }
}

/// What is refused leaves neither a job nor a scene, and whoever asks the same at the same time is refused, too.
#[tokio::test(flavor = "multi_thread")]
async fn a_refused_sequence_was_never_there() {
    let farm = Farm::in_memory(0).await;
    let scene = farm.local.client().add_scene(LAMP.into()).await.expect("a scene").hash;
    let bad = json!({ "job": { "scene": scene, "method": "magic" }, "frames": { "first": 1, "last": 3 } });
    let key = [("Idempotency-Key", "once")];
    let submit = async || farm.json(Method::POST, "/v1/sequences", &key, Some(bad.clone())).await.0;
    let statuses = tokio::join!(submit(), submit(), submit());
    assert_eq!(statuses, (422, 422, 422));
    for moments in [json!([-1.7e308, 1.7e308]), json!([0.0])] {
        let times = sequence(LAMP, json!({ "first": 1, "last": 3, "times": moments }));
        assert_eq!(farm.json(Method::POST, "/v1/sequences", &[], Some(times)).await.0, 422);
    }
    let path = json!({ "first": 1, "last": 3, "camera_path": vec!["left"; 1001] });
    assert_eq!(farm.json(Method::POST, "/v1/sequences", &[], Some(sequence(LAMP, path))).await.0, 422);
    // Only the coordinator writes scenes as changes.
    for bytes in ["", "{}", &format!("{{\"base\":\"{}\",\"changes\":{{}}}}", "0".repeat(64))] {
        let refused = farm.local.client().add_scene(format!("photonfarm changed scene\n{bytes}").into()).await;
        assert!(matches!(refused, Err(FarmError::BadRequest { .. })), "{refused:?}");
    }
    assert_eq!(farm.json(Method::GET, "/v1/sequences", &[], None).await.1, json!({ "sequences": [] }));
    let (_, scenes) = farm.json(Method::GET, "/v1/scenes", &[], None).await;
    assert_eq!(scenes["scenes"].as_array().map(Vec::len), Some(1), "{scenes}");
    assert_eq!(farm.json(Method::DELETE, &format!("/v1/scenes/{scene}"), &[], None).await.0, 204);
}

/// Frames that were stopped one by one are no sequence that is done; one that pauses half is paused whole by the next request.
#[tokio::test(flavor = "multi_thread")]
async fn a_sequence_is_what_its_frames_are() {
    let farm = Farm::in_memory(0).await;
    let body = Some(sequence(LAMP, json!({ "first": 1, "last": 2 })));
    let (_, submitted) = farm.json(Method::POST, "/v1/sequences", &[], body).await;
    let address = format!("/v1/sequences/{}", submitted["id"].as_str().expect("an id"));
    let start = Instant::now();
    while farm.jobs().await < 2 {
        assert!(start.elapsed() < Duration::from_secs(30), "the second frame is not made");
    }
    let (_, jobs) = farm.json(Method::GET, "/v1/jobs", &[], None).await;
    let job = |index: usize| format!("/v1/jobs/{}", jobs["jobs"][index]["id"].as_str().expect("an id"));
    let order = async |address: &str, what: &str| {
        let (status, answer) = farm.json(Method::POST, &format!("{address}/{what}"), &[], None).await;
        (status, answer["state"].as_str().unwrap_or_default().to_owned())
    };
    assert_eq!(order(&address, "pause").await, (200, "paused".to_owned()));
    assert_eq!(order(&address, "pause").await.0, 409);
    assert_eq!(order(&job(1), "resume").await.0, 200);
    assert_eq!(order(&address, "pause").await, (200, "paused".to_owned()));
    assert_eq!(order(&job(1), "pause").await.0, 409, "it pauses again");
    assert_eq!(order(&address, "resume").await, (200, "running".to_owned()));
    for index in 0..2 {
        assert_eq!(order(&job(index), "cancel").await.0, 200);
    }
    assert_eq!(farm.json(Method::GET, &address, &[], None).await.1["state"], "cancelled");
    assert_eq!(order(&address, "resume").await.0, 409);
}

/// Who got no answer sends the same again, also to a coordinator that was started again.
#[tokio::test(flavor = "multi_thread")]
async fn a_sequence_that_is_submitted_again_is_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let location = StoreLocation::folder(folder.path());
    let farm = Farm::start(0, Store::open(&location).await.expect("a store")).await;
    let key = [("Idempotency-Key", "film-1")];
    let body = |last: u32| Some(sequence(LAMP, json!({ "first": 1, "last": last })));
    let answer = farm.send(Method::POST, "/v1/sequences", &key, body(3)).await;
    assert_eq!(answer.status(), 202);
    let location_header = header(&answer, "location");
    let first: Value = serde_json::from_slice(&answer.bytes().await.expect("a body")).expect("JSON");
    assert_eq!(location_header, format!("/v1/sequences/{}", first["id"].as_str().expect("an id")));
    let (_, again) = farm.json(Method::POST, "/v1/sequences", &key, body(3)).await;
    assert_eq!(again["id"], first["id"]);
    assert_eq!(farm.json(Method::POST, "/v1/sequences", &key, body(4)).await.0, 422);
    farm.local.stop().await;
    let farm = Farm::start(0, Store::open(&location).await.expect("a store")).await;
    let (status, again) = farm.json(Method::POST, "/v1/sequences", &key, body(3)).await;
    assert_eq!((status, &again["id"]), (202, &first["id"]));
    // Nobody works here, and two frames wait.
    let start = Instant::now();
    while farm.jobs().await < 2 {
        assert!(start.elapsed() < Duration::from_secs(30), "the second frame is not made");
    }
    tokio::time::sleep(Duration::from_millis(600)).await;
    let (_, status) = farm.json(Method::GET, &location_header, &[], None).await;
    assert_eq!(
        (&status["state"], &status["frames_done"], &status["progress"]),
        (&json!("running"), &json!(0), &json!(0.0))
    );
    let frames: Vec<_> = status["jobs"].as_array().expect("jobs").iter().map(|job| &job["frame"]).collect();
    assert_eq!(frames, [&json!(1), &json!(2)], "a few at a time");
    let (_, jobs) =
        farm.json(Method::GET, &format!("/v1/jobs?sequence={}", first["id"].as_str().expect("an id")), &[], None).await;
    assert_eq!((&jobs["jobs"][1]["name"], &jobs["jobs"][1]["seed"]), (&json!("lamp.0002"), &json!(2)));
}

/// A changed scene is kept as its changes; what it changes stays as long as it does.
#[tokio::test(flavor = "multi_thread")]
async fn a_scene_stays_as_long_as_those_that_change_it() {
    let farm = Farm::in_memory(0).await;
    let scene = farm.local.client().add_scene(LAMP.into()).await.expect("a scene").hash;
    let changed = async |scene: &str, changes: Value| {
        let job = json!({ "scene": scene, "scene_changes": changes });
        let (status, job) = farm.json(Method::POST, "/v1/jobs", &[], Some(job)).await;
        assert_eq!(status, 202, "{job}");
        [&job["id"], &job["scene"]].map(|value| value.as_str().expect("text").to_owned())
    };
    let [wide_job, wide] = changed(&scene, json!({ "width": 64 })).await;
    // Changes of a changed scene are changes of the first one.
    let [moved_job, moved] = changed(&wide, json!({ "time": 0.5 })).await;
    let [_, both] = changed(&scene, json!({ "width": 64, "time": 0.5 })).await;
    assert_eq!(moved, both);
    let [_, same] = changed(&scene, json!({})).await;
    assert_eq!(same, scene);
    let (_, listed) = farm.json(Method::GET, "/v1/scenes", &[], None).await;
    for known in listed["scenes"].as_array().expect("scenes") {
        let bytes = known["bytes"].as_u64().expect("bytes");
        assert!(known["hash"] == json!(scene) || bytes < 200, "{known}");
        assert_eq!(known["width"], if known["hash"] == json!(scene) { 8 } else { 64 });
    }
    let (_, jobs) = farm.json(Method::GET, "/v1/jobs", &[], None).await;
    for job in jobs["jobs"].as_array().expect("jobs").iter().filter(|job| job["id"] != json!(moved_job)) {
        let path = format!("/v1/jobs/{}", job["id"].as_str().expect("an id"));
        assert_eq!(farm.json(Method::DELETE, &path, &[], None).await.0, 204);
    }
    let delete = async |hash: &str| farm.json(Method::DELETE, &format!("/v1/scenes/{hash}"), &[], None).await.0;
    assert_eq!(farm.json(Method::GET, &format!("/v1/jobs/{wide_job}"), &[], None).await.0, 404);
    assert_eq!([delete(&scene).await, delete(&moved).await, delete(&wide).await], [409, 409, 204]);
    assert_eq!(farm.json(Method::DELETE, &format!("/v1/jobs/{moved_job}"), &[], None).await.0, 204);
    assert_eq!([delete(&scene).await, delete(&moved).await, delete(&scene).await], [409, 204, 204]);
}
