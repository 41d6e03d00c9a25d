//! `[backend]`: what powers and measures the wires, and which backends there are.
//!
//! Another backend is a file in this folder with its tables `[backend.NAME]` and `[channel.NAME]`, what they are read
//! into and their checks. Here it is a word of [`BackendKind`], a field of [`Backend`] and an entry in each of the lists
//! below; where channels have to be told apart, [`Channel`] gets a field.

pub(crate) mod linux;
pub(crate) mod serial;

use crate::declare::rows::*;
use crate::notes::{Reader, Stated};
use crate::tables::{Channel, Rig};

pub use linux::*;
pub use serial::*;

words! {
    /// The kinds of backend.
    pub enum BackendKind, default Simulated {
        /// Simulated wires.
        Simulated = "simulated",
        /// A front-end on a serial line.
        Serial = "serial",
        /// Linux's own interfaces: PWM by sysfs, converters by IIO.
        Linux = "linux",
    }
}

/// What powers and measures the wires: which kind, and what each kind needs to know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Backend {
    /// Which of them it is.
    pub kind: BackendKind,
    /// A front-end on a serial line.
    pub serial: SerialLine,
    /// Linux's own interfaces.
    pub linux: LinuxInterfaces,
}

impl Backend {
    /// One of which nothing is read yet.
    pub(crate) fn unread() -> Backend {
        Backend { kind: BackendKind::UNREAD, serial: Unread::UNREAD, linux: Unread::UNREAD }
    }
}

/// Keys of `[backend]`.
pub(crate) static SECTION: Section<Rig> = Section {
    table: "backend",
    about: "What powers and measures the wires.",
    optional: false,
    check: None,
    keys: &[keys! {
        Rig;
        /// Simulated wires, a front-end on a serial line: [front-end](front-end.md), or Linux's own PWM outputs and
        /// converters: [Linux](linux-backend.md).
        "kind" = at(backend.kind), BackendKind::KIND, BackendKind::DEFAULT;
    }],
};

/// What each kind needs to know.
pub(crate) static OF_RIG: [&Section<Rig>; 2] = [&serial::SECTION, &linux::SECTION];
/// Where a channel is for each kind.
pub(crate) static OF_CHANNEL: [&Section<Channel>; 2] = [&serial::CHANNEL, &linux::CHANNEL];
/// What each kind cannot do without, and what it cannot do, once all channels are read.
pub(crate) static CHECKS: [fn(&mut Reader<'_>, &Rig, &[Stated<'_>]); 2] =
    [serial::check_channels, linux::check_channels];
