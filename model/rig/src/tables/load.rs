//! `[channel.load]`: what the moving end pulls against.

use sinew_physics::{Load, WireModel};

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};

const KIND: Kind = Kind::Choice(&["spring_mass_damper", "imposed_position", "imposed_force"]);

impl Field for Load {
    /// In motion, with numbers that are still to be read.
    const UNREAD: Load = Load::SpringMassDamper {
        mass_kg: f64::NAN,
        damping_n_s_per_m: f64::NAN,
        spring_n_per_m: 0.0,
        preload_n: f64::NAN,
    };

    fn value(&self) -> Option<Value> {
        let kind = match self {
            Load::SpringMassDamper { .. } => "spring_mass_damper",
            Load::ImposedPosition => "imposed_position",
            Load::ImposedForce => "imposed_force",
        };
        Some(Value::Text(kind.into()))
    }

    fn assign(&mut self, value: Value) {
        let Value::Text(kind) = value else { return };
        *self = match kind.as_str() {
            "imposed_position" => Load::ImposedPosition,
            "imposed_force" => Load::ImposedForce,
            _ => Load::UNREAD,
        };
    }
}

/// A number of a load in motion.
macro_rules! motion {
    ($field:ident) => {
        Accessor::new(
            |model: &WireModel| match model.load {
                Load::SpringMassDamper { $field, .. } => Some(Value::Number($field)),
                _ => None,
            },
            |model, value| {
                if let Load::SpringMassDamper { $field, .. } = &mut model.load {
                    $field.assign(value);
                }
            },
        )
    };
}

/// Keys that only a load in motion has.
fn in_motion() -> Only<WireModel> {
    Only::new(
        |model, _| matches!(model.load, Load::SpringMassDamper { .. }),
        |_, _| {
            "makes no sense with an imposed position or force; take it out, or set kind = \"spring_mass_damper\"".into()
        },
    )
}

/// Keys of `[channel.load]`.
pub(crate) fn section() -> Section<WireModel> {
    Section {
        table: "channel.load",
        about: "What the moving end pulls against: M ẍ + B ẋ + K x = preload + external − tension (eq. 51).",
        optional: false,
        keys: keys! {
            WireModel;
            /// A load in motion, or `position_m` or `force_n` as an input; the other keys belong to the first.
            "kind" = at(load), KIND, Text("spring_mass_damper");
            /// Moving mass M.
            "mass_kg" = motion(mass_kg), number(si("kg"), 1e-6, 1e4),
                Computed("required with kind `spring_mass_damper`"), only in_motion(), prior Relative(0.015);
            /// Damping B.
            "damping_n_s_per_m" = motion(damping_n_s_per_m), number(si("N s/m"), 0.0, 1e6), Number(40.0), only in_motion(),
                prior Relative(0.30);
            /// Spring K; 0 = a hanging mass.
            "spring_n_per_m" = motion(spring_n_per_m), number(si("N/m"), 0.0, 1e7), Number(0.0), only in_motion(),
                prior Relative(0.03);
            /// Pull on the wire at its hot, unloaded length.
            "preload_n" = motion(preload_n), number(si("N"), -1e5, 1e5), Computed("`mass_kg` × 9.80665 m/s²"), only in_motion(),
                prior Relative(0.015);
        },
        check: Some(Box::new(what_moves_has_a_mass)),
    }
}

fn what_moves_has_a_mass(reader: &mut Reader<'_>, model: &WireModel, stated: &Stated<'_>) {
    if matches!(model.load, Load::SpringMassDamper { .. }) && !stated.gives("load", "mass_kg") {
        let expected = "the moving mass in kg, such as 0.2 (or another load kind)".into();
        reader.problem(stated.line_at(&["load"]), stated.label(), "load.mass_kg", What::Missing { expected });
    }
}
