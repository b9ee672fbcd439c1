//! What a worker does between registering and leaving.
//!
//! Four activities run side by side, so that the rendering threads never wait for the network: **fetching** leases and
//! what they need (one ahead), **tracing**, **delivering** finished tallies, and **heartbeats**.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bytes::Bytes;
use prost::Message;
use tokio::sync::{Semaphore, mpsc};
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::cache::{Cache, PrepareError};
use super::client::{Backoff, CallError, Client, TRANSFER_TIMEOUT};
use super::pool::RenderPool;
use crate::estimate::picture_files::Mattes;
use crate::estimate::{RadiusField, Tally};
use crate::evaluation::{PoolStopwatch, RunError};
use crate::farm::events::EVENTS;
use crate::farm::ids::{Fencing, JobId, LeaseId};
use crate::farm::locks::lock;
use crate::farm::method_choice::{best_method, try_methods};
use crate::farm::prepared_scenes::PreparedScenes;
use crate::farm::rules::lease::Errand;
use crate::farm::wire::first_surfaces;
use crate::farm::wire::lease::{ChoiceTerms, JobDescription, LeasedWork, ShardTerms, WorkerLease, decode_lease};
use crate::farm::wire::mattes::encode as encode_mattes;
use crate::farm::wire::messages::result_request::Outcome;
use crate::farm::wire::messages::{
    Choice, HeartbeatRequest, HeartbeatResponse, LeaseResponse, ReleaseRequest, ResultRequest, ResultResponse,
};
use crate::farm::wire::result::{encode_pilot, encode_tally};
use crate::method::MethodChoice;
use crate::render::first_surface::{FirstSurface, first_surface_layers};
use crate::render::mattes::mattes;
use crate::render::{Cancelled, Pilot, Renderer};
use crate::scene::Scene;

/// For everything else; longer than the coordinator lets a worker wait for work.
pub(super) const MESSAGE_TIMEOUT: Duration = Duration::from_secs(20);
/// How long a worker that was asked to stop tries to say so.
const FAREWELL: Duration = Duration::from_secs(3);
/// How long it tries to deliver what it has finished.
const LAST_DELIVERIES: Duration = Duration::from_secs(10);
/// Pause between questions to a coordinator that is shutting down.
const DRAIN_PAUSE: Duration = Duration::from_secs(1);
/// Tallies on their way; a third waits in the rendering loop, which bounds memory.
const DELIVERIES: usize = 2;

/// Why a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SessionEnd {
    /// The worker was asked to stop.
    Shutdown,
    /// The coordinator has no further work for it.
    SentAway,
    /// The coordinator does not know the worker any more.
    Forgotten,
}

/// A lease in the worker's hands.
struct Held {
    /// Ends its tracing.
    cancel: Arc<AtomicBool>,
    /// Ends its delivery.
    unwanted: CancellationToken,
    is_delivering: bool,
}

/// A lease with all that is needed to do it.
struct Task {
    lease: LeaseId,
    fencing: Fencing,
    work: ReadyWork,
    cancel: Arc<AtomicBool>,
}

enum ReadyWork {
    Choice(Arc<Scene>, ChoiceTerms),
    Pilot(Arc<Renderer>),
    Shard(Arc<Renderer>, ShardTerms, Arc<RadiusField>),
    Errand(Arc<Scene>, Errand),
}

enum Product {
    Choice(Choice),
    Pilot(Pilot),
    Tally(Tally),
    FirstSurfaces(Vec<FirstSurface>),
    Mattes(Mattes),
    Failure(String),
}

/// One registration with the coordinator.
pub(super) struct Session {
    pub(super) client: Client,
    pub(super) name: String,
    pub(super) lease_duration: Duration,
    pub(super) pool: Arc<RenderPool>,
    cache: Cache,
    held: Mutex<BTreeMap<LeaseId, Held>>,
    /// The job that was announced last.
    announced: Mutex<Option<JobId>>,
    deliveries: TaskTracker,
    delivery_slots: Arc<Semaphore>,
}

