//! The runs of an evaluation: every scene by every method with every seed.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::exit_code::CliError;
use crate::cli::job_options::{parameters, setting};
use crate::cli::terminal;
use crate::estimate::Picture;
use crate::estimate::picture_files::{encode_png, write_file};
use crate::evaluation::{
    Machine, ProcessStopwatch, Record, Reference, ResultsFile, RunKey, Snapshot, compare, exposure_factor, follow,
    on_threads,
};
use crate::method::{self, CheckedMethod, MethodChoice, SceneTraits, table};

/// Time between lines where there is no terminal for a bar.
const LINE_INTERVAL: Duration = Duration::from_secs(30);
/// Steps of the bar for a second.
const STEPS_PER_SECOND: f64 = 100.0;
/// Processor-seconds between looks of the bar: it must not cost what it measures.
const BAR_INTERVAL: f64 = 0.1;

/// What to measure. All of it was checked.
pub(super) struct Plan {
    pub(super) references: Vec<Reference>,
    pub(super) methods: Vec<NamedChoice>,
    /// Processor-seconds.
    pub(super) budgets: Vec<f64>,
    pub(super) seeds: u64,
    pub(super) threads: usize,
    pub(super) machine: Machine,
    pub(super) pictures: Option<PictureFolder>,
}

/// A method as the user wrote it, and what that means.
pub(super) struct NamedChoice {
    label: String,
    choice: MethodChoice,
}

/// Reads `name:key=value:…`; all methods of the table when there are none. Refuses what any of the scenes would refuse.
pub(super) fn methods(texts: &[String], references: &[Reference]) -> Result<Vec<NamedChoice>, CliError> {
    let all = || table().iter().map(|entry| entry.name.to_owned()).collect();
    let texts: Vec<String> = if texts.is_empty() { all() } else { texts.to_vec() };
    let mut choices = Vec::new();
    for label in texts {
        let mut parts = label.split(':');
        let name = parts.next().unwrap_or_default().to_owned();
        let settings = parts.map(setting).collect::<Result<Vec<_>, _>>();
        let settings = settings.map_err(|error| CliError::Usage(format!("method \"{label}\": {error}")))?;
        let parameters = parameters(settings)?;
        let choice = MethodChoice { name, parameters };
        for reference in references {
            check(&choice, reference)?;
        }
        choices.push(NamedChoice { label, choice });
    }
    Ok(choices)
}

fn check(choice: &MethodChoice, reference: &Reference) -> Result<CheckedMethod, CliError> {
    let checked = method::check(choice, reference.scene.pixel_count() as u64);
    checked.map_err(|error| CliError::BadInput(error.to_string()))
}

/// One run that is still to be made.
struct Cell<'a> {
    reference: &'a Reference,
    method: CheckedMethod,
    run: RunKey,
    /// Budgets that the file lacks.
    budgets: Vec<f64>,
}

/// Makes all runs that the file lacks: seed by seed, so that an interrupted evaluation has something of everything.
pub(super) fn run(plan: &Plan, file: &mut ResultsFile) -> Result<(), CliError> {
    let mut cells = Vec::new();
    let mut known = 0;
    for seed in 1..=plan.seeds {
        for reference in &plan.references {
            for named in &plan.methods {
                let method = check(&named.choice, reference)?;
                let run = run_key(plan, reference, &named.label, &method, seed);
                let budgets = file.missing(&run, &plan.budgets);
                known += usize::from(budgets.is_empty());
                cells.push(Cell { reference, method, run, budgets });
            }
        }
    }
    cells.retain(|cell| !cell.budgets.is_empty());
    let mut progress = EvaluationProgress::new(&cells, known);
    for cell in &cells {
        let snapshots = trace(plan.threads, cell, &mut progress)?;
        file.append(lines(plan, cell, &snapshots)?)?;
        progress.done(cell);
    }
    progress.finish();
    Ok(())
}

fn run_key(plan: &Plan, reference: &Reference, label: &str, method: &CheckedMethod, seed: u64) -> RunKey {
    RunKey {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: plan.threads,
        scene: reference.name.clone(),
        scene_hash: reference.scene_hash.clone(),
        reference_hash: reference.reference_hash.clone(),
        label: label.to_owned(),
        method: method.choice.clone(),
        seed,
    }
}

fn trace(threads: usize, cell: &Cell<'_>, progress: &mut EvaluationProgress) -> Result<Vec<Snapshot>, CliError> {
    let snapshots = on_threads(threads, || {
        let mut stopwatch = ProcessStopwatch::start()?;
        let scene = &cell.reference.scene;
        follow(scene, &cell.method, cell.run.seed, &cell.budgets, &mut stopwatch, &mut |spent| {
            progress.show(cell, spent.processor);
        })
    })?;
    Ok(snapshots?)
}

