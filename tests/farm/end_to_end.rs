//! Whole farms in this process, talking real HTTP on loopback ports: whatever the number of workers and threads and
//! whatever goes wrong, a job's picture has the same bits.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::fault_proxy::FaultProxy;
use crate::hand::Hand;
use photonfarm::estimate::declaration::PHOTONS_EMITTED;
use photonfarm::estimate::picture_files::{LAYERS, Layer};
use photonfarm::estimate::{Declaration, RadiusRule, Shard, Tally};
use photonfarm::farm::cut::Cut;
use photonfarm::farm::dial::Dialer;
use photonfarm::farm::ids::JobId;
use photonfarm::farm::job::{JobRequest, JobState, JobStatus, StopRule};
use photonfarm::farm::prepared_scenes::PreparedScenes;
use photonfarm::farm::wire::BUILD;
use photonfarm::farm::wire::lease::{LeasedWork, decode_lease};
use photonfarm::farm::wire::messages;
use photonfarm::farm::wire::messages::result_request::Outcome;
use photonfarm::farm::wire::result::encode_tally;
use photonfarm::farm::worker::{WorkerError, WorkerOptions, run_worker};
use photonfarm::farm::{CoordinatorHandle, CoordinatorOptions, FarmError, LayeredPicture, LocalFarm};
use photonfarm::method::METHODS;
use serde_json::json;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;

const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="sppm"/>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, 0, 3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm">
      <integer name="width" value="40"/> <integer name="height" value="30"/> <rfilter type="box"/>
    </film>
  </sensor>
  <bsdf type="diffuse" id="plaster"><rgb name="reflectance" value="0.75, 0.73, 0.70"/></bsdf>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="-90"/><translate y="-1"/></transform> <ref id="plaster"/>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><translate z="-1"/></transform> <ref id="plaster"/>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><scale x="0.3" y="0.3"/><rotate x="1" angle="90"/><translate y="0.99"/></transform>
    <emitter type="area"><rgb name="radiance" value="30, 27, 22"/></emitter>
  </shape>
</scene>"#;

/// A coordinator behind a real port; workers come and go.
struct Farm {
    handle: CoordinatorHandle,
    local: LocalFarm,
}

impl Farm {
    async fn start(lease_duration: Duration) -> Self {
        Self::with(CoordinatorOptions { lease_duration, ..CoordinatorOptions::default() }).await
    }

    async fn with(options: CoordinatorOptions) -> Self {
        let local = LocalFarm::builder().workers(0).options(options).start().await.expect("a free port");
        Self { handle: local.client().clone(), local }
    }

    fn url(&self) -> String {
        self.local.url()
    }

    fn worker(&self, name: &str, threads: usize) -> (CancellationToken, JoinHandle<Result<(), WorkerError>>) {
        start_worker(self.url(), name, threads)
    }

    /// Lets a worker come, and leave when more than `passes` of the job are done.
    async fn work_beyond(&self, id: JobId, passes: u32, name: &str) {
        let (stop, worker) = self.worker(name, 1);
        let mut status = self.handle.watch(id).expect("a job");
        status.wait_for(|status| status.passes_done > passes).await.expect("the coordinator lives");
        stop.cancel();
        worker.await.expect("no panic").expect("a clean end");
    }

    async fn submit(&self, rule: &str, stop: StopRule) -> JobId {
        let parameters = [("radius_rule".to_owned(), json!(rule)), ("photons_per_pass".to_owned(), json!(3000))];
        self.submit_method(None, serde_json::Map::from_iter(parameters), stop).await
    }

    async fn submit_method(
        &self,
        method: Option<&str>,
        parameters: serde_json::Map<String, serde_json::Value>,
        stop: StopRule,
    ) -> JobId {
        let scene = self.handle.add_scene(SCENE.into()).await.expect("a good scene").hash;
        let method = method.map(str::to_owned);
        let request = JobRequest { method, parameters, stop, seed: 7, ..JobRequest::of_scene(scene) };
        self.handle.submit(request).await.expect("a good request")
    }

