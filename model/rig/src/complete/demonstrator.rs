//! The demonstrator: the wires that move it.

use sinew_physics::Load;
use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;

use crate::doubts::{WORTH_A_WORD, lasting_pull_n};
use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{BackendKind, Channel, Demonstrator, DemonstratorKind, Rig};
use crate::value::channel_choices;

impl Rig {
    /// The channels whose wires move the demonstrator, where there are these: the named one, else the first; of an arm, that of the elbow
    /// besides; of a hexapod or a torso, those that follow.
    pub fn demonstrator_channels(&self) -> impl Iterator<Item = Option<(usize, &Channel)>> {
        let Demonstrator { kind, channel, elbow_channel, .. } = &self.demonstrator;
        let of = |name: &Option<String>, place| match name {
            Some(name) => self.channel(name),
            None => self.channels.iter().enumerate().nth(place),
        };
        let first = of(channel, 0);
        (0..kind.wires()).map(move |place| match (kind, place) {
            (_, 0) => first,
            (DemonstratorKind::Arm, _) => of(elbow_channel, 1),
            _ => first.and_then(|(first, _)| self.channels.iter().enumerate().nth(first + place)),
        })
    }
}

/// Whether there are wires that can move it.
pub(crate) fn demonstrator(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    let kind = rig.demonstrator.kind;
    // a rig without channels has been told so
    if kind == DemonstratorKind::None || rig.channels.is_empty() {
        return;
    }
    if rig.backend.kind != BackendKind::Simulated {
        let message = "makes no sense with wires that are not simulated; take it out";
        reader.out_of_place(stated, ("demonstrator", "kind"), message);
    }
    let mut refuse = |key: &'static str, what: What| {
        let line = stated.line_of_first(&[("demonstrator", key), ("demonstrator", "kind")]);
        reader.problem(line, None, format!("demonstrator.{key}"), what);
    };
    let Demonstrator { channel, elbow_channel, .. } = &rig.demonstrator;
    for (place, wire) in rig.demonstrator_channels().enumerate() {
        let (key, name) = match (kind, place) {
            (_, 0) => ("channel", channel),
            (DemonstratorKind::Arm, _) => ("elbow_channel", elbow_channel),
            // those after the first have no keys of their own
            _ => ("channel", &None),
        };
        if let Some(what) = unfit(rig, name.as_deref(), wire) {
            refuse(key, what);
            break;
        }
    }
    if kind == DemonstratorKind::Hexapod
        && let Some((femur, most_kg)) = heaviest(rig)
        && rig.demonstrator.body_kg > most_kg
    {
        let (body_g, most_g) = (rig.demonstrator.body_kg * 1e3, most_kg * 1e3);
        let message = format!(
            "is {body_g}, but on three legs, where a middle one bears half of it, the spring of \"{femur}\" holds no more than {most_g:.0}; \
             expected at most that, a longer lever_mm or a larger preload_n"
        );
        refuse("body_g", What::Contradiction { message });
    }
    if kind == DemonstratorKind::Torso
        && rig.demonstrator_channels().all(|wire| wire.is_some())
        && let Some((joint, pull_n, most_n)) = heaviest_joint(rig)
        && !(0.0..=most_n).contains(&pull_n)
    {
        let message = format!(
            "is {}, but with spring, arm, paddle and ball \"{joint}\" pulls with {pull_n:.1} N where it is level; expected more than 0, or it hangs \
             slack, and at most {most_n:.1}, or it tires soon: another weight, lever_mm or preload_n",
            rig.demonstrator.paddle_kg * 1e3
        );
        refuse("paddle_g", What::Contradiction { message });
    }
    let mut found = rig.demonstrator_channels().flatten();
    if let (DemonstratorKind::Arm, Some((shoulder, _)), Some((elbow, channel))) = (kind, found.next(), found.next())
        && shoulder == elbow
    {
        let message = format!("is the shoulder's, \"{}\"; expected another channel", channel.name);
        refuse("elbow_channel", What::Contradiction { message });
    }
}

