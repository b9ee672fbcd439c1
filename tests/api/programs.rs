//! What programs need of the API: to repeat a request safely, to wait, to change what they have seen, to miss nothing, and to go on where a
//! download broke off.

use std::io::{Cursor, Write};
use std::time::Duration;

use crate::hand::Hand;
use crate::http_client::http_client;
use photonfarm::api;
use photonfarm::farm::store::{Store, StoreLocation};
use photonfarm::farm::wire::BUILD;
use photonfarm::farm::wire::messages::result_request::Outcome;
use photonfarm::farm::{CoordinatorOptions, LocalFarm};
use reqwest::{Method, Response};
use serde_json::{Value, json};

/// Six rooms with a lamp each, and the vase that stands in one of them.
const ROOMS: [(&str, &[u8]); 2] = [
    ("scene.xml", include_bytes!("../../scenes/rooms/scene.xml")),
    ("vase.ply", include_bytes!("../../scenes/rooms/vase.ply")),
];
const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");

pub(crate) struct Farm {
    base: String,
    http: reqwest::Client,
    pub(crate) local: LocalFarm,
}

impl Farm {
    pub(crate) async fn start(workers: usize, store: Store) -> Self {
        let routes = |coordinator, shutdown| api::router(api::ApiState { coordinator, shutdown });
        let builder = LocalFarm::builder().workers(workers).options(CoordinatorOptions::default()).store(store);
        let local = builder.routes(routes).start().await.expect("a farm");
        Self { base: local.url(), http: http_client(Duration::from_secs(90)), local }
    }

    pub(crate) async fn in_memory(workers: usize) -> Self {
        Self::start(workers, Store::in_memory().await.expect("a store")).await
    }

    pub(crate) async fn send(
        &self,
        method: Method,
        path: &str,
        headers: &[(&str, &str)],
        body: Option<Value>,
    ) -> Response {
        let mut request = self.http.request(method, format!("{}{path}", self.base));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        if let Some(body) = body {
            request = request.header("Content-Type", "application/json").body(body.to_string());
        }
        request.send().await.expect("an answer")
    }

    pub(crate) async fn json(
        &self,
        method: Method,
        path: &str,
        headers: &[(&str, &str)],
        body: Option<Value>,
    ) -> (u16, Value) {
        let response = self.send(method, path, headers, body).await;
        let status = response.status().as_u16();
        (status, serde_json::from_slice(&response.bytes().await.expect("a body")).unwrap_or_default())
    }

    pub(crate) async fn jobs(&self) -> usize {
        let (_, list) = self.json(Method::GET, "/v1/jobs", &[], None).await;
        list["jobs"].as_array().expect("a list").len()
    }
}

fn job(passes: u32) -> Value {
    json!({ "scene_inline": SCENE, "method": "sppm", "parameters": { "photons_per_pass": 2000 }, "stop": { "passes": passes } })
}

pub(crate) fn header(response: &Response, name: &str) -> String {
    response.headers().get(name).and_then(|value| value.to_str().ok()).unwrap_or_default().to_owned()
}

