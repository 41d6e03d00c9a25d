//! A file that cannot be used, said with its place and the remedy.

use std::fmt;

/// Why a foreign file cannot be used. Shown as `FILE:LINE: message; hint`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// The file, as it was given.
    pub file: String,
    /// Line of a text, row of a spreadsheet, counted from 1.
    pub line: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: String,
}

impl Error {
    /// Of a file whose name is put in by whoever knows it.
    pub(crate) fn new(message: impl Into<String>, hint: impl Into<String>) -> Error {
        Error { file: String::new(), line: None, message: message.into(), hint: hint.into() }
    }

    pub(crate) fn at(mut self, line: usize) -> Error {
        self.line = Some(line);
        self
    }

    pub(crate) fn of(mut self, file: &str) -> Error {
        self.file = file.to_string();
        self
    }

    /// Place and trouble, without the remedy.
    pub fn place_and_message(&self) -> String {
        match self.line {
            Some(line) => format!("{}:{line}: {}", self.file, self.message),
            None => format!("{}: {}", self.file, self.message),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.place_and_message(), self.hint)
    }
}

impl std::error::Error for Error {}

/// A word of a file, fit for a message: printable, and not too long.
pub(crate) fn shorten(word: &str) -> String {
    let mut short: String = word.chars().take(40).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if word.chars().nth(40).is_some() {
        short.push('…');
    }
    short
}
