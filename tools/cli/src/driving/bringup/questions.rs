//! What a person at the bench is asked, and answers: on a terminal, or by lines of a pipe. Waiting for an answer keeps nobody from ending it.

use std::io::IsTerminal as _;
use std::time::Duration;

use crate::driving::typed::Lines;
use crate::failure::Failure;
use crate::output;

/// How often it is looked whether somebody has asked for the end meanwhile.
const LOOK: Duration = Duration::from_millis(50);

/// An answer that is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
    /// Enter alone: done, go on.
    Done,
    /// Go on all the same.
    Skip,
    /// The end.
    Quit,
}

/// Answers as they come.
#[derive(Debug, Default)]
pub struct Questions {
    lines: Lines,
}

impl Questions {
    /// Asks somebody to do something; `id` names the question for whoever answers by a program.
    pub fn ask(&mut self, id: &str, text: &str, over: &dyn Fn() -> bool) -> Result<Word, Failure> {
        loop {
            output::print(format_args!("\n[{id}] {text} "))?;
            match self.line(over)?.as_deref().map(str::trim) {
                None | Some("q" | "quit") => return Ok(Word::Quit),
                Some("") => return Ok(Word::Done),
                Some("s" | "skip") => return Ok(Word::Skip),
                Some(other) => output::print(format_args!("{other}: Enter, s or q\n"))?,
            }
        }
    }

    /// Asks for a number above 0; `None` where nobody has one.
    pub fn number(&mut self, id: &str, text: &str, over: &dyn Fn() -> bool) -> Result<Option<f64>, Failure> {
        loop {
            output::print(format_args!("\n[{id}] {text} "))?;
            let Some(line) = self.line(over)? else { return Ok(None) };
            // a unit behind it says what is known
            let digits = line.trim().trim_end_matches(['V', 'Ω', ' ']).replace(',', ".");
            match digits.parse::<f64>() {
                _ if digits.is_empty() => return Ok(None),
                Ok(number) if number.is_finite() && number >= 0.0 => return Ok(Some(number)),
                _ => output::print(format_args!("{}: a number is wanted, such as 6.48\n", line.trim()))?,
            }
        }
    }

    /// Whether nobody will answer any more.
    pub fn is_at_end(&self) -> bool {
        self.lines.is_at_end()
    }

    /// The next line; `None` at the end of all.
    fn line(&mut self, over: &dyn Fn() -> bool) -> Result<Option<String>, Failure> {
        loop {
            let next = self.lines.next(LOOK);
            if let Some(line) = next.map_err(|error| Failure::own(format!("stdin: {error}")))? {
                if !std::io::stdin().is_terminal() {
                    // nobody has typed it
                    output::print("\n")?;
                }
                return Ok(Some(line));
            }
            if over() {
                return Err(Failure::own("the bring-up was ended; outputs are at zero"));
            }
            if self.lines.is_at_end() {
                return Ok(None);
            }
        }
    }
}
