//! A worker: leases shards, traces them, sends tallies.

mod cache;
mod client;
mod error;
mod pool;
mod session;

use std::sync::Arc;
use std::time::Duration;

use prost::Message;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use crate::farm::access::secret::Secret;
use crate::farm::dial::Dialer;
use crate::farm::events::EVENTS;
use crate::farm::prepared_scenes::PreparedScenes;
use crate::farm::wire;
use crate::farm::wire::messages::{RegisterRequest, RegisterResponse};
use client::{Backoff, CallError, Client};
pub use error::WorkerError;
use pool::RenderPool;
use session::{MESSAGE_TIMEOUT, Session, SessionEnd};

/// Prepared scenes that a worker keeps.
pub const KEPT_SCENES: usize = 2;

/// Who a worker is and for whom it works.
#[derive(Clone)]
pub struct WorkerOptions {
    /// Base address of the coordinator, for example `http://127.0.0.1:8080`; of several that stand in for each other, separated by commas.
    pub coordinator: String,
    /// Name shown in the list of workers.
    pub name: String,
    /// Rendering threads, at least 1.
    pub threads: usize,
    /// The token by which it joins, where the coordinator has users.
    pub token: Option<Secret>,
    /// The prepared scenes of this process.
    pub scenes: PreparedScenes,
    /// How it reaches the coordinator.
    pub dialer: Dialer,
}

/// Works for a coordinator until `shutdown` is cancelled or the coordinator sends it away. Outages are waited out, with growing pauses.
///
/// On shutdown the shard in hand is given back, so that another worker gets it at once.
pub async fn run_worker(options: WorkerOptions, shutdown: CancellationToken) -> Result<(), WorkerError> {
    if options.threads == 0 {
        return Err(WorkerError::Start("0 rendering threads were asked for; give at least 1".to_owned()));
    }
    let client = Client::new(&options.coordinator, options.dialer.clone(), options.token.as_ref())?;
    let pool = Arc::new(RenderPool::new(options.threads)?);
    loop {
        let registered = shutdown.run_until_cancelled(register(&client, &options)).await;
        let Some(registered) = registered.transpose()? else { return Ok(()) };
        let lease_duration = Duration::from_millis(u64::from(registered.lease_milliseconds.max(1)));
        let (client, name) = (client.joined(&registered.secret)?, options.name.clone());
        tracing::info!(
            target: EVENTS,
            "{name} works for {} with {} threads, as number {}",
            options.coordinator,
            options.threads,
            registered.worker
        );
        let session = Session::new(client, name, lease_duration, pool.clone(), options.scenes.clone());
        match session.run(&shutdown).await {
            SessionEnd::Shutdown => return Ok(()),
            SessionEnd::SentAway => {
                tracing::info!(target: EVENTS, "{} was sent away by {}", options.name, options.coordinator);
                return Ok(());
            }
            SessionEnd::Forgotten => tracing::info!("the coordinator forgot this worker; registering again"),
        }
    }
}

/// Registers, for as long as it takes to reach the coordinator.
async fn register(client: &Client, options: &WorkerOptions) -> Result<RegisterResponse, WorkerError> {
    let request = RegisterRequest {
        name: options.name.clone(),
        threads: u32::try_from(options.threads).unwrap_or(u32::MAX),
        build: wire::BUILD.to_owned(),
        features: target_features(),
    };
    let message: bytes::Bytes = request.encode_to_vec().into();
    let mut backoff = Backoff::new(&options.name);
    loop {
        match client.post("register", message.clone(), MESSAGE_TIMEOUT).await {
            Ok(registered) => return Ok(registered),
            Err(CallError::Status(status, problem)) if status.is_client_error() => {
                return Err(WorkerError::Refused(problem));
            }
            Err(problem) => {
                tracing::debug!(%problem, "cannot register; trying again");
                sleep(backoff.next_pause()).await;
            }
        }
    }
}

/// The processor features that the program was compiled for, as far as they matter to speed.
fn target_features() -> String {
    let features = [
        (cfg!(target_feature = "avx2"), "avx2"),
        (cfg!(target_feature = "fma"), "fma"),
        (cfg!(target_feature = "avx512f"), "avx512f"),
        (cfg!(target_feature = "neon"), "neon"),
    ];
    features.iter().filter(|(is_on, _)| *is_on).map(|(_, name)| *name).collect::<Vec<_>>().join(" ")
}
