//! A front-end on a serial line: what it needs.

use std::collections::BTreeMap;

use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{BackendKind, Rig};

pub(crate) fn port_is_given(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    if rig.backend.kind == BackendKind::Serial && !stated.gives("backend.serial", "port") {
        let expected = "the device the front-end is on, such as \"/dev/ttyACM0\"".into();
        reader.problem(stated.line_at(&["backend"]), None, "backend.serial.port", What::Missing { expected });
    }
}

/// No two channels can be the same one of a front-end.
pub(super) fn channels(reader: &mut Reader<'_>, rig: &Rig, stated: &[Stated<'_>]) {
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
