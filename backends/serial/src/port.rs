//! A serial device: raw, exclusive, non-blocking.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, OptionalActions, QueueSelector, SpecialCodeIndex, ioctl_tiocexcl, tcflush, tcgetattr, tcsetattr,
};

use crate::error::Error;

/// An open line.
#[derive(Debug)]
pub(crate) struct Port(OwnedFd);

impl Port {
    /// Opens a device for this process alone: eight bits, no parity, no flow control, nothing translated, nothing left over.
    pub fn open(path: &str, baud_hz: u32) -> Result<Port, Error> {
        let port = || path.to_string();
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let fd = open(path, flags, Mode::empty()).map_err(|error| match error {
            Errno::BUSY => Error::Taken { port: port() },
            error => Error::Open { port: port(), error: error.into() },
        })?;
        let failed = |error: Errno| match error {
            Errno::NOTTY => Error::NotALine { port: port() },
            error => Error::Line { port: port(), error: error.into() },
        };
        let mut settings = tcgetattr(&fd).map_err(failed)?;
        // The lock as well: the kernel's own exclusion does not hold for root.
        flock(&fd, FlockOperation::NonBlockingLockExclusive).map_err(|error| match error {
            Errno::WOULDBLOCK => Error::Taken { port: port() },
            error => failed(error),
        })?;
        ioctl_tiocexcl(&fd).map_err(failed)?;
        settings.make_raw();
        settings.control_modes.insert(ControlModes::CLOCAL | ControlModes::CREAD);
        settings.control_modes.remove(ControlModes::CRTSCTS | ControlModes::HUPCL);
        // With no byte there a read says so, instead of looking like the end of the file.
        settings.special_codes[SpecialCodeIndex::VMIN] = 1;
        settings.special_codes[SpecialCodeIndex::VTIME] = 0;
        settings.set_speed(baud_hz).map_err(failed)?;
        tcsetattr(&fd, OptionalActions::Now, &settings).map_err(failed)?;
        tcflush(&fd, QueueSelector::IOFlush).map_err(failed)?;
        Ok(Port(fd))
    }

    /// The open device alone, with its lock.
    pub fn into_fd(self) -> OwnedFd {
        self.0
    }

    /// What has arrived; `Ok(0)` = nothing. The end of the line is an error.
    ///
    /// It asks first how much there is. Reading from a terminal with nothing to be read waits, non-blocking or not, for the kernel's
    /// thread that hands bytes over (`tty_buffer_flush_work` in `n_tty_read`): an ordinary one, late by milliseconds when the machine
    /// is busy.
    #[inline]
    pub fn read(&self, buffer: &mut [u8]) -> Result<usize, Errno> {
        if rustix::io::ioctl_fionread(&self.0)? == 0 {
            return Ok(0);
        }
        match rustix::io::read(&self.0, buffer) {
            Ok(0) => Err(Errno::IO),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(error) => Err(error),
        }
    }

    /// Gives the line all of these bytes; whether it took them. A frame it takes a part of is damaged, and so not taken.
    #[inline]
    pub fn write(&self, bytes: &[u8]) -> Result<bool, Errno> {
        match rustix::io::write(&self.0, bytes) {
            Ok(count) => Ok(count == bytes.len()),
            Err(Errno::AGAIN | Errno::INTR) => Ok(false),
            Err(error) => Err(error),
        }
    }
}

impl AsFd for Port {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}
