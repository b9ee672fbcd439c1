//! How denoised pictures are asked for, on the command line and of the API.

use std::time::Duration;

use photonfarm::api;
use photonfarm::farm::{CoordinatorOptions, LocalFarm};
use serde_json::{Value, json};

use crate::command_line::{success, text};
use crate::exr_channels::exr_channels;
use crate::http_client::http_client;

const SCENE: &str = "tests/references/cornell-diffuse/scene.xml";
const RENDER: [&str; 8] = ["render", SCENE, "--size", "48", "--method", "path", "--threads", "1"];

#[test]
fn the_command_line_adds_layers_and_leaves_the_picture_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let [raw, new, raw_png, new_png] =
        ["raw.exr", "new.exr", "raw.png", "new.png"].map(|name| folder.path().join(name));
    success(&[RENDER.as_slice(), &["--passes", "16", "-o", text(&raw), "-o", text(&raw_png)]].concat());
    let told = success(
        &[RENDER.as_slice(), &["--passes", "16", "--denoise", "-o", text(&new), "-o", text(&new_png)]].concat(),
    );
    assert!(told.contains("denoised: relMSE "), "{told}");
    let [raw, new] = [raw, new].map(|path| exr_channels(&std::fs::read(path).expect("a picture")));
    for channel in ["R", "G", "B"] {
        assert!(raw[channel] == new[channel], "{channel} changed");
    }
    let added: Vec<&str> = new.keys().map(String::as_str).filter(|name| !raw.contains_key(*name)).collect();
    assert_eq!(added, ["denoised.B", "denoised.G", "denoised.R", "denoised_error.Y"]);
    let right = folder.path().join("right.exr");
    success(&["render", SCENE, "--size", "48", "--method", "bdpt", "--passes", "256", "-o", text(&right)]);
    let right = exr_channels(&std::fs::read(right).expect("a picture"));
    // The lamp's edge is so bright that it would be all that counts.
    let error = |values: &[f32]| {
        let squares =
            values.iter().zip(&right["G"]).map(|(value, right)| f64::from((value - right) / (right + 0.01)).powi(2));
        squares.sum::<f64>()
    };
    let left = error(&new["denoised.G"]) / error(&raw["G"]);
    assert!(left < 0.5, "{left:.2} of the squared error is left");
    let [raw_png, new_png] = [raw_png, new_png].map(|path| std::fs::read(path).expect("a picture"));
    assert!(raw_png != new_png, "the picture to look at is not denoised");
}

#[test]
fn a_picture_of_one_pass_is_written_as_it_is_and_that_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("one.exr");
    let told = success(&[RENDER.as_slice(), &["--passes", "1", "--denoise", "-o", text(&path)]].concat());
    assert!(
        told.contains("the picture is written as it is: denoising compares the even with the odd passes"),
        "{told}"
    );
    let channels = exr_channels(&std::fs::read(path).expect("a picture"));
    assert!(channels.keys().eq(["B", "G", "R"]), "{:?}", channels.keys());
}

struct Farm {
    http: reqwest::Client,
    local: LocalFarm,
}

impl Farm {
    async fn start() -> Self {
        let routes = |coordinator, shutdown| api::router(api::ApiState { coordinator, shutdown });
        let options = CoordinatorOptions::default();
        let local = LocalFarm::builder().workers(1).options(options).routes(routes).start().await.expect("a farm");
        Self { http: http_client(Duration::from_secs(120)), local }
    }

    async fn get(&self, path: &str) -> (u16, reqwest::header::HeaderMap, Vec<u8>) {
        let response = self.http.get(format!("{}{path}", self.local.url())).send().await.expect("an answer");
        let (status, headers) = (response.status().as_u16(), response.headers().clone());
        (status, headers, response.bytes().await.expect("a body").to_vec())
    }

    /// The id of a job that has ended.
    async fn job(&self, passes: u32) -> String {
        let scene = std::fs::read_to_string("tests/references/furnace-env/scene.xml").expect("a scene");
        let job = json!({ "scene_inline": scene, "method": "path", "stop": { "passes": passes } });
        let request =
            self.http.post(format!("{}/v1/jobs", self.local.url())).header("Content-Type", "application/json");
        let answer = request.body(job.to_string()).send().await.expect("an answer").bytes().await.expect("a body");
        let id = serde_json::from_slice::<Value>(&answer).expect("JSON")["id"].as_str().expect("an id").to_owned();
        // The stream of events ends with the job.
        self.get(&format!("/v1/jobs/{id}/events")).await;
        id
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_api_answers_denoised_pictures_everywhere() {
    let farm = Farm::start().await;
    let id = farm.job(4).await;
    let [as_it_is, denoised] = ["", "&layer=denoised"].map(|layer| format!("/v1/jobs/{id}/image.png?bits=16{layer}"));
    let (as_it_is, denoised) = (farm.get(&as_it_is).await, farm.get(&denoised).await);
    assert_eq!((as_it_is.0, denoised.0), (200, 200));
    assert!(as_it_is.2 != denoised.2 && as_it_is.1["etag"] != denoised.1["etag"]);
    let relmse: f64 = denoised.1["photonfarm-denoised-relmse"].to_str().expect("text").parse().expect("a number");
    assert!(relmse > 0.0 && relmse < 1.0, "{relmse}");
    assert!(!as_it_is.1.contains_key("photonfarm-denoised-relmse"));

    let (status, headers, file) = farm.get(&format!("/v1/jobs/{id}/image.exr?layers=denoised,error")).await;
    assert_eq!((status, &headers["photonfarm-denoised-relmse"]), (200, &denoised.1["photonfarm-denoised-relmse"]));
    let channels = exr_channels(&file);
    assert_eq!(channels.len(), 7, "{:?}", channels.keys());
    // The furnace shines with 1 everywhere.
    let mean =
        |name: &str| channels[name].iter().map(|value| f64::from(*value)).sum::<f64>() / channels[name].len() as f64;
    assert!((mean("denoised.G") - 1.0).abs() < 0.02 && (mean("G") - 1.0).abs() < 0.02);

    let (status, headers, bytes) = farm.get(&format!("/v1/jobs/{id}/pixels?layer=denoised")).await;
    assert_eq!(
        (status, headers["photonfarm-channels"].as_bytes()),
        (200, b"denoised.R,denoised.G,denoised.B".as_slice())
    );
    let first = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    assert_eq!(first, channels["denoised.R"][0]);
    assert_eq!(farm.get(&format!("/v1/jobs/{id}/map.png?layer=denoised_error")).await.0, 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_api_refuses_to_denoise_one_pass() {
    let farm = Farm::start().await;
    let id = farm.job(1).await;
    let paths = ["image.png?layer=denoised", "image.exr?layers=denoised_error", "pixels?layer=denoised"];
    for path in paths {
        let (status, _, body) = farm.get(&format!("/v1/jobs/{id}/{path}")).await;
        let problem: Value = serde_json::from_slice(&body).expect("JSON");
        assert_eq!((status, &problem["type"]), (409, &json!("urn:photonfarm:problem:cannot-denoise")), "{path}");
    }
    assert_eq!(farm.get(&format!("/v1/jobs/{id}/image.png")).await.0, 200);
}