/// The femur of a hexapod whose spring holds least with its joint level, and what of a body it can carry, kg.
fn heaviest(rig: &Rig) -> Option<(&str, f64)> {
    let declared = &rig.demonstrator;
    let beside_m = declared.femur_m * declared.femur_rad.cos() + declared.tibia_m * declared.tibia_rad.sin();
    let carries = |(_, channel): (usize, &'_ Channel)| {
        let torque_n_m = level_pull_n(declared, channel)? * declared.lever_m;
        Some(2.0 * torque_n_m / (STANDARD_GRAVITY_M_S2 * beside_m))
    };
    let femora = rig.demonstrator_channels().flatten().skip(1).step_by(3);
    femora
        .filter_map(|femur| Some((femur.1.name.as_str(), carries(femur)?)))
        .min_by(|(_, one), (_, other)| one.total_cmp(other))
}

/// The shoulder or elbow of a torso that its spring and the weight of its arm pull furthest beyond what it should, by name; that pull with the joint
/// level, and the most it should be, N.
fn heaviest_joint(rig: &Rig) -> Option<(&str, f64, f64)> {
    let declared = &rig.demonstrator;
    let Demonstrator { upper_link_m, lower_link_m, upper_link_kg, lower_link_kg, lever_m, .. } = *declared;
    let raised_rad = [declared.shoulder_rad, declared.shoulder_rad + declared.elbow_rad];
    let out_m = [upper_link_m * raised_rad[0].cos(), lower_link_m * raised_rad[1].cos()];
    let wires = rig.demonstrator_channels().flatten().enumerate();
    let pulls = wires.filter_map(|(place, (_, channel))| {
        let in_hand_kg = if place < 4 { declared.paddle_kg + declared.ball_kg } else { 0.0 };
        let elbow_kg_m = out_m[1] * (0.5 * lower_link_kg + in_hand_kg);
        let beyond_kg_m = match place % 4 {
            0 => elbow_kg_m + out_m[0] * (0.5 * upper_link_kg + lower_link_kg + in_hand_kg),
            1 => elbow_kg_m,
            _ => return None,
        };
        let pull_n = level_pull_n(declared, channel)? + STANDARD_GRAVITY_M_S2 * beyond_kg_m / lever_m;
        Some((channel.name.as_str(), pull_n, WORTH_A_WORD * lasting_pull_n(channel)))
    });
    let beyond = |(_, pull_n, most_n): &(&str, f64, f64)| if *pull_n <= 0.0 { f64::INFINITY } else { pull_n / most_n };
    pulls.max_by(|one, other| beyond(one).total_cmp(&beyond(other)))
}

/// What the spring of a wire pulls with where its joint is level, N.
fn level_pull_n(declared: &Demonstrator, channel: &Channel) -> Option<f64> {
    let Load::SpringMassDamper { spring_n_per_m, preload_n, .. } = channel.model.load else { return None };
    let cold_m = sinew_physics::cold_length_m(&channel.model).ok()?;
    let hot_m = sinew_physics::hot_length_m(&channel.model).ok()?;
    let level_m = cold_m - declared.level_stroke * (cold_m - hot_m) - channel.model.geometry.length_m;
    Some(preload_n - spring_n_per_m * level_m)
}

/// Why a wire cannot move it.
fn unfit(rig: &Rig, name: Option<&str>, wire: Option<(usize, &Channel)>) -> Option<What> {
    match (name, wire) {
        (None, None) if rig.demonstrator.kind != DemonstratorKind::Arm => Some(What::Contradiction {
            message: format!(
                "has too few channels from there on: {} are {}, the rig has {}",
                if rig.demonstrator.kind == DemonstratorKind::Torso {
                    "two arms of four wires"
                } else {
                    "six legs of three wires"
                },
                rig.demonstrator.kind.wires(),
                rig.channels.len()
            ),
        }),
        (None, None) => Some(What::Missing { expected: "a second channel, for the elbow".into() }),
        (Some(name), None) => Some(What::NotAChoice {
            found: name.into(),
            expected: channel_choices(name, rig.channels.iter().map(|c| c.name.as_str())),
        }),
        (_, Some((index, Channel { name, .. }))) if rig.joint_of(index).is_some() => Some(What::Contradiction {
            message: format!("is \"{name}\", which turns a joint; expected a wire of its own"),
        }),
        (_, Some((_, Channel { name, model, .. }))) if !matches!(model.load, Load::SpringMassDamper { .. }) => {
            let message = format!("is \"{name}\", whose load does not move by itself; expected one with a mass_kg");
            Some(What::Contradiction { message })
        }
        (_, Some(_)) => None,
    }
}
