//! What a worker does between registering and leaving.
//!
//! Four activities run side by side, so that the rendering threads never wait for the network: **fetching** leases and
//! what they need (one ahead), **tracing**, **delivering** finished tallies, and **heartbeats**.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::body::Bytes;
use prost::Message;
use tokio::sync::{Semaphore, mpsc};
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::cache::{Cache, PrepareError};
use super::client::{Backoff, CallError, Client};
use super::pool::RenderPool;
use crate::estimate::{RadiusField, Tally};
use crate::farm::coordinator::lock;
use crate::farm::rules::plan::PlannedShard;
use crate::farm::wire::lease::{LeasedWork, decode_lease};
use crate::farm::wire::messages::result_request::Outcome;
use crate::farm::wire::messages::{
    HeartbeatRequest, HeartbeatResponse, LeaseRequest, LeaseResponse, ReleaseRequest, ResultRequest, ResultResponse,
};
use crate::farm::wire::result::{encode_pilot, encode_tally};
use crate::render::{Cancelled, Pilot, Renderer};

/// For scenes, radius fields and results.
pub(super) const TRANSFER_TIMEOUT: Duration = Duration::from_secs(300);
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
    /// The coordinator does not know the worker any more.
    Forgotten,
}

/// A lease in the worker's hands.
struct Held {
    cancel: Arc<AtomicBool>,
    is_delivering: bool,
}

/// A lease with all that is needed to trace it.
struct Task {
    lease: u64,
    fencing: u64,
    renderer: Arc<Renderer>,
    shard: Option<(PlannedShard, Arc<RadiusField>)>,
    cancel: Arc<AtomicBool>,
}

enum Product {
    Pilot(Pilot),
    Tally(Tally),
    Failure(String),
}

/// One registration with the coordinator.
pub(super) struct Session {
    pub(super) client: Client,
    pub(super) name: String,
    pub(super) worker: u64,
    pub(super) lease_duration: Duration,
    pub(super) pool: Arc<RenderPool>,
    cache: Cache,
    held: Mutex<BTreeMap<u64, Held>>,
    deliveries: TaskTracker,
    delivery_slots: Arc<Semaphore>,
}