fn lines(plan: &Plan, cell: &Cell<'_>, snapshots: &[Snapshot]) -> Result<Vec<Record>, CliError> {
    let largest = plan.budgets.iter().copied().fold(0.0, f64::max);
    let line = |snapshot: &Snapshot| {
        let mut record = record(plan, cell, snapshot)?;
        let wanted = record.seed == 1 && record.budget == largest;
        if let Some(folder) = plan.pictures.as_ref().filter(|_| wanted) {
            folder.keep(&mut record, &snapshot.picture, cell.reference)?;
        }
        Ok(record)
    };
    snapshots.iter().map(line).collect()
}

fn record(plan: &Plan, cell: &Cell<'_>, snapshot: &Snapshot) -> Result<Record, CliError> {
    let Cell { reference, method, .. } = cell;
    let run = cell.run.clone();
    let theory_rate = method::theory_rate(method);
    let metrics = compare(&snapshot.picture, &reference.picture, reference.standard_error.as_ref());
    Ok(Record {
        version: run.version,
        machine: plan.machine.clone(),
        threads: run.threads,
        scene: run.scene,
        scene_hash: run.scene_hash,
        reference_hash: run.reference_hash,
        label: run.label,
        method: run.method.name,
        parameters: run.method.parameters,
        theory_rate,
        blind: method::blind_spot(method, SceneTraits::of(&reference.scene)),
        seed: run.seed,
        budget: snapshot.budget,
        passes: snapshot.passes,
        cpu_seconds: snapshot.spent.processor,
        wall_seconds: snapshot.spent.wall,
        metrics: metrics.map_err(CliError::failed)?,
        picture: None,
        reference_picture: None,
    })
}

/// `results.pictures` beside `results.jsonl`.
pub(super) struct PictureFolder {
    folder: PathBuf,
    name: String,
}

impl PictureFolder {
    pub(super) fn beside(results: &Path) -> Self {
        let folder = results.with_extension("pictures");
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Self { folder, name }
    }

    /// Writes the picture and its reference and says so in the record.
    fn keep(&self, record: &mut Record, picture: &Picture, reference: &Reference) -> Result<(), CliError> {
        std::fs::create_dir_all(&self.folder).map_err(|error| {
            CliError::File(format!("cannot make \"{}\": {error}; choose another place", self.folder.display()))
        })?;
        let stops = exposure_factor(&reference.picture).log2() as f32;
        let write = |what: &str, picture: &Picture| -> Result<String, CliError> {
            let file = format!("{}--{}.png", record.scene, what.replace([':', '=', '/', '\\'], "_"));
            write_file(&self.folder.join(&file), &encode_png(picture, stops)?)?;
            Ok(format!("{}/{file}", self.name))
        };
        let (ours, theirs) = (write(&record.label, picture)?, write("reference", &reference.picture)?);
        record.picture = Some(ours);
        record.reference_picture = Some(theirs);
        Ok(())
    }
}

/// How far the evaluation is: a bar on a terminal, else a line now and then.
struct EvaluationProgress {
    bar: ProgressBar,
    total: f64,
    finished: f64,
    shown: f64,
    last_line: Option<Instant>,
}

impl EvaluationProgress {
    fn new(cells: &[Cell<'_>], known: usize) -> Self {
        let total: f64 = cells.iter().map(seconds_of).sum();
        terminal::note(&format!("{} runs, {total:.0} processor-seconds; {known} are in the file already", cells.len()));
        let style =
            ProgressStyle::with_template("[{bar:30}] {wide_msg} {eta}").map(|style| style.progress_chars("=> "));
        let bar = ProgressBar::new((total * STEPS_PER_SECOND) as u64)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar, total, finished: 0.0, shown: 0.0, last_line: None }
    }

    fn show(&mut self, cell: &Cell<'_>, seconds: f64) {
        let position = self.finished + seconds;
        if position < self.shown + BAR_INTERVAL {
            return;
        }
        self.shown = position;
        let RunKey { scene, label, seed, .. } = &cell.run;
        let text = format!("{scene} by {label}, seed {seed}: {seconds:.0} s");
        self.bar.set_position((position * STEPS_PER_SECOND) as u64);
        if self.bar.is_hidden() && self.last_line.is_none_or(|last| last.elapsed() >= LINE_INTERVAL) {
            self.last_line = Some(Instant::now());
            terminal::note(&format!("{position:.0} of {:.0} s: {text}", self.total));
        }
        self.bar.set_message(text);
    }

    fn done(&mut self, cell: &Cell<'_>) {
        self.finished += seconds_of(cell);
    }

    fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// The largest budget of a run.
fn seconds_of(cell: &Cell<'_>) -> f64 {
    cell.budgets.iter().copied().fold(0.0, f64::max)
}
