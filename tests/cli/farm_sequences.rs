//! Sequences of a coordinator: one id for many jobs, through the command line and through kills.

use serde_json::{Value, json};

use crate::command_line::{failure, program, success, text};
use crate::serving::{Coordinator, WorkerProcess, wait_for};

/// A lamp on its way.
const LAMP: &str = "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><film type='hdrfilm'>
    <integer name='width' value='8'/><integer name='height' value='8'/></film></sensor><shape type='sphere'><emitter type='area'/>
    <animation name='to_world'><transform time='0'><translate z='4'/></transform><transform time='1'><translate z='8'/></transform>
    </animation></shape></scene>";

/// What a command that must succeed prints.
fn printed(url: &str, arguments: &[&str]) -> String {
    let output = program(arguments).env("PHOTONFARM_URL", url).output().expect("the program starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8").trim_end().to_owned()
}

/// How a command ends, and what it says to people.
fn said(url: &str, arguments: &[&str]) -> (i32, String) {
    let output = program(arguments).env("PHOTONFARM_URL", url).output().expect("the program starts");
    (output.status.code().expect("a code"), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn listed(url: &str, arguments: &[&str]) -> Vec<Value> {
    serde_json::from_str(&printed(url, &[arguments, &["--json"]].concat())).expect("JSON")
}

fn names(url: &str, arguments: &[&str]) -> Vec<String> {
    let name = |job: &Value| job["name"].as_str().unwrap_or_default().to_owned();
    listed(url, arguments).iter().map(name).collect()
}

fn pixels(file: &std::path::Path) -> Vec<u32> {
    let picture = photonfarm::estimate::picture_files::read_exr(file).unwrap_or_else(|error| panic!("{error}"));
    picture.radiance.iter().flatten().map(|value| value.to_bits()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sequence_is_submitted_watched_and_fetched_by_one_id() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let coordinator = Coordinator::start(&folder.join("data"), 1).await;
    let url = coordinator.url();
    let [scene, output, preview] = ["lamp.xml", "all.exr", "all.png"].map(|name| folder.join(name));
    std::fs::write(&scene, LAMP).expect("writes");
    let job = ["--passes", "2", "--seed", "5", "--tag", "night"];
    let submit = [["submit", text(&scene), "--frames", "1-3", "--frames-at-once", "1"].as_slice(), &job].concat();
    let id = printed(&url, &submit);
    assert!(id.starts_with("seq-"), "{id}");
    let (code, told) = said(&url, &["watch", &id]);
    assert_eq!(code, 0, "{told}");
    assert!(told.contains("done: 3 of 3 frames"), "{told}");
    assert!(printed(&url, &["sequences"]).ends_with("\tdone\t3/3\t100 %\t-\tlamp"));
    assert_eq!(names(&url, &["jobs", "--sequence", &id]), ["lamp.0001", "lamp.0002", "lamp.0003"]);
    let jobs = listed(&url, &["jobs", "--tag", "night"]);
    let seeds: Vec<u64> = jobs.iter().map(|job| job["seed"].as_u64().expect("a seed")).collect();
    assert_eq!(seeds, [6, 7, 8]);
    // A copy of a frame is no frame.
    printed(&url, &["clone", jobs[0]["id"].as_str().expect("an id"), "--name", "copy"]);
    assert_eq!(names(&url, &["jobs", "--sequence", &id]).len(), 3);
    // Of each frame only what is changed of the scene is kept.
    let mut bytes: Vec<u64> =
        listed(&url, &["scenes"]).iter().map(|scene| scene["bytes"].as_u64().expect("bytes")).collect();
    bytes.sort_unstable();
    assert!(bytes.len() == 4 && bytes[2] < 200 && bytes[3] == LAMP.len() as u64, "{bytes:?}");

    printed(&url, &["fetch", &id, "-o", text(&output), "--preview", text(&preview)]);
    let first = std::fs::read(&preview).expect("a preview");
    assert!(first.windows(4).any(|window| window == b"acTL"), "an animation");
    // The same as if they were rendered here.
    let here = folder.join("here.exr");
    let here = [["render", text(&scene), "--frames", "1-3", "-o", text(&here)].as_slice(), &job].concat();
    success(&here);
    for number in ["0001", "0002", "0003"] {
        let [fetched, rendered] = ["all", "here"].map(|name| pixels(&folder.join(format!("{name}.{number}.exr"))));
        assert!(fetched == rendered, "frame {number}");
    }
    let first = folder.join("all.0001.png");
    let over = ["fetch", &id, "-o", text(&preview), "--preview", text(&first)];
    assert_eq!(said(&url, &over).0, 2, "a preview takes no frame's place");
    assert_eq!(said(&url, &["extend", &id, "--passes", "9"]).0, 2);
    let left: Vec<Value> = {
        printed(&url, &["rm", &id]);
        listed(&url, &["jobs"])
    };
    assert_eq!((left.len(), left[0]["name"].as_str()), (1, Some("copy")));
    assert!(listed(&url, &["sequences"]).is_empty());
    // The copy's scene stays, and with it the one that it changes.
    assert_eq!(listed(&url, &["scenes"]).len(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sequence_is_paused_resumed_and_cancelled_as_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let coordinator = Coordinator::start(&folder.path().join("data"), 1).await;
    let url = coordinator.url();
    let scene = folder.path().join("lamp.xml");
    std::fs::write(&scene, LAMP).expect("writes");
    let id = printed(&url, &["submit", text(&scene), "--frames", "1-50", "--passes", "1000000"]);
    let (code, told) = said(&url, &["fetch", &id, "--tone", "agx", "--preview", "a.gif"]);
    assert_eq!(code, 2, "{told}");
    wait_for("frames", async || listed(&url, &["jobs", "--sequence", &id]).len() == 2).await;
    printed(&url, &["pause", &id]);
    assert_eq!(listed(&url, &["jobs", "--state", "paused"]).len(), 2, "no third frame is made");
    assert_eq!(said(&url, &["pause", &id]).0, 1);
    let sequence: Value = serde_json::from_str(&printed(&url, &["resume", &id, "--json"])).expect("JSON");
    assert_eq!((&sequence["state"], &sequence["frames_total"]), (&json!("running"), &json!(50)));
    assert!(listed(&url, &["jobs", "--state", "paused"]).is_empty());
    // Its scene is needed by frames to come.
    let base = sequence["scene"].as_str().expect("a hash");
    assert_eq!(said(&url, &["rm", "--scene", base]).0, 1);
    printed(&url, &["cancel", &id]);
    assert_eq!(listed(&url, &["jobs", "--state", "cancelled"]).len(), 2);
    let (code, told) = said(&url, &["watch", &id]);
    assert!(code == 1 && told.contains("was cancelled"), "{told}");
    printed(&url, &["cancel", &id]);
    // A sequence goes with its last job.
    for job in listed(&url, &["jobs"]) {
        printed(&url, &["rm", job["id"].as_str().expect("an id")]);
    }
    wait_for("end of the sequence", async || listed(&url, &["sequences"]).is_empty()).await;
    for wrong in [["watch", "seq-0000000z"], ["cancel", "seq-0000000z"], ["fetch", "seq-0000000z"]] {
        assert!(said(&url, &wrong).1.contains("there is no sequence"), "{wrong:?}");
    }
    failure(&["submit", text(&scene), "--frames-at-once", "2"], 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn sequences_go_on_after_kills_to_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let sequence = json!({ "job": { "scene_inline": LAMP, "name": "lamp", "method": "path", "stop": { "passes": 400 } },
        "frames": { "first": 1, "last": 6 }, "at_once": 2 });
    let pictures = async |data: &str, kills: u32| {
        let mut coordinator = Coordinator::start(&folder.path().join(data), 0).await;
        let _worker = WorkerProcess::start(&coordinator, "other");
        let (status, submitted) = coordinator.post("/v1/sequences", &sequence).await;
        assert_eq!(status, 202, "{submitted}");
        let id = submitted["id"].as_str().expect("an id").to_owned();
        for round in 0..kills {
            let frames = async || coordinator.jobs().await.len() > 2 * round as usize;
            wait_for("frames", frames).await;
            coordinator.kill();
            coordinator.restart().await;
        }
        let ended = async || coordinator.sequence(&id).await["state"] == "done";
        wait_for("end", ended).await;
        let jobs = coordinator.jobs().await;
        let numbers: Vec<&Value> = jobs.iter().map(|job| &job["frame"]["number"]).collect();
        assert_eq!(numbers, [&json!(1), &json!(2), &json!(3), &json!(4), &json!(5), &json!(6)], "each once");
        let mut pictures = Vec::new();
        for job in &jobs {
            pictures.push(coordinator.picture(job["id"].as_str().expect("an id")).await);
        }
        pictures
    };
    let quiet = pictures("quiet", 0).await;
    assert!(pictures("killed", 3).await == quiet, "other bits");
    assert!(quiet[0] != quiet[5]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_deletion_goes_on_when_nobody_waits_for_it_and_after_a_kill() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut coordinator = Coordinator::start(&folder.path().join("data"), 0).await;
    for is_killed in [false, true] {
        let sequence = json!({ "job": { "scene_inline": LAMP }, "frames": { "first": 1, "last": 30 }, "at_once": 30 });
        let (status, submitted) = coordinator.post("/v1/sequences", &sequence).await;
        assert_eq!(status, 202, "{submitted}");
        wait_for("frames", async || coordinator.jobs().await.len() == 30).await;
        let path = format!("/v1/sequences/{}", submitted["id"].as_str().expect("an id"));
        let hurry = std::time::Duration::from_millis(30);
        if tokio::time::timeout(hurry, coordinator.delete(&path)).await.is_err() && is_killed {
            // What is deleted was stored as such before.
            wait_for("deletion", async || coordinator.jobs().await.len() < 30).await;
            coordinator.kill();
            coordinator.restart().await;
        }
        wait_for("end of the deletion", async || coordinator.jobs().await.is_empty()).await;
        wait_for("end of the record", async || listed(&coordinator.url(), &["sequences"]).is_empty()).await;
        let scenes = listed(&coordinator.url(), &["scenes"]);
        assert_eq!(scenes.len(), 1, "only the scene that was uploaded stays: {scenes:?}");
        assert_eq!(coordinator.delete(&path).await, 404);
    }
}
