//! A farm inside a program: a coordinator, workers and a door to both, in this process.
//!
//! Workers speak HTTP to the coordinator over loopback like any others, so everything that happens on a large farm happens here.
//!
//! ```no_run
//! use photonfarm::farm::LocalFarm;
//! use photonfarm::farm::job::JobRequest;
//!
//! # async fn render(scene: Vec<u8>) -> Result<(), Box<dyn std::error::Error>> {
//! let farm = LocalFarm::builder().workers(2).start().await?;
//! let scene = farm.client().add_scene(scene).await?;
//! let job = farm.client().submit(JobRequest::of_scene(scene.hash)).await?;
//! let mut status = farm.client().watch(job)?;
//! status.wait_for(|status| status.state.is_final()).await?;
//! let (picture, _) = farm.client().picture(job).await?;
//! println!("{} × {} pixels", picture.width, picture.height);
//! farm.stop().await;
//! # Ok(())
//! # }
//! ```

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use tokio::net::TcpListener;
use tokio::task::{JoinHandle, JoinSet};
use tokio_util::sync::CancellationToken;

use super::access::secret::Secret;
use super::coordinator::{CoordinatorHandle, CoordinatorOptions};
use super::dial::Dialer;
use super::error::FarmError;
use super::http;
use super::prepared_scenes::PreparedScenes;
use super::store::Store;
use super::tls::TlsError;
use super::tls::client::{self, Trust};
use super::tls::server::ServerTls;
use super::worker::{KEPT_SCENES, WorkerError, WorkerOptions, run_worker};

/// How long requests and workers may take to end.
const SHUTDOWN_PATIENCE: Duration = Duration::from_secs(10);

