//! What a pass spends its time on, found by leaving parts out: multiple importance weights by `show: unweighted`, density
//! estimates by a radius within which nothing lies.

use std::sync::Arc;

use serde_json::{Value, json};

use super::run::{Run, RunError};
use super::stopwatch::Stopwatch;
use crate::method::{self, MethodChoice};
use crate::scene::Scene;

/// Processor-seconds that each variant is given, told in hundredths.
const TIME: f64 = 1.6;
/// They take turns, so that what else the machine does falls on all of them.
const TURNS: u32 = 8;
/// Nothing lies within this share of the scene's radius.
const NOTHING: f32 = 1e-7;

/// Shares of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeShares {
    /// Processor-seconds of a pass, all threads together.
    pub pass: f64,
    /// The share of density estimates, with their weights; `None` for methods without.
    pub density_estimates: Option<f64>,
    /// The share of multiple importance weights; `None` for methods that do not show themselves without.
    pub weights: Option<f64>,
}

/// Measures a choice of method on `scene`, on the calling rayon pool; about five processor-seconds.
///
/// # Errors
/// Parameters that the method does not take, or time that cannot be told.
pub fn time_shares(
    scene: &Arc<Scene>,
    choice: &MethodChoice,
    seed: u64,
    stopwatch: &mut dyn Stopwatch,
) -> Result<TimeShares, RunError> {
    let radius = NOTHING * scene.geometry.bounding_sphere().1;
    let mut whole = Variant::new(scene, choice, seed)?;
    let mut unweighted = Variant::without(scene, choice, ("show", json!("unweighted")), seed)?;
    let mut unmerged = Variant::without(scene, choice, ("initial_radius", json!(radius)), seed)?;
    for turn in 1..=TURNS {
        let until = TIME * f64::from(turn) / f64::from(TURNS);
        for variant in [Some(&mut whole), unweighted.as_mut(), unmerged.as_mut()].into_iter().flatten() {
            variant.run_until(until, stopwatch)?;
        }
    }
    let pass = whole.pass();
    let share = |without: Option<Variant>| without.map(|without| (1.0 - without.pass() / pass).max(0.0));
    Ok(TimeShares { pass, density_estimates: share(unmerged), weights: share(unweighted) })
}

/// A method with or without a part, and what its passes took.
struct Variant {
    run: Run,
    seconds: f64,
}

impl Variant {
    fn new(scene: &Arc<Scene>, choice: &MethodChoice, seed: u64) -> Result<Self, RunError> {
        let checked = method::check(choice, scene.pixel_count() as u64)?;
        Ok(Self { run: Run::start(scene, &checked, seed)?, seconds: 0.0 })
    }

    /// With one parameter changed; `None` where the method has no such parameter.
    fn without(
        scene: &Arc<Scene>,
        choice: &MethodChoice,
        (name, value): (&str, Value),
        seed: u64,
    ) -> Result<Option<Self>, RunError> {
        if !method::entry(&choice.name)?.parameters.iter().any(|parameter| parameter.name == name) {
            return Ok(None);
        }
        let mut choice = choice.clone();
        choice.parameters.insert(name.to_owned(), value);
        Self::new(scene, &choice, seed).map(Some)
    }

    fn run_until(&mut self, seconds: f64, stopwatch: &mut dyn Stopwatch) -> Result<(), RunError> {
        let start = stopwatch.spent()?.processor - self.seconds;
        while self.seconds < seconds {
            self.run.pass()?;
            self.seconds = stopwatch.spent()?.processor - start;
        }
        Ok(())
    }

    /// Processor-seconds of a pass.
    fn pass(&self) -> f64 {
        self.seconds / f64::from(self.run.passes())
    }
}