impl Session {
    /// A session that holds nothing yet.
    pub(super) fn new(
        client: Client,
        name: String,
        lease_duration: Duration,
        pool: Arc<RenderPool>,
        scenes: PreparedScenes,
    ) -> Arc<Self> {
        Arc::new(Self {
            client,
            name,
            lease_duration,
            pool,
            cache: Cache::new(scenes),
            held: Mutex::new(BTreeMap::new()),
            announced: Mutex::new(None),
            deliveries: TaskTracker::new(),
            delivery_slots: Arc::new(Semaphore::new(DELIVERIES)),
        })
    }

    /// Works until `shutdown` is cancelled or the coordinator forgets the worker, then gives back what it holds.
    pub(super) async fn run(self: &Arc<Self>, shutdown: &CancellationToken) -> SessionEnd {
        let (sender, receiver) = mpsc::channel(1);
        let end = tokio::select! {
            () = shutdown.cancelled() => SessionEnd::Shutdown,
            end = self.fetch(sender) => end,
            end = self.send_heartbeats() => end,
            () = self.trace(receiver) => SessionEnd::Forgotten,
        };
        for held in lock(&self.held).values() {
            held.cancel.store(true, Ordering::Relaxed);
        }
        if end != SessionEnd::Forgotten {
            self.leave().await;
        }
        end
    }

    async fn fetch(self: &Arc<Self>, tasks: mpsc::Sender<Task>) -> SessionEnd {
        let mut backoff = Backoff::new(&self.name);
        while let Ok(slot) = tasks.reserve().await {
            match self.client.post::<LeaseResponse>("lease", Bytes::new(), MESSAGE_TIMEOUT).await {
                Ok(LeaseResponse { lease: Some(lease), .. }) => match self.accept(lease).await {
                    Some(task) => {
                        backoff.reset();
                        slot.send(task);
                    }
                    // The next lease may be just as useless.
                    None => sleep(backoff.next_pause()).await,
                },
                Ok(LeaseResponse { leave: true, .. }) => return SessionEnd::SentAway,
                Ok(LeaseResponse { drain: true, .. }) => sleep(DRAIN_PAUSE).await,
                Ok(_) => backoff.reset(),
                Err(CallError::Forgotten) => return SessionEnd::Forgotten,
                Err(problem) => {
                    tracing::debug!(%problem, "no work can be had; trying again");
                    sleep(backoff.next_pause()).await;
                }
            }
        }
        SessionEnd::Forgotten
    }

    /// Records a lease and fetches what it needs. A lease that cannot be used is given back or reported.
    async fn accept(self: &Arc<Self>, lease: crate::farm::wire::messages::Lease) -> Option<Task> {
        let (id, fencing) = (LeaseId::new(lease.id), Fencing::new(lease.fencing));
        let cancel = Arc::new(AtomicBool::new(false));
        lock(&self.held)
            .insert(id, Held { cancel: cancel.clone(), unwanted: CancellationToken::new(), is_delivering: false });
        let prepared = match decode_lease(lease) {
            Ok(lease) => self.prepare(lease, cancel).await,
            Err(problem) => Err(PrepareError::Unusable(problem.to_string())),
        };
        match prepared {
            Ok(task) => Some(task),
            Err(PrepareError::Unusable(problem)) => {
                tracing::warn!(lease = %id, problem, "a lease cannot be used");
                self.deliver(id, fencing, Product::Failure(problem)).await;
                None
            }
            Err(PrepareError::Call(problem)) => {
                tracing::info!(lease = %id, %problem, "what a lease needs cannot be had; giving it back");
                self.give_back(vec![id], false).await;
                None
            }
        }
    }

