//! How a command ends when it does not succeed: a message naming the place, a hint what to do, and the exit code.

use std::fmt;

/// Why a command did not do what was asked. Printed as `error: …` and `hint: …` on stderr.
#[derive(Debug)]
pub struct Failure {
    message: String,
    hint: Option<String>,
    code: u8,
}

impl Failure {
    /// Bad input or use: exit 2. The message names the place, the hint what would be right.
    pub fn input(message: impl fmt::Display) -> Self {
        Failure { message: message.to_string(), hint: None, code: 2 }
    }

    /// What this program was compiled without: exit 2. The remedy is one that has it.
    #[allow(dead_code, reason = "where nothing is left out nobody asks")]
    pub fn left_out(what: impl fmt::Display, feature: &str) -> Self {
        Failure::input(format!("{what}: this program was compiled without it")).hint(format!(
            "a release's package has it, or compile it in: `cargo install --path tools/cli --features {feature}`"
        ))
    }

    /// Our own failure, or the machine's: exit 1.
    pub fn own(message: impl fmt::Display) -> Self {
        Failure { message: message.to_string(), hint: None, code: 1 }
    }

    /// Another exit code of a command's own.
    pub fn of_code(code: u8, message: impl fmt::Display) -> Self {
        Failure { message: message.to_string(), hint: None, code }
    }

    /// With more to say, on a line of its own.
    pub fn also(mut self, more: impl fmt::Display) -> Self {
        self.message += &format!("\n{more}");
        self
    }

    /// With the remedy.
    pub fn hint(mut self, hint: impl fmt::Display) -> Self {
        self.hint = Some(hint.to_string());
        self
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        self.code
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.message)?;
        match &self.hint {
            Some(hint) => write!(f, "\nhint: {hint}"),
            None => Ok(()),
        }
    }
}

/// What every command returns.
pub type Outcome = Result<(), Failure>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hint_stands_on_its_own_line() {
        let failure = Failure::input("rig.toml:3: unknown key `rat_hz`").hint("did you mean `rate_hz`?");
        assert_eq!(failure.to_string(), "error: rig.toml:3: unknown key `rat_hz`\nhint: did you mean `rate_hz`?");
    }
}
