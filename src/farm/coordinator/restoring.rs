//! Jobs go on from stored states: after a restart, and after wrong bits from one that can be trusted.

use super::shared::{JobRecord, Shared};
use crate::farm::events::EVENTS;
use crate::farm::locks::lock;
use crate::farm::merging::Merging;
use crate::farm::store::jobs::Snapshots;
use crate::farm::store::{BlobName, StoreError};

/// A stored state.
struct Found {
    name: BlobName,
    merging: Merging,
}

impl Shared {
    /// Lets a job go on from its newest good snapshot.
    pub(super) async fn restore(&self, job: &JobRecord) -> Result<(), StoreError> {
        let found = self.newest_good(job, |_| true).await?;
        self.go_on(job, found.map(|found| found.merging));
        Ok(())
    }

    /// Lets a job go on from its newest good snapshot of at most `keep` shards; of none where there is none. Later ones are forgotten
    /// first, so that no restart goes on from them.
    pub(super) async fn roll_back(&self, job: &JobRecord, keep: Option<u64>) -> Result<(), StoreError> {
        let found = self.newest_good(job, |merged| keep.is_some_and(|most| merged <= most)).await?;
        let (newest, merging) = found.map(|found| (found.name, found.merging)).unzip();
        self.keep_snapshots(job, Snapshots { newest, ..Snapshots::default() }).await?;
        let mut place = lock(&job.merging);
        {
            let state = self.lock();
            // A job that was cancelled meanwhile stays cancelled.
            let Some(progress) = state.rules.job(job.id).filter(|progress| progress.is_rolling_back) else {
                return Ok(());
            };
            let mut facts = lock(&job.facts);
            (facts.pause, facts.ran) = (progress.pause.clone(), progress.ran(self.clock.now()));
            facts.history.clone_from(&progress.history);
        }
        self.replace_state(job, &mut place, merging);
        Ok(())
    }

    /// From now on these are a job's snapshots; others that it had are deleted, once its record does not name them.
    pub(super) async fn keep_snapshots(&self, job: &JobRecord, kept: Snapshots) -> Result<(), StoreError> {
        let old = std::mem::replace(&mut lock(&job.facts).snapshots, kept.clone());
        if let Err(problem) = self.store.update_job(&self.row(job)).await {
            // The record names the old ones still, as far as anybody knows.
            lock(&job.facts).snapshots = old;
            return Err(problem);
        }
        self.delete_unless_kept(&old, &kept).await
    }

    /// Deletes those of the `old` snapshots that are not among the `kept` ones.
    pub(super) async fn delete_unless_kept(&self, old: &Snapshots, kept: &Snapshots) -> Result<(), StoreError> {
        for name in old.all().filter(|name| !kept.all().any(|kept| kept == *name)) {
            self.store.blobs().delete(name).await?;
        }
        Ok(())
    }

    /// The newest snapshot that can be read and whose number of merged shards `fits`.
    async fn newest_good(&self, job: &JobRecord, fits: impl Fn(u64) -> bool) -> Result<Option<Found>, StoreError> {
        let snapshots = lock(&job.facts).snapshots.clone();
        for name in snapshots.all() {
            match self.load(job, name).await {
                Ok(merging) if fits(merging.merged()) => return Ok(Some(Found { name: name.clone(), merging })),
                Ok(_) => {}
                Err(problem @ StoreError::Damaged { .. }) => tracing::error!(target: EVENTS, "{problem}"),
                Err(problem) if problem.is_temporary() || problem.is_full() => return Err(problem),
                Err(problem) => tracing::error!(target: EVENTS, "job {}: {problem}", job.id),
            }
        }
        Ok(None)
    }
}
