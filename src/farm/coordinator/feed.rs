//! All changes of all jobs, numbered, so that whoever was away is told what they missed.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use tokio::sync::watch;

use crate::farm::ids::JobId;
use crate::farm::locks::lock;

/// Deleted jobs that are remembered.
const DELETED_KEPT: usize = 10_000;

/// A job that was deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Deleted {
    pub(super) number: u64,
    pub(super) job: JobId,
}

/// Numbers changes as they happen.
#[derive(Debug)]
pub(super) struct Feed {
    deleted: Mutex<VecDeque<Deleted>>,
    newest: watch::Sender<u64>,
}

impl Feed {
    pub(super) fn new() -> Self {
        Self { deleted: Mutex::new(VecDeque::new()), newest: watch::Sender::new(0) }
    }

    /// Gives the next number to a job that changed. Numbers are given one after the other: nobody sees one before all smaller ones.
    pub(super) fn number(&self, place: &AtomicU64) {
        let _turn = lock(&self.deleted);
        let number = *self.newest.borrow() + 1;
        place.store(number, Ordering::Relaxed);
        self.newest.send_replace(number);
    }

    /// A job was deleted.
    pub(super) fn delete(&self, job: JobId) {
        let mut deleted = lock(&self.deleted);
        let number = *self.newest.borrow() + 1;
        if deleted.len() == DELETED_KEPT {
            deleted.pop_front();
        }
        deleted.push_back(Deleted { number, job });
        self.newest.send_replace(number);
    }

    /// The newest number as it rises.
    pub(super) fn watch(&self) -> watch::Receiver<u64> {
        self.newest.subscribe()
    }

    /// The newest number, and the jobs that were deleted after number `seen`; `None` when some of them are not remembered any more.
    pub(super) fn deleted_since(&self, seen: u64) -> (u64, Option<Vec<Deleted>>) {
        let deleted = lock(&self.deleted);
        let is_whole = deleted.len() < DELETED_KEPT || deleted.front().is_some_and(|first| first.number <= seen + 1);
        let since = deleted.iter().filter(|deleted| deleted.number > seen).copied().collect();
        (*self.newest.borrow(), is_whole.then_some(since))
    }
}
