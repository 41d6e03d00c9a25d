//! Errors of making a figure.

use std::fmt;

/// Why there is no figure.
#[derive(Debug)]
pub enum Error {
    /// A recording cannot be read.
    Recording(sinew_recording::Error),
    /// No recording has such a channel.
    NoChannel {
        /// The one requested.
        name: String,
        /// Those there are.
        known: Vec<String>,
    },
    /// No recording has such a quantity.
    NoQuantity {
        /// The one requested.
        name: String,
        /// Those there are.
        known: Vec<String>,
    },
    /// What a kind of figure needs is not there.
    Lacks {
        /// The kind.
        kind: &'static str,
        /// What it needs.
        needs: &'static str,
        /// Where that would be found.
        remedy: &'static str,
    },
    /// Nothing was recorded in that time, or nothing that can be drawn.
    Nothing,
    /// The picture cannot be made.
    Picture {
        /// In the renderer's words.
        reason: String,
    },
}

impl Error {
    /// What to do about it; empty where the message says it.
    pub fn remedy(&self) -> String {
        match self {
            Error::Recording(error) => error.hint().to_string(),
            Error::NoChannel { known, .. } => format!("its channels are {}", known.join(", ")),
            Error::NoQuantity { known, .. } => format!("recorded are {}", known.join(", ")),
            Error::Lacks { remedy, .. } => (*remedy).into(),
            Error::Nothing => "look at --from, --to and --channel; `sinew recording info` says how long it is".into(),
            Error::Picture { .. } => "write .svg or .html instead".into(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Recording(error) => write!(f, "{error}"),
            Error::NoChannel { name, .. } => write!(f, "no recording has a channel \"{name}\""),
            Error::NoQuantity { name, .. } => write!(f, "no recording has a quantity \"{name}\""),
            Error::Lacks { kind, needs, .. } => {
                write!(f, "a figure of kind {kind} needs {needs}, which no recording has")
            }
            Error::Nothing => write!(f, "there is nothing to draw"),
            Error::Picture { reason } => write!(f, "the picture cannot be made: {reason}"),
        }
    }
}

impl std::error::Error for Error {}