/// Who got no answer sends the same again, also to a coordinator that was started again.
#[tokio::test(flavor = "multi_thread")]
async fn a_request_that_is_repeated_makes_one_job() {
    let folder = tempfile::tempdir().expect("a folder");
    let location = StoreLocation::folder(folder.path());
    let farm = Farm::start(0, Store::open(&location).await.expect("a store")).await;
    let key = [("Idempotency-Key", "render-42")];
    let submit = async |farm: &Farm, body: Value| farm.json(Method::POST, "/v1/jobs", &key, Some(body)).await;
    let (status, first) = submit(&farm, job(5)).await;
    assert_eq!(status, 202, "{first}");
    let both = tokio::join!(submit(&farm, job(5)), submit(&farm, job(5)));
    assert_eq!((&both.0.1["id"], &both.1.1["id"]), (&first["id"], &first["id"]));
    let (status, problem) = submit(&farm, job(6)).await;
    assert_eq!((status, problem["type"].as_str()), (422, Some("urn:photonfarm:problem:bad-request")), "{problem}");
    let (status, other) = farm.json(Method::POST, "/v1/jobs", &[], Some(job(5))).await;
    assert!(status == 202 && other["id"] != first["id"], "without a key it is another job");
    assert_eq!(farm.jobs().await, 2);
    let (status, _) = farm.json(Method::POST, "/v1/jobs", &[("Idempotency-Key", "two words")], Some(job(5))).await;
    assert_eq!(status, 400);
    // The name changed meanwhile; the request was the same.
    let path = format!("/v1/jobs/{}", first["id"].as_str().expect("an id"));
    farm.json(Method::PATCH, &path, &[], Some(json!({ "name": "later" }))).await;
    farm.local.stop().await;
    let farm = Farm::start(0, Store::open(&location).await.expect("a store")).await;
    assert_eq!(submit(&farm, job(5)).await.1["id"], first["id"]);
    let clone = format!("{path}/clone");
    let copies = [
        farm.json(Method::POST, &clone, &[("Idempotency-Key", "copy")], Some(json!({}))).await.1,
        farm.json(Method::POST, &clone, &[("Idempotency-Key", "copy")], Some(json!({}))).await.1,
    ];
    assert_eq!(copies[0]["id"], copies[1]["id"]);
    assert_eq!(farm.jobs().await, 3);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_end_can_be_waited_for() {
    let farm = Farm::in_memory(1).await;
    let wait = [("Prefer", "wait=60")];
    let response = farm.send(Method::POST, "/v1/jobs", &wait, Some(job(3))).await;
    assert_eq!((response.status().as_u16(), header(&response, "preference-applied").as_str()), (200, "wait=60"));
    assert!(header(&response, "location").starts_with("/v1/jobs/"));
    let done: Value = serde_json::from_slice(&response.bytes().await.expect("a body")).expect("JSON");
    assert_eq!(done["state"], "done");
    let (status, endless) = farm.json(Method::POST, "/v1/jobs", &[("Prefer", "wait=1")], Some(job(1_000_000))).await;
    assert!(status == 202 && endless["state"] != "done", "{endless}");
    let path = format!("/v1/jobs/{}", endless["id"].as_str().expect("an id"));
    let cancel = async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        farm.json(Method::POST, &format!("{path}/cancel"), &[], None).await
    };
    let (waited, _) = tokio::join!(farm.json(Method::GET, &path, &wait, None), cancel);
    assert_eq!(waited.1["state"], "cancelled");
    let longer = farm.send(Method::GET, &path, &[("Prefer", "wait=100000")], None).await;
    assert_eq!(header(&longer, "preference-applied"), "wait=60", "what is not done as asked is said");
}

