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

/// Where a channel is on a front-end, and by how much its inputs err.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontEndPlace {
    /// Which of the front-end's channels it is; `None` = its place in the rig.
    pub index: Option<u32>,
    /// By how much its inputs err.
    pub inputs: Corrections,
    /// When and by what that was found.
    pub measured: Option<String>,
}

/// What the values of a channel's inputs are short of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corrections {
    /// First tap.
    pub v1: Correction,
    /// Second tap.
    pub v2: Correction,
    /// Moving end.
    pub v3: Correction,
    /// Current.
    pub current: Correction,
    /// Supply.
    pub supply: Correction,
}

/// What a front-end's value is short of: true value = `gain` · what it says, in V or A, + `offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// Above 0.
    pub gain: f64,
    /// In V or A.
    pub offset: f64,
}

impl Correction {
    /// Nothing.
    pub const NONE: Correction = Correction { gain: 1.0, offset: 0.0 };

    /// The true value, V or A, where the front-end says `value`.
    #[inline]
    pub fn apply(&self, value: f64) -> f64 {
        self.gain * value + self.offset
    }
}

impl Unread for FrontEndPlace {
    const UNREAD: FrontEndPlace = {
        const INPUT: Correction = Correction { gain: Field::UNREAD, offset: Field::UNREAD };
        let inputs = Corrections { v1: INPUT, v2: INPUT, v3: INPUT, current: INPUT, supply: INPUT };
        FrontEndPlace { index: Field::UNREAD, inputs, measured: Field::UNREAD }
    };
}

/// The keys of an input's correction.
macro_rules! correction {
    (
        $(#[doc = $doc:literal])+
        $gain:literal, $offset:literal in $unit:literal = $field:ident
    ) => {
        keys! {
            FrontEndPlace;
            $(#[doc = $doc])+
            $gain = at(inputs.$field.gain), number(si("1"), 0.01, 100.0), Number(1.0);
            /// Added to that.
            $offset = at(inputs.$field.offset), number(si($unit), -100.0, 100.0), Number(0.0);
        }
    };
}

/// Keys of `[channel.front_end]`.
pub(crate) fn channel() -> Section<FrontEndPlace> {
    Section {
        table: "channel.front_end",
        about: "Where the channel is on a front-end, with kind `serial` of the backend, and by how much its inputs err: `sinew bringup` \
                finds that against a meter and writes it here.",
        optional: false,
        keys: [
            keys! {
                FrontEndPlace;
                /// Which of the front-end's channels it is.
                "index" = at(index), integer(0, 63), Computed("its place in the file, from 0");
            },
            correction! {
                /// The first tap's voltage is so many times what the front-end says.
                "v1_gain", "v1_offset_v" in "V" = v1
            },
            correction! {
                /// The second tap's voltage is so many times what the front-end says.
                "v2_gain", "v2_offset_v" in "V" = v2
            },
            correction! {
                /// The moving end's voltage is so many times what the front-end says.
                "v3_gain", "v3_offset_v" in "V" = v3
            },
            correction! {
                /// The current is so many times what the front-end says.
                "current_gain", "current_offset_a" in "A" = current
            },
            correction! {
                /// The supply is so many times what the front-end says.
                "supply_gain", "supply_offset_v" in "V" = supply
            },
            keys! {
                FrontEndPlace;
                /// When gains and offsets were measured, and against what.
                "measured" = at(measured), text("a date and what it was measured against", MAX_PATH), Computed("not measured");
            },
        ]
        .into_iter()
        .flatten()
        .collect(),
        check: None,
    }
}
