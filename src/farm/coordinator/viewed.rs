//! States of ended jobs that somebody looks at. They are on disk; in memory they stay for a short while.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::time::Instant;

use super::shared::{JobRecord, Shared, blocking};
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::locks::lock;
use crate::farm::merging::Merging;

/// How long a state stays that nobody looks at.
const PATIENCE: Duration = Duration::from_secs(20);
/// States that stay at the same time.
const KEPT: usize = 2;

struct View {
    job: JobId,
    merging: Arc<Merging>,
    looked: Instant,
}

/// States of ended jobs that somebody looks at.
#[derive(Default)]
pub(super) struct Viewed(Mutex<Vec<View>>);

/// A state as it was looked for in memory.
enum InMemory<T, Read> {
    /// What was read of it.
    Read(T),
    /// Nothing is merged yet.
    Empty,
    /// It is not in memory; nothing was read.
    Elsewhere(Read),
}

impl Viewed {
    /// Keeps a state for those who will look soon.
    pub(super) fn insert(&self, job: JobId, merging: Option<Merging>) {
        if let Some(merging) = merging {
            self.insert_shared(job, Arc::new(merging));
        }
    }

    fn insert_shared(&self, job: JobId, merging: Arc<Merging>) {
        let mut views = lock(&self.0);
        views.retain(|view| view.job != job);
        views.push(View { job, merging, looked: Instant::now() });
        if views.len() > KEPT {
            views.remove(0);
        }
    }

    fn get(&self, job: JobId) -> Option<Arc<Merging>> {
        let mut views = lock(&self.0);
        let view = views.iter_mut().find(|view| view.job == job)?;
        view.looked = Instant::now();
        Some(view.merging.clone())
    }

    /// Forgets a job's state.
    pub(super) fn remove(&self, job: JobId) {
        lock(&self.0).retain(|view| view.job != job);
    }

    /// Forgets what nobody looks at.
    pub(super) fn expire(&self) {
        lock(&self.0).retain(|view| view.looked.elapsed() < PATIENCE);
    }
}

impl Shared {
    /// Reads a job's merged state, once there is something in it, wherever it is.
    pub(super) async fn with_merged<T: Send + 'static>(
        self: &Arc<Self>,
        job: &Arc<JobRecord>,
        read: impl FnOnce(&Merging) -> T + Send + 'static,
    ) -> Result<T, FarmError> {
        let no_picture = || FarmError::NoPictureYet(job.id);
        let record = job.clone();
        // One look under the lock decides where it is: the keeper may take it to the store at any time.
        let in_memory = blocking(move || {
            let merging = lock(&record.merging);
            Ok(match merging.as_ref() {
                Some(merging) if merging.merged() == 0 => InMemory::Empty,
                Some(merging) => InMemory::Read(read(merging)),
                None => InMemory::Elsewhere(read),
            })
        });
        let read = match in_memory.await? {
            InMemory::Read(found) => return Ok(found),
            InMemory::Empty => return Err(no_picture()),
            InMemory::Elsewhere(read) => read,
        };
        let merging = self.stored_state(job).await?.ok_or_else(no_picture)?;
        blocking(move || Ok(read(&merging))).await
    }

    /// The final state of an ended job.
    async fn stored_state(&self, job: &JobRecord) -> Result<Option<Arc<Merging>>, FarmError> {
        if let Some(merging) = self.viewed.get(job.id) {
            return Ok(Some(merging));
        }
        let newest = lock(&job.facts).snapshots.newest.clone();
        let Some(newest) = newest else { return Ok(None) };
        let merging = Arc::new(self.load(job, &newest).await?);
        self.viewed.insert_shared(job.id, merging.clone());
        Ok(Some(merging).filter(|merging| merging.totals().shards > 0))
    }
}
