//! The pilot of methods that sample lights: which lights are seen where.
//!
//! Lights are tried where the method will sample them, first with plain picks, then with picks that know what earlier rounds learnt: where
//! a lamp is hidden that takes most picks, few are left for others at first. The last round tells what all of it is worth.

use std::sync::atomic::{AtomicBool, Ordering};

use super::parameter_values::LightPicks;
use crate::scene::Scene;
use crate::scene::light::LightVisibility;
use crate::transport::Limits;
use crate::transport::light_trials::{LightTrials, SamplingVertices, WeighedTrial};
use crate::transport::visibility_learning::{LightTrial, learn};

/// Rounds that teach.
const ROUNDS: u32 = 3;
/// Picks stay plain where others would have less than this many times less variance.
const WORTHWHILE_GAIN: f64 = 1.2;
/// Relative to the mean over the picture: what is darker does not count more, as in relMSE.
const DARK: f64 = 0.03;

/// How a method samples lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightSampling {
    /// How they are picked.
    pub picks: LightPicks,
    /// Where.
    pub vertices: SamplingVertices,
    /// Limits on path length.
    pub limits: Limits,
}

impl LightSampling {
    /// Where camera paths gather photons.
    pub fn gathering(picks: LightPicks, limits: Limits) -> Self {
        Self { picks, vertices: SamplingVertices::Gathering, limits }
    }

    /// What picks need to know in a scene, as numbers of a [`LightVisibility`]; the inner `None` where plain picks do. The outer:
    /// cancelled.
    pub fn learn(&self, scene: &Scene, seed: u64, cancel: &AtomicBool) -> Option<Option<Vec<f32>>> {
        let light_count = scene.lights.lights().len();
        if self.picks == LightPicks::Importance || light_count < 2 {
            return Some(None);
        }
        let (mut values, mut taught) = (None, scene.clone());
        let mut trials: Vec<LightTrial> = Vec::new();
        let Self { vertices, limits, .. } = *self;
        let tried = |taught: &Scene, round: u32| {
            let trials = LightTrials { plain: scene, scene: taught, limits, vertices, seed };
            (!cancel.load(Ordering::Relaxed)).then(|| trials.round(round))
        };
        for round in 0..ROUNDS {
            trials.extend(tried(&taught, round)?.iter().map(|found| found.trial));
            let Some(learnt) = learn(&trials, light_count) else { return Some(None) };
            let Ok(visibility) = LightVisibility::new(&learnt, &scene.lights) else { return Some(None) };
            (values, taught) = (Some(learnt), scene.with_lights(scene.lights.with_visibility(visibility)));
        }
        let worthwhile =
            self.picks == LightPicks::Visible || gain(&taught, &tried(&taught, ROUNDS)?) >= WORTHWHILE_GAIN;
        Some(values.filter(|_| worthwhile))
    }
}

/// The mean relative variance of direct light with plain picks over that with those of the trials, which were picked so. Second moments
/// stand for variances.
fn gain(taught: &Scene, trials: &[WeighedTrial]) -> f64 {
    let mut cells: Vec<[f64; 2]> = Vec::new();
    let mut cell_of = |trial: &WeighedTrial| {
        let cell = taught.lights.visibility().map_or(0, |visibility| visibility.cell_index(trial.trial.position));
        if cell >= cells.len() {
            cells.resize(cell + 1, [0.0; 2]);
        }
        cells[cell][0] += 1.0;
        cells[cell][1] += f64::from(trial.brought);
        cell
    };
    let indices: Vec<usize> = trials.iter().map(&mut cell_of).collect();
    let mean = cells.iter().map(|[_, sum]| sum).sum::<f64>() / trials.len().max(1) as f64;
    let (mut plain, mut seen) = (0.0, 0.0);
    for (trial, cell) in trials.iter().zip(indices) {
        let [count, sum] = cells[cell];
        let relative = f64::from(trial.brought) / (sum / count + DARK * mean);
        if relative > 0.0 {
            seen += relative * relative;
            plain += relative * relative * f64::from(trial.pick) / f64::from(trial.plain_pick);
        }
    }
    if seen > 0.0 { plain / seen } else { 1.0 }
}
