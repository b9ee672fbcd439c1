//! What users do to jobs and scenes, at bad moments and at the same time: one of them wins, and the farm goes on.

use std::time::Duration;

use photonfarm::farm::ids::JobId;
use photonfarm::farm::job::{JobRequest, JobState, SceneChanges, StopRule};
use photonfarm::farm::store::{Store, StoreLocation};
use photonfarm::farm::{CoordinatorHandle, CoordinatorOptions, FarmError, Limits, LocalFarm};
use serde_json::json;
use tokio::time::timeout;

const SCENE: &str = include_str!("../references/furnace-closed/scene.xml");

fn passes(passes: u32) -> StopRule {
    StopRule { passes: Some(passes), ..StopRule::default() }
}

fn request(scene: &str, stop: StopRule) -> JobRequest {
    let parameters = serde_json::Map::from_iter([("photons_per_pass".to_owned(), json!(500))]);
    JobRequest { method: Some("sppm".to_owned()), parameters, stop, ..JobRequest::of_scene(scene.to_owned()) }
}

async fn ended(client: &CoordinatorHandle, id: JobId) -> JobState {
    let mut status = client.watch(id).expect("a job");
    let ended = timeout(Duration::from_secs(60), status.wait_for(|status| status.state.is_final()));
    ended.await.expect("jobs end").expect("the coordinator lives").state
}

