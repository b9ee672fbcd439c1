//! Errors over time from any source: our own results and those of other programs.

use super::record::Record;

/// Which error a chart or a comparison looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// Relative mean square error.
    #[default]
    Relmse,
    /// The same without the worst 0.1 % of pixels.
    RelmseTrimmed,
    /// Root mean square error, W·sr⁻¹·m⁻².
    Rmse,
}

impl Measure {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Relmse, Self::RelmseTrimmed, Self::Rmse];

    /// The name that users write.
    pub fn name(self) -> &'static str {
        match self {
            Self::Relmse => "relmse",
            Self::RelmseTrimmed => "relmse_trimmed",
            Self::Rmse => "rmse",
        }
    }

    /// What charts call it.
    pub fn title(self) -> &'static str {
        match self {
            Self::Relmse => "relMSE",
            Self::RelmseTrimmed => "relMSE without the worst 0.1 %",
            Self::Rmse => "RMSE",
        }
    }

    /// Its power of time when that of a mean square is `rate`.
    pub fn rate(self, rate: f64) -> f64 {
        if self == Self::Rmse { rate / 2.0 } else { rate }
    }

    /// What is left of `error` without the reference's `noise`. Not above 0 when nothing is left.
    fn left(self, error: f64, noise: f64) -> f64 {
        if self != Self::Rmse {
            return error - noise;
        }
        let square = error * error - noise * noise;
        square.signum() * square.abs().sqrt()
    }
}

/// The error of one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The scene's name.
    pub scene: String,
    /// Name of the curve.
    pub label: String,
    /// Whether another program made it.
    pub peer: bool,
    /// Light of the scene that the method never finds.
    pub blind: Option<String>,
    /// Power of time with which theory says that the measure falls, if it says so.
    pub theory_rate: Option<f64>,
    /// Seed of the run.
    pub seed: u64,
    /// The time budget, processor-seconds.
    pub budget: f64,
    /// Processor-seconds spent.
    pub cpu_seconds: f64,
    /// Seconds by the clock; empty when not known.
    pub wall_seconds: Option<f64>,
    /// The measure.
    pub error: f64,
    /// The reference's own part in it, if it is known.
    pub noise: Option<f64>,
}

impl Sample {
    /// The sample of one line of results.
    pub fn of(record: &Record, measure: Measure) -> Self {
        let metrics = &record.metrics;
        let noise = metrics.reference_noise.as_ref();
        let (error, noise) = match measure {
            Measure::Relmse => (metrics.relmse, noise.map(|noise| noise.relmse)),
            // Which pixels are left out depends on the picture; what the noise adds to the others is not known.
            Measure::RelmseTrimmed => (metrics.relmse_trimmed, None),
            Measure::Rmse => (metrics.rmse, noise.map(|noise| noise.rmse)),
        };
        Self {
            scene: record.scene.clone(),
            label: record.label.clone(),
            peer: false,
            blind: record.blind.clone(),
            theory_rate: Some(measure.rate(record.theory_rate)),
            seed: record.seed,
            budget: record.budget,
            cpu_seconds: record.cpu_seconds,
            wall_seconds: Some(record.wall_seconds),
            error,
            noise,
        }
    }

    /// The error without the reference's part.
    pub fn left(&self, measure: Measure) -> f64 {
        measure.left(self.error, self.noise.unwrap_or(0.0))
    }
}
