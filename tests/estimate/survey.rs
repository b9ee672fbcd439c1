//! The choice among methods by short trials, with a clock that the test holds.

use crate::progressive;
use std::sync::atomic::AtomicBool;

use photonfarm::evaluation::{Spent, Stopwatch, StopwatchError, Survey, Trial, survey};
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

fn surveyed(reference: &str, wanted: f64, step: f64) -> Survey {
    let scene = progressive::reference_scene(reference);
    let choice = |name: &str| MethodChoice { name: name.to_owned(), parameters: serde_json::Map::default() };
    survey(&scene, choice, wanted, &mut Steps { now: 0.0, step }, &AtomicBool::new(false)).expect("methods are found")
}

/// On a machine so slow that the first passes outlast the later rounds, a method has nothing new to tell there.
#[test]
fn slow_machines_get_a_plan_too() {
    for step in [0.3, 5.0] {
        let found = surveyed("furnace-env", 1e-4, step);
        assert!(found.trials.len() > 3);
        for trial in &found.trials {
            let seconds = trial.expected_seconds;
            assert!(seconds.is_finite() && seconds > 0.0, "{} in {seconds} s", trial.method.choice.name);
            let [low, high] = trial.seconds_range;
            assert!(0.0 < low && low < seconds && seconds < high, "{low} to {seconds} to {high} s");
        }
        assert!(found.trials.is_sorted_by_key(|trial| trial.expected_seconds));
    }
}

/// Noise of camera paths falls as 1/time, what density estimates add as time^−2/3 where no connections take over, and all of it between
/// the two where both are there.
#[test]
fn promises_follow_the_rates() {
    let found = surveyed("furnace-closed", 1e-3, 0.1);
    for Trial { method, seconds, error, expected_seconds, .. } in &found.trials {
        let error = error.expect("all see light");
        let all = (error.noise + error.bias) / found.wanted;
        let [soonest, latest] = [all, all.powf(1.5)].map(|longer| seconds * longer / expected_seconds);
        if method.choice.name == "sppm" {
            assert!(soonest < 0.99 && latest > 1.01, "{}: {soonest} to {latest}", method.choice.name);
        } else {
            assert!((soonest - 1.0).abs() < 1e-9, "{}: {soonest}", method.choice.name);
        }
    }
    assert!(found.trials.iter().any(|trial| trial.method.choice.name == "sppm"));
}