async fn bits(client: &CoordinatorHandle, id: JobId) -> Vec<u32> {
    let (picture, _) = client.picture(id).await.expect("a picture");
    picture.radiance.iter().flatten().map(|value| value.to_bits()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn who_extends_and_who_deletes_at_the_same_time_do_not_both_win() {
    let farm = LocalFarm::builder().start().await.expect("a farm");
    let client = farm.client();
    let scene = client.add_scene(SCENE.into()).await.expect("a scene").hash;
    for _ in 0..30 {
        let id = client.submit(request(&scene, passes(1))).await.expect("a job");
        assert_eq!(ended(client, id).await, JobState::Done);
        let (extended, deleted) = tokio::join!(client.extend(id, passes(1_000_000)), client.delete(id));
        deleted.expect("who deletes always wins in the end");
        assert!(matches!(client.job(id), Err(FarmError::UnknownJob(_))), "{extended:?}");
    }
    // Nobody works for a job that is gone.
    let next = client.submit(request(&scene, passes(20))).await.expect("a job");
    assert_eq!(ended(client, next).await, JobState::Done);
    farm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_job_goes_on_to_the_bits_of_the_longer_one_or_says_from_where_on_it_can() {
    let farm = LocalFarm::builder().workers(2).start().await.expect("a farm");
    let client = farm.client();
    let scene = client.add_scene(SCENE.into()).await.expect("a scene").hash;
    let mut refused = 0;
    for round in 0..12 {
        let id = client.submit(request(&scene, passes(100_000))).await.expect("a job");
        let mut status = client.watch(id).expect("a job");
        status.wait_for(|status| status.passes_done > 20 + 7 * round).await.expect("the coordinator lives");
        let done = client.cancel(id).await.expect("cancelled").passes_done;
        let mut wanted = done + 1;
        if let Err(problem) = client.extend(id, passes(wanted)).await {
            let FarmError::BadRequest { remedy, .. } = &problem else { panic!("{problem}") };
            let mut words = remedy.split_whitespace().filter_map(|word| word.parse::<u32>().ok());
            wanted = words.next_back().unwrap_or_else(|| panic!("{problem} names the passes that can be had"));
            client.extend(id, passes(wanted)).await.expect("what it says can be had");
            refused += 1;
        }
        assert_eq!(ended(client, id).await, JobState::Done, "round {round}");
        assert_eq!(client.job(id).expect("a job").passes_done, wanted);
        let direct = client.submit(request(&scene, passes(wanted))).await.expect("a job");
        assert_eq!(ended(client, direct).await, JobState::Done);
        assert!(
            bits(client, id).await == bits(client, direct).await,
            "round {round}: cancelled at {done}, then {wanted}"
        );
    }
    assert!(refused < 12, "half of all states are whole pairs");
    farm.stop().await;
}

/// When a job ends its state goes from memory to disk; whoever looks meanwhile sees it.
#[tokio::test(flavor = "multi_thread")]
async fn a_picture_is_there_while_its_job_leaves_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(&StoreLocation::folder(folder.path())).await.expect("a store");
    let farm = LocalFarm::builder().store(store).start().await.expect("a farm");
    let client = farm.client();
    let scene = client.add_scene(SCENE.into()).await.expect("a scene").hash;
    for round in 0..20 {
        let id = client.submit(request(&scene, passes(1))).await.expect("a job");
        assert_eq!(ended(client, id).await, JobState::Done);
        let looks = async || {
            for _ in 0..50 {
                client.picture(id).await.unwrap_or_else(|problem| panic!("round {round}: {problem}"));
            }
        };
        futures_util::future::join_all((0..8).map(|_| looks())).await;
    }
    farm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_scene_is_there_with_its_bytes_or_not_at_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(&StoreLocation::folder(folder.path())).await.expect("a store");
    let farm = LocalFarm::builder().workers(0).store(store).start().await.expect("a farm");
    let client = farm.client();
    let hash = client.add_scene(SCENE.into()).await.expect("a scene").hash;
    for _ in 0..40 {
        let (added, deleted, submitted) = tokio::join!(
            client.add_scene(SCENE.into()),
            client.delete_scene(&hash),
            client.submit(request(&hash, passes(1)))
        );
        added.expect("a good scene");
        assert!(
            matches!(deleted, Ok(()) | Err(FarmError::UnknownScene(_) | FarmError::Conflict { .. })),
            "{deleted:?}"
        );
        assert!(matches!(submitted, Ok(_) | Err(FarmError::UnknownScene(_))), "{submitted:?}");
        if client.scene(&hash).is_ok() {
            assert!(client.scene_bytes(&hash).await.is_ok(), "{deleted:?}, {submitted:?}");
        }
        if let Ok(id) = submitted {
            client.delete(id).await.expect("deleted");
        }
        client.add_scene(SCENE.into()).await.expect("a good scene");
    }
    farm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_whose_scene_is_lost_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(&StoreLocation::folder(folder.path())).await.expect("a store");
    let mut farm = LocalFarm::builder().workers(0).store(store).start().await.expect("a farm");
    let client = farm.client().clone();
    let hash = client.add_scene(SCENE.into()).await.expect("a scene").hash;
    let changes = SceneChanges { width: Some(8), ..SceneChanges::default() };
    let changed = client.changed_scene(&hash, changes).await.expect("a changed scene");
    let changed = client.add_scene(changed).await.expect("a scene").hash;
    let mut ids = Vec::new();
    for scene in [&hash, &changed] {
        ids.push(client.submit(request(scene, passes(1))).await.expect("a job"));
    }
    std::fs::remove_file(folder.path().join("blobs/scenes").join(&hash)).expect("it was there");
    farm.add_worker("searching", 1);
    for id in ids {
        assert_eq!(ended(&client, id).await, JobState::Failed);
        let error = client.job(id).expect("a job").error.expect("a reason");
        assert!(error.contains("its scene is lost"), "{error}");
    }
    assert!(matches!(client.scene_bytes(&hash).await, Err(FarmError::Lost { .. })));
    farm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_limit_of_live_jobs_holds_for_many_at_once_and_for_extensions() {
    const LIMIT: usize = 10;
    let options = CoordinatorOptions {
        limits: Limits { live_jobs: LIMIT, ..Limits::default() },
        ..CoordinatorOptions::default()
    };
    let mut farm = LocalFarm::builder().workers(0).options(options).start().await.expect("a farm");
    let client = farm.client().clone();
    let scene = client.add_scene(SCENE.into()).await.expect("a scene").hash;
    let stop = farm.add_worker("for the first one", 1);
    let first = client.submit(request(&scene, passes(1))).await.expect("a job");
    assert_eq!(ended(&client, first).await, JobState::Done);
    stop.cancel();
    let submit = |_| client.submit(request(&scene, passes(1_000_000)));
    let answers = futures_util::future::join_all((0..4 * LIMIT).map(submit)).await;
    assert_eq!(answers.iter().filter(|answer| answer.is_ok()).count(), LIMIT);
    assert!(
        answers
            .iter()
            .flat_map(|answer| answer.as_ref().err())
            .all(|problem| matches!(problem, FarmError::Busy { .. }))
    );
    assert!(matches!(client.extend(first, passes(5)).await, Err(FarmError::Busy { .. })));
    farm.stop().await;
}
