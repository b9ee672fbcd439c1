//! One HTML file with all charts, a table, and the pictures side by side. It needs nothing else, neither files nor network.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::canvas::{CanvasError, to_svg};
use super::scale::number;
use super::{ChartData, ChartKind};
use crate::evaluation::curves::{Curve, Spread};
use crate::evaluation::record::Record;

/// Placeholders `{{…}}` stand where this file's functions put text.
const TEMPLATE: &str = include_str!("report.html");

/// A report that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A chart cannot be drawn.
    #[error(transparent)]
    Canvas(#[from] CanvasError),
    /// A picture that the results name is missing.
    #[error("cannot read \"{path}\": {source}; keep the pictures' folder beside the results", path = .path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
}

/// The report on `records`, whose pictures are below `folder`.
pub fn report(data: &ChartData, records: &[Record], folder: &Path) -> Result<String, ReportError> {
    let mut html = TEMPLATE.to_owned();
    let mut put = |name: &str, text: &str| html = html.replacen(&format!("{{{{{name}}}}}"), text, 1);
    put("facts", &facts(records));
    for kind in ChartKind::ALL {
        put(kind.name(), &to_svg(&data.draw(kind))?);
    }
    put("table", &table(data, records));
    // Last, since pictures are long.
    put("pictures", &pictures(records, folder)?);
    Ok(html)
}

/// Text in which nothing is markup.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

fn facts(records: &[Record]) -> String {
    let mut lines: Vec<String> = Vec::new();
    for record in records {
        let Record { version, machine, threads, .. } = record;
        let threads = if *threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") };
        let line = format!("photonfarm {version}, {threads} of {}", machine.processor);
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    escaped(&lines.join("; "))
}

const HEADINGS: [&str; 13] = [
    "scene",
    "method",
    "s",
    "passes",
    "error",
    "smallest",
    "largest",
    "mean bias",
    "worst block",
    "SSIM",
    "FLIP",
    "rate",
    "theory",
];

fn table(data: &ChartData, records: &[Record]) -> String {
    let mut html = "<thead><tr>".to_owned();
    for heading in HEADINGS {
        let heading = if heading == "error" { data.measure.title() } else { heading };
        html += &format!("<th>{heading}</th>");
    }
    html += "</tr></thead><tbody>";
    for curve in &data.curves {
        let cells = row(curve, records).map(|cell| format!("<td>{}</td>", escaped(&cell)));
        html += &format!("<tr>{}</tr>", cells.concat());
    }
    html + "</tbody>"
}

/// A curve's last point; medians over seeds.
fn row(curve: &Curve, records: &[Record]) -> [String; 13] {
    let Some(last) = curve.points.last() else { return HEADINGS.map(|_| String::new()) };
    let of_point = || {
        records.iter().filter(|record| {
            (&record.scene, &record.label, record.budget) == (&curve.scene, &curve.label, last.budget) && !curve.peer
        })
    };
    let median = |value: &dyn Fn(&Record) -> Option<f64>, text: &dyn Fn(f64) -> String| {
        Spread::of(of_point().filter_map(value)).map_or("–".to_owned(), |spread| text(spread.median))
    };
    let percent = |value: f64| format!("{:+.2} %", 100.0 * value);
    let blind = if curve.blind.is_some() { " °" } else { "" };
    [
        curve.scene.clone(),
        format!("{}{blind}", curve.label),
        number(last.cpu_seconds),
        median(&|record| Some(f64::from(record.passes)), &number),
        format!("{:.2e}", last.error.median),
        format!("{:.2e}", last.error.low),
        format!("{:.2e}", last.error.high),
        median(&|record| Some(record.metrics.bias), &percent),
        median(&|record| Some(record.metrics.block_bias_max), &|value| format!("{:.1} %", 100.0 * value)),
        median(&|record| record.metrics.ssim, &|value| format!("{value:.4}")),
        median(&|record| Some(record.metrics.flip), &|value| format!("{value:.4}")),
        curve.slope.map_or("–".to_owned(), |slope| format!("{:.2}", slope.median)),
        curve.theory_rate.map_or("–".to_owned(), |rate| format!("{rate:.2}")),
    ]
}

/// For each scene the pictures as a JSON array of `{scene, label, data}`; the reference comes first.
fn pictures(records: &[Record], folder: &Path) -> Result<String, ReportError> {
    let mut seen: Vec<&str> = Vec::new();
    let mut json = Vec::new();
    for record in records {
        let both = [("reference", &record.reference_picture), (record.label.as_str(), &record.picture)];
        for (label, file) in both {
            let Some(file) = file.as_deref().filter(|file| !seen.contains(file)) else { continue };
            seen.push(file);
            let path = folder.join(file);
            let bytes = std::fs::read(&path).map_err(|source| ReportError::Picture { path, source })?;
            let entry = serde_json::json!({"scene": record.scene, "label": label, "data": STANDARD.encode(bytes)});
            json.push(entry.to_string());
        }
    }
    // Inside a script element only "</" could end it; JSON may write it so.
    Ok(format!("[{}]", json.join(",\n").replace("</", "<\\/")))
}
