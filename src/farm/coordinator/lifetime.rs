//! How a coordinator starts, lets time pass, and stops.

use std::sync::{Arc, Weak};
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use super::announcing::keep_announcing;
use super::chores::Chore;
use super::clock::Clock;
use super::frames::keep_making_frames;
use super::keeper::keep;
use super::options::CoordinatorOptions;
use super::shared::Shared;
use crate::farm::error::FarmError;
use crate::farm::events::EVENTS;
use crate::farm::rules::check::CheckShare;
use crate::farm::rules::{Event, Rules, RulesOptions};
use crate::farm::store::Store;
use crate::farm::store::leadership::RENEWAL;

/// How often time passes for the rules.
const TICK: Duration = Duration::from_millis(200);
/// Ids of workers and leases that a coordinator may use before those of the next run begin: 2⁴⁰.
const EPOCH_SHIFT: u32 = 40;

impl Shared {
    /// Takes over what the store has and begins to work.
    pub(super) async fn start(options: CoordinatorOptions, store: Store) -> Result<Arc<Self>, FarmError> {
        let clock = Clock::start();
        let rules = RulesOptions {
            lease_duration: options.lease_duration,
            memory_budget: options.limits.job_memory,
            early_budget: options.limits.early_memory,
            check_share: CheckShare::new(options.check_share),
            // Ids that rise from one run to the next: a worker of an earlier run is not taken for one of this.
            first_id: (store.epoch() << EPOCH_SHIFT).max(clock.unix(Duration::ZERO).as_micros() as u64),
        };
        let last_job = store.last_job().await?;
        let (chores, waiting) = mpsc::unbounded_channel();
        let shared = Arc::new(Self::new(options, store, clock, Rules::new(rules), last_job, chores)?);
        shared.take_over_members().await?;
        shared.take_over_scenes().await?;
        let rows = shared.store.job_rows().await?;
        shared.take_over(rows).await?;
        shared.take_over_sequences().await?;
        tokio::spawn(keep(Arc::downgrade(&shared), waiting));
        tokio::spawn(keep_time(Arc::downgrade(&shared), shared.stopped.clone()));
        tokio::spawn(keep_leading(Arc::downgrade(&shared), shared.stopped.clone()));
        tokio::spawn(keep_making_frames(Arc::downgrade(&shared), shared.stopped.clone()));
        tokio::spawn(keep_announcing(Arc::downgrade(&shared), shared.stopped.clone()));
        Ok(shared)
    }

    /// Ends when every tally that arrived has been merged, and everything is stored.
    pub(super) async fn stop(&self) {
        self.busy.close();
        self.busy.wait().await;
        if self.store.is_durable() {
            self.leave_to_keeper(Chore::SnapshotAll);
        }
        if let Err(problem) = self.stored().await {
            tracing::error!(target: EVENTS, "{problem}");
        }
        self.stopped.cancel();
        self.store.close().await;
    }
}

/// Says that this coordinator lives, until it is stopped or dropped, or another one leads.
async fn keep_leading(shared: Weak<Shared>, stopped: CancellationToken) {
    while stopped.run_until_cancelled(sleep(RENEWAL)).await.is_some() {
        let Some(shared) = shared.upgrade() else { return };
        match shared.store.renew().await {
            Ok(()) => {}
            Err(problem) if problem.is_deposed() => return shared.depose(),
            // It leads on if the database comes back before somebody else does.
            Err(problem) => tracing::debug!(%problem, "the term cannot be prolonged"),
        }
    }
}

/// Lets time pass until the coordinator is stopped or dropped.
async fn keep_time(shared: Weak<Shared>, stopped: CancellationToken) {
    let mut interval = tokio::time::interval(TICK);
    interval.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    while stopped.run_until_cancelled(interval.tick()).await.is_some() {
        match shared.upgrade() {
            Some(shared) => {
                shared.apply(Event::TimePassed);
                shared.viewed.expire();
            }
            None => return,
        }
    }
}
