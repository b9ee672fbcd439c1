//! A pbrt file as tokens.

use super::super::values::shown;
use crate::scene::error::{Location, SceneError};

/// One token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// A directive, a number, `true` or `false`.
    Word(&'a str),
    /// A string, without its quotes.
    Quoted(String),
    /// `[`
    Open,
    /// `]`
    Close,
}

impl Token<'_> {
    /// What it looks like, for an error.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Word(word) => shown(word),
            Self::Quoted(text) => format!("the string {}", shown(text)),
            Self::Open => "\"[\"".to_owned(),
            Self::Close => "\"]\"".to_owned(),
        }
    }
}

/// What is left of a file.
#[derive(Clone)]
pub(super) struct Tokens<'a> {
    file: &'a str,
    rest: &'a str,
    /// 1-based line of `rest`.
    line: u32,
}

impl<'a> Tokens<'a> {
    /// The tokens of `text`, which stands in `file`.
    pub(super) fn new(file: &'a str, text: &'a str) -> Self {
        Self { file, rest: text.strip_prefix('\u{feff}').unwrap_or(text), line: 1 }
    }

    /// The place of the token that comes next; `directive` is what it belongs to.
    pub(super) fn place(&mut self, directive: &str) -> Location {
        self.skip_gap();
        Location { file: self.file.to_owned(), line: self.line, path: directive.chars().take(40).collect() }
    }

    /// Takes the next token; nothing at the end.
    ///
    /// # Errors
    /// When a string has no end on its line.
    pub(super) fn next(&mut self) -> Result<Option<Token<'a>>, SceneError> {
        self.skip_gap();
        let Some(first) = self.rest.chars().next() else { return Ok(None) };
        let is_end = |letter: char| letter.is_whitespace() || matches!(letter, '"' | '[' | ']' | '#');
        let (token, length) = match first {
            '[' => (Token::Open, 1),
            ']' => (Token::Close, 1),
            '"' => self.quoted()?,
            _ => {
                let length = self.rest.find(is_end).unwrap_or(self.rest.len());
                (Token::Word(&self.rest[..length]), length)
            }
        };
        self.rest = &self.rest[length..];
        Ok(Some(token))
    }

    /// Takes the next token if it is a string.
    pub(super) fn next_if_quoted(&mut self) -> Result<Option<String>, SceneError> {
        self.skip_gap();
        if !self.rest.starts_with('"') {
            return Ok(None);
        }
        Ok(match self.next()? {
            Some(Token::Quoted(text)) => Some(text),
            _ => None,
        })
    }

    /// Takes the next token if it is `[`.
    pub(super) fn next_if_open(&mut self) -> bool {
        self.skip_gap();
        let rest = self.rest.strip_prefix('[');
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn skip_gap(&mut self) {
        loop {
            let trimmed = self.rest.trim_start();
            let skipped = &self.rest[..self.rest.len() - trimmed.len()];
            self.line += skipped.bytes().filter(|byte| *byte == b'\n').count() as u32;
            self.rest = trimmed;
            if !trimmed.starts_with('#') {
                return;
            }
            self.rest = &trimmed[trimmed.find('\n').unwrap_or(trimmed.len())..];
        }
    }

    /// A string and its length with quotes, bytes.
    fn quoted(&mut self) -> Result<(Token<'a>, usize), SceneError> {
        let mut text = String::new();
        let mut letters = self.rest.char_indices().skip(1);
        while let Some((index, letter)) = letters.next() {
            match letter {
                '"' => return Ok((Token::Quoted(text), index + 1)),
                '\n' => break,
                '\\' => match letters.next() {
                    Some((_, 'n')) => text.push('\n'),
                    Some((_, 't')) => text.push('\t'),
                    Some((_, 'r')) => text.push('\r'),
                    Some((_, other)) => text.push(other),
                    None => break,
                },
                _ => text.push(letter),
            }
        }
        let problem = format!("the string {} has no end", shown(&text));
        Err(SceneError::new(&self.place(""), problem, "close it with a \" on the same line"))
    }
}
