//! The envelope an answer is in. It is no secret: Base64 keeps a glance from reading it, and nothing keeps anybody from decoding it.
//! What it does: its seal, the SHA-256 of what is in it, shows whoever wrote the seal down that nothing was changed afterwards, neither
//! the answer nor the files it belongs to.

use std::collections::BTreeMap;
use std::fmt;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::generator::case::Answer;

/// First word of an envelope.
const SCHEMA: &str = "sinew.sealed/1";
const SAYS: &str =
    "# An envelope, no secret: what is hidden in the recordings beside it, in Base64. `sinew reveal` opens it.";
/// Characters of a line.
const LINE: usize = 100;

/// What is in an envelope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sealed {
    /// What is concealed.
    pub answer: Answer,
    /// SHA-256 of the files it is concealed in, by name.
    pub files: BTreeMap<String, String>,
}

/// Why an envelope cannot be opened.
#[derive(Debug, PartialEq, Eq)]
pub enum Broken {
    /// It is none.
    NoEnvelope,
    /// What is in it is not what was sealed.
    Changed {
        /// The seal on it.
        seal: String,
        /// That of what is in it.
        found: String,
    },
    /// What is in it is sealed, and is no answer.
    NoAnswer {
        /// Why.
        reason: String,
    },
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Broken::NoEnvelope => write!(f, "is no sealed answer: it does not begin with `{SCHEMA}` and its seal"),
            Broken::Changed { seal, found } => {
                write!(f, "was changed after it was sealed: its seal is {seal}, what is in it has {found}")
            }
            Broken::NoAnswer { reason } => write!(f, "holds no answer: {reason}"),
        }
    }
}

impl std::error::Error for Broken {}

/// SHA-256 in hexadecimal digits.
fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Sealed {
    /// The envelope as the text of a file, and its seal.
    ///
    /// # Errors
    /// Of the answer's JSON.
    pub fn seal(&self) -> Result<(String, String), serde_json::Error> {
        let json = serde_json::to_vec(self)?;
        let seal = sha256(&json);
        let letters = STANDARD.encode(&json);
        let mut text = format!("{SCHEMA} {seal}\n{SAYS}\n");
        let mut rest = letters.as_str();
        while !rest.is_empty() {
            let (line, more) = rest.split_at(LINE.min(rest.len()));
            text += line;
            text.push('\n');
            rest = more;
        }
        Ok((text, seal))
    }

    /// Opens an envelope: what is in it, and its seal.
    ///
    /// # Errors
    /// It is none, or was changed.
    pub fn open(text: &str) -> Result<(Sealed, String), Broken> {
        let (head, rest) = text.split_once('\n').ok_or(Broken::NoEnvelope)?;
        let seal = head.strip_prefix(SCHEMA).ok_or(Broken::NoEnvelope)?.trim();
        let letters: String = rest.lines().filter(|line| !line.starts_with('#')).map(str::trim).collect();
        // letters that are no Base64 are not what was sealed, either
        let json = STANDARD.decode(&letters).unwrap_or_else(|_| letters.clone().into_bytes());
        let found = sha256(&json);
        if found != seal {
            return Err(Broken::Changed { seal: seal.to_string(), found });
        }
        let sealed = serde_json::from_slice(&json).map_err(|error| Broken::NoAnswer { reason: error.to_string() })?;
        Ok((sealed, seal.to_string()))
    }
}
