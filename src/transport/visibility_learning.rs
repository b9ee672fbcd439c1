//! Learning which lights are seen where, from lights that were tried where a method samples them.
//!
//! A cell's share of a light is the probability that a place in it sees the light. Where some places do and some do not, variance is
//! least for picks in proportion to the root of the mean of squares, so the root of that probability counts.

use crate::math::Vec3;
use crate::scene::light::visibility::{MOST_HALVINGS, MOST_VALUES, VisibilityNode};

/// The cell around counts as so many trials in each cell; around all, every light is seen.
const PRIOR_TRIALS: f64 = 1.0;
/// Cells with fewer trials are not parted.
const LEAST_TRIALS: usize = 64;
/// Where a cell is parted, as a share of its longest side: near the middle, but seldom along a wall, which often stands there.
const PARTING: f32 = 0.489;
/// No share is less, so that all stay above zero in single precision.
const LEAST_SHARE: f64 = 1e-6;

/// A light that was tried at a place.
#[derive(Clone, Copy, Debug)]
pub struct LightTrial {
    /// Where, m.
    pub position: Vec3,
    /// Index of the light.
    pub light: u32,
    /// Whether any of its light arrived.
    pub arrives: bool,
}

/// What is known of a light in a cell.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// The probability that a place sees it.
    seen: f64,
    /// Whether any place did.
    was_seen: bool,
}

impl Known {
    /// In a part of the cell, with its trials.
    fn in_part(self, trials: u32, arrived: u32) -> Self {
        if !self.was_seen && arrived == 0 {
            // All around it is hidden, too: the part adds nothing.
            return self;
        }
        let (trials, arrived) = (f64::from(trials), f64::from(arrived));
        let seen = (arrived + PRIOR_TRIALS * self.seen) / (trials + PRIOR_TRIALS);
        Self { seen, was_seen: arrived > 0.0 }
    }

    /// What is left of the light's importance.
    fn share(self) -> f32 {
        let share = if self.was_seen { self.seen.sqrt() } else { self.seen };
        share.max(LEAST_SHARE) as f32
    }
}

/// Learns the visibility of `light_count` lights, as numbers of a tree, from trials in an order that is always the same; `None` where
/// there are more lights than trees have numbers.
pub fn learn(trials: &[LightTrial], light_count: usize) -> Option<Vec<f32>> {
    let most_cells = MOST_VALUES / light_count.max(1) / 4;
    if most_cells == 0 {
        return None;
    }
    let mut trials = trials.to_vec();
    let least_trials = LEAST_TRIALS.max(trials.len() / most_cells);
    let mut learner = Learner { light_count, least_trials, values: Vec::new() };
    let before = vec![Known { seen: 1.0, was_seen: true }; light_count];
    learner.cell(&mut trials, &before, 0);
    Some(learner.values)
}

struct Learner {
    light_count: usize,
    least_trials: usize,
    values: Vec<f32>,
}

impl Learner {
    /// Writes the tree of a cell with these trials in it.
    fn cell(&mut self, trials: &mut [LightTrial], around: &[Known], halvings: usize) {
        let mut counts = vec![[0u32; 2]; self.light_count];
        for trial in &*trials {
            let [tried, arrived] = &mut counts[trial.light as usize];
            *tried += 1;
            *arrived += u32::from(trial.arrives);
        }
        let known: Vec<Known> =
            around.iter().zip(&counts).map(|(around, [tried, arrived])| around.in_part(*tried, *arrived)).collect();
        let differs = counts.iter().any(|[tried, arrived]| *arrived > 0 && arrived < tried);
        let parts = (differs && trials.len() >= self.least_trials && halvings < MOST_HALVINGS).then(|| part(trials));
        match parts.flatten() {
            Some(Parts { axis, at, first_count }) => {
                VisibilityNode::Parted { axis, at }.write(&mut self.values);
                let (first, second) = trials.split_at_mut(first_count);
                self.cell(first, &known, halvings + 1);
                self.cell(second, &known, halvings + 1);
            }
            None => {
                let shares: Vec<f32> = known.iter().map(|known| known.share()).collect();
                VisibilityNode::Cell(&shares).write(&mut self.values);
            }
        }
    }
}

/// How a cell is parted.
struct Parts {
    axis: usize,
    at: f32,
    first_count: usize,
}

/// Parts trials across the longest side of their box and moves those below the plane to the front; `None` when they have no extent.
fn part(trials: &mut [LightTrial]) -> Option<Parts> {
    let positions = || trials.iter().map(|trial| trial.position);
    let (low, high) = (positions().reduce(Vec3::min)?, positions().reduce(Vec3::max)?);
    let axis = (high - low).max_position();
    let at = low[axis] + PARTING * (high - low)[axis];
    if !(low[axis] < at && at < high[axis]) {
        return None;
    }
    // Stable, so that the order stays the same.
    trials.sort_by_key(|trial| trial.position[axis] >= at);
    let first_count = trials.partition_point(|trial| trial.position[axis] < at);
    Some(Parts { axis, at, first_count })
}
