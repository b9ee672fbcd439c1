//! `serve`: a coordinator, with workers of its own if wanted.

use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;

use super::exit_code::CliError;
use super::farm_options::{farm_with_api, threads_per_worker};
use super::log_option::LogOption;
use super::progress::passes_of;
use super::provider_options::LoginOptions;
use super::store_options::StoreOptions;
use super::tls_options::TlsOptions;
use super::token_option::token_file;
use super::{signals, terminal};
use crate::api;
use crate::farm::local_farm::LocalFarmError;
use crate::farm::standby::{Standby, open_in_turn};
use crate::farm::store::Store;
use crate::farm::tls::fingerprint::Fingerprint;
use crate::farm::tls::server::ServerTls;
use crate::farm::{CoordinatorOptions, LocalFarm, UserLimits};

/// How long shards that are being traced are waited for.
const DRAIN_PATIENCE: Duration = Duration::from_secs(60);
/// Running jobs that are named when the coordinator stops.
const LISTED_JOBS: usize = 10;
/// The longest pause between snapshots, seconds: a day.
const LONGEST_INTERVAL: f64 = 86_400.0;

/// Run a coordinator.
///
/// It keeps scenes, jobs and pictures in a folder, and goes on from there when it is started again. It runs until Ctrl-C or SIGTERM; then it
/// waits for what is being traced.
#[derive(Clone, Debug, Args)]
pub(super) struct Serve {
    /// Address to listen at; port 0 takes any free one.
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDRESS")]
    listen: String,
    /// Workers to start in this process.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    workers: u16,
    /// Threads per worker [default: processors / workers].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    tls: TlsOptions,
    #[command(flatten)]
    login: LoginOptions,
    #[command(flatten)]
    pub(super) log: LogOption,
    /// Memory for the states of running jobs, GiB [default: half of this machine's].
    #[arg(long, value_name = "GIB")]
    memory: Option<f64>,
    /// Share of shards that a second worker traces to compare their bits, 0 to 1.
    #[arg(long, default_value_t = 0.01, value_name = "SHARE")]
    check_share: f64,
    /// Days after which ended jobs are deleted with their pictures, and scenes that no job refers to [default: never].
    #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u16).range(1..))]
    keep_days: Option<u16>,
    /// Name by which browsers, workers and programs may call this coordinator. May be repeated. Addresses, names without dots and names that
    /// end with .local, .internal, .localhost or .home.arpa need not be given.
    #[arg(long = "host-name", value_name = "NAME")]
    host_names: Vec<String>,
    /// File with a token of the admin "operator", which is taken as long as this process runs.
    #[arg(long, env = "PHOTONFARM_ADMIN_TOKEN_FILE", value_name = "FILE")]
    admin_token_file: Option<PathBuf>,
    /// File with a token by which workers join as long as this process runs.
    #[arg(long, env = "PHOTONFARM_WORKER_TOKEN_FILE", value_name = "FILE")]
    worker_token_file: Option<PathBuf>,
    /// Jobs that one user may have waiting or running; admins are not limited.
    #[arg(long, default_value_t = UserLimits::default().live_jobs, value_name = "COUNT")]
    user_jobs: usize,
    /// Pixels of all pictures of such jobs together.
    #[arg(long, default_value_t = UserLimits::default().pixels, value_name = "COUNT")]
    user_pixels: u64,
    /// Bytes of all scenes of one user.
    #[arg(long, default_value_t = UserLimits::default().scene_bytes, value_name = "BYTES")]
    user_scene_bytes: u64,
    /// Seconds that one job of a user may ask for.
    #[arg(long, default_value_t = UserLimits::default().seconds, value_name = "SECONDS")]
    user_seconds: f64,
    /// Let anyone who reaches this coordinator do everything, also from other machines, while there are no users.
    #[arg(long)]
    insecure: bool,
    /// Seconds between two snapshots of a job at least.
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS")]
    snapshot_interval: f64,
}

