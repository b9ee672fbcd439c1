//! `chart`: results of `evaluate` as pictures.

use std::path::{Path, PathBuf};

use clap::Args;

use super::evaluate::measure;
use super::exit_code::CliError;
use crate::estimate::picture_files::{check_writable, write_file};
use crate::evaluation::chart::{CanvasError, ChartData, ChartKind, Drawing, ReportError, report, to_png, to_svg};
use crate::evaluation::{Measure, read_peers, read_results};

/// Draw results of `evaluate`.
///
/// A report (.html) holds all charts, a table and the pictures that `evaluate --pictures` kept; an .svg or .png holds one chart.
#[derive(Clone, Debug, Args)]
pub(super) struct Chart {
    /// Results file, JSON lines.
    results: PathBuf,
    /// Curves of other programs, JSON or CSV. May be repeated.
    #[arg(long, value_name = "FILE")]
    peers: Vec<PathBuf>,
    /// File to write, .html, .svg or .png. May be repeated.
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,
    /// Which chart an .svg or .png shows: error (against time), time (to an error) or best (method of each scene).
    #[arg(long, default_value = "error", value_parser = kind)]
    kind: ChartKind,
    /// The error that charts show: relmse, relmse_trimmed or rmse.
    #[arg(long, default_value = "relmse", value_parser = measure)]
    measure: Measure,
    /// The error of the chart of times.
    #[arg(long, default_value_t = 0.01)]
    target: f64,
}

/// What a file holds, by the end of its name.
enum Format {
    Html,
    Drawing(Encoder),
}

/// Makes a file of a drawing.
pub(super) type Encoder = fn(&Drawing) -> Result<Vec<u8>, CanvasError>;

impl Chart {
    pub(super) fn run(self) -> Result<(), CliError> {
        if !(self.target > 0.0 && self.target.is_finite()) {
            return Err(CliError::Usage(format!("--target is {}; give a number above 0", self.target)));
        }
        let formats = self.outputs.iter().map(|path| format(path)).collect::<Result<Vec<_>, _>>()?;
        for path in &self.outputs {
            check_writable(path)?;
        }
        let records = read_results(&self.results)?;
        let peers = self.peers.iter().map(|path| read_peers(path)).collect::<Result<Vec<_>, _>>()?.concat();
        if records.is_empty() && peers.is_empty() {
            return Err(CliError::BadInput(format!("\"{}\" has no results yet", self.results.display())));
        }
        let data = ChartData::new(&records, &peers, self.measure, self.target);
        for (path, format) in self.outputs.iter().zip(formats) {
            let bytes = match format {
                Format::Html => {
                    let folder = self.results.parent().unwrap_or(Path::new(""));
                    report(&data, &records, folder)?.into_bytes()
                }
                Format::Drawing(encode) => encode(&data.draw(self.kind)).map_err(CliError::failed)?,
            };
            write_file(path, &bytes)?;
        }
        Ok(())
    }
}

impl From<ReportError> for CliError {
    fn from(error: ReportError) -> Self {
        match error {
            ReportError::Picture { .. } => Self::File(error.to_string()),
            ReportError::Canvas(error) => Self::failed(error),
        }
    }
}

fn format(path: &Path) -> Result<Format, CliError> {
    if path.extension().is_some_and(|extension| extension == "html") {
        return Ok(Format::Html);
    }
    drawing_encoder(path).map(Format::Drawing).ok_or_else(|| {
        let text = format!("\"{}\" does not say what it is; end the name in .html, .svg or .png", path.display());
        CliError::Usage(text)
    })
}

/// What the end of a file's name asks for; `None` where that is no drawing.
pub(super) fn drawing_encoder(path: &Path) -> Option<Encoder> {
    match path.extension()?.to_str()? {
        "svg" => Some(|drawing| to_svg(drawing).map(String::into_bytes)),
        "png" => Some(to_png),
        _ => None,
    }
}

fn kind(name: &str) -> Result<ChartKind, String> {
    let known = || ChartKind::ALL.map(ChartKind::name).join(", ");
    ChartKind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| format!("known charts: {}", known()))
}
