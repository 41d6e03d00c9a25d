//! What can be wrong with a rig file, said with its place and what would be right.

use std::fmt;

/// A rig file that cannot be used. Every case is bad input: a program that meets it should exit with 2.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// The file could not be read at all.
    Unreadable {
        /// The file, as it was asked for.
        file: String,
        /// The operating system's reason.
        reason: String,
    },
    /// The file was read and is wrong in at least one place; all places are listed, in the order of their lines.
    Invalid {
        /// Every mistake found, never empty.
        problems: Vec<Problem>,
    },
}

impl Error {
    /// The mistakes found; empty when the file could not be read.
    pub fn problems(&self) -> &[Problem] {
        match self {
            Error::Unreadable { .. } => &[],
            Error::Invalid { problems } => problems,
        }
    }
}

/// Mistakes printed at once. A file of another kind has one in every line.
const MOST_SHOWN: usize = 30;

impl fmt::Display for Error {
    /// One line per mistake.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Unreadable { file, reason } => write!(f, "{file}: cannot be read: {reason}"),
            Error::Invalid { problems } => {
                for (i, problem) in problems.iter().take(MOST_SHOWN).enumerate() {
                    if i > 0 {
                        writeln!(f)?;
                    }
                    write!(f, "{problem}")?;
                }
                match problems.len().saturating_sub(MOST_SHOWN) {
                    0 => Ok(()),
                    more => write!(f, "\nand {more} more"),
                }
            }
        }
    }
}

impl std::error::Error for Error {}

/// One mistake in a rig file and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The file, as it was asked for.
    pub file: String,
    /// Line, counted from 1: of the key, or of the nearest table header where the key is not written.
    pub line: usize,
    /// The channel it concerns, by name or, where that is the trouble, by its place ("#2").
    pub channel: Option<String>,
    /// The key with its table, such as `material.latent_heat_j_per_kg`; empty for a mistake of syntax.
    pub key: String,
    /// What is wrong.
    pub what: What,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: ", self.file, self.line)?;
        if let Some(channel) = &self.channel {
            write!(f, "channel \"{channel}\": ")?;
        }
        if self.key.is_empty() { write!(f, "{}", self.what) } else { write!(f, "{} {}", self.key, self.what) }
    }
}

/// The kinds of mistake, each with what was found and what would be right.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// Not TOML.
    Syntax {
        /// The parser's words.
        message: String,
    },
    /// A key or table that does not exist.
    Unknown {
        /// What it was probably meant to be.
        hint: String,
    },
    /// A key that has to be there and is not.
    Missing {
        /// What to write.
        expected: String,
    },
    /// A value of another kind than the key takes.
    WrongType {
        /// The kind found.
        found: String,
        /// The kind expected.
        expected: String,
    },
    /// A number outside its range, in the key's unit.
    OutOfRange {
        /// The value found.
        found: f64,
        /// Least value allowed.
        low: f64,
        /// Largest value allowed.
        high: f64,
        /// Whether the value is the default, not written in the file.
        defaulted: bool,
    },
    /// A NaN or an infinity.
    NotFinite {
        /// As written.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// A word that is none of the choices.
    NotAChoice {
        /// As written.
        found: String,
        /// The choices, with a suggestion where one is near.
        expected: String,
    },
    /// A name that is used twice.
    Duplicate {
        /// The name.
        name: String,
        /// Line of the first use.
        first_line: usize,
    },
    /// A name that cannot be one.
    BadName {
        /// As written.
        found: String,
        /// The rule.
        expected: String,
    },
    /// A key that makes no sense beside another.
    Contradiction {
        /// What stands against what, and the remedy.
        message: String,
    },
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            What::Syntax { message } => write!(f, "{message}"),
            What::Unknown { hint } => write!(f, "is unknown{hint}"),
            What::Missing { expected } => write!(f, "is missing, expected {expected}"),
            What::WrongType { found, expected } => write!(f, "is {found}, expected {expected}"),
            What::OutOfRange { found, low, high, defaulted } => {
                let default = if *defaulted { " (the default)" } else { "" };
                write!(f, "is {}{default}, expected {} to {}", Plain(*found), Plain(*low), Plain(*high))
            }
            What::NotFinite { found, expected } => write!(f, "is {found}, expected {expected}"),
            What::NotAChoice { found, expected } => write!(f, "is \"{found}\", expected {expected}"),
            What::Duplicate { name, first_line } => {
                write!(f, "\"{name}\" is used twice, first in line {first_line}; expected a name of its own")
            }
            What::BadName { found, expected } => write!(f, "is \"{found}\", expected {expected}"),
            What::Contradiction { message } => write!(f, "{message}"),
        }
    }
}

/// A number as one would write it: with an exponent only where there would be a row of zeros.
pub(crate) struct Plain(pub f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && !(1e-6..1e15).contains(&size) { write!(f, "{:e}", self.0) } else { write!(f, "{}", self.0) }
    }
}
