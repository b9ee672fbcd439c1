//! Results files: one JSON object a line, one line for each picture that was measured (docs/EVALUATION.md).

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::machine::Machine;
use super::metrics::Metrics;
use crate::method::MethodChoice;

/// One measured picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version of the program.
    pub version: String,
    /// Where it ran.
    pub machine: Machine,
    /// Threads it ran on.
    pub threads: usize,
    /// The scene's name.
    pub scene: String,
    /// Hash of the scene.
    pub scene_hash: String,
    /// Hash of the reference.
    pub reference_hash: String,
    /// The method as the user wrote it: the name of its curve.
    pub label: String,
    /// The method.
    pub method: String,
    /// All its parameters.
    pub parameters: Map<String, Value>,
    /// Power of time with which theory says that relMSE falls.
    pub theory_rate: f64,
    /// Light of the scene that the method never finds, if there is any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blind: Option<String>,
    /// Seed of the run.
    pub seed: u64,
    /// The time budget, processor-seconds.
    pub budget: f64,
    /// Passes made.
    pub passes: u32,
    /// Processor-seconds spent on them.
    pub cpu_seconds: f64,
    /// Seconds by the clock.
    pub wall_seconds: f64,
    /// How far the picture is from the reference.
    pub metrics: Metrics,
    /// The picture as a PNG, below the results file's folder, if it was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
    /// The reference as a PNG with the same exposure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_picture: Option<String>,
}

/// What decides whether two lines come from the same run of the same program: a run that is in a file already need not be made again.
#[derive(Clone, Debug, PartialEq)]
pub struct RunKey {
    /// Version of the program.
    pub version: String,
    /// Threads.
    pub threads: usize,
    /// The scene's name.
    pub scene: String,
    /// Hash of the scene.
    pub scene_hash: String,
    /// Hash of the reference.
    pub reference_hash: String,
    /// The method as the user wrote it.
    pub label: String,
    /// The method and all its parameters.
    pub method: MethodChoice,
    /// Seed of the run.
    pub seed: u64,
}

impl Record {
    /// The run that this line is from.
    pub fn run(&self) -> RunKey {
        RunKey {
            version: self.version.clone(),
            threads: self.threads,
            scene: self.scene.clone(),
            scene_hash: self.scene_hash.clone(),
            reference_hash: self.reference_hash.clone(),
            label: self.label.clone(),
            method: MethodChoice { name: self.method.clone(), parameters: self.parameters.clone() },
            seed: self.seed,
        }
    }
}

/// A results file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The file system refused.
    #[error("cannot {action} \"{path}\": {source}; check the name and the permissions", path = .path.display())]
    File {
        /// Read or write.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// A line is not what it should be.
    #[error("{path}:{line}: {problem}; give a file that `photonfarm evaluate` wrote", path = .path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
}

/// Reads a results file. Of lines for the same scene, label, seed and budget only the last counts, at its first one's place. A last line
/// without an end was being written when the program stopped, and does not count.
pub fn read_results(path: &Path) -> Result<Vec<Record>, ResultsError> {
    let text = std::fs::read_to_string(path).map_err(|source| ResultsError::File {
        action: "read",
        path: path.to_owned(),
        source,
    })?;
    let mut records: Vec<Record> = Vec::new();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    for (index, line) in whole.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let record: Record = serde_json::from_str(line).map_err(|error| ResultsError::Line {
            path: path.to_owned(),
            line: index + 1,
            problem: error.to_string(),
        })?;
        let cell = |record: &Record| (record.scene.clone(), record.label.clone(), record.seed, record.budget.to_bits());
        match records.iter_mut().find(|known| cell(known) == cell(&record)) {
            Some(known) => *known = record,
            None => records.push(record),
        }
    }
    Ok(records)
}

/// A results file that lines are added to.
#[derive(Debug)]
pub struct ResultsFile {
    path: PathBuf,
    known: Vec<Record>,
}

impl ResultsFile {
    /// Opens or makes a file. What an interrupted program left of a last line is cut off.
    pub fn open(path: &Path) -> Result<Self, ResultsError> {
        let failed = |action| move |source| ResultsError::File { action, path: path.to_owned(), source };
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(failed("write"))?;
        let known = read_results(path)?;
        let bytes = std::fs::read(path).map_err(failed("read"))?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        if whole < bytes.len() {
            file.set_len(whole as u64).map_err(failed("write"))?;
        }
        Ok(Self { path: path.to_owned(), known })
    }

    /// Those of `budgets` that no line holds for a run.
    pub fn missing(&self, run: &RunKey, budgets: &[f64]) -> Vec<f64> {
        let known: Vec<f64> = self.known.iter().filter(|known| known.run() == *run).map(|known| known.budget).collect();
        budgets.iter().copied().filter(|budget| !known.contains(budget)).collect()
    }

    /// Adds lines in one go, so that a run is there whole or not at all.
    pub fn append(&mut self, records: Vec<Record>) -> Result<(), ResultsError> {
        let failed = |source| ResultsError::File { action: "write", path: self.path.clone(), source };
        let mut text = String::new();
        for record in &records {
            text += &serde_json::to_string(record).map_err(|error| failed(error.into()))?;
            text.push('\n');
        }
        let mut file = OpenOptions::new().append(true).open(&self.path).map_err(failed)?;
        file.write_all(text.as_bytes()).map_err(failed)?;
        self.known.extend(records);
        Ok(())
    }
}
