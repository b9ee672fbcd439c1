//! What became better or worse between two results files, beyond the noise of seeds.

use super::record::Record;
use super::sample::{Measure, Sample};
use super::significance::{holm, student_two_sided};

/// How sure and how large a change must be to count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangeRule {
    /// The error that is compared.
    pub measure: Measure,
    /// Probability of one or more false alarms among all cells when nothing changed.
    pub level: f64,
    /// Changes by a smaller share than this do not count, however sure they are.
    pub tolerance: f64,
}

impl Default for ChangeRule {
    fn default() -> Self {
        Self { measure: Measure::Relmse, level: 0.01, tolerance: 0.05 }
    }
}

/// What became of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The error is smaller.
    Better,
    /// The error is larger.
    Worse,
    /// It may have changed, but by no more than seeds or the tolerance explain.
    Same,
    /// Fewer than two seeds in both files together: nothing is known of noise.
    Unknown,
    /// Scene or reference are others.
    OtherScene,
}

/// A scene, a method and a budget that both files have.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// The scene.
    pub scene: String,
    /// The method as its user wrote it.
    pub label: String,
    /// The budget, processor-seconds.
    pub budget: f64,
    /// New error over old error, geometric means over seeds.
    pub ratio: f64,
    /// Probability of such a difference by chance alone, this cell by itself.
    pub probability: f64,
    /// What became of it.
    pub verdict: Verdict,
}

/// Sums over the seeds of one cell in one file, of log errors.
struct Group<'a> {
    records: Vec<&'a Record>,
    logs: Vec<f64>,
}

impl<'a> Group<'a> {
    fn new(records: &'a [Record], like: &Record, measure: Measure) -> Self {
        let same =
            |record: &&Record| (&record.scene, &record.label, record.budget) == (&like.scene, &like.label, like.budget);
        let records: Vec<&Record> = records.iter().filter(same).collect();
        let logs = records.iter().map(|record| Sample::of(record, measure).error.max(f64::MIN_POSITIVE).ln()).collect();
        Self { records, logs }
    }

    fn mean(&self) -> f64 {
        self.logs.iter().sum::<f64>() / self.logs.len() as f64
    }

    fn squares(&self) -> f64 {
        self.logs.iter().map(|log| (log - self.mean()).powi(2)).sum()
    }

    fn freedom(&self) -> usize {
        self.logs.len() - 1
    }
}

/// Compares the cells that both files have, in the order of the new one. The errors' logarithms of a method on a scene are taken to
/// vary alike at all budgets and in both files: Student's t test with that common variance, and Holm's correction for the number of cells.
pub fn changes(old: &[Record], new: &[Record], rule: ChangeRule) -> Vec<Change> {
    let cells = cells(old, new, rule.measure);
    let tested: Vec<(f64, f64)> = cells.iter().map(|cell| test(cell, &cells)).collect();
    let known: Vec<usize> =
        (0..cells.len()).filter(|index| cells[*index].comparable() && tested[*index].1 > 0.0).collect();
    let probabilities: Vec<f64> = known.iter().map(|index| tested[*index].0).collect();
    let counts = holm(&probabilities, rule.level);
    let verdict = |index: usize, ratio: f64| match known.iter().position(|known| *known == index) {
        None if cells[index].comparable() => Verdict::Unknown,
        None => Verdict::OtherScene,
        Some(place) if counts[place] && ratio > 1.0 + rule.tolerance => Verdict::Worse,
        Some(place) if counts[place] && ratio < 1.0 / (1.0 + rule.tolerance) => Verdict::Better,
        Some(_) => Verdict::Same,
    };
    let change = |(index, cell): (usize, &Cell<'_>)| {
        let like = cell.new.records[0];
        let ratio = (cell.new.mean() - cell.old.mean()).exp();
        Change {
            scene: like.scene.clone(),
            label: like.label.clone(),
            budget: like.budget,
            ratio,
            probability: tested[index].0,
            verdict: verdict(index, ratio),
        }
    };
    cells.iter().enumerate().map(change).collect()
}

struct Cell<'a> {
    old: Group<'a>,
    new: Group<'a>,
}

impl Cell<'_> {
    fn comparable(&self) -> bool {
        let hashes = |group: &Group<'_>| {
            let record = group.records[0];
            (record.scene_hash.clone(), record.reference_hash.clone())
        };
        hashes(&self.old) == hashes(&self.new)
    }

    fn same_curve(&self, other: &Self) -> bool {
        let key = |cell: &Self| (cell.new.records[0].scene.clone(), cell.new.records[0].label.clone());
        key(self) == key(other)
    }
}

fn cells<'a>(old: &'a [Record], new: &'a [Record], measure: Measure) -> Vec<Cell<'a>> {
    let mut cells: Vec<Cell<'a>> = Vec::new();
    for record in new {
        let known = cells.iter().any(|cell| cell.new.records.iter().any(|known| std::ptr::eq(*known, record)));
        let old = Group::new(old, record, measure);
        if !known && !old.records.is_empty() {
            cells.push(Cell { old, new: Group::new(new, record, measure) });
        }
    }
    cells
}

/// Probability and degrees of freedom of a cell's difference; 1 and 0 when nothing is known of noise.
fn test(cell: &Cell<'_>, cells: &[Cell<'_>]) -> (f64, f64) {
    let curve = || cells.iter().filter(|other| other.same_curve(cell));
    let freedom: usize = curve().map(|cell| cell.old.freedom() + cell.new.freedom()).sum();
    if freedom == 0 {
        return (1.0, 0.0);
    }
    let variance = curve().map(|cell| cell.old.squares() + cell.new.squares()).sum::<f64>() / freedom as f64;
    let counts = [&cell.old, &cell.new].map(|group| 1.0 / group.logs.len() as f64);
    let difference = (cell.new.mean() - cell.old.mean()).abs();
    let error = (variance * (counts[0] + counts[1])).sqrt();
    // Without any spread every difference is one.
    let t = if difference == 0.0 { 0.0 } else { difference / error };
    (student_two_sided(t, freedom as f64), freedom as f64)
}
