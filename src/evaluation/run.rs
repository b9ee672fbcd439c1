//! One method on one scene, pass by pass, as a farm with one worker would run it.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::stopwatch::{Spent, Stopwatch, StopwatchError};
use crate::estimate::{ErrorEstimate, Estimate, EstimateError, MergeError, Picture, RadiusField, Region, Shard};
use crate::method::{CheckedMethod, MethodError};
use crate::render::{Cancelled, GuideError, Renderer};
use crate::scene::Scene;

/// Passes traced with one radius field, as many as a small farm has in flight.
const PASSES_PER_FIELD: u32 = 16;

/// A run that cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The method refuses the scene.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The pilot does not fit the scene's lights.
    #[error(transparent)]
    Guide(#[from] GuideError),
    /// The pilot does not fit the picture.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// A pass does not fit the estimate.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// The time is not known.
    #[error(transparent)]
    Stopwatch(#[from] StopwatchError),
    /// Threads cannot be started.
    #[error("cannot start {count} threads: {problem}; ask for fewer")]
    Threads {
        /// How many.
        count: usize,
        /// What the system said.
        problem: String,
    },
}

/// A run with the passes that it has made so far.
pub struct Run {
    renderer: Renderer,
    region: Region,
    estimate: Estimate,
    field: RadiusField,
    never: AtomicBool,
}

impl Run {
    /// Prepares the method and finds the first radii, on the calling rayon pool.
    pub fn start(scene: &Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Self, RunError> {
        let renderer = Renderer::new(scene.clone(), method, seed)?;
        let never = AtomicBool::new(false);
        let region = Region { row_start: 0, row_end: scene.height };
        let pilot = renderer.pilot(&never)?;
        let renderer = renderer.guided(&pilot.guides())?;
        let declaration = renderer.declaration().clone();
        let estimate = Estimate::new(scene.width, scene.height, &[region], declaration, pilot.radius_squared())?;
        let field = estimate.radius_field(region);
        Ok(Self { renderer, region, estimate, field, never })
    }

    /// Makes one more pass, on the calling rayon pool.
    pub fn pass(&mut self) -> Result<(), RunError> {
        let first_pass = self.estimate.passes();
        if first_pass.is_multiple_of(PASSES_PER_FIELD) {
            self.field = self.estimate.radius_field(self.region);
        }
        let shard = Shard { first_pass, passes: 1, region: self.region };
        let tally = self.renderer.trace(shard, &self.field, &self.never)?;
        Ok(self.estimate.merge(&tally, &self.field)?)
    }

    /// Passes made.
    pub fn passes(&self) -> u32 {
        self.estimate.passes()
    }

    /// A count of all passes so far, by its name in tallies; 0 for what is not counted.
    pub fn count(&self, name: &str) -> f64 {
        self.estimate.scalar(name)
    }

    /// The error of the picture so far, as its passes tell it.
    pub fn error(&self) -> Option<ErrorEstimate> {
        self.estimate.error()
    }

    /// The picture so far.
    pub fn picture(&self) -> Picture {
        self.estimate.picture()
    }
}

/// The picture of a run when a budget was spent.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The budget, processor-seconds.
    pub budget: f64,
    /// What was spent after the pass that reached it.
    pub spent: Spent,
    /// Passes in the picture.
    pub passes: u32,
    /// The picture.
    pub picture: Picture,
}

/// Renders until the largest of `budgets` is spent and keeps the picture after the pass that reaches each of them, in rising order.
/// Time counts from the call: the pilot is part of it, loading and preparing the scene are not. `on_pass` is told what was spent
/// after every pass. Runs on the calling rayon pool.
pub fn follow(
    scene: &Arc<Scene>,
    method: &CheckedMethod,
    seed: u64,
    budgets: &[f64],
    stopwatch: &mut dyn Stopwatch,
    on_pass: &mut dyn FnMut(Spent),
) -> Result<Vec<Snapshot>, RunError> {
    let mut budgets = budgets.to_vec();
    budgets.sort_by(f64::total_cmp);
    let mut run = Run::start(scene, method, seed)?;
    let mut snapshots: Vec<Snapshot> = Vec::with_capacity(budgets.len());
    while snapshots.len() < budgets.len() {
        run.pass()?;
        let spent = stopwatch.spent()?;
        while let Some(budget) = budgets.get(snapshots.len()).filter(|budget| **budget <= spent.processor) {
            snapshots.push(Snapshot { budget: *budget, spent, passes: run.passes(), picture: run.picture() });
        }
        on_pass(spent);
    }
    Ok(snapshots)
}

/// Does `work` on `count` threads of its own.
pub fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> Result<T, RunError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    let pool = pool.map_err(|error| RunError::Threads { count, problem: error.to_string() })?;
    Ok(pool.install(work))
}
