//! `[channel.load]`: what the moving end pulls against.

use sinew_physics::Load;
use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{Channel, Joint};

/// The load of a joint's wire: the joint says where its end is.
const IN_JOINT: Load = Load::ImposedPosition;

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
        Accessor {
            get: |c| match c.model.load {
                Load::SpringMassDamper { $field, .. } => Some(Value::Number($field)),
                _ => None,
            },
            set: |c, value| {
                if let Load::SpringMassDamper { $field, .. } = &mut c.model.load {
                    $field.assign(value);
                }
            },
        }
    };
}

/// Keys that only a load in motion has.
static MOTION: Only<Channel> = Only {
    with: |c, _| matches!(c.model.load, Load::SpringMassDamper { .. }),
    otherwise: |_, _| {
        "makes no sense with an imposed position or force; take it out, or set kind = \"spring_mass_damper\"".into()
    },
};

/// Keys of `[channel.load]`.
pub(crate) static SECTION: Section<Channel> = Section {
    table: "channel.load",
    about: "What the moving end pulls against: M ẍ + B ẋ + K x = preload + external − tension (eq. 51).",
    optional: false,
    check: Some(what_moves_has_a_mass),
    keys: &[keys! {
        Channel;
        /// A load in motion, or `position_m` or `force_n` as an input; the other keys belong to the first.
        "kind" = at(model.load), KIND, Text("spring_mass_damper");
        /// Moving mass M.
        "mass_kg" = motion(mass_kg), number(si("kg"), 1e-6, 1e4),
            Computed("required with kind `spring_mass_damper`"), only MOTION;
        /// Damping B.
        "damping_n_s_per_m" = motion(damping_n_s_per_m), number(si("N s/m"), 0.0, 1e6), Number(40.0), only MOTION,
            prior Relative(0.30);
        /// Spring K; 0 = a hanging mass.
        "spring_n_per_m" = motion(spring_n_per_m), number(si("N/m"), 0.0, 1e7), Number(0.0), only MOTION;
        /// Pull on the wire at its hot, unloaded length.
        "preload_n" = motion(preload_n), number(si("N"), -1e5, 1e5), Computed("`mass_kg` × 9.80665 m/s²"), only MOTION;
    }],
};

fn what_moves_has_a_mass(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    if matches!(channel.model.load, Load::SpringMassDamper { .. }) && !stated.gives("load", "mass_kg") {
        let expected = "the moving mass in kg, such as 0.2 (or another load kind)".into();
        reader.problem(stated.line_at(&["load"]), stated.label(), "load.mass_kg", What::Missing { expected });
    }
}

/// Fills in the computed defaults.
pub(crate) fn fill(channel: &mut Channel, stated: &Stated<'_>) {
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
