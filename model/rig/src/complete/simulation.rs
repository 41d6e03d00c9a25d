//! The simulated backend: what makes no sense with wires that are not simulated.

use crate::notes::{Reader, Stated};
use crate::tables::{BackendKind, Pace, Rig};

pub(super) fn only_simulated_wires_have_a_pace(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    if rig.backend.kind == BackendKind::Simulated {
        return;
    }
    let has_its_own = [("pace", rig.simulation.pace != Pace::RealTime), ("speed", rig.simulation.speed != 1.0)];
    for (key, _) in has_its_own.into_iter().filter(|(_, has)| *has) {
        let message = "makes no sense with wires that are not simulated; take it out";
        reader.out_of_place(stated, ("simulation", key), message);
    }
}
