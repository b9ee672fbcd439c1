//! Curves of error over time: medians and spread over seeds, and how fast they fall.

use super::sample::{Measure, Sample};

/// Median and extremes over seeds. With `count` seeds the median of all possible seeds lies between the extremes with probability
/// 1 − 2^(1 − count): 75 % for three, 94 % for five.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Median; the mean of the two middle values of an even number.
    pub median: f64,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Number of values.
    pub count: usize,
}

impl Spread {
    /// Of some values; `None` of none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let (low, high) = (*values.first()?, *values.last()?);
        let middle = values.len() / 2;
        let median = if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) };
        Some(Self { median, low, high, count: values.len() })
    }
}

/// All seeds at one budget.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePoint {
    /// The budget, processor-seconds.
    pub budget: f64,
    /// Median of the processor-seconds spent.
    pub cpu_seconds: f64,
    /// Median of the seconds by the clock, if they are known.
    pub wall_seconds: Option<f64>,
    /// The error without the reference's noise.
    pub error: Spread,
}

/// One method, or another program, on one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The scene.
    pub scene: String,
    /// The method as its user wrote it, or the program's name.
    pub label: String,
    /// Whether another program made it.
    pub peer: bool,
    /// Light that the method never finds there.
    pub blind: Option<String>,
    /// The reference's own part in the error; what is below is not known.
    pub noise: Option<f64>,
    /// Power of time that theory says.
    pub theory_rate: Option<f64>,
    /// Power of time fitted to each seed's errors above the noise; empty with fewer than two of them.
    pub slope: Option<Spread>,
    /// In rising order of the budget.
    pub points: Vec<CurvePoint>,
}

/// When a curve reaches an error, processor-seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reached {
    /// It was below at its first point already.
    Before(f64),
    /// Between two points, interpolated on logarithmic scales.
    At(f64),
    /// Not until its last point.
    NotBy(f64),
}

/// The samples as curves, scenes and labels in the order of their first samples.
pub fn curves(samples: &[Sample], measure: Measure) -> Vec<Curve> {
    let mut groups: Vec<Vec<&Sample>> = Vec::new();
    for sample in samples {
        let group =
            groups.iter_mut().find(|group| (&group[0].scene, &group[0].label) == (&sample.scene, &sample.label));
        match group {
            Some(group) => group.push(sample),
            None => groups.push(vec![sample]),
        }
    }
    groups.iter().map(|group| curve(group, measure)).collect()
}

fn curve(samples: &[&Sample], measure: Measure) -> Curve {
    let first = samples[0];
    let mut budgets: Vec<f64> = samples.iter().map(|sample| sample.budget).collect();
    budgets.sort_by(f64::total_cmp);
    budgets.dedup();
    let point = |budget: &f64| {
        let at = || samples.iter().filter(|sample| sample.budget == *budget);
        Some(CurvePoint {
            budget: *budget,
            cpu_seconds: Spread::of(at().map(|sample| sample.cpu_seconds))?.median,
            wall_seconds: Spread::of(at().filter_map(|sample| sample.wall_seconds)).map(|seconds| seconds.median),
            error: Spread::of(at().map(|sample| sample.left(measure)))?,
        })
    };
    let mut seeds: Vec<u64> = samples.iter().map(|sample| sample.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let slopes = seeds.iter().filter_map(|seed| slope(samples.iter().filter(|sample| sample.seed == *seed), measure));
    Curve {
        scene: first.scene.clone(),
        label: first.label.clone(),
        peer: first.peer,
        blind: first.blind.clone(),
        noise: first.noise,
        theory_rate: first.theory_rate,
        slope: Spread::of(slopes),
        points: budgets.iter().filter_map(point).collect(),
    }
}

/// Least squares of log error against log time, over what is above the noise.
fn slope<'a>(samples: impl Iterator<Item = &'a &'a Sample>, measure: Measure) -> Option<f64> {
    let points: Vec<[f64; 2]> = samples
        .filter(|sample| sample.left(measure) > sample.noise.unwrap_or(0.0))
        .map(|sample| [sample.cpu_seconds.ln(), sample.left(measure).ln()])
        .collect();
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let spread: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let common: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    (spread > 0.0).then(|| common / spread)
}

impl Curve {
    /// When the median reaches `error`.
    pub fn reaches(&self, error: f64) -> Option<Reached> {
        let below = |point: &CurvePoint| point.error.median <= error;
        let Some(index) = self.points.iter().position(below) else {
            return self.points.last().map(|point| Reached::NotBy(point.cpu_seconds));
        };
        let point = &self.points[index];
        let Some(before) = index.checked_sub(1).map(|index| &self.points[index]) else {
            return Some(Reached::Before(point.cpu_seconds));
        };
        // A median below the noise may be negative: then the curve went through the error at the latest here.
        let bottom = point.error.median.max(f64::MIN_POSITIVE);
        let share = (before.error.median / error).ln() / (before.error.median / bottom).ln();
        Some(Reached::At(before.cpu_seconds * (point.cpu_seconds / before.cpu_seconds).powf(share)))
    }

    /// The point at `budget`.
    pub fn at(&self, budget: f64) -> Option<&CurvePoint> {
        self.points.iter().find(|point| point.budget == budget)
    }
}

/// The largest budget that all curves of `scene` have in common.
pub fn common_budget(curves: &[Curve], scene: &str) -> Option<f64> {
    let mut of_scene = curves.iter().filter(|curve| curve.scene == scene && !curve.peer);
    let first = of_scene.next()?;
    let shared = |budget: f64| of_scene.clone().all(|curve| curve.at(budget).is_some());
    first.points.iter().rev().map(|point| point.budget).find(|budget| shared(*budget))
}
