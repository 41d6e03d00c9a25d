//! The load of a wire: its computed defaults, and what a joint makes of it.

use sinew_physics::Load;
use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;

use crate::notes::{Reader, Stated};
use crate::tables::{Channel, Joint};

/// The load of a joint's wire: the joint says where its end is.
const IN_JOINT: Load = Load::ImposedPosition;

/// Fills in the computed defaults.
pub(super) fn fill(channel: &mut Channel, stated: &Stated<'_>) {
    if let Load::SpringMassDamper { mass_kg, preload_n, .. } = &mut channel.model.load
        && !stated.gives("load", "preload_n")
    {
        *preload_n = *mass_kg * STANDARD_GRAVITY_M_S2;
    }
}

/// A wire in a joint has no load but that.
pub(crate) fn in_joint(reader: &mut Reader<'_>, channel: &mut Channel, joint: &Joint, stated: &mut Stated<'_>) {
    let allowed = |key: &str| key == "kind" && channel.model.load == IN_JOINT;
    for (place, _) in stated.given.iter().filter(|((table, key), _)| *table == "load" && !allowed(key)) {
        let message = format!(
            "makes no sense: the wire turns joint \"{}\" and has no load of its own; take [channel.load] out",
            joint.name
        );
        reader.out_of_place(stated, *place, message);
    }
    for key in ["minimum_force_n", "maximum_force_n"] {
        let message = format!(
            "makes no sense: the tension of a joint's wires is limited by joint \"{}\"; \
             use its minimum_tension_n and maximum_tension_n",
            joint.name
        );
        reader.out_of_place(stated, ("limits", key), message);
    }
    // Said once.
    stated.given.retain(|(table, _), _| *table != "load");
    channel.model.load = IN_JOINT;
}
