//! Keeps the store up to date in the background: records of jobs as they change, snapshots of their merged states from time to time,
//! final states of those that ended, and the journal.
//!
//! A job's acceptance and a user's changes are stored before they are answered. Tallies are not: shards are pure functions, so what was
//! merged after the last snapshot is traced again, to the same bits.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};
use std::time::Duration;

use tokio::sync::{mpsc, oneshot};
use tokio::time::{Instant, sleep, timeout};

use super::chores::Chore;
use super::shared::{JobRecord, Shared};
use crate::farm::error::FarmError;
use crate::farm::events::EVENTS;
use crate::farm::ids::JobId;
use crate::farm::job::JobState;
use crate::farm::locks::lock;
use crate::farm::rules::Event;
use crate::farm::rules::job::Job;
use crate::farm::rules::terms::PauseReason;
use crate::farm::store::jobs::Snapshots;
use crate::farm::store::{BlobName, StoreError};

/// How often the keeper looks whether a snapshot is due.
const LOOK: Duration = Duration::from_millis(250);
/// Of the time at most one part in so many goes into a job's snapshots.
const SNAPSHOT_SHARE: u32 = 50;
/// The pause before something is tried again.
const RETRY: Duration = Duration::from_secs(2);
/// How long an answer waits for the store.
const ANSWER_PATIENCE: Duration = Duration::from_secs(10);
/// The longest pause between two looks for jobs that need not be kept any more.
const SWEEP: Duration = Duration::from_secs(60);
/// How long a store may be out of reach before jobs pause.
const OUTAGE_PATIENCE: Duration = Duration::from_secs(30);

struct Keeper {
    shared: Weak<Shared>,
    /// When a job's next snapshot is due.
    due: BTreeMap<JobId, Instant>,
    /// Since when the store fails.
    failing_since: Option<Instant>,
    /// When old jobs are looked for next.
    sweep: Instant,
}

/// Works until the coordinator is gone.
pub(super) async fn keep(shared: Weak<Shared>, mut chores: mpsc::UnboundedReceiver<Chore>) {
    let mut keeper = Keeper { shared, due: BTreeMap::new(), failing_since: None, sweep: Instant::now() };
    loop {
        match timeout(LOOK, chores.recv()).await {
            Ok(None) => return,
            Ok(Some(chore)) => {
                if !keeper.do_until_done(chore).await {
                    return;
                }
            }
            Err(_) => {}
        }
        let Some(shared) = keeper.shared.upgrade() else { return };
        keeper.take_due_snapshots(&shared).await;
        keeper.delete_what_is_old(&shared).await;
    }
}

impl Keeper {
    /// Tries until the store has it; jobs pause meanwhile. Answers false when the coordinator is gone.
    async fn do_until_done(&mut self, chore: Chore) -> bool {
        let chore = match chore {
            Chore::Barrier(waiting) => {
                // Whoever asked may have gone.
                let _ = waiting.send(());
                return true;
            }
            chore => chore,
        };
        loop {
            let Some(shared) = self.shared.upgrade() else { return false };
            match self.do_once(&shared, &chore).await {
                Ok(()) => {
                    self.store_works(&shared);
                    return true;
                }
                // The store is closed: what comes now belongs to nobody.
                Err(_) if shared.stopped.is_cancelled() => return false,
                Err(problem) if problem.is_deposed() => {
                    shared.depose();
                    return false;
                }
                Err(problem) => self.store_fails(&shared, &problem),
            }
            drop(shared);
            sleep(RETRY).await;
        }
    }

    async fn do_once(&mut self, shared: &Arc<Shared>, chore: &Chore) -> Result<(), StoreError> {
        match chore {
            Chore::Record(id) => match shared.job(*id) {
                Ok(job) => shared.store.update_job(&shared.row(&job)).await,
                Err(_) => Ok(()),
            },
            Chore::Refused(id) => shared.store.delete_job(*id).await,
            Chore::Finish(id) => match shared.job(*id) {
                Ok(job) => self.finish(shared, &job).await,
                Err(_) => Ok(()),
            },
            Chore::RollBack(rollback) => match shared.job(rollback.job) {
                Ok(job) => shared.roll_back(&job, rollback.keep).await,
                Err(_) => Ok(()),
            },
            Chore::Sequence(id) => match shared.sequence_record(*id) {
                Some(sequence) => shared.store.put_sequence(&sequence.row()).await,
                None => Ok(()),
            },
            Chore::ForgetSequence(id) => shared.store.delete_sequence(*id).await,
            Chore::Announce { job, state } => shared.announce(*job, *state).await,
            Chore::Journal(rows) => shared.store.append_journal(rows).await,
            Chore::Worker { name, threads } => {
                shared.store.record_worker(name, *threads, shared.clock.unix_milliseconds()).await
            }
            Chore::SnapshotAll => {
                for job in shared.trusted_jobs() {
                    self.snapshot(shared, &job).await?;
                }
                Ok(())
            }
            Chore::Barrier(_) => Ok(()),
        }
    }

