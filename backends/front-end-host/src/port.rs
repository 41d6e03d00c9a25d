//! The front-end's end of the line: the master of a pseudo-terminal, or a serial device of its own.

use std::fs;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags, fcntl_setfl, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use crate::error::Error;

/// An open end.
#[derive(Debug)]
pub(crate) struct Port {
    fd: OwnedFd,
    /// What the driver is to open.
    pub path: PathBuf,
    link: Option<PathBuf>,
}

/// What a read found.
pub(crate) enum Read {
    Bytes(usize),
    Nothing,
    /// Nobody has the other end open: there is nothing to wait for.
    Alone,
}

impl Port {
    /// A new pseudo-terminal, `link` pointing at the end that is the driver's.
    pub fn pty(link: Option<&Path>) -> Result<Port, Error> {
        let failed = |error: Errno| Error::Line { what: "a pseudo-terminal".into(), error: error.into() };
        let fd = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).map_err(failed)?;
        grantpt(&fd).map_err(failed)?;
        unlockpt(&fd).map_err(failed)?;
        fcntl_setfl(&fd, OFlags::RDWR | OFlags::NONBLOCK).map_err(failed)?;
        let name = ptsname(&fd, Vec::new()).map_err(failed)?;
        let own = PathBuf::from(name.to_string_lossy().into_owned());
        let mut port = Port { fd, path: own.clone(), link: None };
        if let Some(link) = link {
            let failed = |error: io::Error| Error::Link { path: link.into(), error };
            // Whoever opens it at any time finds the old end or the new one.
            let fresh = link.with_extension("new");
            let _ = fs::remove_file(&fresh);
            std::os::unix::fs::symlink(&own, &fresh).map_err(failed)?;
            fs::rename(&fresh, link).map_err(failed)?;
            port.path = link.into();
            port.link = Some(link.into());
        }
        Ok(port)
    }

    /// A serial device.
    pub fn device(path: &Path, baud_hz: u32) -> Result<Port, Error> {
        let failed = |error: Errno| Error::Line { what: path.display().to_string(), error: error.into() };
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let fd = open(path, flags, Mode::empty()).map_err(failed)?;
        let mut settings = tcgetattr(&fd).map_err(failed)?;
        settings.make_raw();
        settings.set_speed(baud_hz).map_err(failed)?;
        tcsetattr(&fd, OptionalActions::Now, &settings).map_err(failed)?;
        Ok(Port { fd, path: path.into(), link: None })
    }

    pub fn read(&self, buffer: &mut [u8]) -> Read {
        match rustix::io::read(&self.fd, buffer) {
            Ok(0) | Err(Errno::IO) => Read::Alone,
            Ok(count) => Read::Bytes(count),
            Err(_) => Read::Nothing,
        }
    }

    /// Sends a frame; what the line does not take is lost.
    pub fn write(&self, bytes: &[u8]) {
        let _ = rustix::io::write(&self.fd, bytes);
    }
}

impl AsFd for Port {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        if let Some(link) = &self.link {
            let _ = fs::remove_file(link);
        }
    }
}
