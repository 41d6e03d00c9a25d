//! What can be wrong with a formula or a unit, and where.

use std::fmt;
use std::ops::Range;

/// Bytes of the text that an error is about.
pub type Place = Range<usize>;

/// What is wrong with a formula or a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// Where in the text, in bytes: on the borders of characters, and inside it.
    pub at: Place,
    /// What, and what to do about it.
    pub what: String,
}

impl Error {
    pub(crate) fn new(at: Place, what: impl Into<String>) -> Error {
        Error { at, what: what.into() }
    }

    /// The text with its place marked, as two lines.
    pub fn marked(&self, text: &str) -> String {
        let before = text.get(..self.at.start).map_or(0, |before| before.chars().count());
        let marked = text.get(self.at.clone()).map_or(1, |there| there.chars().count().max(1));
        let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        format!("{line}\n{}{}", " ".repeat(before), "^".repeat(marked))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_marked_by_characters_and_not_by_bytes() {
        let error = Error::new(5..6, "what is this?");
        assert_eq!(error.marked("2 µ$ 3"), "2 µ$ 3\n    ^");
    }
}
