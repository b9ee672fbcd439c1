//! `plan`: what a scene needs, and which method would render it soonest.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use clap::Args;
use serde_json::{Value, json};

use super::exit_code::CliError;
use super::job_options::{parameters, setting};
use super::scene_input::scene_help;
use super::scene_options::SceneOptions;
use super::terminal;
use crate::evaluation::{DEFAULT_ERROR, ProcessStopwatch, Survey, Trial};
use crate::farm::method_choice::try_methods;
use crate::scene::needs::SceneNeeds;
use crate::scene::prepare::Scene;

/// Say what a scene needs and which method would render it soonest.
///
/// It finds out by short trials. `render --method auto` does the same and goes on with the best method. Seconds are those until the error is
/// expected to be there, from the least to the most that the trial leaves open: its error within the bound that its own passes give with
/// 95 % confidence, and density estimates that get better as slowly as theory says or as fast as all else. A job with `--error` goes on
/// until it is sure, and takes two to three times as long.
#[derive(Clone, Debug, Args)]
pub(super) struct Plan {
    #[arg(help = scene_help())]
    scene: PathBuf,
    /// relMSE to plan for.
    #[arg(long, value_name = "RELMSE", default_value_t = DEFAULT_ERROR)]
    error: f64,
    /// Method parameter that every candidate gets. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    settings: Vec<(String, Value)>,
    #[command(flatten)]
    options: SceneOptions,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Plan {
    pub(super) fn run(self) -> Result<(), CliError> {
        if !(self.error > 0.0 && self.error.is_finite()) {
            return Err(CliError::Usage(format!("--error is {}; give a relMSE above 0, as 0.01", self.error)));
        }
        let scene = Scene::prepare(&self.options.load(&self.scene)?)?;
        let (needs, size) = (scene.needs(), [scene.width, scene.height]);
        let parameters = parameters(self.settings.iter().cloned())?;
        let mut stopwatch = ProcessStopwatch::start().map_err(CliError::failed)?;
        let found = try_methods(&scene, &parameters, self.error, &mut stopwatch, &AtomicBool::new(false))
            .map_err(|problem| CliError::BadInput(problem.to_string()))?;
        let text = if self.json { as_json(&needs, size, &found)? } else { as_text(&needs, size, &found) };
        terminal::result(&text)
    }
}

fn as_text(needs: &SceneNeeds, [width, height]: [u32; 2], found: &Survey) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:<12}{value}");
    };
    let lights = if needs.lights == 1 { "1 light".to_owned() } else { format!("{} lights", needs.lights) };
    line("picture", format!("{width} × {height} pixels, {} primitives, {lights}", needs.primitives));
    line("needs", listed(&needs.used));
    line("not needed", format!("{}; costs nothing", listed(&needs.unused)));
    for (index, trial) in found.trials.iter().enumerate() {
        line(if index == 0 { "method" } else { "" }, told(trial, found.wanted));
    }
    for sentence in &found.left_out {
        line("left out", sentence.clone());
    }
    if found.best().is_none() {
        line("method", found.reason());
    }
    text.trim_end().to_owned()
}

fn told(trial: &Trial, wanted: f64) -> String {
    let name = &trial.label;
    match trial.error {
        Some(error) => format!(
            "{name:<14}{:>14} processor-seconds to relMSE {wanted} (trial: {} passes in {:.2} s, noise {:.4}, bias {:.4})",
            trial.range_told(),
            trial.passes,
            trial.seconds,
            error.noise,
            error.bias
        ),
        None => format!("{name:<14}saw no light in {} passes", trial.passes),
    }
}

fn listed(names: &[&str]) -> String {
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

fn as_json(needs: &SceneNeeds, [width, height]: [u32; 2], found: &Survey) -> Result<String, CliError> {
    let trial = |trial: &Trial| {
        json!({
            "method": trial.method.choice,
            "expected_seconds": trial.expected_seconds.is_finite().then_some(trial.expected_seconds),
            "seconds_range": trial.expected_seconds.is_finite().then_some(trial.seconds_range),
            "passes": trial.passes,
            "seconds": trial.seconds,
            "noise": trial.error.map(|error| error.noise),
            "bias": trial.error.map(|error| error.bias),
            "bound": trial.error.map(|error| error.bound),
        })
    };
    let document = json!({
        "width": width,
        "height": height,
        "primitives": needs.primitives,
        "lights": needs.lights,
        "needs": needs.used,
        "does_not_need": needs.unused,
        "error": found.wanted,
        "trials": found.trials.iter().map(trial).collect::<Vec<_>>(),
        "left_out": found.left_out,
    });
    serde_json::to_string_pretty(&document).map_err(CliError::failed)
}
