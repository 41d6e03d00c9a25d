//! What ends the program: in words, with a remedy, and with the exit codes of `sinew`.

use std::fmt;

/// Why it ends.
#[derive(Debug)]
pub struct Failure {
    words: String,
    hint: String,
    code: u8,
}

/// What became of it.
pub type Outcome = Result<(), Failure>;

impl Failure {
    /// Something about what was asked for.
    pub fn input(words: impl fmt::Display) -> Failure {
        Failure { words: words.to_string(), hint: String::new(), code: 2 }
    }

    /// Something that is not the user's doing.
    pub fn own(words: impl fmt::Display) -> Failure {
        Failure { words: words.to_string(), hint: String::new(), code: 1 }
    }

    /// With what to do.
    pub fn hint(self, hint: impl fmt::Display) -> Failure {
        Failure { hint: hint.to_string(), ..self }
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        self.code
    }
}

impl From<sinew_ipc::Error> for Failure {
    fn from(error: sinew_ipc::Error) -> Failure {
        let code = if matches!(error, sinew_ipc::Error::RigName { .. }) { 2 } else { 1 };
        Failure { words: error.message(), hint: error.remedy(), code }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.words)?;
        if self.hint.is_empty() { Ok(()) } else { write!(f, "\nhint: {}", self.hint) }
    }
}
