//! A front-end on a serial line: `[backend.serial]` and `[channel.front_end]`.

use std::collections::BTreeMap;

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{BackendKind, Channel, MAX_PATH, Rig};

table! {
    "backend.serial" of Rig, at (backend.serial), check port_is_given:
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

fn port_is_given(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    if rig.backend.kind == BackendKind::Serial && !stated.gives("backend.serial", "port") {
        let expected = "the device the front-end is on, such as \"/dev/ttyACM0\"".into();
        reader.problem(stated.header, None, "backend.serial.port", What::Missing { expected });
    }
}

/// Keys of `[channel.front_end]`.
pub(crate) static CHANNEL: Section<Channel> = Section {
    table: "channel.front_end",
    about: "Where the channel is on a front-end, with kind `serial` of the backend.",
    optional: false,
    check: None,
    keys: &[keys! {
        Channel;
        /// Which of the front-end's channels it is.
        "index" = at(front_end_index), integer(0, 63), Computed("its place in the file, from 0");
    }],
};

impl Rig {
    /// Which channel of a serial front-end a channel of the rig is.
    pub fn front_end_index(&self, channel: usize) -> Option<u32> {
        let own = self.channels.get(channel)?.front_end_index;
        own.or(u32::try_from(channel).ok())
    }
}

/// No two channels can be the same one of a front-end.
pub(crate) fn check_channels(reader: &mut Reader<'_>, rig: &Rig, stated: &[Stated<'_>]) {
    if rig.backend.kind != BackendKind::Serial {
        return;
    }
    let mut taken: BTreeMap<u32, &str> = BTreeMap::new();
    for (index, (channel, stated)) in rig.channels.iter().zip(stated).enumerate() {
        let Some(place) = rig.front_end_index(index) else { continue };
        if let Some(other) = taken.insert(place, &channel.name) {
            let message = format!(
                "is {place}, where channel \"{other}\" is already; expected a place of its own (without an index it \
                 is the place in the file, from 0)"
            );
            let line = stated.line_at(&["front_end", "index"]);
            reader.problem(line, Some(&channel.name), "front_end.index", What::Contradiction { message });
        }
    }
}
