//! What a person at the bench is asked, and answers: on a terminal, or by lines of a pipe. Waiting for an answer keeps nobody from ending it.

use std::io::IsTerminal as _;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};

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
    held: Vec<u8>,
    is_at_end: bool,
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
        self.is_at_end
    }

    /// The next line; `None` at the end of all.
    fn line(&mut self, over: &dyn Fn() -> bool) -> Result<Option<String>, Failure> {
        loop {
            if let Some(end) = self.held.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.held.drain(..=end).collect();
                if !std::io::stdin().is_terminal() {
                    // nobody has typed it
                    output::print("\n")?;
                }
                return Ok(Some(String::from_utf8_lossy(&line).trim_end().to_string()));
            }
            if over() {
                return Err(Failure::own("the bring-up was ended; outputs are at zero"));
            }
            if self.is_at_end {
                return Ok(None);
            }
            let stdin = std::io::stdin();
            let wait = Timespec { tv_sec: 0, tv_nsec: LOOK.subsec_nanos().into() };
            match poll(&mut [PollFd::new(&stdin, PollFlags::IN)], Some(&wait)) {
                Ok(0) | Err(rustix::io::Errno::INTR) => continue,
                Ok(_) => {}
                Err(error) => return Err(Failure::own(format!("stdin: {}", std::io::Error::from(error)))),
            }
            let mut bytes = [0; 256];
            match rustix::io::read(&stdin, &mut bytes) {
                Ok(0) => self.is_at_end = true,
                Ok(count) => self.held.extend_from_slice(&bytes[..count]),
                Err(rustix::io::Errno::INTR | rustix::io::Errno::AGAIN) => {}
                Err(error) => return Err(Failure::own(format!("stdin: {}", std::io::Error::from(error)))),
            }
        }
    }
}