/// Two who change the same job do not undo each other's changes unseen.
#[tokio::test(flavor = "multi_thread")]
async fn changes_are_made_to_what_was_seen() {
    let farm = Farm::in_memory(1).await;
    let (_, created) = farm.json(Method::POST, "/v1/jobs", &[("Prefer", "wait=60")], Some(job(3))).await;
    let path = format!("/v1/jobs/{}", created["id"].as_str().expect("an id"));
    let seen = header(&farm.send(Method::GET, &path, &[], None).await, "etag");
    let patch = async |tag: &str, name: &str| {
        farm.send(Method::PATCH, &path, &[("If-Match", tag)], Some(json!({ "name": name }))).await
    };
    let changed = patch(&seen, "one").await;
    assert_eq!(changed.status(), 200);
    let newer = header(&changed, "etag");
    assert_eq!(header(&farm.send(Method::GET, &path, &[], None).await, "etag"), newer);
    let refused = patch(&seen, "two").await;
    assert_eq!(refused.status(), 412);
    assert_eq!(patch("*", "three").await.status(), 200);
    assert_eq!(farm.json(Method::GET, &path, &[], None).await.1["name"], "three");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_can_be_checked_without_making_it() {
    let farm = Farm::in_memory(0).await;
    let check = async |body: Value| farm.json(Method::POST, "/v1/jobs/validate", &[], Some(body)).await;
    let (status, checked) = check(json!({ "scene_inline": SCENE, "method": "ppm", "stop": { "seconds": 3 } })).await;
    assert_eq!(status, 200, "{checked}");
    assert!(checked["method"] == "ppm" && checked["width"] == 64 && checked["parameters"].is_object(), "{checked}");
    assert_eq!(farm.jobs().await, 0);
    let (_, scenes) = farm.json(Method::GET, "/v1/scenes", &[], None).await;
    assert_eq!(scenes["scenes"].as_array().map(Vec::len), Some(0), "nothing is kept");
    assert_eq!(check(json!({ "scene_inline": SCENE, "method": "nothing" })).await.0, 422);
    assert_eq!(check(json!({ "scene_inline": "<scene" })).await.0, 422);
    assert_eq!(check(json!({ "method": "ppm" })).await.0, 422);
}

/// The events of a stream until one `is_last`, each as name, id and data.
async fn events(mut stream: Response, is_last: impl Fn(&Event) -> bool) -> Vec<Event> {
    let (mut text, mut events) = (String::new(), Vec::new());
    loop {
        let chunk = stream.chunk().await.expect("it goes on").expect("it does not end");
        text.push_str(std::str::from_utf8(&chunk).expect("text"));
        while let Some(end) = text.find("\n\n") {
            let block: String = text.drain(..end + 2).collect();
            let field = |name: &str| {
                let line = block.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
                line.map(|value| value.trim().to_owned()).unwrap_or_default()
            };
            if field("event").is_empty() {
                continue;
            }
            let data = serde_json::from_str(&field("data")).expect("JSON");
            let event = Event { name: field("event"), id: field("id"), data };
            let is_end = is_last(&event);
            events.push(event);
            if is_end {
                return events;
            }
        }
    }
}

#[derive(Debug)]
struct Event {
    name: String,
    id: String,
    data: Value,
}

#[tokio::test(flavor = "multi_thread")]
async fn one_stream_tells_of_all_jobs_and_of_what_was_missed() {
    let farm = Farm::in_memory(1).await;
    let submit = async |passes: u32| {
        let (_, created) = farm.json(Method::POST, "/v1/jobs", &[("Prefer", "wait=60")], Some(job(passes))).await;
        created["id"].as_str().expect("an id").to_owned()
    };
    let old = submit(2).await;
    let stream = farm.send(Method::GET, "/v1/events", &[], None).await;
    let new = async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        submit(3).await
    };
    let is_end = |event: &Event| event.data["id"] != old && event.data["state"] == "done" && !event.id.is_empty();
    let (seen, new) = tokio::join!(events(stream, is_end), new);
    assert_eq!(seen[0].data["id"], old, "those that are there come first: {seen:?}");
    assert!(seen.iter().any(|event| event.data["id"] == new && event.data["links"]["self"].is_string()));
    let last = seen.last().expect("events").id.clone();

    // Two things happen while nobody listens.
    farm.send(Method::DELETE, &format!("/v1/jobs/{old}"), &[], None).await;
    farm.json(Method::PATCH, &format!("/v1/jobs/{new}"), &[], Some(json!({ "name": "changed" }))).await;
    let stream = farm.send(Method::GET, "/v1/events", &[("Last-Event-ID", &last)], None).await;
    let missed = events(stream, |event| !event.id.is_empty()).await;
    let told: Vec<(&str, &Value)> = missed.iter().map(|event| (event.name.as_str(), &event.data["id"])).collect();
    assert_eq!(told, [("deleted", &json!(old)), ("status", &json!(new))], "{missed:?}");
    assert_eq!(missed[1].data["name"], "changed");

    // What an earlier coordinator numbered says nothing here.
    let stream = farm.send(Method::GET, "/v1/events", &[("Last-Event-ID", "17-3")], None).await;
    let again = events(stream, |event| !event.id.is_empty()).await;
    assert_eq!(again[0].name, "reset", "{again:?}");
    assert_eq!(again.len(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn downloads_go_on_where_they_broke_off() {
    let farm = Farm::in_memory(1).await;
    let (_, created) = farm.json(Method::POST, "/v1/jobs", &[("Prefer", "wait=60")], Some(job(2))).await;
    let path = format!("/v1/jobs/{}/image.exr", created["id"].as_str().expect("an id"));
    let whole = farm.send(Method::GET, &path, &[], None).await;
    assert_eq!(header(&whole, "accept-ranges"), "bytes");
    let tag = header(&whole, "etag");
    let whole = whole.bytes().await.expect("a body");
    let part = async |range: &str, tag: &str| {
        let response = farm.send(Method::GET, &path, &[("Range", range), ("If-Range", tag)], None).await;
        let (status, place) = (response.status().as_u16(), header(&response, "content-range"));
        (status, place, response.bytes().await.expect("a body"))
    };
    let length = whole.len();
    let (status, place, bytes) = part("bytes=100-", &tag).await;
    assert_eq!((status, place), (206, format!("bytes 100-{}/{length}", length - 1)));
    assert!(bytes == whole.slice(100..));
    let (status, _, bytes) = part("bytes=0-9", &tag).await;
    assert!(status == 206 && bytes == whole.slice(..10));
    let (status, _, bytes) = part("bytes=-7", &tag).await;
    assert!(status == 206 && bytes == whole.slice(length - 7..));
    let (status, _, bytes) = part(&format!("bytes=-{}", length + 1), &tag).await;
    assert!(status == 200 && bytes == whole, "the last so many of fewer bytes are all");
    let (status, _, bytes) = part("bytes=100-", "\"another picture\"").await;
    assert!(status == 200 && bytes == whole, "another picture begins anew");
    let (status, place, _) = part(&format!("bytes={length}-"), &tag).await;
    assert_eq!((status, place), (416, format!("bytes */{length}")));
    let (status, _, bytes) = part("bytes=0-1,5-6", &tag).await;
    assert!(status == 200 && bytes == whole);
}

fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).expect("a file");
        archive.write_all(bytes).expect("written");
    }
    archive.finish().expect("an archive").into_inner()
}

