//! `[channel.drive]`: what heats the wire.

use sinew_physics::{DriveKind, WireModel};

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};

key_words! {
    DriveKind, default Pwm = "pwm"; {
        Pwm = "pwm",
        Power = "power",
        Current = "current",
        Temperature = "temperature",
    }
}

/// Keys of `[channel.drive]`.
pub(crate) fn section() -> Section<WireModel> {
    Section {
        table: "channel.drive",
        about: "What heats the wire.",
        optional: false,
        keys: keys! {
            WireModel;
            /// What the input is: `duty` of the supply, `power_w` into the wire, a steady `current_a`, or an imposed
            /// `temperature_c`.
            "kind" = at(drive.kind), DriveKind::KIND, DriveKind::DEFAULT;
            /// Supply voltage; the driver needs more than 0.
            "supply_v" = at(drive.supply_v), number(si("V"), 0.0, 1000.0),
                Computed("required with kind `pwm`, else 0"), prior Relative(0.004);
            /// Current shunt.
            "shunt_ohm" = at(drive.shunt_ohm), number(si("Ω"), 0.0, 1000.0), Number(0.0), prior Relative(0.02);
            /// Switch in its on state.
            "switch_ohm" = at(drive.switch_ohm), number(si("Ω"), 0.0, 1000.0), Number(0.0), prior Relative(0.2);
            /// Leads outside the taps.
            "lead_ohm" = at(drive.lead_ohm), number(si("Ω"), 0.0, 1000.0), Number(0.0);
        },
        check: Some(Box::new(pwm_has_a_supply)),
    }
}

fn pwm_has_a_supply(reader: &mut Reader<'_>, model: &WireModel, stated: &Stated<'_>) {
    if model.drive.kind == DriveKind::Pwm && !stated.gives("drive", "supply_v") {
        let expected = "the supply voltage in V, such as 6.0 (or another drive kind)".into();
        reader.problem(stated.line_at(&["drive"]), stated.label(), "drive.supply_v", What::Missing { expected });
    }
}
