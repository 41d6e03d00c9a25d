//! `[backend]`: what powers and measures the wires, and which backends there are.
//!
//! Another backend is a file in this folder with its tables `[backend.NAME]` and `[channel.NAME]` and what they are read
//! into, and a row of [`backends`] here. What it cannot do without is checked in `complete/backend.rs`.

mod enable;
mod estop;
mod linux;
mod serial;

use crate::declare::part;
use crate::declare::rows::*;

pub use enable::{Enable, EnableSignal};
pub use estop::EmergencyStop;
pub use linux::*;
pub use serial::*;

/// The backends: what each is, its word, the module of its tables, and what these are read into, for the rig and for a
/// channel. The first has no tables of its own but `[simulation]`.
macro_rules! backends {
    (
        $(#[doc = $usual_doc:literal])+ $usual:ident = $usual_word:literal;
        $( $(#[doc = $doc:literal])+ $kind:ident = $word:literal, $module:ident: $of_rig:ty, $of_channel:ty; )+
    ) => {
        words! {
            /// The kinds of backend.
            pub enum BackendKind, default $usual {
                $(#[doc = $usual_doc])+ $usual = $usual_word,
                $( $(#[doc = $doc])+ $kind = $word, )+
            }
        }

        /// What powers and measures the wires: which kind, and what each kind needs to know.
        #[derive(Debug, Clone, PartialEq)]
        pub struct Backend {
            /// Which of them it is.
            pub kind: BackendKind,
            $( $(#[doc = $doc])+ pub $module: $of_rig, )+
            /// The line that switches the supply of all power stages.
            pub enable: Enable,
            /// The input of an emergency stop.
            pub estop: EmergencyStop,
        }

        impl Unread for Backend {
            const UNREAD: Backend = Backend {
                kind: BackendKind::UNREAD,
                $( $module: <$of_rig>::UNREAD, )+
                enable: Enable::UNREAD,
                estop: EmergencyStop::UNREAD,
            };
        }

        /// Where a channel is for each kind of backend.
        #[derive(Debug, Clone, PartialEq)]
        pub struct BackendChannel {
            $( $(#[doc = $doc])+ pub $module: $of_channel, )+
        }

        impl Unread for BackendChannel {
            const UNREAD: BackendChannel = BackendChannel { $( $module: <$of_channel>::UNREAD, )+ };
        }

        /// The tables of the rig.
        pub(crate) fn of_rig() -> Vec<Section<Backend>> {
            vec![
                section(),
                $( part!($module::section(), Backend.$module), )+
                part!(enable::section(), Backend.enable),
                part!(estop::section(), Backend.estop),
            ]
        }

        /// The tables of a channel.
        pub(crate) fn of_channel() -> Vec<Section<BackendChannel>> {
            vec![$( part!($module::channel(), BackendChannel.$module), )+]
        }
    };
}

backends! {
    /// Simulated wires.
    Simulated = "simulated";
    /// A front-end on a serial line.
    Serial = "serial", serial: SerialLine, FrontEndPlace;
    /// Linux's own interfaces: PWM by sysfs, converters by IIO.
    Linux = "linux", linux: LinuxInterfaces, LinuxChannel;
}

/// Keys of `[backend]`.
fn section() -> Section<Backend> {
    Section {
        table: "backend",
        about: "What powers and measures the wires.",
        optional: false,
        keys: keys! {
            Backend;
            /// Simulated wires, a front-end on a serial line: [front-end](front-end.md), or Linux's own PWM outputs and
            /// converters: [Linux](linux-backend.md).
            "kind" = at(kind), BackendKind::KIND, BackendKind::DEFAULT;
        },
        check: None,
    }
}