    fn store_works(&mut self, shared: &Arc<Shared>) {
        if self.failing_since.take().is_none() {
            return;
        }
        tracing::info!(target: EVENTS, "the store works again");
        for job in shared.live_jobs() {
            let is_ours = shared
                .lock()
                .rules
                .job(job.id)
                .is_some_and(|progress| matches!(progress.pause, Some(PauseReason::Store { .. })));
            if is_ours {
                shared.apply(Event::JobResumed { job: job.id });
            }
        }
    }

    /// A full disk pauses jobs at once, a database that restarts only when it takes long.
    fn store_fails(&mut self, shared: &Arc<Shared>, problem: &StoreError) {
        if problem.is_deposed() {
            return shared.depose();
        }
        let since = *self.failing_since.get_or_insert_with(|| {
            tracing::error!(target: EVENTS, "{problem}");
            Instant::now()
        });
        if problem.is_temporary() && !problem.is_full() && since.elapsed() < OUTAGE_PATIENCE {
            return;
        }
        for job in shared.live_jobs() {
            let reason = PauseReason::Store { problem: problem.to_string() };
            let state = shared.lock().rules.job(job.id).map(|progress| progress.state);
            if state.is_some_and(|state| state != JobState::Paused) {
                shared.apply(Event::JobPaused { job: job.id, reason });
            }
        }
    }

    async fn take_due_snapshots(&mut self, shared: &Arc<Shared>) {
        if !shared.store.is_durable() {
            return;
        }
        let now = Instant::now();
        let jobs = shared.trusted_jobs();
        self.due.retain(|id, _| jobs.iter().any(|job| job.id == *id));
        for job in jobs {
            let due = *self.due.entry(job.id).or_insert(now + shared.options.snapshot_interval);
            if due > now {
                continue;
            }
            match self.snapshot(shared, &job).await {
                Ok(true) => self.store_works(shared),
                // Nothing was written, so nothing is known of the store.
                Ok(false) => {}
                Err(problem) => {
                    self.store_fails(shared, &problem);
                    self.due.insert(job.id, Instant::now() + RETRY);
                }
            }
        }
    }

    /// Deletes jobs that ended longer ago than they are kept, and scenes that are as old and that no job refers to.
    async fn delete_what_is_old(&mut self, shared: &Arc<Shared>) {
        let Some(kept) = shared.options.keep_ended.filter(|_| self.sweep <= Instant::now()) else { return };
        self.sweep = Instant::now() + kept.min(SWEEP);
        let before = shared.clock.unix_milliseconds() - kept.as_millis() as i64;
        let jobs: Vec<Arc<JobRecord>> = shared.lock().jobs.values().cloned().collect();
        for job in jobs {
            let is_old = lock(&job.facts).ended.is_some_and(|ended| ended < before);
            let Some(_turn) = job.users.take_now().filter(|_| is_old) else { continue };
            if let Err(problem) = shared.erase(&job).await {
                self.store_fails(shared, &problem);
                return;
            }
        }
        if let Err(problem) = shared.delete_old_scenes(before).await {
            self.store_fails(shared, &problem);
        }
    }

    /// Stores a running job's merged state, if it is one from which any longer job can go on. Answers whether there was something to store.
    async fn snapshot(&mut self, shared: &Arc<Shared>, job: &Arc<JobRecord>) -> Result<bool, StoreError> {
        let start = Instant::now();
        let record = job.clone();
        let encoded = tokio::task::spawn_blocking(move || {
            let snapshot = {
                let merging = lock(&record.merging);
                merging.as_ref().filter(|merging| merging.is_of_longer_jobs()).map(|merging| merging.snapshot())
            };
            snapshot.and_then(|snapshot| Some((snapshot.merged, snapshot.encode().ok()?)))
        });
        let mut is_written = false;
        if let Ok(Some((merged, bytes))) = encoded.await {
            let name = BlobName::of_snapshot(job.id, merged, &bytes);
            let known = lock(&job.facts).snapshots.clone();
            if known.newest.as_ref() != Some(&name) {
                let count = bytes.len() as u64;
                shared.store.blobs().put(&name, bytes).await?;
                let snapshots = Snapshots { newest: Some(name), earlier: known.newest, resume: None };
                shared.keep_snapshots(job, snapshots).await?;
                shared.counters.snapshot_written(count, start.elapsed());
                lock(&job.facts).last_snapshot = Some(shared.clock.now());
                is_written = true;
            }
        }
        let pause = shared.options.snapshot_interval.max(start.elapsed() * SNAPSHOT_SHARE);
        self.due.insert(job.id, Instant::now() + pause);
        Ok(is_written)
    }

