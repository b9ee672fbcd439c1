//! The API over real HTTP: a coordinator at a free port, workers in this process, and a plain client.

use std::io::Cursor;
use std::time::Duration;

use crate::exr_channels::exr_channels;
use crate::http_client::http_client;
use exr::meta::MetaData;
use exr::prelude::LayerAttributes;
use photonfarm::api;
use photonfarm::estimate::picture_files::{LAYERS, decode_exr};
use photonfarm::farm::wire::BUILD;
use photonfarm::farm::wire::messages::RegisterRequest;
use photonfarm::farm::{CoordinatorOptions, Limits, LocalFarm};
use photonfarm::method::METHODS;
use prost::Message;
use reqwest::header;
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");
const FIRST_SURFACE: &str = "image.exr?layers=albedo,normal,depth,position";

/// A coordinator and its workers; all end when this is dropped.
pub(crate) struct Farm {
    base: String,
    http: reqwest::Client,
    _local: LocalFarm,
}

impl Farm {
    /// The beginning of the answer to a POST whose body does not come whole.
    async fn status_of_unfinished(&self, path: &str, headers: &str, body: &str) -> String {
        let address = self.base.trim_start_matches("http://");
        let mut stream = TcpStream::connect(address).await.expect("a connection");
        let request = format!("POST {path} HTTP/1.1\r\nHost: {address}\r\n{headers}\r\n\r\n{body}");
        stream.write_all(request.as_bytes()).await.expect("sent");
        let mut answer = vec![0; "HTTP/1.1 200".len()];
        stream.read_exact(&mut answer).await.expect("an answer");
        String::from_utf8_lossy(&answer).into_owned()
    }

    pub(crate) async fn start(workers: usize) -> Self {
        Self::start_with(workers, Limits::default()).await
    }

    async fn start_with(workers: usize, limits: Limits) -> Self {
        let routes = |coordinator, shutdown| api::router(api::ApiState { coordinator, shutdown });
        let options = CoordinatorOptions { limits, ..CoordinatorOptions::default() };
        let local =
            LocalFarm::builder().workers(workers).options(options).routes(routes).start().await.expect("a farm");
        let http = http_client(Duration::from_secs(120));
        Self { base: local.url(), http, _local: local }
    }

    pub(crate) async fn get(&self, path: &str) -> reqwest::Response {
        self.http.get(format!("{}{path}", self.base)).send().await.expect("an answer")
    }

    pub(crate) async fn post(&self, path: &str, body: impl Into<reqwest::Body>) -> reqwest::Response {
        let request = self.http.post(format!("{}{path}", self.base)).header(header::CONTENT_TYPE, "application/json");
        request.body(body).send().await.expect("an answer")
    }

    /// Submits a job of the furnace with an inline scene; tells its id.
    async fn submit(&self, stop: Value) -> String {
        let job = json!({ "scene_inline": SCENE, "method": "sppm", "parameters": { "photons_per_pass": 2000 }, "stop": stop });
        let response = self.post("/v1/jobs", job.to_string()).await;
        let (status, body) = answer(response).await;
        assert_eq!(status, 202, "{body}");
        body["id"].as_str().expect("an id").to_owned()
    }

    /// Reads a job's events until the stream ends.
    pub(crate) async fn events(&self, id: &str) -> Vec<Value> {
        let text = self.get(&format!("/v1/jobs/{id}/events")).await.text().await.expect("a stream that ends");
        let data = text.lines().filter_map(|line| line.strip_prefix("data:"));
        data.map(|data| serde_json::from_str(data).expect("JSON")).collect()
    }
}

async fn answer(response: reqwest::Response) -> (u16, Value) {
    let status = response.status().as_u16();
    let bytes = response.bytes().await.expect("a body");
    (status, serde_json::from_slice(&bytes).expect("JSON"))
}

/// Checks that an answer is a problem of the expected kind, and gives it.
async fn problem(response: reqwest::Response, status: u16, kind: &str) -> Value {
    let content_type = response.headers()[header::CONTENT_TYPE].to_str().expect("text").to_owned();
    let (found, body) = answer(response).await;
    assert_eq!((found, content_type.as_str()), (status, "application/problem+json"), "{body}");
    assert_eq!(body["type"], format!("urn:photonfarm:problem:{kind}"));
    assert_eq!(body["status"], status);
    assert!(body["detail"].as_str().is_some_and(|detail| !detail.is_empty()), "{body}");
    assert!(body["remedy"].as_str().is_some_and(|remedy| !remedy.is_empty()), "{body}");
    body
}

#[tokio::test(flavor = "multi_thread")]
async fn a_scene_becomes_a_picture() {
    let farm = Farm::start(2).await;
    let uploaded = farm.post("/v1/scenes", SCENE).await;
    let location = uploaded.headers()[header::LOCATION].to_str().expect("text").to_owned();
    let (status, scene) = answer(uploaded).await;
    assert_eq!((status, &scene["width"], &scene["height"]), (201, &json!(64), &json!(64)));
    assert_eq!(scene["links"]["self"], location);
    assert_eq!(answer(farm.get(&location).await).await, (200, scene.clone()));

    let job = json!({ "scene": scene["hash"], "method": "sppm", "parameters": { "photons_per_pass": 2000 }, "stop": { "passes": 4 }, "seed": 7 });
    let accepted = farm.post("/v1/jobs", job.to_string()).await;
    let location = accepted.headers()[header::LOCATION].to_str().expect("text").to_owned();
    let (status, job) = answer(accepted).await;
    assert_eq!((status, &job["links"]["self"]), (202, &json!(location)));

    let events = farm.events(job["id"].as_str().expect("an id")).await;
    let last = events.last().expect("at least one event");
    assert_eq!((&last["state"], &last["passes_done"], &last["seed"]), (&json!("done"), &json!(4), &json!(7)));
    let (_, list) = answer(farm.get("/v1/jobs").await).await;
    assert_eq!(list["jobs"][0]["links"], job["links"]);
    let (_, methods) = answer(farm.get("/v1/methods").await).await;
    assert_eq!(methods["methods"][0]["name"], "sppm");
    assert_eq!(methods["methods"][0]["parameters"][0]["name"], "alpha");
    let (_, workers) = answer(farm.get("/v1/workers").await).await;
    assert_eq!(workers["workers"].as_array().map(Vec::len), Some(2));

    let path = job["links"]["image_exr"].as_str().expect("an address");
    let image = farm.get(path).await;
    assert_eq!(image.headers()[header::CONTENT_TYPE], "image/x-exr");
    assert_eq!(image.headers()[header::CACHE_CONTROL], "no-cache");
    let picture = decode_exr(&image.bytes().await.expect("bytes")).expect("an EXR");
    assert_eq!((picture.width, picture.height), (64, 64));
    assert!(picture.radiance.iter().flatten().all(|value| value.is_finite() && *value > 0.0));

    let bound = last["estimated_error"]["bound"].as_f64().expect("an error estimate");
    assert!(bound > 0.0 && last["estimated_error"]["confidence"] == 0.95);
    let chart = farm.get(job["links"]["chart_svg"].as_str().expect("an address")).await;
    assert_eq!(chart.headers()[header::CONTENT_TYPE], "image/svg+xml");
    let chart = chart.text().await.expect("text");
    assert!(chart.starts_with("<svg") && chart.contains("after 4 passes"), "{chart}");
}

