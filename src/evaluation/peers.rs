//! Curves of other programs, from files that they or scripts beside them wrote (docs/EVALUATION.md).

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::sample::{Measure, Sample};

/// One picture of another program, as a JSON object or a row of CSV.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PeerPoint {
    /// The program, with its version and settings: the name of its curve.
    pub name: String,
    /// The scene, named as in our results.
    pub scene: String,
    /// Seed of the run.
    pub seed: u64,
    /// The time budget, processor-seconds.
    pub budget: f64,
    /// Processor-seconds spent.
    pub cpu_seconds: f64,
    /// Seconds by the clock.
    #[serde(default)]
    pub wall_seconds: Option<f64>,
    /// Root mean square error.
    #[serde(default)]
    pub rmse: Option<f64>,
    /// Relative mean square error.
    #[serde(default)]
    pub relmse: Option<f64>,
    /// The same without the worst 0.1 % of pixels.
    #[serde(default)]
    pub relmse_trimmed: Option<f64>,
    /// What the reference's noise adds to `rmse`.
    #[serde(default)]
    pub noise_rmse: Option<f64>,
    /// What the reference's noise adds to `relmse`.
    #[serde(default)]
    pub noise_relmse: Option<f64>,
}

/// A file of peers that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PeersError {
    /// The file cannot be read.
    #[error("cannot read \"{path}\": {source}; check the name and the permissions", path = .path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// The contents are wrong.
    #[error("{place}: {problem}; docs/EVALUATION.md describes the file")]
    Content {
        /// File and line.
        place: String,
        /// What is wrong.
        problem: String,
    },
}

/// Reads curves: a JSON array of points, or CSV with the points' fields as heading.
pub fn read_peers(path: &Path) -> Result<Vec<PeerPoint>, PeersError> {
    let text = std::fs::read_to_string(path).map_err(|source| PeersError::File { path: path.to_owned(), source })?;
    let wrong = |place: String, problem: String| PeersError::Content { place, problem };
    let points: Vec<PeerPoint> = if text.trim_start().starts_with('[') {
        serde_json::from_str(&text).map_err(|error| wrong(path.display().to_string(), error.to_string()))?
    } else {
        csv_points(&text).map_err(|(line, problem)| wrong(format!("{}:{line}", path.display()), problem))?
    };
    for point in &points {
        let times = [point.budget, point.cpu_seconds];
        if times.iter().any(|seconds| !(*seconds > 0.0 && seconds.is_finite())) {
            let place = format!("{}: {} on {}", path.display(), point.name, point.scene);
            return Err(wrong(place, "budget and cpu_seconds must be above 0".to_owned()));
        }
    }
    Ok(points)
}

/// Fields have no quotes and no commas. An error has its line number.
fn csv_points(text: &str) -> Result<Vec<PeerPoint>, (usize, String)> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (_, heading) = lines.next().ok_or((1, "the file is empty".to_owned()))?;
    let names: Vec<&str> = heading.split(',').map(str::trim).collect();
    let point = |(index, line): (usize, &str)| {
        let values: Vec<&str> = line.split(',').map(str::trim).collect();
        if values.len() != names.len() {
            return Err((index + 1, format!("{} values under {} names", values.len(), names.len())));
        }
        let fields = names.iter().zip(values).filter(|(_, value)| !value.is_empty());
        let object: Map<String, Value> = fields.map(|(name, value)| ((*name).to_owned(), cell(name, value))).collect();
        serde_json::from_value(Value::Object(object)).map_err(|error| (index + 1, error.to_string()))
    };
    lines.map(point).collect()
}

/// Numbers as numbers, except where a name is wanted.
fn cell(name: &str, value: &str) -> Value {
    let text = || Value::String(value.to_owned());
    if name == "name" || name == "scene" { text() } else { serde_json::from_str(value).unwrap_or_else(|_| text()) }
}

impl PeerPoint {
    /// The sample of a measure that the other program knows.
    pub fn sample(&self, measure: Measure) -> Option<Sample> {
        let (error, noise) = match measure {
            Measure::Relmse => (self.relmse, self.noise_relmse),
            Measure::RelmseTrimmed => (self.relmse_trimmed, None),
            Measure::Rmse => (self.rmse, self.noise_rmse),
        };
        Some(Sample {
            scene: self.scene.clone(),
            label: self.name.clone(),
            peer: true,
            blind: None,
            theory_rate: None,
            seed: self.seed,
            budget: self.budget,
            cpu_seconds: self.cpu_seconds,
            wall_seconds: self.wall_seconds,
            error: error?,
            noise,
        })
    }
}
