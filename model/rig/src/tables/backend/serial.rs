//! A front-end on a serial line: `[backend.serial]` and `[channel.front_end]`.

use crate::declare::rows::*;
use crate::value::MAX_PATH;

table! {
    "backend.serial":
    "The line to a front-end, with kind `serial`.";

    /// The line to a front-end.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct SerialLine {
        /// The device it is on, such as `/dev/ttyACM0` or, better, its name in `/dev/serial/by-id`.
        port: Option<String> = "port", text("a device", MAX_PATH), Computed("none: **required** with kind `serial`");
        /// Bits a second of a UART; USB takes no notice of it.
        baud_hz: u32 = "baud_hz", integer(9600, 12_000_000), Integer(2_000_000);
        /// Periods without a good frame after which the front-end switches its outputs off by itself, and after which
        /// the driver calls the front-end silent.
        watchdog_periods: u32 = "watchdog_periods", integer(2, 1000), Integer(5);
    }
}

/// Where a channel is on a front-end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrontEndPlace {
    /// Which of the front-end's channels it is; `None` = its place in the rig.
    pub index: Option<u32>,
}

impl Unread for FrontEndPlace {
    const UNREAD: FrontEndPlace = FrontEndPlace { index: Field::UNREAD };
}

/// Keys of `[channel.front_end]`.
pub(crate) fn channel() -> Section<FrontEndPlace> {
    Section {
        table: "channel.front_end",
        about: "Where the channel is on a front-end, with kind `serial` of the backend.",
        optional: false,
        keys: keys! {
            FrontEndPlace;
            /// Which of the front-end's channels it is.
            "index" = at(index), integer(0, 63), Computed("its place in the file, from 0");
        },
        check: None,
    }
}