/// A point of the world in the picture, from (0, 0) in the upper left to (1, 1) in the lower right corner.
fn in_picture(layout: &Value, point: [f64; 3]) -> [f64; 2] {
    let row = |row: usize, column: usize| layout["world_to_ndc"][4 * row + column].as_f64().expect("a matrix");
    let along = |column| row(3, column) + (0..3).map(|axis| point[axis] * row(axis, column)).sum::<f64>();
    [along(0) / along(3), along(1) / along(3)]
}

/// What is needed to draw paths of light: where the camera looks to, and lights with names from which a path may start.
#[tokio::test(flavor = "multi_thread")]
async fn camera_and_lights_are_told() {
    let farm = Farm::in_memory(0).await;
    let scene = farm.local.client().add_scene(archive(&ROOMS)).await.expect("a scene").hash;
    let rooms = json!({ "scene": scene, "scene_changes": { "width": 32 }, "method": "path", "stop": { "passes": 1 } });
    let (_, job) = farm.json(Method::POST, "/v1/jobs", &[], Some(rooms.clone())).await;
    let path = format!("/v1/jobs/{}/layout", job["id"].as_str().expect("an id"));
    let (status, layout) = farm.json(Method::GET, &path, &[], None).await;
    assert_eq!(
        (status, &layout["lights_left_out"], &layout["first_pixel"]),
        (200, &json!(0), &json!([0, 0])),
        "{layout}"
    );
    let middle = in_picture(&layout, [0.55, 0.8, -1.6]);
    assert!(middle.iter().all(|place| (place - 0.5).abs() < 1e-4), "{middle:?}");
    let lights = layout["lights"].as_array().expect("a list");
    let names: Vec<&str> = lights.iter().filter_map(|light| light["name"].as_str()).collect();
    assert_eq!(names, ["lamp-2", "lamp-5", "lamp-4", "lamp-3", "lamp-1", "lamp-faint"], "by power");
    assert!(
        lights.iter().all(|light| light["kind"] == "area" && light["points"].as_array().expect("places").len() == 8)
    );
    // Every place of lamp-3 stands above the floor before the doorway.
    for point in lights[3]["points"].as_array().expect("places") {
        let paths = json!([{ "points": [point, [-0.75, 0, -3]] }]);
        let mut job = rooms.clone();
        (job["method"], job["parameters"]) = (json!("mlt"), json!({ "user_paths": paths }));
        let (status, checked) = farm.json(Method::POST, "/v1/jobs/validate", &[], Some(job)).await;
        assert_eq!(status, 200, "{point}: {checked}");
    }
    assert_eq!(farm.json(Method::GET, "/v1/jobs/00000000/layout", &[], None).await.0, 404);
    let mut part = rooms;
    part["scene_changes"]["crop"] = json!({ "x": 7, "y": 3, "width": 4, "height": 5 });
    let (_, job) = farm.json(Method::POST, "/v1/jobs", &[], Some(part)).await;
    let path = format!("/v1/jobs/{}/layout", job["id"].as_str().expect("an id"));
    assert_eq!(farm.json(Method::GET, &path, &[], None).await.1["first_pixel"], json!([7, 3]));
}