    /// Stores the final state of an ended job; from then on it costs memory only while somebody looks.
    async fn finish(&mut self, shared: &Arc<Shared>, job: &Arc<JobRecord>) -> Result<(), StoreError> {
        if shared.store.is_durable() {
            let record = job.clone();
            let encoded = tokio::task::spawn_blocking(move || {
                let merging = lock(&record.merging);
                merging.as_ref().and_then(|merging| {
                    let resume = merging.resume_snapshot().map(<[u8]>::to_vec);
                    Some((merging.merged(), merging.snapshot().encode().ok()?, resume))
                })
            });
            if let Ok(Some((merged, bytes, resume))) = encoded.await {
                let newest = BlobName::of_snapshot(job.id, merged, &bytes);
                let resume = resume.map(|bytes| (BlobName::of_snapshot(job.id, 0, &bytes), bytes));
                shared.store.blobs().put(&newest, bytes).await?;
                if let Some((name, bytes)) = &resume {
                    shared.store.blobs().put(name, bytes.clone()).await?;
                }
                let resume = resume.map(|(name, _)| name);
                shared.keep_snapshots(job, Snapshots { newest: Some(newest), earlier: None, resume }).await?;
                shared.viewed.insert(job.id, lock(&job.merging).take());
                return Ok(());
            }
        }
        shared.store.update_job(&shared.row(job)).await
    }
}

impl Shared {
    /// Returns when everything that was handed to the keeper so far is stored.
    ///
    /// # Errors
    /// Nothing is stored any more.
    pub(super) async fn stored(&self) -> Result<(), FarmError> {
        let (sender, receiver) = oneshot::channel();
        self.leave_to_keeper(Chore::Barrier(sender));
        let ended = |_| FarmError::Store { problem: "nothing is stored any more; restart the coordinator".to_owned() };
        receiver.await.map_err(ended)
    }

    /// The same for somebody who waits for an answer.
    ///
    /// # Errors
    /// The store does not get it done in time, for example because the disk is full. It is stored later.
    pub(super) async fn stored_in_time(&self) -> Result<(), FarmError> {
        let late = |_| FarmError::Store { problem: "it is done, but the store does not take it yet".to_owned() };
        timeout(ANSWER_PATIENCE, self.stored()).await.map_err(late)?
    }

    /// Nothing of a job stays.
    pub(super) async fn erase(&self, job: &JobRecord) -> Result<(), StoreError> {
        let snapshots = lock(&job.facts).snapshots.clone();
        match self.store.delete_job(job.id).await {
            // A database needs room to forget: the snapshots make it.
            Err(problem) if problem.is_full() => {
                self.delete_unless_kept(&snapshots, &Snapshots::default()).await?;
                self.store.delete_job(job.id).await?;
            }
            deleted => deleted?,
        }
        self.apply(Event::JobErased { job: job.id });
        self.lock().jobs.remove(&job.id);
        self.feed.delete(job.id);
        self.viewed.remove(job.id);
        self.delete_unless_kept(&snapshots, &Snapshots::default()).await
    }

    /// Jobs that have not ended.
    pub(super) fn live_jobs(&self) -> Vec<Arc<JobRecord>> {
        self.jobs_that(|job| !job.has_ended())
    }

    /// Those of them whose merged state is worth storing.
    fn trusted_jobs(&self) -> Vec<Arc<JobRecord>> {
        self.jobs_that(|job| !job.has_ended() && !job.is_rolling_back)
    }

    fn jobs_that(&self, are: impl Fn(&Job) -> bool) -> Vec<Arc<JobRecord>> {
        let state = self.lock();
        let found = state.rules.jobs().filter(|(_, job)| are(job));
        found.filter_map(|(id, _)| state.jobs.get(&id).cloned()).collect()
    }
}