    async fn end(&self, id: JobId) -> JobStatus {
        let mut status = self.handle.watch(id).expect("a job");
        let ended = timeout(Duration::from_secs(60), status.wait_for(|status| status.state.is_final()));
        ended.await.expect("jobs end").expect("the coordinator lives").clone()
    }

    /// The bits of a job's picture and layers, once it is done.
    async fn bits(&self, id: JobId) -> Vec<u32> {
        let status = self.end(id).await;
        assert_eq!(status.state, JobState::Done, "{status:?}");
        let keeps_groups = !status.light_groups.is_empty();
        let layers = LAYERS.map(|row| row.layer).into_iter();
        let layers: Vec<Layer> = layers.filter(|layer| keeps_groups || *layer != Layer::LightGroups).collect();
        let LayeredPicture { picture, layers, .. } =
            self.handle.picture_with_layers(id, &layers).await.expect("a picture");
        let channels = layers.iter().flat_map(|layer| &layer.channels).flatten();
        picture.radiance.iter().flatten().chain(channels).map(|value| value.to_bits()).collect()
    }
}

fn start_worker(
    coordinator: String,
    name: &str,
    threads: usize,
) -> (CancellationToken, JoinHandle<Result<(), WorkerError>>) {
    let stop = CancellationToken::new();
    let scenes = PreparedScenes::new(1);
    let options =
        WorkerOptions { coordinator, name: name.to_owned(), threads, token: None, scenes, dialer: Dialer::tcp(None) };
    (stop.clone(), tokio::spawn(run_worker(options, stop)))
}

fn passes(passes: u32) -> StopRule {
    StopRule { passes: Some(passes), ..StopRule::default() }
}

/// The bits that one undisturbed single-threaded worker makes.
async fn reference(rule: &str, count: u32) -> Vec<u32> {
    let farm = Farm::start(Duration::from_secs(15)).await;
    let _worker = farm.worker("alone", 1);
    let id = farm.submit(rule, passes(count)).await;
    farm.bits(id).await
}

#[tokio::test(flavor = "multi_thread")]
async fn workers_and_threads_do_not_change_the_picture() {
    for rule in ["statistics", "schedule"] {
        let expected = reference(rule, 75).await;
        for (workers, threads) in [(4, 1), (1, 2)] {
            let farm = Farm::start(Duration::from_secs(15)).await;
            let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), threads)).collect();
            let id = farm.submit(rule, passes(75)).await;
            assert!(farm.bits(id).await == expected, "{rule}, {workers} workers, {threads} threads");
        }
    }
}

/// Another cut is another picture of the same scene, with the same bits from any farm.
#[tokio::test(flavor = "multi_thread")]
async fn a_cut_that_was_asked_for_is_kept_and_decides_the_bits() {
    let cut = Cut { passes_per_shard: Some(2), shards_per_epoch: Some(40) };
    let mut pictures = Vec::new();
    for (workers, cut) in [(1, cut), (4, cut), (1, Cut::default())] {
        let farm = Farm::start(Duration::from_secs(15)).await;
        let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), 1)).collect();
        let scene = farm.handle.add_scene(SCENE.into()).await.expect("a good scene").hash;
        let parameters = [("photons_per_pass".to_owned(), json!(3000))].into_iter().collect();
        let request = JobRequest { parameters, stop: passes(90), cut, seed: 7, ..JobRequest::of_scene(scene) };
        let id = farm.handle.submit(request).await.expect("a good request");
        assert_eq!(farm.end(id).await.cut, cut);
        pictures.push(farm.bits(id).await);
    }
    assert!(pictures[0] == pictures[1], "one worker and four");
    assert!(pictures[0] != pictures[2], "the cut decides after which passes radii are refreshed");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cut_that_cannot_be_is_refused() {
    let farm = Farm::start(Duration::from_secs(15)).await;
    let scene = farm.handle.add_scene(SCENE.into()).await.expect("a good scene").hash;
    for (passes_per_shard, shards_per_epoch) in
        [(Some(0), None), (Some(1025), None), (None, Some(0)), (None, Some(15)), (None, Some(4098))]
    {
        let cut = Cut { passes_per_shard, shards_per_epoch };
        let refused = farm.handle.submit(JobRequest { cut, ..JobRequest::of_scene(scene.clone()) }).await;
        let problem = refused.expect_err("it is refused").to_string();
        assert!(problem.contains("cut."), "{problem}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn every_method_has_the_same_bits_from_one_worker_and_from_four() {
    for method in METHODS.iter().filter(|method| method.name != "sppm") {
        let mut pictures = Vec::new();
        for (workers, threads) in [(1, 1), (4, 1), (1, 2)] {
            let farm = Farm::start(Duration::from_secs(15)).await;
            let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), threads)).collect();
            let id = farm.submit_method(Some(method.name), serde_json::Map::new(), passes(20)).await;
            pictures.push(farm.bits(id).await);
        }
        assert!(pictures.windows(2).all(|pair| pair[0] == pair[1]), "{}", method.name);
    }
}