    async fn prepare(&self, lease: WorkerLease, cancel: Arc<AtomicBool>) -> Result<Task, PrepareError> {
        let WorkerLease { id, fencing, job, work } = lease;
        self.announce(&job);
        let (cache, client, pool) = (&self.cache, &self.client, &self.pool);
        let work = match work {
            LeasedWork::Choice(terms) => ReadyWork::Choice(cache.scene(client, pool, &job.scene).await?, terms),
            LeasedWork::Errand(errand) => ReadyWork::Errand(cache.scene(client, pool, &job.scene).await?, errand),
            LeasedWork::Pilot => ReadyWork::Pilot(cache.renderer(client, pool, &job).await?),
            LeasedWork::Shard(terms) => {
                let renderer = cache.pass_renderer(client, pool, &job, &terms).await?;
                ReadyWork::Shard(renderer, terms, cache.field(client, &job, &terms).await?)
            }
        };
        Ok(Task { lease: id, fencing, work, cancel })
    }

    /// Says what this worker works on, when that changes.
    fn announce(&self, job: &JobDescription) {
        if lock(&self.announced).replace(job.id) != Some(job.id) {
            let method = job.method.as_ref().map_or("no method yet", |method| method.choice.name.as_str());
            tracing::info!(target: EVENTS, "{} works on job {} ({method}, {} × {} pixels)", self.name, job.id, job.width, job.height);
        }
    }

    async fn trace(self: &Arc<Self>, mut tasks: mpsc::Receiver<Task>) {
        while let Some(task) = tasks.recv().await {
            let (lease, fencing) = (task.lease, task.fencing);
            let product = match self.pool.run(move || task.trace()).await {
                Ok(Ok(product)) => product,
                Ok(Err(Cancelled)) => {
                    tracing::debug!(%lease, "tracing was cancelled");
                    lock(&self.held).remove(&lease);
                    continue;
                }
                Err(problem) => Product::Failure(problem),
            };
            self.deliver(lease, fencing, product).await;
        }
    }

    /// Begins a delivery as soon as not too many are under way.
    async fn deliver(self: &Arc<Self>, lease: LeaseId, fencing: Fencing, product: Product) {
        let unwanted = match lock(&self.held).get_mut(&lease) {
            Some(held) => {
                held.is_delivering = true;
                held.unwanted.clone()
            }
            None => return,
        };
        let Ok(slot) = self.delivery_slots.clone().acquire_owned().await else { return };
        let session = self.clone();
        self.deliveries.spawn(async move {
            if unwanted.run_until_cancelled(session.send_result(lease, fencing, product)).await.is_none() {
                tracing::debug!(%lease, "a result is not wanted any more");
            }
            lock(&session.held).remove(&lease);
            drop(slot);
        });
    }

    /// Keeps at it through outages, until the coordinator has said yes or no.
    async fn send_result(&self, lease: LeaseId, fencing: Fencing, product: Product) {
        let encode = move || Bytes::from(ResultRequest { outcome: Some(product.encode()) }.encode_to_vec());
        let Ok(message) = tokio::task::spawn_blocking(encode).await else { return };
        let path = format!("leases/{lease}/{fencing}/result");
        let mut backoff = Backoff::new(&self.name);
        loop {
            match self.client.post::<ResultResponse>(&path, message.clone(), TRANSFER_TIMEOUT).await {
                Ok(_) => return,
                Err(problem) if problem.is_temporary() => {
                    tracing::debug!(%lease, %problem, "a result cannot be delivered; trying again");
                    sleep(backoff.next_pause()).await;
                }
                Err(problem) => {
                    tracing::info!(%lease, %problem, "a result was not wanted");
                    return;
                }
            }
        }
    }

    async fn send_heartbeats(&self) -> SessionEnd {
        loop {
            sleep(self.lease_duration / 3).await;
            let leases = lock(&self.held).keys().map(|lease| lease.number()).collect();
            let message = HeartbeatRequest { leases }.encode_to_vec().into();
            match self.client.post::<HeartbeatResponse>("heartbeat", message, MESSAGE_TIMEOUT).await {
                Ok(answer) => self.cancel(&answer.cancelled),
                Err(CallError::Forgotten) => return SessionEnd::Forgotten,
                Err(problem) => tracing::debug!(%problem, "heartbeat failed"),
            }
        }
    }

