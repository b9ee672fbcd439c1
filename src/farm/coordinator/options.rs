//! How a coordinator runs.

use std::sync::Arc;
use std::time::Duration;

use super::limits::{FaultHooks, Limits};
use crate::farm::access::secret::Secret;
use crate::farm::login::provider::Provider;
use crate::farm::prepared_scenes::PreparedScenes;

/// How a coordinator runs.
#[derive(Clone)]
pub struct CoordinatorOptions {
    /// How long a lease lives without a heartbeat.
    pub lease_duration: Duration,
    /// What it takes.
    pub limits: Limits,
    /// The share of shards that two workers trace and whose bits are compared, 0 to 1.
    pub check_share: f64,
    /// The least time between two snapshots of a job.
    pub snapshot_interval: Duration,
    /// For how long ended jobs are kept, and scenes without jobs; for ever by default.
    pub keep_ended: Option<Duration>,
    /// Names by which browsers and workers may call it, beside addresses and names that nobody can own publicly.
    pub host_names: Vec<String>,
    /// A token of the admin `operator`, which is taken as long as the coordinator runs.
    pub admin_token: Option<Secret>,
    /// A token by which workers join as long as it runs.
    pub worker_token: Option<Secret>,
    /// At whose page people may log in to the page.
    pub login: Option<Arc<Provider>>,
    /// Whether its connections are encrypted, so that browsers keep its cookies from others.
    pub is_encrypted: bool,
    /// The prepared scenes of this process.
    pub scenes: PreparedScenes,
    /// Faults on purpose, for tests.
    pub faults: FaultHooks,
}

impl Default for CoordinatorOptions {
    fn default() -> Self {
        Self {
            lease_duration: Duration::from_secs(15),
            limits: Limits::default(),
            check_share: 0.01,
            snapshot_interval: Duration::from_secs(30),
            keep_ended: None,
            host_names: Vec::new(),
            admin_token: None,
            worker_token: None,
            login: None,
            is_encrypted: false,
            scenes: PreparedScenes::new(0),
            faults: FaultHooks::default(),
        }
    }
}
