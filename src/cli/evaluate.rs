//! `evaluate`: error over time of methods on scenes whose picture is known.

mod cells;
mod comparison;
mod table;

use std::path::PathBuf;

use clap::Args;

use super::exit_code::CliError;
use super::job_options::define;
use super::terminal;
use crate::evaluation::{
    ChangeRule, Machine, Measure, PeersError, Reference, ReferenceError, ReferencePlace, ResultsError, ResultsFile,
    RunError, Sample, curves, read_results,
};

/// Measure how the error of methods falls with time.
///
/// Scenes are those whose picture is known (docs/EVALUATION.md). Each method renders each scene once per seed, and the picture
/// is measured whenever a time budget is spent. Results are added to a file of JSON lines; what the file holds already is not
/// measured again, so Ctrl-C loses one run at most.
#[derive(Clone, Debug, Args)]
pub(super) struct Evaluate {
    /// Folders with scene.xml, ref.exr and stderr.exr, or scene files with these beside them.
    #[arg(value_name = "SCENE", required_unless_present = "compare")]
    scenes: Vec<PathBuf>,
    /// Methods, separated by commas, with parameters as in sppm:alpha=0.8:radius_rule=schedule [default: all].
    #[arg(long, value_name = "METHODS", value_delimiter = ',')]
    methods: Vec<String>,
    /// Time budgets, processor-seconds of a run.
    #[arg(long, value_name = "SECONDS", value_delimiter = ',', default_values_t = [1.0, 3.0, 10.0, 30.0])]
    seconds: Vec<f64>,
    /// Number of runs for each scene and method; the seeds are 1, 2, …
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// Threads of a run. More than one measures how well a method uses them, too.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// The reference picture of the one scene, in place of its ref.exr.
    #[arg(long, value_name = "FILE.exr")]
    reference: Option<PathBuf>,
    /// The reference's standard error, in place of the scene's stderr.exr.
    #[arg(long, value_name = "FILE.exr")]
    stderr: Option<PathBuf>,
    /// Value of a scene parameter, in place of its <default>. May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    defines: Vec<(String, String)>,
    /// Results file, JSON lines.
    #[arg(short, long, value_name = "FILE.jsonl", required_unless_present = "compare")]
    output: Option<PathBuf>,
    /// Also keep the pictures of the first seed at the largest budget, as PNG files in a folder beside the results.
    #[arg(long)]
    pictures: bool,
    /// Measure nothing; say what is better and worse in NEW than in OLD. Exit code 6 when anything is worse.
    #[arg(long, num_args = 2, value_names = ["OLD", "NEW"], conflicts_with_all = ["scenes", "output", "pictures"])]
    compare: Option<Vec<PathBuf>>,
    /// The error that tables and comparisons look at.
    #[arg(long, default_value = "relmse", value_parser = measure)]
    measure: Measure,
    /// With --compare: changes by a smaller share than this do not count.
    #[arg(long, value_name = "SHARE", default_value_t = 0.05)]
    tolerance: f64,
    /// With --compare: probability of any false alarm when nothing changed.
    #[arg(long, value_name = "PROBABILITY", default_value_t = 0.01)]
    level: f64,
}

impl Evaluate {
    pub(super) fn run(self) -> Result<(), CliError> {
        if let Some([old, new]) = self.compare.as_deref() {
            let rule = ChangeRule { measure: self.measure, level: self.level, tolerance: self.tolerance };
            return comparison::run(old, new, rule);
        }
        let output = self.output.clone().ok_or_else(|| CliError::Usage("name a results file with -o".to_owned()))?;
        let plan = self.plan()?;
        let mut file = ResultsFile::open(&output)?;
        cells::run(&plan, &mut file)?;
        let samples: Vec<Sample> =
            read_results(&output)?.iter().map(|record| Sample::of(record, self.measure)).collect();
        terminal::result(&table::of(&curves(&samples, self.measure), self.measure))
    }

    /// Everything that can be wrong is looked at before the first pass.
    fn plan(&self) -> Result<cells::Plan, CliError> {
        if let Some(seconds) = self.seconds.iter().find(|seconds| !(**seconds > 0.0 && seconds.is_finite())) {
            return Err(CliError::Usage(format!("--seconds has {seconds}; give numbers above 0")));
        }
        if self.scenes.len() > 1 && (self.reference.is_some() || self.stderr.is_some()) {
            let text = "--reference and --stderr belong to one scene; evaluate the others by themselves";
            return Err(CliError::Usage(text.to_owned()));
        }
        let mut references: Vec<Reference> = Vec::new();
        for scene in &self.scenes {
            let reference = Reference::load_from(&self.place(scene))?;
            if let Some(known) = references.iter().find(|known| known.name == reference.name) {
                let text = format!("two scenes are called \"{}\"; rename a folder", known.name);
                return Err(CliError::BadInput(text));
            }
            references.push(reference);
        }
        let output = self.output.as_deref().filter(|_| self.pictures);
        Ok(cells::Plan {
            methods: cells::methods(&self.methods, &references)?,
            references,
            budgets: self.seconds.clone(),
            seeds: self.seeds,
            threads: usize::from(self.threads),
            machine: Machine::here(),
            pictures: output.map(cells::PictureFolder::beside),
        })
    }

    fn place(&self, scene: &std::path::Path) -> ReferencePlace {
        ReferencePlace {
            scene: scene.to_owned(),
            picture: self.reference.clone(),
            standard_error: self.stderr.clone(),
            defines: self.defines.clone(),
        }
    }
}

/// A measure by its name.
pub(super) fn measure(name: &str) -> Result<Measure, String> {
    let known = || Measure::ALL.map(Measure::name).join(", ");
    Measure::ALL
        .into_iter()
        .find(|measure| measure.name() == name)
        .ok_or_else(|| format!("known measures: {}", known()))
}

impl From<ReferenceError> for CliError {
    fn from(error: ReferenceError) -> Self {
        match error {
            ReferenceError::Scene(error) => error.into(),
            ReferenceError::Picture(error) => error.into(),
            ReferenceError::Read { .. } => Self::File(error.to_string()),
            ReferenceError::Unfit { .. } => Self::BadInput(error.to_string()),
        }
    }
}

impl From<ResultsError> for CliError {
    fn from(error: ResultsError) -> Self {
        match error {
            ResultsError::File { .. } => Self::File(error.to_string()),
            ResultsError::Line { .. } => Self::BadInput(error.to_string()),
        }
    }
}

impl From<PeersError> for CliError {
    fn from(error: PeersError) -> Self {
        match error {
            PeersError::File { .. } => Self::File(error.to_string()),
            PeersError::Content { .. } => Self::BadInput(error.to_string()),
        }
    }
}

impl From<RunError> for CliError {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Method(error) => Self::BadInput(error.to_string()),
            _ => Self::failed(error),
        }
    }
}
