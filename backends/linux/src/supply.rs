//! The line that switches the supply, from the loop's side.

use rustix::io::Errno;

use crate::Error;
use crate::line::Output;

/// The enable line, and what it was last given.
#[derive(Debug)]
pub(crate) struct Supply {
    line: Output,
    pulses: bool,
    /// The level it has; `None` = not known.
    level: Option<bool>,
}

impl Supply {
    /// Puts a line off that the guard holds already, and keeps it off until it is driven.
    pub fn set_up(line: Output, pulses: bool) -> Result<Supply, Error> {
        line.set_up()?;
        Ok(Supply { line, pulses, level: Some(false) })
    }

    /// One period with the supply or without: a level is written where it is another, an edge with every call.
    #[inline]
    pub fn drive(&mut self, on: bool) -> Result<(), Errno> {
        let level = on && !(self.pulses && self.level == Some(true));
        if self.level == Some(level) {
            return Ok(());
        }
        self.level = None;
        self.line.put(level)?;
        self.level = Some(level);
        Ok(())
    }

    /// Another process may have written to it: the next level is written whatever it is.
    pub fn forget(&mut self) {
        // An edge is written with every period anyway, and is one only if the level before it is known.
        if !self.pulses || self.level == Some(false) {
            self.level = None;
        }
    }
}
