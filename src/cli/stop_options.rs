//! When a job stops, as the command line says it.

use clap::Args;

use crate::farm::job::StopRule;

/// When a job stops; by several, whatever comes first.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct StopOptions {
    /// Stop after this many passes in all.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 31))]
    passes: Option<u32>,
    /// Stop after this many seconds in all.
    #[arg(long, value_parser = above_zero, allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Stop when the picture's relMSE is below this, as the job itself estimates with 95 % confidence.
    #[arg(long, value_name = "RELMSE", value_parser = above_zero, allow_negative_numbers = true)]
    error: Option<f64>,
    /// With --error: also for a method that never finds some of the scene's light.
    #[arg(long)]
    accept_missing_light: bool,
}

/// A number that a rule can have. JSON has none for what is not finite, and a rule without a number would be no rule.
fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("give a finite number above 0".to_owned()),
    }
}

impl StopOptions {
    pub(super) fn rule(self) -> StopRule {
        StopRule {
            passes: self.passes,
            seconds: self.seconds,
            error: self.error,
            accepts_missing_light: self.accept_missing_light,
        }
    }
}
