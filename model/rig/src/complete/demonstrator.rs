//! The demonstrator: the wire that moves it.

use sinew_physics::Load;

use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{BackendKind, Channel, DemonstratorKind, Rig};
use crate::value::channel_choices;

/// Whether there is a wire that can move it.
pub(crate) fn demonstrator(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    if rig.demonstrator.kind == DemonstratorKind::None {
        return;
    }
    if rig.backend.kind != BackendKind::Simulated {
        let message = "makes no sense with wires that are not simulated; take it out";
        reader.out_of_place(stated, ("demonstrator", "kind"), message);
    }
    let name = rig.demonstrator.channel.clone().unwrap_or_default();
    let what = match rig.demonstrator_channel() {
        // a rig without channels has been told so
        None if rig.demonstrator.channel.is_none() => return,
        None => What::NotAChoice {
            found: name.clone(),
            expected: channel_choices(&name, rig.channels.iter().map(|c| c.name.as_str())),
        },
        Some((index, Channel { name, .. })) if rig.joint_of(index).is_some() => {
            What::Contradiction { message: format!("is \"{name}\", which turns a joint; expected a wire of its own") }
        }
        Some((_, Channel { name, model, .. })) if !matches!(model.load, Load::SpringMassDamper { .. }) => {
            let message = format!("is \"{name}\", whose load does not move by itself; expected one with a mass_kg");
            What::Contradiction { message }
        }
        Some(_) => return,
    };
    let line = stated.line_of_first(&[("demonstrator", "channel"), ("demonstrator", "kind")]);
    reader.problem(line, None, "demonstrator.channel", what);
}
