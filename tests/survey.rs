//! The choice among methods by short trials, with a clock that the test holds.

#[path = "support/progressive.rs"]
#[expect(dead_code, reason = "no jobs are run here")]
mod progressive;

use std::sync::Arc;

use photonfarm::evaluation::{Spent, Stopwatch, StopwatchError, survey};
use photonfarm::method::MethodChoice;

/// Every look at it takes so many seconds.
struct Steps {
    now: f64,
    step: f64,
}

impl Stopwatch for Steps {
    fn spent(&mut self) -> Result<Spent, StopwatchError> {
        self.now += self.step;
        Ok(Spent { processor: self.now, wall: self.now })
    }
}

/// On a machine so slow that the first passes outlast the later rounds, a method has nothing new to tell there.
#[test]
fn slow_machines_get_a_plan_too() {
    for step in [0.3, 5.0] {
        let scene = Arc::into_inner(progressive::reference_scene("furnace-env")).expect("nobody else has it");
        let choice = |name: &str| MethodChoice { name: name.to_owned(), parameters: serde_json::Map::default() };
        let found = survey(scene, choice, 1e-4, &mut Steps { now: 0.0, step }).expect("methods are found");
        assert!(found.trials.len() > 3);
        for trial in &found.trials {
            let seconds = trial.expected_seconds;
            assert!(seconds.is_finite() && seconds > 0.0, "{} in {seconds} s", trial.method.choice.name);
        }
        assert!(found.trials.is_sorted_by_key(|trial| trial.expected_seconds));
    }
}
