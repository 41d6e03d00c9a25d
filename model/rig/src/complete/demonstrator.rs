//! The demonstrator: the wires that move it.

use sinew_physics::Load;

use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{BackendKind, Channel, DemonstratorKind, Rig};
use crate::value::channel_choices;

impl Rig {
    /// The channels whose wires move the demonstrator, where there are these: the named one, else the first; of an arm, that of the elbow
    /// besides.
    pub fn demonstrator_channels(&self) -> [Option<(usize, &Channel)>; 2] {
        let of = |name: &Option<String>, place| match name {
            Some(name) => self.channel(name),
            None => self.channels.iter().enumerate().nth(place),
        };
        let elbow = (self.demonstrator.kind == DemonstratorKind::Arm).then(|| of(&self.demonstrator.elbow_channel, 1));
        [of(&self.demonstrator.channel, 0), elbow.flatten()]
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
    let named = [("channel", &rig.demonstrator.channel), ("elbow_channel", &rig.demonstrator.elbow_channel)];
    let count = if kind == DemonstratorKind::Arm { 2 } else { 1 };
    let found = rig.demonstrator_channels();
    for ((key, name), wire) in named.into_iter().zip(found).take(count) {
        if let Some(what) = unfit(rig, name.as_deref(), wire) {
            refuse(key, what);
        }
    }
    if let [Some((shoulder, _)), Some((elbow, channel))] = found
        && shoulder == elbow
    {
        let message = format!("is the shoulder's, \"{}\"; expected another channel", channel.name);
        refuse("elbow_channel", What::Contradiction { message });
    }
}

/// Why a wire cannot move it.
fn unfit(rig: &Rig, name: Option<&str>, wire: Option<(usize, &Channel)>) -> Option<What> {
    match (name, wire) {
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