    fn cancel(&self, leases: &[u64]) {
        let held = lock(&self.held);
        for lease in leases.iter().filter_map(|lease| held.get(&LeaseId::new(*lease))) {
            lease.cancel.store(true, Ordering::Relaxed);
            lease.unwanted.cancel();
        }
    }

    /// Gives leases back so that others get them at once.
    async fn give_back(&self, leases: Vec<LeaseId>, leaving: bool) {
        for lease in &leases {
            lock(&self.held).remove(lease);
        }
        let leases = leases.into_iter().map(LeaseId::number).collect();
        let message = ReleaseRequest { leases, leaving }.encode_to_vec().into();
        // Unheard, it only takes longer: the leases expire.
        let sent = timeout(FAREWELL, self.client.post::<()>("release", message, MESSAGE_TIMEOUT)).await;
        if !matches!(sent, Ok(Ok(()))) {
            tracing::info!("leases could not be given back; they will expire");
        }
    }

    async fn leave(&self) {
        let unfinished: Vec<LeaseId> =
            lock(&self.held).iter().filter(|(_, held)| !held.is_delivering).map(|(id, _)| *id).collect();
        if !unfinished.is_empty() {
            self.give_back(unfinished, false).await;
        }
        self.deliveries.close();
        if timeout(LAST_DELIVERIES, self.deliveries.wait()).await.is_err() {
            tracing::warn!("a finished shard could not be delivered");
        }
        self.give_back(Vec::new(), true).await;
    }
}

impl Task {
    fn trace(self) -> Result<Product, Cancelled> {
        let cancel = &*self.cancel;
        match self.work {
            ReadyWork::Choice(scene, terms) => choose(&scene, &terms, cancel),
            ReadyWork::Pilot(renderer) => renderer.pilot(cancel).map(Product::Pilot),
            ReadyWork::Shard(renderer, terms, field) => {
                renderer.trace(terms.planned.shard, &field, cancel).map(Product::Tally)
            }
            ReadyWork::Errand(scene, Errand::FirstSurfaces) => Ok(Product::FirstSurfaces(first_surface_layers(&scene))),
            ReadyWork::Errand(scene, Errand::Mattes) => Ok(Product::Mattes(mattes(&scene))),
        }
    }
}

/// Lets methods try a small picture of the scene.
fn choose(scene: &Scene, terms: &ChoiceTerms, cancel: &AtomicBool) -> Result<Product, Cancelled> {
    let found = PoolStopwatch::start()
        .map_err(RunError::from)
        .and_then(|mut time| try_methods(scene, &terms.parameters, terms.error, &mut time, cancel));
    match found {
        Ok(found) => {
            let MethodChoice { name, parameters } = best_method(&found);
            let parameters =
                if parameters.is_empty() { String::new() } else { serde_json::Value::Object(parameters).to_string() };
            Ok(Product::Choice(Choice { method: name, reason: found.reason(), parameters }))
        }
        Err(RunError::Cancelled(cancelled)) => Err(cancelled),
        Err(problem) => Ok(Product::Failure(problem.to_string())),
    }
}

impl Product {
    fn encode(self) -> Outcome {
        match self {
            Self::Choice(choice) => Outcome::Choice(choice),
            Self::Pilot(pilot) => Outcome::Pilot(encode_pilot(&pilot)),
            Self::Tally(tally) => Outcome::Tally(encode_tally(&tally)),
            Self::FirstSurfaces(seen) => Outcome::FirstSurfaces(first_surfaces::encode(&seen)),
            Self::Mattes(seen) => encode_mattes(seen).map_or_else(Outcome::Failure, Outcome::Mattes),
            Self::Failure(problem) => Outcome::Failure(problem),
        }
    }
}