/// The guide that one worker learns reaches all others before their first shard.
#[tokio::test(flavor = "multi_thread")]
async fn guided_photons_have_the_same_bits_from_one_worker_and_from_four() {
    for method in ["sppm", "ppm"] {
        let mut pictures = Vec::new();
        for (workers, threads, emission) in [(1, 1, "guided"), (4, 1, "guided"), (1, 2, "guided"), (1, 1, "power")] {
            let farm = Farm::start(Duration::from_secs(15)).await;
            let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), threads)).collect();
            let parameters = [("emission".to_owned(), json!(emission)), ("photons_per_pass".to_owned(), json!(3000))];
            let id = farm.submit_method(Some(method), serde_json::Map::from_iter(parameters), passes(40)).await;
            pictures.push(farm.bits(id).await);
        }
        assert!(pictures[0] == pictures[1] && pictures[1] == pictures[2], "{method}");
        assert!(pictures[2] != pictures[3], "{method}: photons start elsewhere than by power");
    }
}

/// So does what it learns of a second lamp, which a wall hides.
#[tokio::test(flavor = "multi_thread")]
async fn visible_picks_have_the_same_bits_from_one_worker_and_from_four() {
    let hidden = "<shape type='sphere'><point name='center' value='50, 0, 0'/><float name='radius' value='0.2'/>\
        <emitter type='area'><rgb name='radiance' value='1e6'/></emitter></shape>\
        <shape type='sphere'><point name='center' value='50, 0, 0'/><bsdf type='diffuse'/></shape></scene>";
    let scene = SCENE.replace("</scene>", hidden);
    for method in ["path", "bdpt"] {
        let mut pictures = Vec::new();
        for (workers, threads, picks) in [(1, 1, "auto"), (4, 1, "auto"), (1, 2, "auto"), (1, 1, "importance")] {
            let farm = Farm::start(Duration::from_secs(15)).await;
            let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), threads)).collect();
            let scene = farm.handle.add_scene(scene.clone().into()).await.expect("a good scene").hash;
            let parameters = serde_json::Map::from_iter([("light_picks".to_owned(), json!(picks))]);
            let method = Some(method.to_owned());
            let request = JobRequest { method, parameters, stop: passes(40), seed: 7, ..JobRequest::of_scene(scene) };
            let id = farm.handle.submit(request).await.expect("a good request");
            pictures.push(farm.bits(id).await);
        }
        assert!(pictures[0] == pictures[1] && pictures[1] == pictures[2], "{method}");
        assert!(pictures[2] != pictures[3], "{method}: the hidden lamp is picked less often");
    }
}

