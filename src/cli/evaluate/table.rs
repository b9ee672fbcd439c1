//! The table of an evaluation, in Markdown.

use crate::evaluation::{Curve, Measure, Spread};

/// One row for each scene and method: the error at its largest budget, and how fast it fell.
pub(super) fn of(curves: &[Curve], measure: Measure) -> String {
    let mut lines = vec![
        format!("| scene | method | seconds | {} | seeds | fitted rate | theory | |", measure.title()),
        "|---|---|---:|---:|---:|---:|---:|---|".to_owned(),
    ];
    lines.extend(curves.iter().filter_map(row));
    lines.join("\n")
}

fn row(curve: &Curve) -> Option<String> {
    let last = curve.points.last()?;
    let Spread { median, low, high, count } = last.error;
    let slope = curve
        .slope
        .map_or("–".to_owned(), |slope| format!("{:.2} ({:.2} to {:.2})", slope.median, slope.low, slope.high));
    let theory = curve.theory_rate.map_or("–".to_owned(), |rate| format!("{rate:.2}"));
    let blind = if curve.blind.is_some() { "blind" } else { "" };
    Some(format!(
        "| {} | {} | {:.1} | {median:.3e} ({low:.2e} to {high:.2e}) | {count} | {slope} | {theory} | {blind} |",
        curve.scene, curve.label, last.cpu_seconds
    ))
}
