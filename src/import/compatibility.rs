//! What becomes of every part of a format: the rows of `docs/COMPATIBILITY.md`, which the readers' own tables are.

use std::fmt::Write;

use super::{gltf, mgf, pbrt};

/// How well something is represented.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// As the format says.
    Same,
    /// Wholly or in part by something similar, with a notice.
    Approximated,
    /// Left out: it changes no picture here, or a notice tells.
    PassedOver,
    /// An error, since the picture would be another.
    Refused,
}

impl Support {
    /// Its name in the tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Approximated => "approximated",
            Self::PassedOver => "passed over",
            Self::Refused => "refused",
        }
    }
}

/// One part of a format.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its name in the format.
    pub name: &'static str,
    /// How well it is represented.
    pub support: Support,
    /// What takes its place, or what is lost; may be empty.
    pub remark: &'static str,
}

impl Row {
    /// A row of a table.
    pub(super) const fn new(name: &'static str, support: Support, remark: &'static str) -> Self {
        Self { name, support, remark }
    }
}

/// The tables of all formats that have one, with their titles.
pub fn tables() -> Vec<(&'static str, &'static [Row])> {
    vec![
        ("glTF extensions", gltf::EXTENSIONS),
        ("pbrt-v4 directives", pbrt::DIRECTIVES),
        ("MGF entities", mgf::ENTITIES),
    ]
}

/// The tables as Markdown.
pub fn markdown() -> String {
    let mut text = String::new();
    for (title, rows) in tables() {
        // Writing to a String cannot fail.
        let _ = write!(text, "### {title}\n\n| name | support | remark |\n|---|---|---|\n");
        for Row { name, support, remark } in rows {
            let _ = writeln!(text, "| `{name}` | {} | {remark} |", support.name());
        }
        text.push('\n');
    }
    text
}

/// Whether a table has a name.
pub(super) fn has(rows: &[Row], name: &str) -> bool {
    rows.iter().any(|row| row.name == name)
}

/// The names of a table.
pub(super) fn names(rows: &'static [Row]) -> Vec<&'static str> {
    rows.iter().map(|row| row.name).collect()
}
