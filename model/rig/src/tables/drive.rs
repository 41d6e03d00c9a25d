//! `[channel.drive]`: what heats the wire.

use sinew_physics::{Amplifier, DriveKind, WireModel};

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};

/// The kinds with their words; an amplifier's current is what the file says, its low-pass the thesis'.
const KINDS: [(&str, DriveKind); 5] = [
    ("pwm", DriveKind::Pwm),
    ("power", DriveKind::Power),
    ("current", DriveKind::Current),
    ("temperature", DriveKind::Temperature),
    ("amplifier", DriveKind::Amplifier(Amplifier { full_current_a: f64::NAN, filter_hz: FILTER_HZ })),
];

const KIND: Kind = Kind::Choice(&{
    let mut words = [""; KINDS.len()];
    let mut i = 0;
    while i < words.len() {
        words[i] = KINDS[i].0;
        i += 1;
    }
    words
});

/// Cut-off of the low-pass of fig. 64 and 83.
const FILTER_HZ: f64 = 40.0;

impl Field for DriveKind {
    const UNREAD: DriveKind = DriveKind::Pwm;

    fn value(&self) -> Option<Value> {
        let same = |kind: &DriveKind| std::mem::discriminant(kind) == std::mem::discriminant(self);
        KINDS.iter().find(|(_, kind)| same(kind)).map(|(word, _)| Value::Text((*word).into()))
    }

    fn assign(&mut self, value: Value) {
        if let Some((_, kind)) = KINDS.iter().find(|(word, _)| Value::Text((*word).into()) == value) {
            *self = *kind;
        }
    }
}

/// A number of the current amplifier.
macro_rules! amplifier {
    ($field:ident) => {
        Accessor::new(
            |model: &WireModel| match model.drive.kind {
                DriveKind::Amplifier(amplifier) => amplifier.$field.value(),
                _ => None,
            },
            |model, value| {
                if let DriveKind::Amplifier(amplifier) = &mut model.drive.kind {
                    amplifier.$field.assign(value);
                }
            },
        )
    };
}

/// Keys that only the amplifier has.
fn of_amplifier() -> Only<WireModel> {
    Only::new(
        |model, _| matches!(model.drive.kind, DriveKind::Amplifier(_)),
        |_, _| "makes no sense without kind = \"amplifier\"; add that or take it out".into(),
    )
}

/// Keys of `[channel.drive]`.
pub(crate) fn section() -> Section<WireModel> {
    Section {
        table: "channel.drive",
        about: "What heats the wire.",
        optional: false,
        keys: keys! {
            WireModel;
            /// What the input is: `duty` of the supply, `power_w` into the wire, a steady `current_a`, an imposed `temperature_c`, or
            /// with `amplifier` the `duty` of a current amplifier (fig. 64, 83), for `sinew simulate` alone.
            "kind" = at(drive.kind), KIND, Text("pwm");
            /// Supply voltage; the driver needs more than 0. An amplifier drives no more current than it does.
            "supply_v" = at(drive.supply_v), number(si("V"), 0.0, 1000.0),
                Computed("required with kinds `pwm` and `amplifier`, else 0"), prior Relative(0.004);
            /// Regulated current at duty 1; only with kind `amplifier`.
            "full_current_a" = amplifier(full_current_a), number(si("A"), 1e-4, 1000.0),
                Computed("required with kind `amplifier`"), only of_amplifier();
            /// Cut-off of the low-pass between PWM and current; only with kind `amplifier`.
            "filter_hz" = amplifier(filter_hz), number(si("Hz"), 0.1, 100_000.0), Number(40.0), only of_amplifier();
            /// Current shunt.
            "shunt_ohm" = at(drive.shunt_ohm), number(si("Ω"), 0.0, 1000.0), Number(0.0), prior Relative(0.02);
            /// Switch in its on state.
            "switch_ohm" = at(drive.switch_ohm), number(si("Ω"), 0.0, 1000.0), Number(0.0), prior Relative(0.2);
            /// Leads outside the taps.
            "lead_ohm" = at(drive.lead_ohm), number(si("Ω"), 0.0, 1000.0), Number(0.0);
        },
        check: Some(Box::new(circuits_are_whole)),
    }
}

fn circuits_are_whole(reader: &mut Reader<'_>, model: &WireModel, stated: &Stated<'_>) {
    let is_amplifier = matches!(model.drive.kind, DriveKind::Amplifier(_));
    let mut missing = |key, expected: &str| {
        if !stated.gives("drive", key) {
            let what = What::Missing { expected: expected.into() };
            reader.problem(stated.line_at(&["drive"]), stated.label(), format!("drive.{key}"), what);
        }
    };
    if is_amplifier || model.drive.kind == DriveKind::Pwm {
        missing("supply_v", "the supply voltage in V, such as 6.0 (or another drive kind)");
    }
    if is_amplifier {
        missing("full_current_a", "the regulated current at duty 1 in A, such as 0.5");
    }
}
