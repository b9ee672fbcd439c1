//! What a coordinator tells Prometheus: counters of what happened since it started, and how things are now.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::Registry;

use super::CoordinatorHandle;
use super::counters::{Labels, PREFIX};
use super::shared::Shared;
use crate::farm::error::FarmError;
use crate::farm::job::{JobState, JobStatus, WorkerState, WorkerStatus};
use crate::farm::locks::lock;
use crate::farm::wire::BUILD;

/// The owner of jobs that have none.
const NOBODY: &str = "";

type Gauges = Family<Labels, Gauge>;
type Numbers = Family<Labels, Gauge<f64, AtomicU64>>;

impl CoordinatorHandle {
    /// Counters and gauges as OpenMetrics text.
    pub fn metrics(&self) -> Result<String, FarmError> {
        let mut text = String::new();
        let failed = |problem: std::fmt::Error| FarmError::Internal(problem.to_string());
        encode(&mut text, &self.shared.gauges()).map_err(failed)?;
        // Both end with the mark of the end, which may stand there once.
        text.truncate(text.trim_end_matches("# EOF\n").len());
        encode(&mut text, &self.shared.counters.registry).map_err(failed)?;
        Ok(text)
    }

    /// Counts a result that a worker sent.
    pub(in crate::farm) fn count_received(&self, bytes: u64) {
        self.shared.counters.received(bytes);
    }
}

impl Shared {
    fn gauges(&self) -> Registry {
        let now = self.clock.now();
        let (workers, jobs, waiting, leases) = {
            let state = self.lock();
            let live = state.rules.jobs().filter(|(_, job)| !job.has_ended());
            let live = live.filter_map(|(id, _)| state.jobs.get(&id));
            let jobs: Vec<JobStatus> = live.map(|job| state.status(job, &self.clock)).collect();
            let workers = state.workers(&self.clock, self.options.lease_duration);
            (workers, jobs, state.rules.work_waiting(), state.rules.leases().active().count())
        };
        let mut registry = Registry::with_prefix(PREFIX);
        let info = Gauges::default();
        info.get_or_create(&vec![("version", env!("CARGO_PKG_VERSION").to_owned()), ("build", BUILD.to_owned())])
            .set(1);
        registry.register("build", "What this program is", info);
        register_number(&mut registry, "uptime_seconds", "Since the coordinator started", now.as_secs_f64());
        register_number(&mut registry, "work_waiting", "Pieces of work that workers could take now", waiting as f64);
        register_number(&mut registry, "leases", "Leases that workers hold", leases as f64);
        register_workers(&mut registry, &workers);
        register_jobs(&mut registry, &jobs);
        let age = self.oldest_snapshot().map_or(0.0, |age| age.as_secs_f64());
        let help = "Since the last snapshot of the running job whose last one is oldest; 0 without running jobs";
        register_number(&mut registry, "snapshot_age_seconds", help, age);
        registry
    }

    /// The time since the last snapshot of the job for which it is longest.
    fn oldest_snapshot(&self) -> Option<Duration> {
        let now = self.clock.now();
        let running = self.live_jobs();
        running.iter().filter_map(|job| Some(now.saturating_sub(lock(&job.facts).last_snapshot?))).max()
    }
}

fn register_number(registry: &mut Registry, name: &str, help: &str, value: f64) {
    let gauge = Gauge::<f64, AtomicU64>::default();
    gauge.set(value);
    registry.register(name, help, gauge);
}

fn register_workers(registry: &mut Registry, workers: &[WorkerStatus]) {
    let (by_state, threads) = (Gauges::default(), Gauges::default());
    for state in WorkerState::ALL {
        let labels = vec![("state", state.name().to_owned())];
        let such = workers.iter().filter(|worker| worker.state == state);
        by_state.get_or_create(&labels).set(such.clone().count() as i64);
        threads.get_or_create(&labels).set(such.map(|worker| i64::from(worker.threads)).sum());
    }
    registry.register("workers", "Workers by state", by_state);
    registry.register("worker_threads", "Rendering threads of workers by state", threads);
}

fn register_jobs(registry: &mut Registry, jobs: &[JobStatus]) {
    let (by_state, by_owner) = (Gauges::default(), Gauges::default());
    for state in JobState::ALL.into_iter().filter(|state| !state.is_final()) {
        let count = jobs.iter().filter(|job| job.state == state).count();
        by_state.get_or_create(&vec![("state", state.name().to_owned())]).set(count as i64);
    }
    let mut owners: BTreeMap<&str, i64> = BTreeMap::new();
    for job in jobs {
        *owners.entry(job.owner.as_ref().map_or(NOBODY, |owner| owner.as_str())).or_default() += 1;
    }
    for (owner, count) in owners {
        by_owner.get_or_create(&vec![("user", owner.to_owned())]).set(count);
    }
    registry.register("jobs", "Jobs that have not ended, by state", by_state);
    registry.register("user_jobs", "Jobs that have not ended, by user", by_owner);
    let (passes, relmse, bound) = (Gauges::default(), Numbers::default(), Numbers::default());
    for job in jobs {
        let labels = vec![("job", job.id.clone())];
        passes.get_or_create(&labels).set(i64::from(job.passes_done));
        if let Some(error) = &job.estimated_error {
            relmse.get_or_create(&labels).set(error.relmse);
            bound.get_or_create(&labels).set(error.bound);
        }
    }
    registry.register("job_passes", "Passes merged of a job that has not ended", passes);
    registry.register("job_relmse", "Its own estimate of its relative mean square error", relmse);
    registry.register("job_relmse_bound", "What that error is below with 95 % confidence", bound);
}
