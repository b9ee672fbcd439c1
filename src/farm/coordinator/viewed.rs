//! States of ended jobs that somebody looks at. They are on disk; in memory they stay for a short while.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use tokio::time::Instant;

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

impl Viewed {
    /// Keeps a state for those who will look soon.
    pub(super) fn insert(&self, job: JobId, merging: Option<Merging>) {
        if let Some(merging) = merging {
            self.insert_shared(job, Arc::new(merging));
        }
    }

    /// The same of one that somebody looks at already.
    pub(super) fn insert_shared(&self, job: JobId, merging: Arc<Merging>) {
        let mut views = lock(&self.0);
        views.retain(|view| view.job != job);
        views.push(View { job, merging, looked: Instant::now() });
        if views.len() > KEPT {
            views.remove(0);
        }
    }

    /// The state of a job, if somebody looked at it lately.
    pub(super) fn get(&self, job: JobId) -> Option<Arc<Merging>> {
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
