//! What can be wrong with a scene, always with the place and the remedy.

use std::fmt;

/// Where in the user's files something stands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Location {
    /// File name inside the bundle, as the user wrote it.
    pub file: String,
    /// 1-based line; 0 when the format has no lines (for example a dictionary made by a program).
    pub line: u32,
    /// Path in the scene tree, for example `scene/shape[3]/bsdf/reflectance`.
    pub path: String,
}

impl fmt::Display for Location {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.file)?;
        if self.line > 0 {
            write!(formatter, ":{}", self.line)?;
        }
        if !self.path.is_empty() {
            write!(formatter, " ({})", self.path)?;
        }
        Ok(())
    }
}

/// A scene that cannot be rendered: what is wrong, where, and what to do about it.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{location}: {problem}{}", remedy_suffix(.remedy))]
pub struct SceneError {
    /// Where the problem stands.
    pub location: Location,
    /// What is wrong, as a lowercase fragment.
    pub problem: String,
    /// What the user can do, as a lowercase fragment; may be empty.
    pub remedy: String,
}

fn remedy_suffix(remedy: &str) -> String {
    if remedy.is_empty() { String::new() } else { format!("; {remedy}") }
}

impl SceneError {
    /// An error at `location`.
    pub fn new(location: &Location, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { location: location.clone(), problem: problem.into(), remedy: remedy.into() }
    }
}

/// A number as messages write it: with an exponent where it would have more than 20 digits.
pub fn shown_number(number: impl fmt::Display + fmt::LowerExp) -> String {
    const LONGEST: usize = 20;
    let digits = number.to_string();
    if digits.len() > LONGEST { format!("{number:e}") } else { digits }
}

/// Three numbers as messages write them.
pub fn shown_numbers(numbers: [impl fmt::Display + fmt::LowerExp; 3]) -> String {
    numbers.map(shown_number).join(", ")
}

/// The known name closest to `name`, as a remedy: `did you mean "…"?`, or the list of known names when none is close.
pub fn nearest_name(name: &str, known: &[&str]) -> String {
    const LISTED: usize = 20;
    match closest_name(name, known.iter().copied()) {
        Some(candidate) => format!("did you mean \"{candidate}\"?"),
        None if known.is_empty() => "nothing is expected here".to_owned(),
        None if known.len() <= LISTED => format!("known names: {}", known.join(", ")),
        None => format!("known names: {}, … ({} in all)", known[..LISTED].join(", "), known.len()),
    }
}

/// The remedy for a name that nothing defines: the known name closest to it, or, where none is known, how to `define` one.
pub fn nearest_defined_name(name: &str, known: &[&str], define: &str) -> String {
    if known.is_empty() { define.to_owned() } else { nearest_name(name, known) }
}

/// The candidate that `name` is most likely a misspelling of, if any is close.
///
/// Compares with at most 4096 candidates, and long names with none, so that a hostile scene cannot make the message of
/// its error expensive.
pub fn closest_name<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const LONGEST: usize = 256;
    if name.len() > LONGEST {
        return None;
    }
    let short_enough = candidates.into_iter().take(4096).filter(|candidate| candidate.len() <= LONGEST);
    let (distance, candidate) = short_enough.map(|candidate| (edit_distance(name, candidate), candidate)).min()?;
    (distance <= 1 + name.len().max(candidate.len()) / 3).then_some(candidate)
}

/// Levenshtein distance in characters.
fn edit_distance(left: &str, right: &str) -> usize {
    let right: Vec<char> = right.chars().collect();
    let mut row: Vec<usize> = (0..=right.len()).collect();
    for (i, a) in left.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in right.iter().enumerate() {
            let substitution = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = substitution.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[right.len()]
}