/// The answer to `auto` comes before any trial; workers try, and the method that they found is written into the job, with the reason.
#[tokio::test(flavor = "multi_thread")]
async fn auto_is_chosen_by_workers_and_written_into_the_job() {
    let farm = Farm::start(1).await;
    let scene = serde_json::from_str::<serde_json::Value>(SMALL_SCENE).expect("JSON");
    let job = json!({ "scene_inline": scene, "method": "auto", "stop": { "passes": 2 } });
    let (status, job) = answer(farm.post("/v1/jobs", job.to_string()).await).await;
    assert_eq!((status, &job["method"], &job["state"]), (202, &json!("auto"), &json!("queued")), "{job}");
    let events = farm.events(job["id"].as_str().expect("an id")).await;
    assert!(events.iter().any(|event| event["state"] == "choosing"), "{events:?}");
    let job = events.last().expect("an event");
    assert_eq!(job["state"], "done");
    let chosen = job["method"].as_str().expect("a name");
    assert!(METHODS.iter().any(|method| method.name == chosen), "{chosen}");
    let notices = job["notices"].as_array().expect("a list");
    let reason = format!("auto chose {chosen}, ");
    assert!(notices.iter().any(|notice| notice.as_str().is_some_and(|text| text.starts_with(&reason))), "{notices:?}");
    let wrong = json!({ "scene_inline": scene, "method": "auto", "parameters": { "no_such": 1 } });
    let (status, problem) = answer(farm.post("/v1/jobs", wrong.to_string()).await).await;
    assert!(status == 422 && problem.to_string().contains("no_such"), "{problem}");
}

/// The case of an error that nobody reaches: the trials are bounded, and end when the job is cancelled.
#[tokio::test(flavor = "multi_thread")]
async fn trials_end_when_their_job_is_cancelled() {
    let farm = Farm::start(1).await;
    let job = json!({ "scene_inline": SCENE, "method": "auto", "stop": { "error": 1e-12 } });
    let (status, job) = answer(farm.post("/v1/jobs", job.to_string()).await).await;
    assert_eq!(status, 202, "{job}");
    let path = job["links"]["self"].as_str().expect("an address").to_owned();
    while answer(farm.get(&path).await).await.1["state"] != "choosing" {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let (_, cancelled) = answer(farm.post(&format!("{path}/cancel"), "").await).await;
    assert_eq!(cancelled["state"], "cancelled");
    // The only worker is free for others as soon as it hears of it, by its next heartbeat.
    let id = farm.submit(json!({ "passes": 1 })).await;
    assert_eq!(farm.events(&id).await.last().expect("an event")["state"], "done");
}

const SMALL_SCENE: &str = r#"{"type": "scene",
    "sensor": {"type": "perspective", "fov": 40,
        "to_world": [{"look_at": {"origin": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0]}}],
        "film": {"type": "hdrfilm", "width": 16, "height": 16}},
    "ball": {"type": "sphere"}, "sky": {"type": "constant"}}"#;

#[tokio::test(flavor = "multi_thread")]
async fn an_unchanged_image_is_not_sent_twice() {
    let farm = Farm::start(1).await;
    let id = farm.submit(json!({ "passes": 1 })).await;
    farm.events(&id).await;
    let mut tags = Vec::new();
    let variants = [
        "image.png",
        "image.png?exposure=1.5",
        "image.png?exposure=auto",
        "image.png?tone=filmic",
        "image.png?tone=agx",
        "image.png?bits=16",
        "image.jpg",
        "image.jpg?quality=50",
        "image.jpg?tone=agx&exposure=auto",
        "image.webp",
        "image.webp?tone=agx",
        "image.exr",
        "image.exr?half=true",
        "image.exr?layers=radius,photons",
        FIRST_SURFACE,
        "map.png?layer=radius",
        "map.svg?layer=radius",
        "map.svg?layer=radius&scale=log",
    ];
    for variant in variants {
        let path = format!("/v1/jobs/{id}/{variant}");
        let first = farm.get(&path).await;
        let tag = first.headers()[header::ETAG].to_str().expect("text").to_owned();
        let bytes = first.bytes().await.expect("bytes");
        let ask = |tag: String| farm.http.get(format!("{}{path}", farm.base)).header(header::IF_NONE_MATCH, tag).send();
        let unchanged = ask(format!("\"other\", {tag}")).await.expect("an answer");
        assert_eq!((unchanged.status().as_u16(), unchanged.headers()[header::ETAG].to_str().ok()), (304, Some(&*tag)));
        let other = ask("\"other\"".to_owned()).await.expect("an answer");
        assert_eq!(
            (other.status().as_u16(), other.bytes().await.expect("bytes")),
            (200, bytes),
            "the same bytes again"
        );
        tags.push(tag);
    }
    tags.sort_unstable();
    tags.dedup();
    assert_eq!(tags.len(), variants.len(), "every variant has its own tag");
}

/// Every format of a picture to look at is what its name says, at the tone and exposure that were asked for.
#[tokio::test(flavor = "multi_thread")]
async fn pictures_to_look_at_have_many_formats() {
    let farm = Farm::start(1).await;
    let id = farm.submit(json!({ "passes": 1 })).await;
    farm.events(&id).await;
    let decoded = async |path: &str, media_type: &str| {
        let answer = farm.get(&format!("/v1/jobs/{id}/{path}")).await;
        assert_eq!(
            (answer.status().as_u16(), answer.headers()[header::CONTENT_TYPE].to_str().ok()),
            (200, Some(media_type))
        );
        assert_eq!(answer.headers()[header::ACCEPT_RANGES], "bytes");
        image::load_from_memory(&answer.bytes().await.expect("bytes")).expect("decodes")
    };
    let png = decoded("image.png?bits=8&exposure=-1", "image/png").await;
    assert_eq!(png.color(), image::ColorType::Rgb8);
    assert_eq!(decoded("image.png?bits=16&exposure=-1", "image/png").await.color(), image::ColorType::Rgb16);
    assert!(decoded("image.webp?exposure=-1", "image/webp").await.to_rgb8() == png.to_rgb8());
    let jpeg = decoded("image.jpg?exposure=-1&quality=100", "image/jpeg").await.to_rgb8();
    assert!(jpeg.iter().zip(png.to_rgb8().iter()).all(|(a, b)| a.abs_diff(*b) < 12));
    // The furnace is about as bright everywhere: exposed by itself it is middle grey, which AgX shows as half of all code values.
    let auto = decoded("image.png?tone=agx&exposure=auto", "image/png").await.to_rgb8();
    let mean = auto.iter().map(|byte| f64::from(*byte)).sum::<f64>() / auto.len() as f64;
    assert!((mean - 127.5).abs() < 8.0, "{mean}");
}