impl Serve {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let workers = usize::from(self.workers);
        let threads = threads_per_worker(self.threads.map(usize::from), workers);
        let options = self.options()?;
        let tls = self.tls()?;
        let listener = self.bind().await?;
        let is_shared = self.store.location()?.is_some_and(|place| place.records.is_shared());
        if is_shared {
            // It may stand by for long.
            let address = listener.local_addr().map_err(|problem| self.cannot_listen(&problem))?;
            self.say_where(address, tls.as_ref().map(ServerTls::fingerprint));
        }
        let Some(store) = self.open_in_turn(&listener, tls.clone()).await? else { return Ok(()) };
        if let Err(refused) = self.refuse_to_stand_open(&listener, &store).await {
            store.close().await;
            return Err(refused);
        }
        match self.store.location()? {
            Some(location) => terminal::note(&format!("data is kept in {}", location.folder.display())),
            None => terminal::note("all is kept in memory and ends with this process"),
        }
        let fingerprint = tls.as_ref().map(ServerTls::fingerprint);
        let builder = farm_with_api(workers, threads).listener(listener).options(options).store(store).tls(tls);
        let mut farm = builder.start().await?;
        let live = farm.client().jobs().iter().filter(|job| !job.state.is_final()).count();
        if live > 0 {
            let (jobs, they) = if live == 1 { ("job goes", "it was") } else { ("jobs go", "they were") };
            terminal::note(&format!("{live} {jobs} on from where {they} stored"));
        }
        if !is_shared {
            self.say_where(farm.address(), fingerprint);
        }
        match fingerprint {
            None if !farm.address().ip().is_loopback() => {
                terminal::note(
                    "connections are not encrypted: tokens and pictures can be read on their way; see --tls",
                );
            }
            _ => {}
        }
        let result = tokio::select! {
            result = signals::interrupted() => result,
            failure = farm.failure() => match failure {
                // Nothing that this one says counts any more, so it says nothing.
                deposed @ LocalFarmError::Deposed => return Err(deposed.into()),
                failure => Err(failure.into()),
            },
        };
        if result.is_ok() {
            self.drain(&farm).await;
        }
        let is_durable = self.store.location()?.is_some();
        let left = farm.client().jobs().iter().filter(|job| !job.state.is_final()).count();
        farm.stop().await;
        if is_durable && left > 0 {
            let jobs = if left == 1 {
                "1 job that has not ended is".to_owned()
            } else {
                format!("{left} jobs that have not ended are")
            };
            terminal::note(&format!("{jobs} stored; start `serve` with the same --data to go on"));
        }
        result
    }

    fn say_where(&self, address: SocketAddr, fingerprint: Option<Fingerprint>) {
        let scheme = if fingerprint.is_some() { "https" } else { "http" };
        terminal::note(&format!("photonfarm listens at {scheme}://{address}"));
        if let Some(fingerprint) = fingerprint {
            terminal::note(&format!("its certificate is {fingerprint}"));
        }
    }

    /// A socket for as long as this coordinator runs, whether it stands by or leads.
    async fn bind(&self) -> Result<TcpListener, CliError> {
        let bound = tokio::net::TcpListener::bind(&self.listen).await.and_then(tokio::net::TcpListener::into_std);
        bound.map_err(|problem| self.cannot_listen(&problem))
    }

    fn cannot_listen(&self, problem: &std::io::Error) -> CliError {
        CliError::Failed(format!("cannot listen at {}: {problem}; give a free address as HOST:PORT", self.listen))
    }

    /// Opens the store when nobody else leads; `None` when it is asked to stop before.
    async fn open_in_turn(&self, listener: &TcpListener, tls: Option<ServerTls>) -> Result<Option<Store>, CliError> {
        let Some(location) = self.store.location()? else { return Ok(Some(self.store.open().await?)) };
        let listener = listener.try_clone().map_err(|problem| self.cannot_listen(&problem))?;
        let standby = Standby { listener, answers: api::standby::router(), tls };
        tokio::select! {
            store = open_in_turn(&location, standby) => Ok(Some(store?)),
            interrupted = signals::interrupted() => interrupted.map(|()| None),
        }
    }

    /// The certificate, if connections are to be encrypted. One that is made here names this host as far as it is known.
    fn tls(&self) -> Result<Option<ServerTls>, CliError> {
        let folder = self.store.location()?.map(|location| location.folder);
        let mut names = vec!["localhost".to_owned(), "127.0.0.1".to_owned(), "::1".to_owned()];
        names.extend(self.host_names.iter().cloned().chain(own_names()));
        names.dedup();
        self.tls.server(folder.as_deref(), &names)
    }

    /// Whoever listens beyond this machine has users, or says that none are wanted.
    async fn refuse_to_stand_open(&self, listener: &TcpListener, store: &Store) -> Result<(), CliError> {
        let listen = &self.listen;
        let address = listener.local_addr().map_err(|problem| self.cannot_listen(&problem))?;
        if address.ip().is_loopback() || self.admin_token_file.is_some() || !store.users().await?.is_empty() {
            return Ok(());
        }
        if self.insecure {
            terminal::note(&format!("there are no users: anyone who reaches {listen} may do everything"));
            return Ok(());
        }
        let is_elsewhere = self.store.location()?.is_some_and(|place| place.records.is_shared());
        let database = if is_elsewhere { " and the same --database and --blobs" } else { "" };
        let data = self.store.location()?.map_or_else(|| "DIR".to_owned(), |place| place.folder.display().to_string());
        Err(CliError::Usage(format!(
            "there are no users, so anyone who reaches {listen} could do everything; make the first one with \
             `photonfarm store add-admin NAME --data {data}`{database}, give --admin-token-file, or start with --insecure"
        )))
    }

    fn options(&self) -> Result<CoordinatorOptions, CliError> {
        let mut options = CoordinatorOptions { check_share: self.check_share, ..CoordinatorOptions::default() };
        if !(0.0..=1.0).contains(&self.check_share) {
            return Err(CliError::Usage(format!("--check-share is {}; give 0 to 1", self.check_share)));
        }
        if let Some(memory) = self.memory {
            if !(memory.is_finite() && memory > 0.0) {
                return Err(CliError::Usage(format!("--memory is {memory}; give a number of GiB above 0")));
            }
            options.limits.job_memory = (memory * f64::from(1 << 30)) as u64;
        }
        options.limits.user = UserLimits {
            live_jobs: self.user_jobs,
            pixels: self.user_pixels,
            scene_bytes: self.user_scene_bytes,
            seconds: self.user_seconds,
        };
        options.keep_ended = self.keep_days.map(|days| Duration::from_secs(86_400 * u64::from(days)));
        let interval = self.snapshot_interval;
        if !(0.0..=LONGEST_INTERVAL).contains(&interval) {
            let text = format!("--snapshot-interval is {interval}; give 0 to {LONGEST_INTERVAL} seconds");
            return Err(CliError::Usage(text));
        }
        options.snapshot_interval = Duration::from_secs_f64(interval);
        options.host_names.clone_from(&self.host_names);
        options.login = self.login.provider()?.map(Arc::new);
        options.admin_token = self.admin_token_file.as_deref().map(token_file).transpose()?;
        options.worker_token = self.worker_token_file.as_deref().map(token_file).transpose()?;
        Ok(options)
    }

    /// Waits for what is being traced. A further Ctrl-C ends that at once.
    async fn drain(&self, farm: &LocalFarm) {
        let running: Vec<_> = farm.client().jobs().into_iter().filter(|job| !job.state.is_final()).collect();
        for job in running.iter().take(LISTED_JOBS) {
            terminal::note(&format!("job {} is {} after {}", job.id, job.state.name(), passes_of(job.passes_done)));
        }
        if running.len() > LISTED_JOBS {
            terminal::note(&format!("and {} further jobs", running.len() - LISTED_JOBS));
        }
        if farm.client().leases() > 0 {
            terminal::note("waiting for the shards that are being traced; press Ctrl-C again to stop now");
        }
        let now = signals::interrupted();
        tokio::select! {
            () = farm.drain(DRAIN_PATIENCE) => {}
            _ = now => {}
        }
        signals::end_on_next_interrupt();
    }
}

/// By what other machines call this one, as far as it knows: its name, and the address from which it reaches others.
fn own_names() -> Vec<String> {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").ok().map(|name| name.trim().to_owned());
    // Nothing is sent: connecting a UDP socket only chooses the address. 192.0.2.1 is nobody's (RFC 5737).
    let address = UdpSocket::bind("0.0.0.0:0").and_then(|socket| {
        socket.connect("192.0.2.1:9")?;
        socket.local_addr()
    });
    let address = address.ok().map(|address| address.ip()).filter(|ip| !ip.is_loopback() && !ip.is_unspecified());
    name.into_iter().filter(|name| !name.is_empty()).chain(address.map(|ip| ip.to_string())).collect()
}
