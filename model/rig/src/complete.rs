//! Computed defaults of tables that are read, and what tables need of each other: everything about a key that its own
//! table cannot say. A file each, as the tables have.

mod adc;
mod backend;
mod control;
mod demonstrator;
mod joints;
mod limits;
mod load;
mod simulation;
mod wire;

use crate::derive::Reach;
use crate::error::What;
use crate::key::local;
use crate::notes::{Reader, Stated, tidy};
use crate::tables::{Channel, Joint, Rig, tables_with};

pub(crate) use demonstrator::demonstrator;
pub(crate) use joints::joints;
pub(crate) use load::in_joint;
pub(crate) use wire::of_its_kind;

fn joint_of<'a>(joints: &'a [Joint], channel: &Channel) -> Option<&'a Joint> {
    joints.iter().find(|joint| joint.side(&channel.name).is_some())
}

/// What the tables of the rig as a whole need of each other.
pub(crate) fn rig(reader: &mut Reader<'_>, rig: &Rig, stated: &Stated<'_>) {
    backend::serial::port_is_given(reader, rig, stated);
    backend::linux::lines_are_given(reader, rig, stated);
    simulation::only_simulated_wires_have_a_pace(reader, rig, stated);
}

/// What the tables of a channel need of each other to be right key by key.
pub(crate) fn channel(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    limits::duty_belongs_to_pwm(reader, channel, stated);
    control::dual_has_taps(reader, channel, stated);
}

/// Computed defaults and cross-checks, which only make sense of channels that are right key by key, and of those in a
/// joint only if that is right too.
pub(crate) fn channels(reader: &mut Reader<'_>, read: &[Stated<'_>], rig: &mut Rig) {
    for (channel, stated) in rig.channels.iter_mut().zip(read).filter(|(_, stated)| stated.right) {
        let joint = joint_of(&rig.joints, channel);
        if joint.is_some_and(|joint| joint.tension_n.is_nan()) {
            continue;
        }
        fill(channel, joint, stated);
        physics(reader, channel, stated);
        limits::relations(reader, channel, stated);
        control::relations(reader, channel, stated);
        adc::relations(reader, channel, stated);
        limits::relations_to_supply(reader, channel, stated);
    }
    for check_channels in backend::CHECKS {
        check_channels(reader, rig, read);
    }
}

/// Fills in every computed default, each after those it follows from.
fn fill(channel: &mut Channel, joint: Option<&Joint>, stated: &Stated<'_>) {
    load::fill(channel, stated);
    control::fill_sensing(channel, stated);
    let reach = Reach::of(channel, joint);
    limits::fill(channel, &reach, stated);
    adc::fill(channel, stated);
    control::fill_gains(channel, reach.stroke_m(), stated);
}

/// What the physics finds wrong with the model, at the line of the key it names.
fn physics(reader: &mut Reader<'_>, channel: &Channel, stated: &Stated<'_>) {
    let Err(error) = channel.model.validate() else { return };
    let sinew_physics::Error::OutOfRange { key, found, low, high } = error;
    let place = stated.given.iter().find(|((_, k), _)| *k == key);
    let table = place.map(|((t, _), _)| *t).or_else(|| tables_with(key).first().map(|t| local(t)));
    let path = table.map_or(key.to_string(), |t| format!("{t}.{key}"));
    let line = place.map_or(stated.header, |(_, line)| *line);
    let what = What::OutOfRange { found: tidy(found), low: tidy(low), high: tidy(high), defaulted: place.is_none() };
    reader.problem(line, stated.label(), path, what);
}