/// Whoever traces a shard traces it for all groups; workers that are killed meanwhile leave nothing of it.
#[tokio::test(flavor = "multi_thread")]
async fn light_groups_have_the_same_bits_from_one_worker_and_from_four() {
    let bulb = "<emitter type='point'><point name='position' value='0.5, 0, 0.5'/>\
        <string name='light_group' value='bulb'/></emitter></scene>";
    let scene = SCENE.replace("</scene>", bulb);
    for (name, parameters) in [("sppm", json!({ "photons_per_pass": 3000 })), ("path", json!({}))] {
        let mut pictures = Vec::new();
        for (workers, victims, light_groups) in [(1, 0, true), (4, 3, true), (1, 0, false)] {
            let farm = Farm::start(Duration::from_millis(600)).await;
            let scene = farm.handle.add_scene(scene.clone().into()).await.expect("a good scene").hash;
            let parameters = parameters.as_object().expect("an object").clone();
            let method = Some(name.to_owned());
            let request =
                JobRequest { method, parameters, stop: passes(40), light_groups, ..JobRequest::of_scene(scene) };
            let id = farm.handle.submit(request).await.expect("a good request");
            for round in 0..victims {
                let (_, victim) = farm.worker(&format!("victim{round}"), 1);
                sleep(Duration::from_millis(60 + 40 * round)).await;
                victim.abort();
            }
            let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), 1)).collect();
            pictures.push(farm.bits(id).await);
            let groups = if light_groups { ["bulb", "others"].as_slice() } else { &[] };
            assert_eq!(farm.end(id).await.light_groups, groups, "{name}");
        }
        assert!(pictures[0] == pictures[1], "{name}");
        // Two groups of three channels more.
        assert_eq!(pictures[0].len(), pictures[2].len() + 6 * 40 * 30, "{name}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn killed_workers_do_not_change_the_picture() {
    let farm = Farm::start(Duration::from_millis(600)).await;
    let id = farm.submit("statistics", passes(75)).await;
    for round in 0..4 {
        let (_, worker) = farm.worker(&format!("victim{round}"), 1);
        sleep(Duration::from_millis(60 + 40 * round)).await;
        worker.abort();
    }
    let _worker = farm.worker("survivor", 1);
    assert!(farm.bits(id).await == reference("statistics", 75).await);
}

