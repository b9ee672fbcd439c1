//! An MGF file as lines of words, and what a line's words must be.

use super::super::values::shown;
use crate::scene::bundle::text_of;
use crate::scene::error::{Location, SceneError, shown_number};

/// The text of one file, cut into entities.
pub(super) struct Text {
    /// The name inside of the bundle.
    pub name: String,
    text: String,
    /// 1-based number of the first line and the range of bytes of every entity.
    lines: Vec<(u32, std::ops::Range<usize>)>,
}

impl Text {
    /// Cuts a file into entities: one a line, continued where a line ends in a backslash. Comments and empty lines are
    /// left out.
    pub(super) fn new(name: &str, bytes: &[u8]) -> Self {
        // The format is ASCII; comments in other encodings do no harm.
        let text = text_of(bytes).into_owned();
        let mut lines = Vec::new();
        let (mut number, mut start) = (0, 0);
        let mut open: Option<(u32, usize)> = None;
        while start < text.len() {
            number += 1;
            let end = text[start..].find('\n').map_or(text.len(), |length| start + length);
            let (first, begin) = open.unwrap_or((number, start));
            let continued = text[start..end].trim_end_matches('\r').ends_with('\\');
            open = continued.then_some((first, begin));
            if !continued {
                lines.push((first, begin..end));
            }
            start = end + 1;
        }
        // A file that ends in a backslash.
        lines.extend(open.map(|(first, begin)| (first, begin..text.len())));
        lines.retain(|(_, range)| !matches!(text[range.clone()].trim_start().chars().next(), None | Some('#')));
        Self { name: name.to_owned(), text, lines }
    }

    /// The entity at `index`, if there are so many.
    pub(super) fn entity(&self, index: usize) -> Option<Entity<'_>> {
        let (line, range) = self.lines.get(index)?;
        let is_gap = |letter: char| letter.is_whitespace() || letter == '\0';
        // A backslash counts as a gap only at the end of a line.
        let pieces = self.text[range.clone()].split('\n').map(|piece| piece.trim_end_matches('\r'));
        let words = pieces.flat_map(|piece| piece.strip_suffix('\\').unwrap_or(piece).split(is_gap));
        let mut words = words.filter(|word| !word.is_empty());
        let keyword = words.next().unwrap_or_default();
        Some(Entity { keyword, words: words.collect(), file: &self.name, line: *line })
    }

    /// How many bytes it has.
    pub(super) fn size(&self) -> usize {
        self.text.len()
    }
}

/// One entity: a keyword and its arguments.
pub(super) struct Entity<'a> {
    pub keyword: &'a str,
    pub words: Vec<&'a str>,
    file: &'a str,
    line: u32,
}

impl<'a> Entity<'a> {
    /// Where it stands.
    pub(super) fn location(&self) -> Location {
        let keyword = self.keyword.chars().take(40).collect();
        Location { file: self.file.to_owned(), line: self.line, path: keyword }
    }

    /// An error at this entity.
    pub(super) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(&self.location(), problem, remedy)
    }

    /// An error unless it has between `least` and `most` arguments; `form` is how it is written.
    pub(super) fn check_count(&self, least: usize, most: usize, form: &str) -> Result<(), SceneError> {
        if (least..=most).contains(&self.words.len()) {
            return Ok(());
        }
        let problem = format!("\"{}\" has {} arguments", self.keyword, self.words.len());
        Err(self.error(problem, format!("write \"{form}\"")))
    }

    /// The argument at `index`; empty when there are fewer.
    pub(super) fn word(&self, index: usize) -> &'a str {
        self.words.get(index).copied().unwrap_or_default()
    }

    /// A finite number.
    pub(super) fn number(&self, index: usize) -> Result<f64, SceneError> {
        let word = self.word(index);
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => {
                Err(self.error(format!("{} is not a finite number", shown(word)), "write a number such as 0.5 or 1e-3"))
            }
        }
    }

    /// A finite number that is not negative.
    pub(super) fn amount(&self, index: usize) -> Result<f64, SceneError> {
        let number = self.number(index)?;
        if number >= 0.0 {
            return Ok(number);
        }
        Err(self.error(format!("{} is negative", shown_number(number)), "give a number of at least 0"))
    }

    /// Three finite numbers from `first` on.
    pub(super) fn triple(&self, first: usize) -> Result<glam::DVec3, SceneError> {
        Ok(glam::DVec3::new(self.number(first)?, self.number(first + 1)?, self.number(first + 2)?))
    }
}
