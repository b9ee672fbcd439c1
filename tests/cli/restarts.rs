//! Real processes that are killed: a coordinator goes on from its store, to the bits of an undisturbed run.

use std::time::Duration;

use crate::serving::{Coordinator, WorkerProcess, wait_for};
use serde_json::{Value, json};

const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");

fn job(passes: u32, seed: u64) -> Value {
    json!({ "scene_inline": SCENE, "method": "sppm", "seed": seed,
        "parameters": { "photons_per_pass": 20_000, "emission": "guided" }, "stop": { "passes": passes } })
}

async fn passes_done(coordinator: &Coordinator, id: &str) -> u64 {
    coordinator.job(id).await["passes_done"].as_u64().expect("a number")
}

/// The pictures of two jobs on a farm that nothing happens to.
async fn undisturbed(passes: [u32; 2]) -> [Vec<u8>; 2] {
    let folder = tempfile::tempdir().expect("a folder");
    let coordinator = Coordinator::start(folder.path(), 0).await;
    let _worker = WorkerProcess::start(&coordinator, "quiet");
    let ids = [coordinator.submit(&job(passes[0], 0)).await, coordinator.submit(&job(passes[1], 1)).await];
    [coordinator.picture_when_done(&ids[0]).await, coordinator.picture_when_done(&ids[1]).await]
}

#[tokio::test(flavor = "multi_thread")]
async fn killed_coordinators_and_workers_do_not_change_a_bit() {
    const PASSES: [u32; 2] = [400, 60];
    let expected = undisturbed(PASSES).await;
    let folder = tempfile::tempdir().expect("a folder");
    let mut coordinator = Coordinator::start(folder.path(), 0).await;
    let mut workers: Vec<WorkerProcess> =
        (0..3).map(|index| WorkerProcess::start(&coordinator, &format!("w{index}"))).collect();
    let ids = [coordinator.submit(&job(PASSES[0], 0)).await, coordinator.submit(&job(PASSES[1], 1)).await];
    for round in 0..2u64 {
        wait_for("passes", async || passes_done(&coordinator, &ids[0]).await > 60 * (round + 1)).await;
        coordinator.kill();
        workers.swap_remove(0).kill();
        workers.push(WorkerProcess::start(&coordinator, &format!("new{round}")));
        coordinator.restart().await;
        assert!(coordinator.jobs().await.len() == 2, "no job is lost");
    }
    for (id, expected) in ids.iter().zip(&expected) {
        assert!(coordinator.picture_when_done(id).await == *expected, "job {id} has other bits");
    }
    // Ended jobs are still there after another restart, with their pictures; one whose end was not stored yet ends once more.
    coordinator.kill();
    coordinator.restart().await;
    for (id, expected) in ids.iter().zip(&expected) {
        assert!(coordinator.picture_when_done(id).await == *expected, "job {id} lost its picture");
    }
    // What was stored before a stop is not rendered again.
    coordinator.interrupt();
    coordinator.restart().await;
    for id in &ids {
        assert_eq!(coordinator.job(id).await["state"], "done");
    }
    // Ids are not used again.
    let next = coordinator.submit(&job(1, 2)).await;
    assert!(ids.iter().all(|id| *id < next), "{ids:?}, {next}");
}

/// A finished job that is extended has the bits of the longer job, although its last shards were cut short.
#[tokio::test(flavor = "multi_thread")]
async fn an_extended_job_has_the_bits_of_the_longer_one() {
    let [long, _] = undisturbed([150, 1]).await;
    let folder = tempfile::tempdir().expect("a folder");
    let mut coordinator = Coordinator::start(folder.path(), 1).await;
    let id = coordinator.submit(&job(37, 0)).await;
    let short = coordinator.picture_when_done(&id).await;
    assert!(short != long);
    let too_short = coordinator.post(&format!("/v1/jobs/{id}/extend"), &json!({ "passes": 37 })).await;
    assert_eq!(too_short.0, 422, "{:?}", too_short.1);
    // The stored state is what counts, not what is in memory.
    coordinator.interrupt();
    coordinator.restart().await;
    assert_eq!(coordinator.job(&id).await["state"], "done");
    let (status, extended) = coordinator.post(&format!("/v1/jobs/{id}/extend"), &json!({ "passes": 150 })).await;
    assert_eq!(status, 200, "{extended}");
    assert!(coordinator.picture_when_done(&id).await == long);
    // States that no record names any more are deleted, by the extension and with the job.
    assert_eq!(coordinator.delete(&format!("/v1/jobs/{id}")).await, 204);
    let left = || std::fs::read_dir(folder.path().join("blobs/snapshots").join(&id)).map(Iterator::count).unwrap_or(0);
    assert_eq!(left(), 0, "all its states are deleted");
}

/// A coordinator that is asked to stop waits for what is traced, stores all, and goes on later.
#[tokio::test(flavor = "multi_thread")]
async fn a_coordinator_that_is_stopped_says_how_to_go_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut coordinator = Coordinator::start(folder.path(), 1).await;
    let id = coordinator.submit(&job(1_000_000, 0)).await;
    wait_for("passes", async || passes_done(&coordinator, &id).await > 20).await;
    let before = passes_done(&coordinator, &id).await;
    let said = coordinator.interrupt();
    assert!(said.contains(&format!("job {id} is running")) && said.contains("to go on"), "{said}");
    coordinator.restart().await;
    let after = passes_done(&coordinator, &id).await;
    assert!(after >= before, "{after} passes after the restart, {before} before");
    let (status, paused) = coordinator.post(&format!("/v1/jobs/{id}/pause"), &json!({})).await;
    assert_eq!((status, &paused["state"]), (200, &json!("paused")));
    coordinator.kill();
    coordinator.restart().await;
    assert_eq!(coordinator.job(&id).await["state"], "paused", "what was answered is durable");
    assert_eq!(coordinator.delete(&format!("/v1/jobs/{id}")).await, 204);
    assert!(coordinator.jobs().await.is_empty());
    tokio::time::sleep(Duration::from_millis(300)).await;
    let snapshots = folder.path().join("blobs/snapshots").join(&id);
    let left = std::fs::read_dir(snapshots).map(Iterator::count).unwrap_or(0);
    assert_eq!(left, 0, "its states are deleted with it");
}
