//! What happened since a coordinator started, counted as it happens.

use std::time::Duration;

use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Registry, Unit};

use crate::farm::rules::{Answer, Event, Notice};

/// What the names of all metrics begin with.
pub(super) const PREFIX: &str = "photonfarm";

/// What becomes of results.
const OUTCOMES: [&str; 5] = ["taken", "compared", "repeated", "late", "bad"];

/// Names and values of labels.
pub(super) type Labels = Vec<(&'static str, String)>;

/// What happened since the coordinator started.
pub(super) struct Counters {
    pub(super) registry: Registry,
    photons: Counter,
    shards: Counter,
    results: Family<Labels, Counter>,
    result_bytes: Counter,
    leases: Counter,
    expired: Counter,
    mismatches: Counter,
    merge_seconds: Histogram,
    snapshot_seconds: Histogram,
    snapshot_bytes: Counter,
}

impl Counters {
    pub(super) fn new() -> Self {
        // 0.1 ms to 1.6 s, and 1 ms to 65 s.
        let merge_seconds = Histogram::new(exponential_buckets(1e-4, 4.0, 8));
        let snapshot_seconds = Histogram::new(exponential_buckets(1e-3, 4.0, 9));
        let mut counters = Self {
            registry: Registry::with_prefix(PREFIX),
            photons: Counter::default(),
            shards: Counter::default(),
            results: Family::default(),
            result_bytes: Counter::default(),
            leases: Counter::default(),
            expired: Counter::default(),
            mismatches: Counter::default(),
            merge_seconds,
            snapshot_seconds,
            snapshot_bytes: Counter::default(),
        };
        for outcome in OUTCOMES {
            counters.results.get_or_create(&vec![("outcome", outcome.to_owned())]).inc_by(0);
        }
        counters.register();
        counters
    }

    fn register(&mut self) {
        let registry = &mut self.registry;
        registry.register("photons", "Photons emitted in merged passes", self.photons.clone());
        registry.register("shards_merged", "Shards merged", self.shards.clone());
        let results = "Results of workers by what became of them";
        registry.register("results", results, self.results.clone());
        registry.register_with_unit("result", "Results received", Unit::Bytes, self.result_bytes.clone());
        registry.register("leases_granted", "Leases granted", self.leases.clone());
        registry.register("leases_expired", "Leases that expired because nothing was heard", self.expired.clone());
        registry.register(
            "shards_mismatched",
            "Shards for which two workers returned different bits",
            self.mismatches.clone(),
        );
        let merging = "Taking a result: waiting for the job, adding it, and what follows";
        registry.register_with_unit("merge", merging, Unit::Seconds, self.merge_seconds.clone());
        let storing = "Writing a snapshot of a running job";
        registry.register_with_unit("snapshot_write", storing, Unit::Seconds, self.snapshot_seconds.clone());
        registry.register_with_unit("snapshot_write", "Snapshots written", Unit::Bytes, self.snapshot_bytes.clone());
    }

    /// Counts an event by what it led to.
    pub(super) fn count(&self, is_result: bool, answer: &Answer, notices: &[Notice]) {
        if let Some(outcome) = outcome(answer).filter(|_| is_result) {
            self.results.get_or_create(&vec![("outcome", outcome.to_owned())]).inc();
        }
        if matches!(answer, Answer::Granted(_)) {
            self.leases.inc();
        }
        for notice in notices {
            match notice {
                Notice::Silent { leases, .. } => drop(self.expired.inc_by(*leases as u64)),
                Notice::Mismatch { .. } => drop(self.mismatches.inc()),
                _ => {}
            }
        }
    }

    /// Counts what was merged.
    pub(super) fn merged(&self, photons: u64, shards: u64) {
        self.photons.inc_by(photons);
        self.shards.inc_by(shards);
    }

    /// Counts a result that came.
    pub(super) fn received(&self, bytes: u64) {
        self.result_bytes.inc_by(bytes);
    }

    /// Records how long a result took.
    pub(super) fn merging_took(&self, time: Duration) {
        self.merge_seconds.observe(time.as_secs_f64());
    }

    /// Records a snapshot that was written.
    pub(super) fn snapshot_written(&self, bytes: u64, time: Duration) {
        self.snapshot_bytes.inc_by(bytes);
        self.snapshot_seconds.observe(time.as_secs_f64());
    }
}

/// Whether an event is a worker's result.
pub(super) fn is_result(event: &Event) -> bool {
    matches!(event, Event::ResultCame { .. })
}

fn outcome(answer: &Answer) -> Option<&'static str> {
    match answer {
        Answer::Take(_) => Some("taken"),
        Answer::Compared => Some("compared"),
        Answer::AlreadyMerged => Some("repeated"),
        Answer::Fenced => Some("late"),
        Answer::Recorded => Some("bad"),
        _ => None,
    }
}