/// A farm that cannot start, or does not go on.
#[derive(Debug, thiserror::Error)]
pub enum LocalFarmError {
    /// The address cannot be had.
    #[error("cannot listen at {address}: {problem}; give a free address as HOST:PORT")]
    Listen {
        /// The address.
        address: String,
        /// What the system says.
        problem: std::io::Error,
    },
    /// The coordinator cannot start, for example because its store cannot be read.
    #[error(transparent)]
    Coordinator(#[from] FarmError),
    /// Connections cannot be encrypted.
    #[error(transparent)]
    Tls(#[from] TlsError),
    /// The server ended.
    #[error("the coordinator's server ended: {0}")]
    Server(String),
    /// Another coordinator leads.
    #[error("another coordinator leads now; start this one again, and it stands by")]
    Deposed,
    /// A worker ended.
    #[error(transparent)]
    Worker(#[from] WorkerError),
}

/// Makes the routes that are served beside the workers' protocol; the token is cancelled when the farm stops.
type Routes = Box<dyn FnOnce(CoordinatorHandle, CancellationToken) -> Router + Send>;

/// What a farm is made of.
pub struct LocalFarmBuilder {
    listen: String,
    listener: Option<std::net::TcpListener>,
    workers: usize,
    threads: usize,
    options: CoordinatorOptions,
    store: Option<Store>,
    tls: Option<ServerTls>,
    routes: Option<Routes>,
}

impl LocalFarmBuilder {
    /// Where the coordinator listens, `127.0.0.1:0` (any free port) by default.
    pub fn listen(mut self, address: impl Into<String>) -> Self {
        self.listen = address.into();
        self
    }

    /// A socket that listens already, instead of an address.
    pub fn listener(mut self, listener: std::net::TcpListener) -> Self {
        self.listener = Some(listener);
        self
    }

    /// How many workers to start, 1 by default. The picture does not depend on it.
    pub fn workers(mut self, workers: usize) -> Self {
        self.workers = workers;
        self
    }

    /// Threads of each worker, 1 by default. The picture does not depend on it.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads;
        self
    }

    /// How the coordinator runs. Its prepared scenes are those that the workers use, too.
    pub fn options(mut self, options: CoordinatorOptions) -> Self {
        self.options = options;
        self
    }

    /// Where scenes and jobs are kept; in memory by default.
    pub fn store(mut self, store: Store) -> Self {
        self.store = Some(store);
        self
    }

    /// How connections are encrypted; not at all by default.
    pub fn tls(mut self, tls: Option<ServerTls>) -> Self {
        self.tls = tls;
        self
    }

    /// Further routes, for example a REST interface.
    pub fn routes(
        mut self,
        routes: impl FnOnce(CoordinatorHandle, CancellationToken) -> Router + Send + 'static,
    ) -> Self {
        self.routes = Some(Box::new(routes));
        self
    }

    /// Starts everything. Must be called inside a tokio runtime.
    pub async fn start(self) -> Result<LocalFarm, LocalFarmError> {
        let Self { listen, listener, workers, threads, options, store, tls, routes } = self;
        let cannot_listen = |problem| LocalFarmError::Listen { address: listen.clone(), problem };
        let listener = match listener {
            Some(listener) => TcpListener::from_std(listener),
            None => TcpListener::bind(&listen).await,
        };
        let listener = listener.map_err(cannot_listen)?;
        let address = listener.local_addr().map_err(cannot_listen)?;
        let scenes = PreparedScenes::new(if workers > 0 { KEPT_SCENES } else { 0 });
        let store = match store {
            Some(store) => store,
            None => Store::in_memory().await.map_err(FarmError::from)?,
        };
        let options = CoordinatorOptions { scenes: scenes.clone(), is_encrypted: tls.is_some(), ..options };
        let pinned = tls.as_ref().map(|tls| client::configure(&Trust::Pinned(tls.fingerprint()), None));
        let dialer = Dialer::tcp(pinned.transpose()?.map(Arc::new));
        let coordinator = CoordinatorHandle::start(options, store).await?;
        let server_shutdown = CancellationToken::new();
        let further = routes.map(|routes| routes(coordinator.clone(), server_shutdown.clone()));
        let protocol = Router::new().nest("/farm/v1", http::router(coordinator.clone()));
        let application = protocol.merge(further.unwrap_or_default());
        let stopped = server_shutdown.clone();
        let limits = coordinator.limits().clone();
        let is_encrypted = tls.is_some();
        let serving = async move { http::server::serve(listener, application, &limits, tls, stopped).await };
        let server = tokio::spawn(serving);
        let mut farm = LocalFarm {
            address,
            is_encrypted,
            dialer,
            workers_token: coordinator.shared.give_own_workers_token()?,
            coordinator,
            scenes,
            server,
            server_shutdown,
            workers: JoinSet::new(),
            workers_shutdown: CancellationToken::new(),
        };
        for index in 1..=workers {
            farm.add_worker(&format!("local-{index}"), threads);
        }
        Ok(farm)
    }
}

/// A running coordinator with its workers.
pub struct LocalFarm {
    address: SocketAddr,
    is_encrypted: bool,
    dialer: Dialer,
    coordinator: CoordinatorHandle,
    scenes: PreparedScenes,
    workers_token: Secret,
    server: JoinHandle<()>,
    server_shutdown: CancellationToken,
    workers: JoinSet<Result<(), WorkerError>>,
    workers_shutdown: CancellationToken,
}

impl LocalFarm {
    /// A farm of one worker with one thread, at any free port of loopback.
    pub fn builder() -> LocalFarmBuilder {
        LocalFarmBuilder {
            listen: "127.0.0.1:0".to_owned(),
            listener: None,
            workers: 1,
            threads: 1,
            options: CoordinatorOptions::default(),
            store: None,
            tls: None,
            routes: None,
        }
    }

    /// The door to the coordinator.
    pub fn client(&self) -> &CoordinatorHandle {
        &self.coordinator
    }

    /// Where the coordinator listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// An address at which this process reaches the coordinator.
    pub fn url(&self) -> String {
        let scheme = if self.is_encrypted { "https" } else { "http" };
        match self.address {
            SocketAddr::V4(address) if address.ip().is_unspecified() => {
                format!("{scheme}://127.0.0.1:{}", address.port())
            }
            SocketAddr::V6(address) if address.ip().is_unspecified() => format!("{scheme}://[::1]:{}", address.port()),
            address => format!("{scheme}://{address}"),
        }
    }

    /// Starts one more worker. It stops when the returned token is cancelled, or with the farm.
    pub fn add_worker(&mut self, name: &str, threads: usize) -> CancellationToken {
        let stop = self.workers_shutdown.child_token();
        let options = WorkerOptions {
            coordinator: self.url(),
            name: name.to_owned(),
            threads,
            token: Some(self.workers_token.clone()),
            scenes: self.scenes.clone(),
            dialer: self.dialer.clone(),
        };
        self.workers.spawn(run_worker(options, stop.clone()));
        stop
    }

    /// Waits until the server or a worker fails; for ever when all is well.
    pub async fn failure(&mut self) -> LocalFarmError {
        let deposed = self.coordinator.deposed();
        loop {
            tokio::select! {
                () = deposed.cancelled() => return LocalFarmError::Deposed,
                ended = &mut self.server => return LocalFarmError::Server(match ended {
                    Err(error) => error.to_string(),
                    Ok(()) => "nobody asked it to".to_owned(),
                }),
                Some(ended) = self.workers.join_next() => match ended {
                    Ok(Ok(())) => {}
                    Ok(Err(error)) => return error.into(),
                    Err(error) => return LocalFarmError::Server(format!("a worker crashed: {error}")),
                },
            }
        }
    }

    /// Waits for shards that are being traced, for at most `patience`, while no new ones are leased.
    pub async fn drain(&self, patience: Duration) {
        const LOOK: Duration = Duration::from_millis(50);
        self.coordinator.drain();
        let drained = async {
            while self.coordinator.leases() > 0 {
                tokio::time::sleep(LOOK).await;
            }
        };
        let _ = tokio::time::timeout(patience, drained).await;
    }

    /// Lets workers give back their shards, merges what has arrived, answers open requests and stops.
    pub async fn stop(mut self) {
        self.coordinator.drain();
        self.workers_shutdown.cancel();
        let orderly = async {
            while self.workers.join_next().await.is_some() {}
            self.coordinator.shutdown().await;
            self.server_shutdown.cancel();
            let _ = (&mut self.server).await;
        };
        if tokio::time::timeout(SHUTDOWN_PATIENCE, orderly).await.is_err() {
            tracing::warn!("requests or workers did not end in time; they are cut off");
            self.server_shutdown.cancel();
        }
    }
}
