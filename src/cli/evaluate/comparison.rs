//! `evaluate --compare`: what became better and what worse.

use std::collections::BTreeSet;
use std::path::Path;

use crate::cli::exit_code::CliError;
use crate::cli::terminal;
use crate::evaluation::{Change, ChangeRule, Record, Verdict, changes, read_results};

/// Prints a table of changes. An error when anything is worse.
pub(super) fn run(old: &Path, new: &Path, rule: ChangeRule) -> Result<(), CliError> {
    let possible = rule.level > 0.0 && rule.level < 1.0 && rule.tolerance >= 0.0 && rule.tolerance.is_finite();
    if !possible {
        let text = format!("--level {} and --tolerance {}; give a probability and a share", rule.level, rule.tolerance);
        return Err(CliError::Usage(text));
    }
    let (old_records, new_records) = (read_results(old)?, read_results(new)?);
    let found = changes(&old_records, &new_records, rule);
    if found.is_empty() {
        let text = format!("\"{}\" and \"{}\" have no cell in common", old.display(), new.display());
        return Err(CliError::BadInput(format!("{text}; evaluate the same scenes, methods and budgets")));
    }
    note_other_machines(&old_records, &new_records);
    terminal::result(&table(&found, rule))?;
    let count = |verdict| found.iter().filter(|change| change.verdict == verdict).count();
    let [better, worse, same] = [Verdict::Better, Verdict::Worse, Verdict::Same].map(count);
    let unclear = found.len() - better - worse - same;
    terminal::note(&format!("{better} better, {worse} worse, {same} without change, {unclear} not comparable"));
    match worse {
        0 => Ok(()),
        _ => Err(CliError::Worse(format!("{worse} cells are worse than in \"{}\"", old.display()))),
    }
}

/// Processor-seconds of two machines are not the same.
fn note_other_machines(old: &[Record], new: &[Record]) {
    let machines = |records: &[Record]| -> BTreeSet<String> {
        records.iter().map(|record| format!("{}, {} cores", record.machine.processor, record.machine.cores)).collect()
    };
    let (old, new) = (machines(old), machines(new));
    if old != new {
        let list = |names: BTreeSet<String>| names.into_iter().collect::<Vec<_>>().join("; ");
        terminal::note(&format!(
            "note: the machines differ ({} and {}): changes may be theirs and not the program's",
            list(old),
            list(new)
        ));
    }
}

fn table(found: &[Change], rule: ChangeRule) -> String {
    let mut lines = vec![
        format!("| scene | method | seconds | new/old {} | probability | verdict |", rule.measure.title()),
        "|---|---|---:|---:|---:|---|".to_owned(),
    ];
    lines.extend(found.iter().map(|change| {
        let verdict = match change.verdict {
            Verdict::Better => "better",
            Verdict::Worse => "WORSE",
            Verdict::Same => "same",
            Verdict::Unknown => "unknown: one seed",
            Verdict::OtherScene => "other scene or reference",
        };
        let Change { scene, label, budget, ratio, probability, .. } = change;
        format!("| {scene} | {label} | {budget} | {ratio:.3} | {probability:.1e} | {verdict} |")
    }));
    lines.join("\n")
}