impl Session {
    /// A session that holds nothing yet.
    pub(super) fn new(
        client: Client,
        name: String,
        worker: u64,
        lease_duration: Duration,
        pool: Arc<RenderPool>,
    ) -> Arc<Self> {
        Arc::new(Self {
            client,
            name,
            worker,
            lease_duration,
            pool,
            cache: Cache::new(),
            held: Mutex::new(BTreeMap::new()),
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
        if end == SessionEnd::Shutdown {
            self.leave().await;
        }
        end
    }

    async fn fetch(self: &Arc<Self>, tasks: mpsc::Sender<Task>) -> SessionEnd {
        let mut backoff = Backoff::new(&self.name);
        let request: Bytes = LeaseRequest { worker: self.worker }.encode_to_vec().into();
        while let Ok(slot) = tasks.reserve().await {
            match self.client.post::<LeaseResponse>("lease", request.clone(), MESSAGE_TIMEOUT).await {
                Ok(LeaseResponse { lease: Some(lease), .. }) => {
                    backoff.reset();
                    if let Some(task) = self.accept(lease).await {
                        slot.send(task);
                    }
                }
                Ok(LeaseResponse { drain: true, .. }) => sleep(DRAIN_PAUSE).await,
                Ok(_) => backoff.reset(),
                Err(CallError::Forgotten) => return SessionEnd::Forgotten,
                Err(problem) => {
                    tracing::warn!(%problem, "no work can be had; trying again");
                    sleep(backoff.next_pause()).await;
                }
            }
        }
        SessionEnd::Forgotten
    }

    /// Notes a lease and fetches what it needs. A lease that cannot be used is given back or reported.
    async fn accept(self: &Arc<Self>, lease: crate::farm::wire::messages::Lease) -> Option<Task> {
        let (id, fencing) = (lease.id, lease.fencing);
        let cancel = Arc::new(AtomicBool::new(false));
        lock(&self.held).insert(id, Held { cancel: cancel.clone(), is_delivering: false });
        let prepared = match decode_lease(lease) {
            Ok(work) => self.prepare(work, cancel).await,
            Err(problem) => Err(PrepareError::Unusable(problem.to_string())),
        };
        match prepared {
            Ok(task) => Some(task),
            Err(PrepareError::Unusable(problem)) => {
                tracing::warn!(lease = id, problem, "a lease cannot be used");
                self.deliver(id, fencing, Product::Failure(problem)).await;
                None
            }
            Err(PrepareError::Call(problem)) => {
                tracing::info!(lease = id, %problem, "what a lease needs cannot be had; giving it back");
                self.give_back(vec![id], false).await;
                None
            }
        }
    }

    async fn prepare(&self, work: LeasedWork, cancel: Arc<AtomicBool>) -> Result<Task, PrepareError> {
        let renderer = self.cache.renderer(&self.client, &self.pool, &work.job).await?;
        let shard = match work.work {
            None => None,
            Some(planned) => Some((planned, self.cache.field(&self.client, &work.job, &planned).await?)),
        };
        Ok(Task { lease: work.id, fencing: work.fencing, renderer, shard, cancel })
    }

    async fn trace(self: &Arc<Self>, mut tasks: mpsc::Receiver<Task>) {
        while let Some(task) = tasks.recv().await {
            let (lease, fencing) = (task.lease, task.fencing);
            let product = match self.pool.run(move || task.trace()).await {
                Ok(Ok(product)) => product,
                Ok(Err(Cancelled)) => {
                    tracing::debug!(lease, "tracing was cancelled");
                    lock(&self.held).remove(&lease);
                    continue;
                }
                Err(problem) => Product::Failure(problem),
            };
            self.deliver(lease, fencing, product).await;
        }
    }

    /// Begins a delivery as soon as not too many are under way.
    async fn deliver(self: &Arc<Self>, lease: u64, fencing: u64, product: Product) {
        if let Some(held) = lock(&self.held).get_mut(&lease) {
            held.is_delivering = true;
        }
        let Ok(slot) = self.delivery_slots.clone().acquire_owned().await else { return };
        let session = self.clone();
        self.deliveries.spawn(async move {
            session.send_result(lease, fencing, product).await;
            lock(&session.held).remove(&lease);
            drop(slot);
        });
    }

    /// Keeps at it through outages, until the coordinator has said yes or no.
    async fn send_result(&self, lease: u64, fencing: u64, product: Product) {
        let worker = self.worker;
        let encode = move || {
            let outcome = Some(product.encode());
            Bytes::from(ResultRequest { worker, lease, fencing, outcome }.encode_to_vec())
        };
        let Ok(message) = tokio::task::spawn_blocking(encode).await else { return };
        let mut backoff = Backoff::new(&self.name);
        loop {
            match self.client.post::<ResultResponse>("result", message.clone(), TRANSFER_TIMEOUT).await {
                Ok(_) => return,
                Err(problem) if problem.is_temporary() => {
                    tracing::warn!(lease, %problem, "a result cannot be delivered; trying again");
                    sleep(backoff.next_pause()).await;
                }
                Err(problem) => {
                    tracing::info!(lease, %problem, "a result was not wanted");
                    return;
                }
            }
        }
    }

    async fn send_heartbeats(&self) -> SessionEnd {
        loop {
            sleep(self.lease_duration / 3).await;
            let leases = lock(&self.held).keys().copied().collect();
            let message = HeartbeatRequest { worker: self.worker, leases }.encode_to_vec().into();
            match self.client.post::<HeartbeatResponse>("heartbeat", message, MESSAGE_TIMEOUT).await {
                Ok(answer) => self.cancel(&answer.cancelled),
                Err(CallError::Forgotten) => return SessionEnd::Forgotten,
                Err(problem) => tracing::warn!(%problem, "heartbeat failed"),
            }
        }
    }

    fn cancel(&self, leases: &[u64]) {
        let held = lock(&self.held);
        for lease in leases.iter().filter_map(|lease| held.get(lease)) {
            lease.cancel.store(true, Ordering::Relaxed);
        }
    }

    /// Gives leases back so that others get them at once.
    async fn give_back(&self, leases: Vec<u64>, leaving: bool) {
        for lease in &leases {
            lock(&self.held).remove(lease);
        }
        let message = ReleaseRequest { worker: self.worker, leases, leaving }.encode_to_vec().into();
        // Unheard, it only takes longer: the leases expire.
        let sent = timeout(FAREWELL, self.client.post::<()>("release", message, MESSAGE_TIMEOUT)).await;
        if !matches!(sent, Ok(Ok(()))) {
            tracing::info!("leases could not be given back; they will expire");
        }
    }

    async fn leave(&self) {
        let unfinished: Vec<u64> =
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
        match self.shard {
            None => self.renderer.pilot(&self.cancel).map(Product::Pilot),
            Some((planned, field)) => self.renderer.trace(planned.shard, &field, &self.cancel).map(Product::Tally),
        }
    }
}

impl Product {
    fn encode(self) -> Outcome {
        match self {
            Self::Pilot(pilot) => Outcome::Pilot(encode_pilot(&pilot)),
            Self::Tally(tally) => Outcome::Tally(encode_tally(&tally)),
            Self::Failure(problem) => Outcome::Failure(problem),
        }
    }
}
