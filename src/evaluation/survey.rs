//! Which method suits a scene: what `--method auto` and `plan` ask.
//!
//! Every method that finds all of a scene's light renders a small picture of it for a moment. Its own error estimate, without a
//! reference, and the rates with which its parts fall tell when it would reach the error that is wanted. The best go on in further rounds,
//! as long as these are short beside what is promised; the soonest wins. Time is measured, so another machine may choose another
//! method: the choice is made once, when a job is submitted, and written into the job.
//!
//! | symbol | meaning |
//! |---|---|
//! | t | processor-seconds of the trial |
//! | s | the part of its error that falls with 1/time: noise of what camera paths sample |
//! | d | the rest: noise and bias of density estimates |
//! | β | the rate with which that falls, by theory |
//! | x | times as long: s/x + d/x^β = wanted |
//! | x·t·(pixels/small pixels) | processor-seconds to the wanted error |
//!
//! A trial leaves a range open: its error may be as far from what it tells as the bound that goes with it, and what density estimates add
//! falls at the fastest as 1/time (β = 1). The choice goes by the middle, people are told the range.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::run::{Run, RunError};
use super::stopwatch::Stopwatch;
use crate::estimate::ErrorEstimate;
use crate::method::{self, CheckedMethod, MethodChoice, MethodError, SceneTraits};
use crate::render::Cancelled;
use crate::scene::Scene;

/// The methods to choose from. Not the others: the error of `ppm`'s fixed hit points and of the fixed discs of `photon_map`, `mps` and `bdpm` does not
/// show in their passes; `pbdpm` is `vcm` without half of its techniques, and `mmlt` stands for `mlt`, which is as far from the best wherever both were
/// tried.
const CANDIDATES: [Candidate; 7] = [
    Candidate::plain("sppm"),
    Candidate { method: "sppm", parameter: Some(["emission", "metropolis"]) },
    Candidate::plain("path"),
    Candidate::plain("bdpt"),
    Candidate::plain("vcm"),
    Candidate::plain("light_tracing"),
    Candidate::plain("mmlt"),
];
/// relMSE that a survey aims at when nobody says otherwise.
pub const DEFAULT_ERROR: f64 = 0.01;
/// Pixels of the small picture at most.
const SMALL_PIXELS: u32 = 128 * 128;
/// Passes in a trial at least: four for each twin of the estimate.
const LEAST_PASSES: u32 = 8;
/// Processor-seconds of the first round; they are told in hundredths.
const FIRST_ROUND: f64 = 0.4;
/// Each further round lasts until trials took so many times as long as before.
const LONGER: f64 = 4.0;
/// Only those go on that may reach the wanted error in at most so many times the best one's time, …
const CLOSE: f64 = 4.0;
/// … and while the next round is at most this share of the best one's expected time.
const WORTH: f64 = 0.1;
/// Processor-seconds of all trials after the first round: who asks for the impossible is not given a farm to find out.
const MOST_SECONDS: f64 = 60.0;

/// A method to try.
#[derive(Clone, Copy)]
struct Candidate {
    method: &'static str,
    /// A parameter that is not at its default, by name and value.
    parameter: Option<[&'static str; 2]>,
}

impl Candidate {
    const fn plain(method: &'static str) -> Self {
        Self { method, parameter: None }
    }

    /// With the parameters that `choice` gives; `None` where they say something else of this candidate's own.
    fn choice(&self, choice: impl Fn(&str) -> MethodChoice) -> Option<MethodChoice> {
        let mut choice = choice(self.method);
        if let Some([name, value]) = self.parameter
            && choice.parameters.insert(name.to_owned(), value.into()).is_some()
        {
            return None;
        }
        Some(choice)
    }

    fn label(&self) -> String {
        let Some([name, value]) = self.parameter else { return self.method.to_owned() };
        format!("{} with {name}: {value}", self.method)
    }
}

/// How a method did.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Parameters that set it apart from another trial of its method.
    pub own: serde_json::Map<String, serde_json::Value>,
    /// What people call it: the method, and the parameter that sets it apart from another trial.
    pub label: String,
    /// The method, with all parameters for the whole picture.
    pub method: CheckedMethod,
    /// Passes of the trial.
    pub passes: u32,
    /// Processor-seconds that they took, first radii left out.
    pub seconds: f64,
    /// The small picture's error; `None` when it stayed black.
    pub error: Option<ErrorEstimate>,
    /// Processor-seconds in which it would reach the wanted error; infinite when nothing is known.
    pub expected_seconds: f64,
    /// From how many to how many processor-seconds the trial leaves open.
    pub seconds_range: [f64; 2],
}