/// A pass of chains begins anew on another worker as it began on the one that was killed.
#[tokio::test(flavor = "multi_thread")]
async fn killed_workers_do_not_change_the_pictures_of_chains() {
    let whole_paths = json!({ "user_paths": [{ "points": [[0.0, 0.99, 0.0], [0.0, -1.0, 0.3]], "cones": [20.0] }] });
    for (method, parameters) in [
        ("mmlt", json!({ "chains": 7 })),
        ("mlt", whole_paths.clone()),
        ("mps", whole_paths),
        ("sppm", json!({ "emission": "metropolis", "photons_per_pass": 3000 })),
        ("vcm", json!({ "emission": "metropolis" })),
    ] {
        let parameters = parameters.as_object().expect("an object");
        let mut pictures = Vec::new();
        for workers in [1, 5] {
            let farm = Farm::start(Duration::from_millis(600)).await;
            let id = farm.submit_method(Some(method), parameters.clone(), passes(40)).await;
            for round in 0..workers - 1 {
                let (_, victim) = farm.worker(&format!("victim{round}"), 1);
                sleep(Duration::from_millis(60 + 40 * round)).await;
                victim.abort();
            }
            let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), 1)).collect();
            pictures.push(farm.bits(id).await);
        }
        assert!(pictures[0] == pictures[1], "{method}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_outage_of_the_coordinator_does_not_change_the_picture() {
    let farm = Farm::start(Duration::from_secs(5)).await;
    let id = farm.submit("statistics", passes(300)).await;
    let proxy = FaultProxy::start(farm.local.address()).await;
    let _workers = [start_worker(proxy.url(), "one", 1), start_worker(proxy.url(), "two", 1)];
    let mut status = farm.handle.watch(id).expect("a job");
    status.wait_for(|status| status.passes_done > 3).await.expect("the coordinator lives");
    proxy.cut(true);
    sleep(Duration::from_millis(700)).await;
    proxy.cut(false);
    assert!(farm.bits(id).await == reference("statistics", 300).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_worker_that_is_asked_to_stop_gives_its_work_back() {
    let farm = Farm::start(Duration::from_secs(600)).await;
    let id = farm.submit("statistics", passes(75)).await;
    farm.work_beyond(id, 1, "leaving").await;
    assert_eq!(farm.handle.workers(), []);
    // With leases of ten minutes, only work that was given back can be done in time.
    let _worker = farm.worker("successor", 1);
    assert!(farm.bits(id).await == reference("statistics", 75).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_stopped_by_seconds_has_the_bits_of_a_job_of_as_many_passes() {
    let farm = Farm::start(Duration::from_secs(15)).await;
    let _worker = farm.worker("alone", 1);
    let id = farm.submit("statistics", StopRule { seconds: Some(0.8), ..StopRule::default() }).await;
    let stopped = farm.bits(id).await;
    let done = farm.handle.job(id).expect("a job").passes_done;
    let id = farm.submit("statistics", passes(done)).await;
    assert!(farm.bits(id).await == stopped, "{done} passes");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_stopped_by_its_error_has_the_same_bits_from_any_farm() {
    const WANTED: f64 = 0.02;
    let mut pictures = Vec::new();
    for workers in [1, 3] {
        let farm = Farm::start(Duration::from_secs(15)).await;
        let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), 1)).collect();
        let id = farm.submit("statistics", StopRule { error: Some(WANTED), ..StopRule::default() }).await;
        let bits = farm.bits(id).await;
        let status = farm.handle.job(id).expect("a job");
        let error = status.estimated_error.expect("an error estimate");
        assert!(error.bound <= WANTED && error.relmse < error.bound, "{error:?}");
        assert_eq!(error.passes, status.passes_done, "nothing is merged after the end");
        pictures.push((status.passes_done, bits));
    }
    assert!(pictures[0] == pictures[1], "{} and {} passes", pictures[0].0, pictures[1].0);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_job_keeps_its_picture_and_frees_the_farm() {
    let farm = Farm::start(Duration::from_secs(15)).await;
    let id = farm.submit("statistics", passes(1_000_000)).await;
    assert!(matches!(farm.handle.picture(id).await, Err(FarmError::NoPictureYet(_))));
    let _worker = farm.worker("alone", 1);
    let mut status = farm.handle.watch(id).expect("a job");
    status.wait_for(|status| status.passes_done > 1).await.expect("the coordinator lives");
    assert_eq!(farm.handle.cancel(id).await.expect("a job").state, JobState::Cancelled);
    assert!(farm.handle.picture(id).await.is_ok());
    let next = farm.submit("statistics", passes(2)).await;
    assert_eq!(farm.end(next).await.state, JobState::Done);
    assert_eq!(farm.end(id).await.state, JobState::Cancelled);
}

/// The shard of a lease, when it is not the pilot's.
fn shard(lease: &messages::Lease) -> Option<Shard> {
    match decode_lease(lease.clone()).expect("a good lease").work {
        LeasedWork::Shard(terms) => Some(terms.planned.shard),
        _ => None,
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_hostile_worker_disturbs_nobody() {
    let farm = Farm::start(Duration::from_secs(1)).await;
    assert_eq!(Hand::register(&farm.url(), None, "another build").await.err(), Some(409));
    let hand = Hand::register(&farm.url(), None, BUILD).await.expect("a place");
    let id = farm.submit("statistics", passes(75)).await;

    let pilot = hand.lease().await;
    assert_eq!(hand.send(&pilot, vec![0xff; 50]).await, 400);
    let other_hand = Hand::register(&farm.url(), None, BUILD).await.expect("a place");
    assert_eq!(other_hand.deliver(&pilot, None).await, 409, "the lease is somebody else's");
    assert_eq!(hand.deliver(&pilot, None).await, 422);
    farm.work_beyond(id, 0, "honest").await;

    let lease = hand.lease().await;
    let declaration = Arc::new(Declaration::gathering(RadiusRule::Statistics, 2.0 / 3.0));
    let mut tally = Tally::zero(shard(&lease).expect("a shard"), 40, &declaration);
    tally.set_scalar(PHOTONS_EMITTED, 1.0);
    tally.plane_mut("flux").expect("declared")[5] = f32::NAN;
    let wrong = Some(Outcome::Tally(encode_tally(&tally)));
    let other = messages::Lease { fencing: lease.fencing + 1, ..lease.clone() };
    assert_eq!(hand.deliver(&other, wrong.clone()).await, 409, "another fencing number");
    assert_eq!(hand.deliver(&lease, wrong.clone()).await, 422, "not a number");
    assert_eq!(hand.deliver(&lease, wrong).await, 409, "the lease is gone");

    let _worker = farm.worker("honest again", 1);
    assert!(farm.bits(id).await == reference("statistics", 75).await);
}

/// What looks like a tally but is none is found by tracing the shard again, and taken out of the picture.
#[tokio::test(flavor = "multi_thread")]
async fn a_lie_is_taken_out_of_the_picture() {
    let farm = Farm::with(CoordinatorOptions { check_share: 1.0, ..CoordinatorOptions::default() }).await;
    let id = farm.submit("statistics", passes(75)).await;
    farm.work_beyond(id, 0, "first").await;

    let hand = Hand::register(&farm.url(), None, BUILD).await.expect("a place");
    let lease = hand.lease().await;
    let declaration = Arc::new(Declaration::gathering(RadiusRule::Statistics, 2.0 / 3.0));
    let mut tally = Tally::zero(shard(&lease).expect("a shard"), 40, &declaration);
    tally.set_scalar(PHOTONS_EMITTED, 3000.0);
    let _others = [farm.worker("second", 1), farm.worker("third", 1)];
    while farm.handle.workers().len() < 3 {
        sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(hand.deliver(&lease, Some(Outcome::Tally(encode_tally(&tally)))).await, 200, "it looks good");

    assert!(farm.bits(id).await == reference("statistics", 75).await);
    assert!(farm.handle.job(id).expect("a job").shards_mismatched > 0);
    let liar = farm.handle.workers().into_iter().find(|worker| worker.name == "hand").expect("it is still there");
    assert!(liar.set_aside.is_some_and(|reason| reason.contains("other bits")));
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_that_cannot_be_met_say_why() {
    let farm = Farm::start(Duration::from_secs(15)).await;
    let (_, lost) = start_worker("localhost:80".into(), "lost", 1);
    assert!(matches!(lost.await.expect("no panic"), Err(WorkerError::BadAddress { .. })));
    assert!(matches!(farm.handle.add_scene(b"<scene".to_vec()).await, Err(FarmError::BadScene(_))));
    assert!(matches!(farm.handle.job(JobId::new(1)), Err(FarmError::UnknownJob(_))));
    let scene = farm.handle.add_scene(SCENE.into()).await.expect("a good scene").hash;
    let good = JobRequest::of_scene(scene);
    let unknown = JobRequest { scene: "00".into(), ..good.clone() };
    assert!(matches!(farm.handle.submit(unknown).await, Err(FarmError::UnknownScene(_))));
    let method = JobRequest { method: Some("magic".into()), ..good.clone() };
    assert!(matches!(farm.handle.submit(method).await, Err(FarmError::BadMethod(_))));
    for stop in [passes(0), StopRule { seconds: Some(f64::NAN), ..StopRule::default() }] {
        let never = JobRequest { stop, ..good.clone() };
        assert!(matches!(farm.handle.submit(never).await, Err(FarmError::BadRequest { .. })));
    }
    farm.handle.shutdown().await;
    assert!(matches!(farm.handle.submit(good).await, Err(FarmError::ShuttingDown)));
}

/// The case of a fault inside the merge: the job ends and says why, and the farm goes on.
#[tokio::test(flavor = "multi_thread")]
async fn a_panic_inside_a_merge_fails_the_job_and_nothing_else() {
    let is_armed = Arc::new(AtomicBool::new(true));
    let armed = is_armed.clone();
    let mut options = CoordinatorOptions::default();
    options.faults.before_merge = Some(Arc::new(move |_, shard| {
        assert!(shard != 3 || !armed.swap(false, Ordering::Relaxed), "an injected fault");
    }));
    let farm = Farm::with(options).await;
    let _worker = farm.worker("alone", 1);
    let id = farm.submit("statistics", passes(75)).await;
    let status = farm.end(id).await;
    assert_eq!(status.state, JobState::Failed);
    assert!(status.error.is_some_and(|error| error.contains("an injected fault")));
    let id = farm.submit("statistics", passes(75)).await;
    assert!(farm.bits(id).await == reference("statistics", 75).await);
    assert!(!is_armed.load(Ordering::Relaxed));
}

/// The case of a starved coordinator: what the answer to a cancellation says is what stays, although a merge was under way.
#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_job_stays_as_the_answer_said() {
    let mut options = CoordinatorOptions::default();
    options.faults.before_merge = Some(Arc::new(|_, _| std::thread::sleep(Duration::from_millis(30))));
    let farm = Farm::with(options).await;
    let _workers: Vec<_> = (0..4).map(|index| farm.worker(&format!("w{index}"), 1)).collect();
    for _ in 0..4 {
        let id = farm.submit("statistics", passes(1_000_000)).await;
        let mut status = farm.handle.watch(id).expect("a job");
        status.wait_for(|status| status.passes_done > 3).await.expect("the coordinator lives");
        let said = farm.handle.cancel(id).await.expect("a job");
        let picture = farm.handle.picture(id).await.expect("a picture").0;
        sleep(Duration::from_millis(300)).await;
        let now = farm.handle.job(id).expect("a job");
        assert_eq!(
            (now.state, now.passes_done, now.picture_version),
            (JobState::Cancelled, said.passes_done, said.picture_version)
        );
        assert!(farm.handle.picture(id).await.expect("a picture").0 == picture);
    }
}

/// The case of a short job beside a long one, with real workers.
#[tokio::test(flavor = "multi_thread")]
async fn a_short_job_ends_beside_a_long_one() {
    for workers in [1, 4] {
        let farm = Farm::start(Duration::from_secs(15)).await;
        let _workers: Vec<_> = (0..workers).map(|index| farm.worker(&format!("w{index}"), 1)).collect();
        let long = farm.submit("statistics", passes(1_000_000)).await;
        let short = farm.submit("statistics", passes(10)).await;
        assert_eq!(farm.end(short).await.state, JobState::Done, "{workers} workers");
        assert_eq!(farm.handle.job(long).expect("a job").state, JobState::Running);
        farm.handle.cancel(long).await.expect("a job");
    }
}

/// The case of a dead last worker: nobody invents a time left, and the dead are not listed as if they lived.
#[tokio::test(flavor = "multi_thread")]
async fn a_job_without_workers_says_so() {
    let farm = Farm::start(Duration::from_millis(600)).await;
    let id = farm.submit("statistics", passes(1_000_000)).await;
    let (_, worker) = farm.worker("mortal", 1);
    let mut status = farm.handle.watch(id).expect("a job");
    status.wait_for(|status| status.passes_done > 1).await.expect("the coordinator lives");
    worker.abort();
    let waits = status.wait_for(|status| status.waiting_for_workers_since.is_some());
    let waiting = timeout(Duration::from_secs(10), waits).await.expect("it is noticed").expect("lives").clone();
    assert_eq!((waiting.workers, waiting.seconds_left), (0, None));
    let workers = farm.handle.workers();
    assert!(workers.iter().all(|worker| worker.state == photonfarm::farm::job::WorkerState::Silent), "{workers:?}");
    let told = |status: &JobStatus| {
        status.notices.iter().filter(|notice| notice.starts_with("No worker is connected")).count()
    };
    // Whoever watches is told; nobody has to ask again.
    let patience = status.wait_for(|status| told(status) == 1);
    timeout(Duration::from_secs(10), patience).await.expect("a notice").expect("the coordinator lives");
    let (_, _worker) = farm.worker("successor", 1);
    let back = status.wait_for(|status| status.waiting_for_workers_since.is_none());
    assert_eq!(told(&back.await.expect("the coordinator lives")), 0, "the notice goes when a worker comes");
}

/// A job that waits for memory, one job too many, and a picture that never fits.
#[tokio::test(flavor = "multi_thread")]
async fn limits_are_kept_and_told() {
    let mut options = CoordinatorOptions::default();
    options.limits.live_jobs = 2;
    let farm = Farm::with(options.clone()).await;
    let first = farm.submit("statistics", passes(1)).await;
    farm.submit("statistics", passes(1)).await;
    let scene = farm.handle.add_scene(SCENE.into()).await.expect("a good scene").hash;
    let third = farm.handle.submit(JobRequest::of_scene(scene)).await;
    assert!(matches!(third, Err(FarmError::Busy { .. })), "{third:?}");
    farm.handle.cancel(first).await.expect("a job");
    farm.submit("statistics", passes(1)).await;

    options.limits.job_memory = 1000;
    let farm = Farm::with(options).await;
    let scene = farm.handle.add_scene(SCENE.into()).await.expect("a good scene").hash;
    let large = farm.handle.submit(JobRequest::of_scene(scene)).await;
    assert!(matches!(large, Err(FarmError::TooLarge { .. })), "{large:?}");
}

/// A method's own passes cannot tell of light that it never finds.
#[tokio::test(flavor = "multi_thread")]
async fn a_blind_method_is_not_asked_for_an_error_by_mistake() {
    let farm = Farm::start(Duration::from_secs(15)).await;
    let blind = "<emitter type='point'/><shape type='sphere'><bsdf type='dielectric'/></shape></scene>";
    let scene = farm.handle.add_scene(SCENE.replace("</scene>", blind).into()).await.expect("a good scene").hash;
    let request = |method: &str, stop: StopRule| JobRequest {
        method: Some(method.to_owned()),
        stop,
        ..JobRequest::of_scene(scene.clone())
    };
    let by_error = StopRule { error: Some(0.02), ..StopRule::default() };
    let refused = farm.handle.submit(request("path", by_error)).await.expect_err("path is blind here");
    assert!(refused.to_string().contains("path cannot find light that mirrors and glass throw"), "{refused}");
    assert!(refused.to_string().contains("accepts_missing_light"), "{refused}");
    let accepted = StopRule { accepts_missing_light: true, ..by_error };
    farm.handle.submit(request("path", accepted)).await.expect("in so many words");
    farm.handle.submit(request("path", passes(3))).await.expect("passes need no estimate");
    farm.handle.submit(request("sppm", by_error)).await.expect("sppm finds all light");
}

/// Ended jobs and then their scenes are deleted when they are old enough, running ones are not.
#[tokio::test(flavor = "multi_thread")]
async fn old_jobs_are_deleted() {
    let options = CoordinatorOptions { keep_ended: Some(Duration::from_millis(500)), ..CoordinatorOptions::default() };
    let farm = Farm::with(options).await;
    let _worker = farm.worker("alone", 1);
    let unused = farm.handle.add_scene(format!("{SCENE}<!-- another -->").into()).await.expect("a good scene").hash;
    let short = farm.submit("statistics", passes(2)).await;
    assert_eq!(farm.end(short).await.state, JobState::Done);
    let long = farm.submit("statistics", passes(1_000_000)).await;
    let gone = async {
        while farm.handle.job(short).is_ok() || farm.handle.scene(&unused).is_ok() {
            sleep(Duration::from_millis(50)).await;
        }
    };
    timeout(Duration::from_secs(20), gone).await.expect("it is deleted");
    let scene = farm.handle.job(long).expect("it runs").scene;
    assert!(farm.handle.scene(&scene).is_ok());
}
