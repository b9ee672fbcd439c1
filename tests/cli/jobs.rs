//! Jobs of a coordinator as the command line handles them.

use crate::command_line::{failure, program};
use crate::serving::Coordinator;
use serde_json::{Value, json};

const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");

/// What a command that must succeed prints.
fn printed(url: &str, arguments: &[&str]) -> String {
    let output = program(arguments).env("PHOTONFARM_URL", url).output().expect("the program starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8").trim_end().to_owned()
}

/// What it prints on a terminal, which `script` is.
fn on_terminal(url: &str, arguments: &str) -> String {
    let command = format!("{} {arguments}", env!("CARGO_BIN_EXE_photonfarm"));
    let mut script = std::process::Command::new("script");
    script.args(["-qec", &command, "/dev/null"]).env("PHOTONFARM_URL", url).stdin(std::process::Stdio::null());
    String::from_utf8(script.output().expect("script starts").stdout).expect("UTF-8")
}

fn names(url: &str, arguments: &[&str]) -> Vec<String> {
    let jobs: Vec<Value> = serde_json::from_str(&printed(url, &[arguments, &["--json"]].concat())).expect("JSON");
    jobs.iter().map(|job| job["name"].as_str().unwrap_or_default().to_owned()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_are_copied_changed_found_and_deleted() {
    let folder = tempfile::tempdir().expect("a folder");
    let coordinator = Coordinator::start(folder.path(), 0).await;
    let url = coordinator.url();
    let job = json!({ "scene_inline": SCENE, "method": "sppm", "seed": 3, "name": "first", "tags": ["night"],
        "parameters": { "photons_per_pass": 20_000 }, "stop": { "passes": 10 } });
    let first = coordinator.submit(&job).await;

    let copy = printed(&url, &["clone", &first, "--name", "second", "--passes", "20", "--set", "alpha=0.5"]);
    let copied = coordinator.job(&copy).await;
    let expected =
        [("name", json!("second")), ("seed", json!(3)), ("stop", json!({ "passes": 20 })), ("tags", json!(["night"]))];
    for (key, value) in expected {
        assert_eq!(copied[key], value, "{key}");
    }
    assert_eq!(
        (&copied["parameters"]["photons_per_pass"], &copied["parameters"]["alpha"]),
        (&json!(20_000), &json!(0.5))
    );
    let other: Value =
        serde_json::from_str(&printed(&url, &["clone", &first, "--method", "path", "--json"])).expect("JSON");
    assert_eq!((&other["method"], &other["stop"]), (&json!("path"), &json!({ "passes": 10 })));

    printed(&url, &["change", &copy, "--tag", "day"]);
    printed(&url, &["pause", &copy]);
    assert_eq!(names(&url, &["jobs"]), ["first", "second", "first"]);
    // This coordinator has no worker, and a paused job does not wait for one.
    let states = || -> Vec<String> {
        let listed = printed(&url, &["jobs"]);
        listed.lines().map(|line| line.split('\t').nth(1).expect("a state").to_owned()).collect()
    };
    let start = std::time::Instant::now();
    while states() != ["queued, no worker", "paused", "queued, no worker"] {
        assert!(start.elapsed().as_secs() < 10, "{:?}", states());
    }
    assert_eq!(names(&url, &["jobs", "--tag", "night", "--limit", "1"]), ["first"]);
    assert_eq!(names(&url, &["jobs", "--state", "paused"]), ["second"]);
    assert_eq!(names(&url, &["jobs", "--name", "first", "--after", &first]), ["first"]);
    failure(&["jobs", "--state", "asleep"], 2);

    // People are told what columns hold, programs are not.
    assert!(on_terminal(&url, "jobs").starts_with("ID\tSTATE\tPASSES\tSECONDS\tMETHOD\tOWNER\tNAME\r\n"));
    assert!(on_terminal(&url, "scenes").starts_with("HASH\tBYTES"));
    assert!(on_terminal(&url, "workers").starts_with("NUMBER\tSTATE"));

    printed(&url, &["rm", &copy]);
    assert_eq!(names(&url, &["jobs"]), ["first", "first"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn standard_input_is_submitted_as_the_file_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let coordinator = Coordinator::start(folder.path(), 0).await;
    let url = coordinator.url();
    let file = "tests/references/furnace-closed/scene.xml";
    let input = std::fs::File::open(file).expect("a scene");
    let fed = program(&["submit", "-"]).env("PHOTONFARM_URL", &url).stdin(input).output().expect("it starts");
    let from_input = String::from_utf8(fed.stdout).expect("UTF-8");
    let mut scenes = vec![coordinator.job(from_input.trim()).await["scene"].clone()];
    for argument in [file, "tests/references/furnace-closed"] {
        scenes.push(coordinator.job(&printed(&url, &["submit", argument])).await["scene"].clone());
    }
    assert!(scenes.iter().all(|scene| *scene == scenes[0] && scene.is_string()), "{scenes:?}");
}