impl Trial {
    /// The range in words, as `12 to 31`.
    pub fn range_told(&self) -> String {
        let [low, high] = self.seconds_range.map(told_seconds);
        if low == high { low } else { format!("{low} to {high}") }
    }
}

/// Two digits, as far as they are above a hundredth.
fn told_seconds(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "unknown".to_owned();
    }
    let digits = (1.0 - seconds.max(f64::MIN_POSITIVE).log10().floor()).clamp(-300.0, 2.0);
    let step = 10_f64.powf(digits);
    format!("{:.*}", digits.max(0.0) as usize, (seconds * step).round() / step)
}

/// What a survey found.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// relMSE that is wanted.
    pub wanted: f64,
    /// The trials, the best first.
    pub trials: Vec<Trial>,
    /// Why other methods were not tried, one sentence each.
    pub left_out: Vec<String>,
}

impl Survey {
    /// The method that promises the wanted error soonest; `None` when every candidate is blind to some light.
    pub fn best(&self) -> Option<&Trial> {
        self.trials.first()
    }

    /// The choice and why, one sentence.
    pub fn reason(&self) -> String {
        let Some(best) = self.best() else { return "No method finds all light of this scene.".to_owned() };
        let others = self.trials[1..].iter().map(|trial| {
            let factor = trial.expected_seconds / best.expected_seconds;
            format!("{} {factor:.1}", trial.label)
        });
        let others = others.collect::<Vec<_>>().join(", ");
        format!(
            "auto chose {}, which should take {} processor-seconds to relMSE {}; times as long: {others}.",
            best.label,
            best.range_told(),
            self.wanted
        )
    }
}

/// Tries the candidates on `scene`, with the parameters that `choice` gives each, for at most about a minute of processor time. Runs on the
/// calling rayon pool.
///
/// # Errors
/// Parameters that no candidate takes, time that cannot be measured, or `cancel`.
pub fn survey(
    scene: &Scene,
    choice: impl Fn(&str) -> MethodChoice,
    wanted: f64,
    stopwatch: &mut dyn Stopwatch,
    cancel: &AtomicBool,
) -> Result<Survey, RunError> {
    let pixels = scene.pixel_count() as u64;
    let traits = SceneTraits::of(scene);
    let small = Arc::new(scene.with_pixels(SMALL_PIXELS));
    let share = pixels as f64 / small.pixel_count() as f64;
    let (mut racers, mut left_out, mut refused) = (Vec::new(), Vec::new(), None);
    for candidate in CANDIDATES {
        let Some(choice) = candidate.choice(&choice) else { continue };
        let checked = [pixels, small.pixel_count() as u64].map(|pixels| method::check(&choice, pixels));
        match checked {
            [Ok(whole), Ok(checked)] => match method::blind_spot(&whole, traits) {
                Some(unseen) => left_out.push(unseen),
                None => racers.push(Racer::new(&small, &checked, whole, candidate)?),
            },
            [Err(problem), _] | [_, Err(problem)] => {
                left_out.push(format!("{} does not take the parameters: {problem}.", candidate.label()));
                refused = refused.or(Some(problem));
            }
        }
    }
    if let (Some(problem), true) = (refused, racers.is_empty()) {
        return Err(problem.into());
    }
    race(&mut racers, wanted, &mut Trials { stopwatch, cancel })?;
    let mut trials: Vec<Trial> = racers.into_iter().map(|racer| racer.finish(wanted, share)).collect();
    trials.sort_by(|a, b| a.expected_seconds.total_cmp(&b.expected_seconds));
    Ok(Survey { wanted, trials, left_out })
}

/// Whether any method to choose from takes the parameters that `choice` gives it, for a picture of so many pixels.
///
/// # Errors
/// What the first one has against them, when none does.
pub fn check_candidates(choice: impl Fn(&str) -> MethodChoice, pixels: u64) -> Result<(), MethodError> {
    let mut first = None;
    for choice in CANDIDATES.iter().filter_map(|candidate| candidate.choice(&choice)) {
        match method::check(&choice, pixels) {
            Ok(_) => return Ok(()),
            Err(problem) => first = first.or(Some(problem)),
        }
    }
    first.map_or(Ok(()), Err)
}