/// One worker delivers nonsense and is told of; another is sent away, and a third does the rest.
#[tokio::test(flavor = "multi_thread")]
async fn workers_say_what_went_wrong_and_leave_when_they_are_sent_away() {
    let farm = Farm::in_memory(1).await;
    let workers = async || {
        farm.json(Method::GET, "/v1/workers", &[], None).await.1["workers"].as_array().cloned().unwrap_or_default()
    };
    let number = |worker: &Value| worker["id"].as_str().expect("a number").to_owned();
    let own = number(&workers().await[0]);
    let hand = Hand::register(&farm.base, None, BUILD).await.expect("a place");
    let (_, endless) = farm.json(Method::POST, "/v1/jobs", &[], Some(job(1_000_000))).await;
    let lease = hand.lease().await;
    assert_eq!(hand.deliver(&lease, Some(Outcome::Failure("out of photons".into()))).await, 200);
    let failed = workers().await.into_iter().find(|worker| worker["name"] == "hand").expect("it is there");
    let error = &failed["last_error"];
    assert_eq!((&error["job"], &error["problem"]), (&endless["id"], &json!("out of photons")), "{failed}");
    assert!(error["work"].is_string() && error["time"].as_u64().is_some_and(|time| time > 1_700_000_000), "{failed}");
    let (status, drained) = farm.json(Method::POST, &format!("/v1/workers/{own}/drain"), &[], None).await;
    assert_eq!((status, &drained["state"]), (200, &json!("draining")), "{drained}");
    let gone = async {
        while workers().await.iter().any(|worker| number(worker) == own) {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(30), gone).await.expect("it leaves when it has done what it holds");
    for unknown in [own.as_str(), "no-number"] {
        let (status, problem) = farm.json(Method::POST, &format!("/v1/workers/{unknown}/drain"), &[], None).await;
        assert_eq!(
            (status, problem["type"].as_str()),
            (404, Some("urn:photonfarm:problem:unknown-worker")),
            "{problem}"
        );
    }
    let (_, journal) = farm.json(Method::GET, "/v1/journal", &[], None).await;
    let told = |text: &str| {
        journal["lines"]
            .as_array()
            .expect("lines")
            .iter()
            .any(|line| line["text"].as_str().is_some_and(|line| line.contains(text)))
    };
    assert!(told("was told to leave by") && told(" left"), "{journal}");
}

/// The description is what programs are generated from: a change of it is looked at.
#[tokio::test(flavor = "multi_thread")]
async fn the_description_changes_only_on_purpose() {
    let farm = Farm::in_memory(0).await;
    let text = farm.send(Method::GET, "/openapi.json", &[], None).await.text().await.expect("text");
    insta::assert_snapshot!(text);
}