/// What an EXR says of its job in the attributes that OpenEXR names; the time is the job's, not the file's.
#[tokio::test(flavor = "multi_thread")]
async fn an_exr_tells_camera_and_time() {
    let farm = Farm::start(1).await;
    let id = farm.submit(json!({ "passes": 1 })).await;
    farm.events(&id).await;
    let path = format!("/v1/jobs/{id}/image.exr?half=true");
    let read = async || {
        let answer = farm.get(&path).await;
        let tag = answer.headers()[header::ETAG].clone();
        (tag, answer.bytes().await.expect("bytes"))
    };
    let attributes = |bytes: &[u8]| -> LayerAttributes {
        MetaData::read_from_buffered(Cursor::new(bytes), true).expect("an EXR").headers[0].own_attributes.clone()
    };
    let (tag, first) = read().await;
    let known = attributes(&first);
    let date = known.capture_date.expect("a date").to_string();
    assert!(date.len() == 19 && date.starts_with("20") && date.as_bytes()[4] == b':', "{date}");
    assert_eq!((known.utc_offset, known.owner), (Some(0.0), None));
    let camera = known.world_to_camera.expect("a matrix");
    // The furnace is seen from (0.2, 0.1, 0.9).
    for axis in 0..3 {
        let place = 0.2 * camera[axis] + 0.1 * camera[4 + axis] + 0.9 * camera[8 + axis] + camera[12 + axis];
        assert!(place.abs() < 1e-5, "{camera:?}");
    }
    assert!(known.world_to_normalized_device.is_some());
    assert_eq!(known.comments.expect("a comment").to_string(), "1 pass of sppm, radiance in W/(sr*m^2)");
    tokio::time::sleep(Duration::from_millis(1100)).await;
    assert_eq!(read().await, (tag.clone(), first));

    let job = format!("{}/v1/jobs/{id}", farm.base);
    let change = farm.http.patch(job).header(header::CONTENT_TYPE, "application/json").body(r#"{"name":"box"}"#);
    assert_eq!(change.send().await.expect("an answer").status().as_u16(), 200);
    let (renamed, bytes) = read().await;
    assert_ne!(renamed, tag, "the name is in the header");
    let comments = attributes(&bytes).comments.expect("a comment").to_string();
    assert_eq!(comments, "box: 1 pass of sppm, radiance in W/(sr*m^2)");
}

#[tokio::test(flavor = "multi_thread")]
async fn first_surfaces_are_layers_in_any_order() {
    let farm = Farm::start(1).await;
    let id = farm.submit(json!({ "passes": 1 })).await;
    problem(farm.get(&format!("/v1/jobs/none/{FIRST_SURFACE}")).await, 404, "unknown-job").await;
    farm.events(&id).await;
    let first = farm.get(&format!("/v1/jobs/{id}/{FIRST_SURFACE}")).await;
    let tag = first.headers()[header::ETAG].clone();
    let bytes = first.bytes().await.expect("bytes");
    let channels = exr_channels(&bytes);
    let names: Vec<&str> = channels.keys().map(String::as_str).collect();
    let layers = ["albedo.B", "albedo.G", "albedo.R", "depth.Z", "normal.X", "normal.Y", "normal.Z"];
    let position = ["position.X", "position.Y", "position.Z"];
    assert_eq!(names, [["B", "G", "R"].as_slice(), layers.as_slice(), position.as_slice()].concat());
    // A closed box of side 2, all of one grey.
    assert!(channels["albedo.G"].iter().all(|albedo| (albedo - 0.8).abs() < 1e-5));
    assert!(channels["depth.Z"].iter().all(|depth| *depth > 0.1 && *depth < 3.5));
    let within = position.map(|axis| channels[axis].iter().all(|place| place.abs() < 1.00001));
    assert_eq!(within, [true; 3], "all of it is in the box");
    let again = farm.get(&format!("/v1/jobs/{id}/image.exr?layers=position,depth,albedo,normal,depth")).await;
    assert_eq!(again.headers()[header::ETAG], tag);
    assert_eq!(again.bytes().await.expect("bytes"), bytes);
}

/// The furnace with a second lamp in a light group, or with so many.
fn scene_of_groups(groups: &[&str]) -> String {
    let lamp = |group: &&str| {
        format!(
            "<emitter type='point'><rgb name='intensity' value='1'/><string name='light_group' value='{group}'/></emitter>"
        )
    };
    SCENE.replace("</scene>", &(groups.iter().map(lamp).collect::<String>() + "</scene>"))
}

#[tokio::test(flavor = "multi_thread")]
async fn light_groups_are_layers_whose_sum_is_the_picture() {
    let farm = Farm::start(1).await;
    let parameters = json!({ "photons_per_pass": 2000 });
    let job = json!({ "scene_inline": scene_of_groups(&["bulb"]), "method": "sppm", "parameters": parameters,
        "stop": { "passes": 2 }, "light_groups": true });
    let (_, valid) = answer(farm.post("/v1/jobs/validate", job.to_string()).await).await;
    assert_eq!(valid["light_groups"], json!(["bulb", "others"]));
    let (status, body) = answer(farm.post("/v1/jobs", job.to_string()).await).await;
    assert_eq!((status, &body["light_groups"]), (202, &json!(["bulb", "others"])));
    let id = body["id"].as_str().expect("an id");
    farm.events(id).await;
    let exr = farm.get(&format!("/v1/jobs/{id}/image.exr?layers=light_groups")).await.bytes().await.expect("bytes");
    let channels = exr_channels(&exr);
    assert_eq!(channels.len(), 9);
    for color in ["R", "G", "B"] {
        let of = |group: &str| &channels[&format!("light_group.{group}.{color}")];
        let whole = of("bulb").iter().zip(of("others")).map(|(bulb, others)| bulb + others).zip(&channels[color]);
        assert!(of("bulb").iter().any(|value| *value > 0.0) && of("others").iter().any(|value| *value > 0.0));
        assert!(whole.into_iter().all(|(sum, whole)| (sum - whole).abs() <= 1e-6 * whole), "{color}");
    }
    let pixels = async |layer: &str| {
        let answer = farm.get(&format!("/v1/jobs/{id}/pixels?layer={layer}&level=3")).await;
        let names = answer.headers()["photonfarm-channels"].to_str().expect("text").to_owned();
        (names, answer.bytes().await.expect("bytes").len())
    };
    let (bulb, others) = (
        "light_group.bulb.R,light_group.bulb.G,light_group.bulb.B",
        "light_group.others.R,light_group.others.G,light_group.others.B",
    );
    assert_eq!(pixels("light_group.others").await, (others.to_owned(), 8 * 8 * 12));
    assert_eq!(pixels("light_groups").await, (format!("{bulb},{others}"), 8 * 8 * 24));
    let map = farm.get(&format!("/v1/jobs/{id}/map.svg?layer=light_group.bulb")).await.text().await.expect("text");
    assert!(map.contains("light_group.bulb: light of each light group"), "{}", &map[..400]);
    let unknown =
        problem(farm.get(&format!("/v1/jobs/{id}/pixels?layer=light_group.rim")).await, 422, "bad-request").await;
    assert_eq!(unknown["remedy"], "it has bulb, others");
    // A clone is a job of the same kind.
    let (_, clone) = answer(farm.post(&format!("/v1/jobs/{id}/clone"), "{}").await).await;
    assert_eq!(clone["light_groups"], json!(["bulb", "others"]));
}

#[tokio::test(flavor = "multi_thread")]
async fn light_groups_that_cannot_be_are_refused() {
    let farm = Farm::start(1).await;
    let submit = async |scene: String, method: &str, parameters: Value| {
        let job = json!({ "scene_inline": scene, "method": method, "parameters": parameters, "light_groups": true });
        farm.post("/v1/jobs", job.to_string()).await
    };
    let names: Vec<String> = (0..16).map(|index| format!("lamp-{index}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let many = problem(submit(scene_of_groups(&names), "path", json!({})).await, 422, "bad-method").await;
    assert_eq!(many["detail"], "light groups cannot be kept apart: the scene has 17");
    assert_eq!(many["remedy"], "give its lights at most 16");
    let alike = problem(submit(scene_of_groups(&["key", "Key"]), "path", json!({})).await, 422, "bad-scene").await;
    assert_eq!(alike["detail"], "light groups \"key\" and \"Key\" differ only by case");
    assert!(alike["place"].as_str().is_some_and(|place| place.contains("light_group")), "{alike}");
    let hints = json!({ "user_paths": [{ "points": [[0, 0, 0], [0, -1, 0]] }] });
    let refused = problem(submit(scene_of_groups(&["key"]), "mlt", hints).await, 422, "bad-method").await;
    assert_eq!(refused["remedy"], "leave user_paths or light_groups out");
    // A job that keeps none has no such layer.
    let id = farm.submit(json!({ "passes": 1 })).await;
    farm.events(&id).await;
    for path in ["image.exr?layers=light_groups", "pixels?layer=light_groups", "map.png?layer=light_group.key"] {
        let refused = problem(farm.get(&format!("/v1/jobs/{id}/{path}")).await, 422, "bad-request").await;
        assert_eq!(refused["remedy"], "submit one with light_groups (--light-groups)", "{path}");
    }
    let (_, status) = answer(farm.get(&format!("/v1/jobs/{id}")).await).await;
    assert!(status.get("light_groups").is_none(), "{status}");
}

#[tokio::test(flavor = "multi_thread")]
async fn layers_become_maps() {
    let farm = Farm::start(1).await;
    let id = farm.submit(json!({ "passes": 4 })).await;
    farm.events(&id).await;
    let channels = farm.get(&format!("/v1/jobs/{id}/image.exr?layers=error")).await.bytes().await.expect("bytes");
    let errors = exr_channels(&channels).remove("error.Y").expect("the layer");
    assert!(errors.len() == 64 * 64 && errors.iter().all(|error| *error > 0.0 && *error < 1.0));
    let map = |form: &str| {
        let (farm, path) = (&farm, format!("/v1/jobs/{id}/map.{form}"));
        async move { farm.get(&path).await }
    };
    let png = map("png?layer=error").await;
    assert_eq!(png.headers()[header::CONTENT_TYPE], "image/png");
    assert!(png.bytes().await.expect("bytes").starts_with(b"\x89PNG"));
    for (query, title) in [
        ("", "luminance: of the picture"),
        ("?layer=radius&scale=linear&low=0&high=2", "radius: gather radius"),
        ("?layer=normal.X", "normal.X: shading normal"),
    ] {
        let svg = map(&format!("svg{query}")).await;
        assert_eq!(
            (svg.status().as_u16(), &svg.headers()[header::CONTENT_TYPE]),
            (200, &"image/svg+xml".parse().expect("a value"))
        );
        let text = svg.text().await.expect("text");
        assert!(text.contains(title) && text.contains(&format!("{id}: sppm, 4 passes")), "{title}");
    }
    let unknown = problem(map("png?layer=raduis").await, 422, "bad-request").await;
    assert!(unknown["remedy"].as_str().is_some_and(|remedy| remedy.contains("luminance, radius")), "{unknown}");
    let three = problem(map("svg?layer=normal").await, 422, "bad-request").await;
    assert!(three["detail"].as_str().is_some_and(|detail| detail.contains("normal.X")), "{three}");
    problem(map("png?low=2&high=1").await, 422, "bad-request").await;
    problem(map("png?scale=log&low=0").await, 422, "bad-request").await;
    problem(map("png?scale=cubic").await, 400, "bad-query").await;
    problem(farm.get("/v1/jobs/none/map.png").await, 404, "unknown-job").await;
    // One pass tells nothing of its error.
    let id = farm.submit(json!({ "passes": 1 })).await;
    farm.events(&id).await;
    problem(farm.get(&format!("/v1/jobs/{id}/map.png?layer=error")).await, 404, "no-value-yet").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_job_ends_and_stays_cancelled() {
    let farm = Farm::start(0).await;
    let id = farm.submit(json!({ "passes": 1000 })).await;
    problem(farm.get(&format!("/v1/jobs/{id}/image.png")).await, 404, "no-picture-yet").await;
    let (status, job) = answer(farm.post(&format!("/v1/jobs/{id}/cancel"), "").await).await;
    assert_eq!(status, 200, "{job}");
    let events = farm.events(&id).await;
    assert_eq!(events.last().expect("an event")["state"], "cancelled");
    let (_, again) = answer(farm.post(&format!("/v1/jobs/{id}/cancel"), "").await).await;
    assert_eq!(again["state"], "cancelled");
}

#[tokio::test(flavor = "multi_thread")]
async fn unknown_things_are_told() {
    let farm = Farm::start(0).await;
    problem(farm.get("/v1/nothing").await, 404, "unknown-address").await;
    problem(farm.get("/v1/jobs/none").await, 404, "unknown-job").await;
    problem(farm.get("/v1/jobs/none/events").await, 404, "unknown-job").await;
    problem(farm.get("/v1/jobs/none/image.exr").await, 404, "unknown-job").await;
    problem(farm.get(&format!("/v1/scenes/{}", "0".repeat(64))).await, 404, "unknown-scene").await;
    let refused = farm.post("/v1/workers", "").await;
    assert!(refused.headers()[header::ALLOW].to_str().expect("text").contains("GET"));
    problem(refused, 405, "method-not-allowed").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_jobs_are_refused_with_place_and_remedy() {
    let farm = Farm::start(0).await;
    let syntax = problem(farm.post("/v1/jobs", "{\n \"scene\": }").await, 400, "bad-json").await;
    assert_eq!(syntax["place"], "line 2, column 11");
    let unknown = problem(farm.post("/v1/jobs", "{\"sceen\": 1}").await, 422, "bad-request").await;
    assert!(unknown["detail"].as_str().is_some_and(|detail| detail.contains("sceen")), "{unknown}");
    // A list of words, a job's own fields, and dictionaries inside: nothing is given twice.
    for twice in [
        r#"{"seed": 1, "seed": 2}"#,
        r#"{"parameters": {"alpha": 0.5, "alpha": 0.6}}"#,
        r#"{"scene_inline": {"type": "scene", "a": {"type": "sphere"}, "a": {"type": "sphere"}}}"#,
    ] {
        let refused = problem(farm.post("/v1/jobs", twice).await, 422, "bad-request").await;
        let detail = refused["detail"].as_str().expect("text");
        assert!(detail.ends_with("is given twice in one object"), "its place has a field of its own: {refused}");
        assert!(refused["place"].as_str().is_some_and(|place| place.starts_with("line 1, column ")), "{refused}");
        assert_eq!(refused["remedy"], "give it once");
    }
    problem(farm.post("/v1/jobs", "{}").await, 422, "bad-request").await;
    problem(farm.post("/v1/jobs", json!({ "scene_inline": 3 }).to_string()).await, 422, "bad-request").await;
    let scene = json!({ "scene": "0".repeat(64) }).to_string();
    problem(farm.post("/v1/jobs", scene).await, 422, "unknown-scene").await;
    let job = |extra: Value| {
        let mut job = json!({ "scene_inline": SCENE, "method": "sppm" });
        job.as_object_mut().expect("an object").extend(extra.as_object().expect("an object").clone());
        farm.post("/v1/jobs", job.to_string())
    };
    problem(job(json!({ "method": "spmm" })).await, 422, "bad-method").await;
    problem(job(json!({ "parameters": { "alpha": 2 } })).await, 422, "bad-method").await;
    problem(job(json!({ "parameters": { "photons_per_pass": 0 } })).await, 422, "bad-method").await;
    problem(job(json!({ "stop": { "seconds": -1 } })).await, 422, "bad-request").await;
    problem(job(json!({ "stop": { "passes": 0 } })).await, 422, "bad-request").await;
    let request = farm.http.post(format!("{}/v1/jobs", farm.base)).body("{}").send().await.expect("an answer");
    problem(request, 415, "unsupported-media-type").await;
    let (_, list) = answer(farm.get("/v1/jobs").await).await;
    assert_eq!(list["jobs"], json!([]), "no refused job is kept");
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_scenes_are_refused_with_place_and_remedy() {
    let farm = Farm::start(0).await;
    let typo = SCENE.replace("hdrfilm", "hdrfil");
    let refused = problem(farm.post("/v1/scenes", typo).await, 422, "bad-scene").await;
    assert!(refused["remedy"].as_str().is_some_and(|remedy| remedy.contains("hdrfilm")), "{refused}");
    assert!(refused["place"].as_str().is_some_and(|place| place.contains(':')), "{refused}");
    problem(farm.post("/v1/scenes", "").await, 422, "bad-scene").await;
    problem(farm.post("/v1/scenes", vec![0xff; 100]).await, 422, "bad-scene").await;
    let too_long = "x".repeat(Limits::default().job_bytes as usize + 1);
    problem(farm.post("/v1/jobs", too_long).await, 413, "too-large").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_image_options_are_refused() {
    let farm = Farm::start(0).await;
    let id = farm.submit(json!({ "passes": 1 })).await;
    let image = |options: &str| format!("/v1/jobs/{id}/{options}");
    problem(farm.get(&image("image.png?exposure=bright")).await, 400, "bad-query").await;
    problem(farm.get(&image("image.png?exposure=NaN")).await, 422, "bad-request").await;
    problem(farm.get(&image("image.png?brightness=1")).await, 400, "bad-query").await;
    for path in ["image.png?tone=acid", "image.jpg?bits=16", "image.webp?quality=9", "image.exr?half=perhaps"] {
        problem(farm.get(&image(path)).await, 400, "bad-query").await;
    }
    for path in ["image.png?bits=12", "image.jpg?quality=0", "image.jpg?quality=101", "image.webp?exposure=65"] {
        problem(farm.get(&image(path)).await, 422, "bad-request").await;
    }
    let unknown = problem(farm.get(&image("image.exr?layers=radius,detph")).await, 422, "bad-request").await;
    assert!(unknown["detail"].as_str().is_some_and(|detail| detail.contains("detph")), "{unknown}");
    let seen = "radius, photons, error, albedo, normal, depth, position, denoised, denoised_error, light_groups";
    assert_eq!(unknown["remedy"], format!("known layers: {seen}, crypto_object, crypto_material"));
    let unseen = problem(farm.get(&image("pixels?layer=detph")).await, 422, "bad-request").await;
    assert_eq!(unseen["remedy"], format!("known layers: color, {seen}"), "ids are not looked at");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_description_names_every_address() {
    let farm = Farm::start(0).await;
    let (_, description) = answer(farm.get("/openapi.json").await).await;
    assert_eq!(answer(farm.get("/v1/openapi.json").await).await.1, description);
    let mut paths: Vec<&str> = description["paths"].as_object().expect("paths").keys().map(String::as_str).collect();
    paths.sort_unstable();
    let expected = [
        "/healthz",
        "/metrics",
        "/readyz",
        "/v1/events",
        "/v1/jobs",
        "/v1/jobs/validate",
        "/v1/jobs/{id}",
        "/v1/jobs/{id}/cancel",
        "/v1/jobs/{id}/chart.svg",
        "/v1/jobs/{id}/clone",
        "/v1/jobs/{id}/events",
        "/v1/jobs/{id}/extend",
        "/v1/jobs/{id}/history",
        "/v1/jobs/{id}/image.exr",
        "/v1/jobs/{id}/image.jpg",
        "/v1/jobs/{id}/image.png",
        "/v1/jobs/{id}/image.webp",
        "/v1/jobs/{id}/layout",
        "/v1/jobs/{id}/map.png",
        "/v1/jobs/{id}/map.svg",
        "/v1/jobs/{id}/pause",
        "/v1/jobs/{id}/pixels",
        "/v1/jobs/{id}/resume",
        "/v1/journal",
        "/v1/limits",
        "/v1/me",
        "/v1/methods",
        "/v1/scenes",
        "/v1/scenes/{hash}",
        "/v1/sequences",
        "/v1/sequences/{id}",
        "/v1/sequences/{id}/cancel",
        "/v1/sequences/{id}/pause",
        "/v1/sequences/{id}/resume",
        "/v1/session",
        "/v1/session/provider",
        "/v1/session/provider/return",
        "/v1/tokens",
        "/v1/tokens/{id}",
        "/v1/users",
        "/v1/users/{name}",
        "/v1/webhooks",
        "/v1/webhooks/{id}",
        "/v1/workers",
        "/v1/workers/{id}/drain",
        "/version",
    ];
    assert_eq!(paths, expected);
    let text = description.to_string();
    let named = text.split("\"#/components/schemas/").skip(1).filter_map(|rest| rest.split('"').next());
    let missing: Vec<&str> = named.filter(|name| description["components"]["schemas"][name].is_null()).collect();
    assert!(missing.is_empty(), "{missing:?} are named and not described");
    let operations = description["paths"].as_object().expect("paths").values();
    let operations = operations.flat_map(|path| path.as_object().expect("methods").values());
    for operation in operations {
        assert!(!operation["responses"]["default"].is_null(), "{operation} says nothing of 429 and 503");
    }
    let layers = &description["paths"]["/v1/jobs/{id}/image.exr"]["get"]["parameters"][1];
    assert_eq!((&layers["name"], &layers["in"]), (&json!("layers"), &json!("query")));
    let known = layers["description"].as_str().expect("a description");
    assert!(LAYERS.iter().all(|row| known.contains(row.name) && known.contains(row.meaning)), "{known}");
    assert_eq!(answer(farm.get("/healthz").await).await.1["status"], "ok");
    let page = farm.get("/").await.text().await.expect("a page");
    assert!(page.contains("photonfarm") && !page.contains("https://"), "loads nothing from elsewhere");
}

/// A terminal's prompt does not stand behind what `curl` prints.
#[tokio::test(flavor = "multi_thread")]
async fn answers_in_json_end_with_a_line_break() {
    let farm = Farm::start(0).await;
    let id = farm.submit(json!({ "passes": 1 })).await;
    let (job, unknown) = (format!("/v1/jobs/{id}"), "/v1/jobs/zzzzzzzz".to_owned());
    let paths =
        ["/healthz", "/openapi.json", "/v1/methods", "/v1/jobs", "/v1/scenes", "/v1/workers", "/v1/me", &job, &unknown];
    for path in paths {
        let response = farm.get(path).await;
        let kind = response.headers()[header::CONTENT_TYPE].to_str().expect("text").to_owned();
        assert!(kind.contains("json"), "{path}: {kind}");
        let text = response.text().await.expect("text");
        assert!(text.ends_with("}\n"), "{path}: {text}");
    }
}

/// Names, tags, priority, pause, copies and deletion of jobs and scenes.
#[tokio::test(flavor = "multi_thread")]
async fn jobs_are_changed_copied_and_deleted() {
    let farm = Farm::start(0).await;
    let id = farm.submit(json!({ "passes": 1000 })).await;
    let path = format!("/v1/jobs/{id}");
    let send = |method: reqwest::Method, path: String, body: Value| {
        let request = farm.http.request(method, format!("{}{path}", farm.base));
        request.header(header::CONTENT_TYPE, "application/json").body(body.to_string()).send()
    };
    let patch = json!({ "name": "kitchen", "tags": ["night"], "priority": 300 });
    let changed = send(reqwest::Method::PATCH, path.clone(), patch).await.expect("an answer");
    let (status, job) = answer(changed).await;
    assert_eq!((status, &job["name"], &job["priority"]), (200, &json!("kitchen"), &json!(300)));
    let wrong = send(reqwest::Method::PATCH, path.clone(), json!({ "priority": 0 })).await.expect("an answer");
    problem(wrong, 422, "bad-request").await;

    let (status, paused) = answer(farm.post(&format!("{path}/pause"), "").await).await;
    assert_eq!((status, &paused["state"], &paused["paused"]), (200, &json!("paused"), &json!("paused by a user")));
    problem(farm.post(&format!("{path}/pause"), "").await, 409, "conflict").await;
    let (_, resumed) = answer(farm.post(&format!("{path}/resume"), "").await).await;
    assert_eq!(resumed["state"], "queued");
    problem(farm.post(&format!("{path}/extend"), "{\"passes\": 2000}").await, 409, "conflict").await;

    let copy = farm
        .post(
            &format!("{path}/clone"),
            "{\"seed\": 9, \"stop\": {\"passes\": 5}, \"tags\": [\"copy\"], \"priority\": 7}",
        )
        .await;
    let (status, copy) = answer(copy).await;
    assert_eq!(
        (status, &copy["seed"], &copy["passes_total"], &copy["name"]),
        (202, &json!(9), &json!(5), &json!("kitchen"))
    );
    assert_eq!(copy["parameters"]["photons_per_pass"], 2000);
    assert_eq!((&copy["tags"], &copy["priority"]), (&json!(["copy"]), &json!(7)));

    let scene = job["scene"].as_str().expect("a hash").to_owned();
    let (_, scenes) = answer(farm.get("/v1/scenes").await).await;
    assert_eq!(scenes["scenes"][0]["hash"], scene);
    let in_use = send(reqwest::Method::DELETE, format!("/v1/scenes/{scene}"), json!({})).await.expect("an answer");
    problem(in_use, 409, "conflict").await;
    for job in [id, copy["id"].as_str().expect("an id").to_owned()] {
        let deleted = send(reqwest::Method::DELETE, format!("/v1/jobs/{job}"), json!({})).await.expect("an answer");
        assert_eq!(deleted.status(), 204);
        problem(farm.get(&format!("/v1/jobs/{job}")).await, 404, "unknown-job").await;
    }
    let deleted = send(reqwest::Method::DELETE, format!("/v1/scenes/{scene}"), json!({})).await.expect("an answer");
    assert_eq!(deleted.status(), 204);
    let (_, journal) = answer(farm.get("/v1/journal").await).await;
    assert!(journal.to_string().contains("is cancelled"), "{journal}");
}

/// What is too much is refused with the time to try again.
#[tokio::test(flavor = "multi_thread")]
async fn too_many_jobs_are_told_when_to_come_again() {
    let farm = Farm::start_with(0, Limits { live_jobs: 1, scene_bytes: 10_000, ..Limits::default() }).await;
    farm.submit(json!({ "passes": 1 })).await;
    let job = json!({ "scene_inline": SCENE });
    let refused = farm.post("/v1/jobs", job.to_string()).await;
    assert_eq!(refused.headers()[header::RETRY_AFTER], "5");
    problem(refused, 429, "busy").await;
    let large = farm.post("/v1/scenes", format!("{SCENE}<!-- {} -->", "x".repeat(10_000))).await;
    problem(large, 413, "too-large").await;
    let (_, limits) = answer(farm.get("/v1/limits").await).await;
    assert_eq!(limits["scene_bytes"], 10_000);
    for told in
        ["job_bytes", "pixels", "passes", "name_bytes", "tags", "tag_bytes", "live_jobs", "job_memory", "result_bytes"]
    {
        assert!(limits[told].as_u64().is_some_and(|limit| limit > 0), "{told} of {limits}");
    }
}

/// Lists by what is asked for, page by page.
#[tokio::test(flavor = "multi_thread")]
async fn jobs_are_found_by_name_tag_and_state() {
    let farm = Farm::start(0).await;
    let mut ids = Vec::new();
    for (name, tag) in [("a", "red"), ("b", "blue"), ("c", "red"), ("d", "red")] {
        let job = json!({ "scene_inline": SCENE, "stop": { "passes": 1 }, "name": name, "tags": [tag] });
        let (status, job) = answer(farm.post("/v1/jobs", job.to_string()).await).await;
        assert_eq!(status, 202);
        ids.push(job["id"].as_str().expect("an id").to_owned());
    }
    answer(farm.post(&format!("/v1/jobs/{}/cancel", ids[3]), "").await).await;
    let found = async |query: &str| {
        let (status, list) = answer(farm.get(&format!("/v1/jobs?{query}")).await).await;
        assert_eq!(status, 200, "{list}");
        let jobs = list["jobs"].as_array().expect("jobs").iter();
        let names: Vec<String> = jobs.map(|job| job["name"].as_str().expect("a name").to_owned()).collect();
        (names.concat(), list["next_after"].as_str().map(str::to_owned))
    };
    assert_eq!(found("").await, ("abcd".to_owned(), None));
    assert_eq!(found("tag=red").await, ("acd".to_owned(), None));
    assert_eq!(found("tag=red&state=queued").await, ("ac".to_owned(), None));
    assert_eq!(found("name=b").await, ("b".to_owned(), None));
    assert_eq!(found("tag=red&limit=2").await, ("ac".to_owned(), Some(ids[2].clone())));
    assert_eq!(found(&format!("tag=red&limit=2&after={}", ids[2])).await, ("d".to_owned(), None));
    for wrong in ["states=queued", "state=asleep", "limit=0", "after=", "after=!!"] {
        assert_eq!(farm.get(&format!("/v1/jobs?{wrong}")).await.status(), 400, "{wrong}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_upload_that_falls_silent_frees_its_place() {
    let farm = Farm::start_with(0, Limits { uploads: 1, silence: 1, ..Limits::default() }).await;
    assert_eq!(farm.status_of_unfinished("/v1/scenes", "Content-Length: 1000", "abc").await, "HTTP/1.1 408");
    assert_eq!(farm.post("/v1/scenes", SCENE).await.status(), 201);
}

/// A web page that a user visits changes nothing, and reads nothing under a name of its own that it points here.
#[tokio::test(flavor = "multi_thread")]
async fn foreign_pages_are_refused() {
    let farm = Farm::start(0).await;
    let id = farm.submit(json!({ "passes": 1_000_000 })).await;
    let (http, own) = (&farm.http, &farm.base);
    let post = async |path: &str, name: &'static str, value: &str| {
        http.post(format!("{own}{path}")).header(name, value).body("").send().await.expect("an answer")
    };
    let cancel = format!("/v1/jobs/{id}/cancel");
    problem(post(&cancel, "Origin", "https://evil.example").await, 403, "foreign-origin").await;
    problem(post(&cancel, "Sec-Fetch-Site", "cross-site").await, 403, "foreign-origin").await;
    problem(post(&cancel, "Host", "evil.example").await, 403, "foreign-host").await;
    assert_eq!(post("/farm/v1/register", "Origin", "https://evil.example").await.status(), 403);
    assert_eq!(post("/farm/v1/register", "Host", "evil.example").await.status(), 403);
    let read = http.get(format!("{own}/v1/jobs")).header("Host", "evil.example").send().await.expect("an answer");
    problem(read, 403, "foreign-host").await;
    assert_eq!(answer(farm.get(&format!("/v1/jobs/{id}")).await).await.1["state"], "queued");
    assert_eq!(post(&cancel, "Origin", own).await.status(), 200);
}

/// Connections that say nothing, or only half a request, are closed; a request behind them is answered.
#[tokio::test(flavor = "multi_thread")]
async fn half_open_connections_are_closed() {
    let farm = Farm::start_with(0, Limits { connections: 30, silence: 1, ..Limits::default() }).await;
    let address = farm.base.trim_start_matches("http://").to_owned();
    let mut open = Vec::new();
    for index in 0..60 {
        let mut stream = TcpStream::connect(&address).await.expect("a connection");
        if index % 2 == 0 {
            stream.write_all(b"GET /healthz HTTP/1.1\r\nHost: local").await.expect("sent");
        }
        open.push(stream);
    }
    assert_eq!(farm.get("/healthz").await.status(), 200);
    for mut stream in open {
        let mut answer = Vec::new();
        let closed = tokio::time::timeout(Duration::from_secs(20), stream.read_to_end(&mut answer));
        // A reset closes it as well.
        let _ = closed.await.expect("it is closed");
    }
    // A job's request that falls silent is told so.
    let head = "Content-Type: application/json\r\nContent-Length: 99";
    assert_eq!(farm.status_of_unfinished("/v1/jobs", head, "{").await, "HTTP/1.1 408");
}

#[tokio::test(flavor = "multi_thread")]
async fn names_cannot_hold_what_changes_a_terminal() {
    let farm = Farm::start(0).await;
    let job = json!({ "scene_inline": SCENE, "stop": { "passes": 1 }, "name": "\u{1b}[31mred" });
    problem(farm.post("/v1/jobs", job.to_string()).await, 422, "bad-request").await;
    let job = json!({ "scene_inline": SCENE, "stop": { "passes": 1 }, "tags": ["gpj\u{202e}exr"] });
    problem(farm.post("/v1/jobs", job.to_string()).await, 422, "bad-request").await;
    let long = json!({ "scene_inline": SCENE, "stop": { "seconds": 1e300 } });
    problem(farm.post("/v1/jobs", long.to_string()).await, 422, "bad-request").await;
    problem(farm.post("/v1/jobs", "[]").await, 400, "bad-json").await;
    let job = json!({ "scene_inline": SCENE, "stop": { "passes": 1 }, "name": "" });
    let (_, unnamed) = answer(farm.post("/v1/jobs", job.to_string()).await).await;
    assert!(unnamed["name"].is_null(), "{unnamed}");
    for (name, threads) in [("a\nb", 1), ("", 1), ("a", 0), ("a", u32::MAX)] {
        let message =
            RegisterRequest { name: name.to_owned(), threads, build: BUILD.to_owned(), ..RegisterRequest::default() };
        let register = farm.http.post(format!("{}/farm/v1/register", farm.base)).body(message.encode_to_vec());
        assert_eq!(register.send().await.expect("an answer").status(), 400, "{name:?} with {threads} threads");
    }
}

/// The page runs nothing but its own script, and what is private is kept by nobody.
#[tokio::test(flavor = "multi_thread")]
async fn browsers_are_told_what_not_to_do() {
    let farm = Farm::start(0).await;
    for path in ["/", "/page.js", "/v1/jobs", "/v1/jobs/unknown", "/nowhere"] {
        let answer = farm.get(path).await;
        let header = |name: &str| answer.headers().get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
        let policy = header("content-security-policy");
        assert!(policy.contains("default-src 'none'") && policy.contains("frame-ancestors 'none'"), "{path}: {policy}");
        assert!(!policy.contains("unsafe"), "{path}: {policy}");
        assert_eq!(header("x-content-type-options"), "nosniff", "{path}");
        assert_eq!(header("cache-control"), "no-store", "{path}");
    }
    let page = farm.get("/").await.text().await.expect("a page");
    assert!(!page.contains("<style") && !page.contains("onclick=") && !page.contains("<script>"), "{page}");
}

/// What Prometheus reads says the same as the API.
#[tokio::test(flavor = "multi_thread")]
async fn metrics_say_what_happened() {
    let farm = Farm::start(1).await;
    let id = farm.submit(json!({ "passes": 12 })).await;
    let last = farm.events(&id).await.pop().expect("an event");
    let waiting = farm.submit(json!({ "passes": 1_000_000 })).await;
    farm.get(&format!("/v1/jobs/{waiting}/events")).await.chunk().await.expect("a first event");
    let answer = farm.get("/metrics").await;
    assert!(answer.headers()["content-type"].to_str().expect("text").starts_with("application/openmetrics-text"));
    let text = answer.text().await.expect("text");
    assert!(text.ends_with("# EOF\n") && text.matches("# EOF").count() == 1, "{text}");
    let value = |name: &str| -> f64 {
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("photonfarm_{name} ")));
        line.unwrap_or_else(|| panic!("no {name} in {text}")).parse().expect("a number")
    };
    assert!(value("photons_total") >= last["photons_emitted"].as_f64().expect("a number"), "{text}");
    assert!(value("shards_merged_total") >= last["picture_version"].as_f64().expect("a number"), "{text}");
    assert!(value("results_total{outcome=\"taken\"}") >= value("shards_merged_total") + 1.0, "pilots are results, too");
    assert!(value("result_bytes_total") > 0.0 && value("merge_seconds_count") > 0.0 && value("uptime_seconds") > 0.0);
    let workers =
        ["idle", "working", "set_aside", "silent"].map(|state| value(&format!("workers{{state=\"{state}\"}}")));
    assert_eq!(workers.iter().sum::<f64>(), 1.0, "{text}");
    let jobs = ["queued", "choosing", "running", "paused"].map(|state| value(&format!("jobs{{state=\"{state}\"}}")));
    assert_eq!(jobs.iter().sum::<f64>(), 1.0, "{text}");
    assert_eq!(value("user_jobs{user=\"\"}"), 1.0);
    assert_eq!(farm.get("/readyz").await.status(), 200);
}

/// Graphs and alarms ask for numbers that there are.
#[tokio::test(flavor = "multi_thread")]
async fn dashboards_ask_for_metrics_that_exist() {
    let farm = Farm::start(1).await;
    let id = farm.submit(json!({ "passes": 1_000_000 })).await;
    while answer(farm.get(&format!("/v1/jobs/{id}")).await).await.1["estimated_error"].is_null() {
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let text = farm.get("/metrics").await.text().await.expect("text");
    let known: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("# TYPE ")?.split(' ').next()).collect();
    let asked =
        [include_str!("../../deploy/grafana-dashboard.json"), include_str!("../../deploy/photonfarm-alarms.yml")]
            .concat();
    let names = asked.match_indices("photonfarm_").map(|(at, _)| {
        let end = asked[at..].find(|letter: char| !(letter.is_ascii_alphanumeric() || letter == '_'));
        &asked[at..at + end.unwrap_or(asked.len() - at)]
    });
    let names: Vec<&str> = names.map(|name| name.trim_end_matches("_total").trim_end_matches("_bucket")).collect();
    assert!(names.len() > 15, "{names:?}");
    for name in names {
        assert!(known.contains(&name), "{name} is none of {known:?}");
    }
}

/// Who asks for much and reads nothing does not hold a connection for ever.
#[tokio::test(flavor = "multi_thread")]
async fn connections_that_read_nothing_are_closed() {
    const REQUESTS: usize = 3000;
    let farm = Farm::start_with(0, Limits { silence: 1, ..Limits::default() }).await;
    let address = farm.base.trim_start_matches("http://").to_owned();
    let whole = farm.get("/openapi.json").await.bytes().await.expect("a body").len() * REQUESTS;
    let (mut reading, mut writing) = TcpStream::connect(&address).await.expect("a connection").into_split();
    let asking = tokio::spawn(async move {
        for _ in 0..REQUESTS {
            let request = format!("GET /openapi.json HTTP/1.1\r\nHost: {address}\r\n\r\n");
            if writing.write_all(request.as_bytes()).await.is_err() {
                break;
            }
        }
        writing
    });
    tokio::time::sleep(Duration::from_secs(4)).await;
    let (mut received, mut buffer) = (0, vec![0; 1 << 16]);
    while let Ok(count @ 1..) = reading.read(&mut buffer).await {
        received += count;
    }
    assert!(received < whole, "{received} of {whole} bytes came although nothing was read for seconds");
    drop(asking);
}