/// Lets all race for a moment, and the best ones longer, as long as that costs little beside what they promise.
fn race(racers: &mut [Racer], wanted: f64, trials: &mut Trials<'_>) -> Result<(), RunError> {
    let (mut round, mut best) = (FIRST_ROUND, f64::INFINITY);
    while round <= WORTH * best || round == FIRST_ROUND {
        let is_close = |racer: &Racer| round == FIRST_ROUND || racer.hoped_seconds(wanted) <= CLOSE * best;
        let cost: f64 =
            racers.iter().map(|racer| if is_close(racer) { round.max(racer.seconds) } else { racer.seconds }).sum();
        if round > FIRST_ROUND && cost > MOST_SECONDS {
            break;
        }
        for racer in racers.iter_mut() {
            if is_close(racer) {
                racer.run_until(round, trials)?;
            }
        }
        best = racers.iter().map(|racer| racer.expected_seconds(wanted)).fold(f64::INFINITY, f64::min);
        if best.is_infinite() {
            break;
        }
        round *= LONGER;
    }
    Ok(())
}

/// What all trials share.
struct Trials<'a> {
    stopwatch: &'a mut dyn Stopwatch,
    cancel: &'a AtomicBool,
}

/// A method in the race.
struct Racer {
    candidate: Candidate,
    run: Run,
    method: CheckedMethod,
    /// Theory's rate, above 0 for methods that converge.
    rate: f64,
    seconds: f64,
    error: Option<ErrorEstimate>,
}

impl Racer {
    fn new(
        small: &Arc<Scene>,
        checked: &CheckedMethod,
        method: CheckedMethod,
        candidate: Candidate,
    ) -> Result<Self, RunError> {
        let rate = -method::theory_rate(checked);
        Ok(Self { candidate, run: Run::start(small, checked, 0)?, method, rate, seconds: 0.0, error: None })
    }

    /// Makes pairs of passes until `seconds` were spent.
    fn run_until(&mut self, seconds: f64, trials: &mut Trials<'_>) -> Result<(), RunError> {
        let start = trials.stopwatch.spent()?.processor - self.seconds;
        while self.run.passes() < LEAST_PASSES || self.seconds < seconds {
            if trials.cancel.load(Ordering::Relaxed) {
                return Err(Cancelled.into());
            }
            self.run.pass()?;
            self.run.pass()?;
            self.seconds = trials.stopwatch.spent()?.processor - start;
        }
        self.error = self.run.error();
        Ok(())
    }

    /// Processor-seconds until the small picture's error is `wanted`.
    fn expected_seconds(&self, wanted: f64) -> f64 {
        self.seconds_at(self.rate, wanted)
    }

    /// From how many to how many seconds that may be. Its passes tell the error with a bound, and few of them do not tell how fast density
    /// estimates get better: as theory says at the slowest, as 1/time at the fastest.
    fn seconds_range(&self, wanted: f64) -> [f64; 2] {
        // The bound is above the error as far as the error may be below.
        let doubt = self.error.map_or(1.0, |error| (error.bound / (error.noise + error.bias)).max(1.0));
        // Where the trial is better than wanted, less of it is enough, and slow is soon.
        let both = |wanted: f64| [self.hoped_seconds(wanted), self.expected_seconds(wanted)];
        let ([a, b], [c, d]) = (both(wanted * doubt), both(wanted / doubt));
        [a.min(b), c.max(d)]
    }

    /// The same at the best rate that there is: few passes tell little of what falls how fast.
    fn hoped_seconds(&self, wanted: f64) -> f64 {
        self.seconds_at(1.0, wanted)
    }

    /// The same if what density estimates add falls with `rate`; infinite where nothing is known or the error stays.
    fn seconds_at(&self, rate: f64, wanted: f64) -> f64 {
        let Some(error) = self.error.filter(|_| self.rate > 0.0) else { return f64::INFINITY };
        let sampled = error.sampled_noise.min(error.noise);
        self.seconds * times_as_long([sampled, error.noise - sampled + error.bias], rate, wanted)
    }

    fn finish(self, wanted: f64, share: f64) -> Trial {
        let expected_seconds = share * self.expected_seconds(wanted);
        let seconds_range = self.seconds_range(wanted).map(|seconds| share * seconds);
        let Self { candidate, run, method, seconds, error, .. } = self;
        let own = candidate.parameter.map(|[name, value]| (name.to_owned(), value.into())).into_iter().collect();
        let (label, passes) = (candidate.label(), run.passes());
        Trial { own, label, method, passes, seconds, error, expected_seconds, seconds_range }
    }
}

/// The x at which sampled/x + gathered/x^rate is `wanted`, by bisection of its logarithm.
fn times_as_long([sampled, gathered]: [f64; 2], rate: f64, wanted: f64) -> f64 {
    let all = (sampled + gathered) / wanted;
    // Each bound is right if all of the error falls with one of the rates.
    let (mut low, mut high) = (all.min(all.powf(1.0 / rate)), all.max(all.powf(1.0 / rate)));
    for _ in 0..64 {
        let middle = (low * high).sqrt();
        let left = sampled / middle + gathered / middle.powf(rate);
        if left > wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
