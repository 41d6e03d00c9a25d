//! Lines that a person types, or that come by a pipe: taken as they come, so that waiting for one keeps nobody from ending the program.

use std::io;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// A line is cut after so many bytes: nobody types more.
const MOST: usize = 4096;

/// The lines of stdin.
#[derive(Debug, Default)]
pub struct Lines {
    held: Vec<u8>,
    is_at_end: bool,
}

impl Lines {
    /// The next line, without what ends it, if one comes within so long.
    ///
    /// # Errors
    /// Stdin cannot be read; there may be more to read later, as by a program that is not in the foreground of its terminal.
    pub fn next(&mut self, wait: Duration) -> io::Result<Option<String>> {
        if let Some(line) = self.take() {
            return Ok(Some(line));
        }
        let stdin = io::stdin();
        let wait = Timespec::try_from(wait).unwrap_or_default();
        match poll(&mut [PollFd::new(&stdin, PollFlags::IN)], Some(&wait)) {
            Ok(0) | Err(Errno::INTR) => return Ok(None),
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        let mut bytes = [0; 256];
        match rustix::io::read(&stdin, &mut bytes) {
            Ok(0) => self.is_at_end = true,
            Ok(count) => self.held.extend_from_slice(&bytes[..count]),
            Err(Errno::INTR | Errno::AGAIN) => {}
            Err(error) => return Err(error.into()),
        }
        Ok(self.take())
    }

    /// Whether there will be no more: the pipe is empty, or Ctrl-D was typed.
    pub fn is_at_end(&self) -> bool {
        self.is_at_end && self.held.is_empty()
    }

    /// A line that is held whole; at the end, what is left.
    fn take(&mut self) -> Option<String> {
        let end = self.held.iter().position(|byte| *byte == b'\n').map(|end| end + 1);
        let rest = (self.held.len() >= MOST || (self.is_at_end && !self.held.is_empty())).then_some(self.held.len());
        let line: Vec<u8> = self.held.drain(..end.or(rest)?).collect();
        Some(String::from_utf8_lossy(&line).trim_end().to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_whole_in_their_order_and_the_last_needs_no_end() {
        let mut lines = Lines { held: b"set left 40%\r\n\nsta".to_vec(), is_at_end: false };
        assert_eq!(lines.take().as_deref(), Some("set left 40%"));
        assert_eq!(lines.take().as_deref(), Some(""));
        assert_eq!(lines.take(), None, "it is still being typed");
        lines.held.extend_from_slice(b"tus");
        lines.is_at_end = true;
        assert!(!lines.is_at_end());
        assert_eq!(lines.take().as_deref(), Some("status"));
        assert!(lines.is_at_end() && lines.take().is_none());
        lines = Lines { held: vec![0xff; MOST], is_at_end: false };
        assert!(lines.take().is_some_and(|line| line.starts_with('\u{fffd}')));
    }
}
