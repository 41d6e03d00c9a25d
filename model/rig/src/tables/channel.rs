//! `[[channel]]`: one wire with all that belongs to it, and the reading of channels.

use std::collections::BTreeMap;

use sinew_physics::effects::Effects;
use sinew_physics::{Drive, Geometry, Initial, Material, WireModel};

use crate::declare::rows::*;
use crate::derive::Reach;
use crate::effects;
use crate::error::What;
use crate::key::Prior;
use crate::key::local;
use crate::notes::{Given, Reader, Stated, tidy};
use crate::parameters;
use crate::read::value::is_name;
use crate::read::{descend, within};
use crate::tables::{
    Adc, Control, Joint, Limits, LinuxChannel, PositionZero, Rig, adc, control, limits, load, of_channel, tables_with,
};
use crate::tree::{Node, Table, Tree};

/// Most channels a rig can have.
pub const MAX_CHANNELS: usize = 64;
/// Longest name of a channel, in bytes.
pub const MAX_CHANNEL_NAME: usize = 32;

/// One wire with its drive, load, limits and control.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name, unique within the rig.
    pub name: String,
    /// Wire, taps, drive, load, initial state and the effects beyond the reference model.
    pub model: WireModel,
    /// Whether an offset of the measured position means anything.
    pub position_zero: PositionZero,
    /// `[channel.sensors.noise]`: RMS by the name of a recording's column, in the column's unit; above 0.
    pub noise: BTreeMap<String, f64>,
    /// The rig file's own `[channel.priors]`; for those in force use [`Channel::priors_in_force`].
    pub priors: BTreeMap<String, Prior>,
    /// The converter that measures voltages and current.
    pub adc: Adc,
    /// Which channel of a serial front-end it is; `None` = its place in the rig.
    pub front_end_index: Option<u32>,
    /// Where it is among Linux's own outputs and inputs.
    pub linux: LinuxChannel,
    /// What the supervisor holds the channel within.
    pub limits: Limits,
    /// The controller.
    pub control: Control,
    /// Name of the channel whose wire is the neighbour of `thermal.neighbour`; `None` = a body at ambient temperature.
    /// All other effects are in the model.
    pub neighbour: Option<String>,
}

/// Keys of `[[channel]]` itself.
pub(crate) static SECTION: Section<Channel> = Section {
    table: "channel",
    about: "One wire each: `[[channel]]`, at least one and at most 64. Its own tables follow it.",
    optional: false,
    check: None,
    keys: &[keys! {
        Channel;
        /// Name of the channel, unique in the rig. Letters, digits, `-`, `_` and `.`, a letter or digit first, at most
        /// 32.
        "name" = at(name), name(MAX_CHANNEL_NAME), Required("a name such as \"wire\"");
    }],
};

impl Channel {
    /// The wire in the load that its stroke, limits and observers are reckoned with: its own, or, in a joint, the joint's
    /// at a tension kept at the pretension (see [`sinew_physics::Joint::nominal_load`]).
    pub fn nominal_model(&self, joint: Option<&Joint>) -> WireModel {
        let load = joint.map_or(self.model.load, |joint| joint.mechanics.nominal_load());
        WireModel { load, ..self.model.clone() }
    }

    /// Power in the on-phase with the wire at its most conductive, W: what bounds a duty of 1.
    pub fn full_power_w(&self) -> f64 {
        let model = &self.model;
        model.drive.on_power_w(model.geometry.resistance_ohm(model.material.least_resistivity()))
    }

    /// A channel before anything is read.
    fn unread(ambient_c: f64) -> Channel {
        Channel {
            name: String::UNREAD,
            model: WireModel {
                geometry: Geometry { diameter_m: f64::UNREAD, length_m: f64::UNREAD },
                material: Material::default(),
                taps: None,
                drive: Drive { kind: Field::UNREAD, supply_v: 0.0, shunt_ohm: 0.0, switch_ohm: 0.0, lead_ohm: 0.0 },
                load: Field::UNREAD,
                initial: Initial::default(),
                ambient_c,
                effects: Effects::default(),
            },
            position_zero: Field::UNREAD,
            noise: BTreeMap::new(),
            priors: BTreeMap::new(),
            adc: Unread::UNREAD,
            front_end_index: Field::UNREAD,
            linux: LinuxChannel::UNREAD,
            limits: Unread::UNREAD,
            control: Unread::UNREAD,
            neighbour: None,
        }
    }
}

/// Tables of a channel that are more than a plain list of keys.
const OTHER_TABLES: [&str; 2] = ["priors", "effects"];

/// Reads the channels; for each, what of it stood in the file and whether it is right key by key.
pub(crate) fn channels<'n>(reader: &mut Reader<'_>, node: Option<&'n Node>, rig: &mut Rig) -> Vec<Stated<'n>> {
    let mut read = Vec::new();
    let Some(nodes) = array(reader, node) else { return read };
    if let Some(extra) = nodes.get(MAX_CHANNELS) {
        let message = format!(
            "has {} entries, expected at most {MAX_CHANNELS}; split the rig in two files with names of their own",
            nodes.len()
        );
        reader.problem(extra.line, None, "channel", What::Contradiction { message });
    }
    let mut first_use: BTreeMap<String, usize> = BTreeMap::new();
    for (index, node) in nodes.iter().take(MAX_CHANNELS).enumerate() {
        let place = format!("#{}", index + 1);
        let Tree::Table(table) = &node.value else {
            let (found, expected) = (node.value.describe(), "a table: [[channel]]".into());
            reader.problem(node.line, Some(&place), "", What::WrongType { found, expected });
            continue;
        };
        let (channel, stated) = channel(reader, &place, node.line, table, rig);
        if !channel.name.is_empty() {
            let line = stated.line_at(&["name"]);
            match first_use.get(&channel.name) {
                Some(&first_line) => {
                    let name = channel.name.clone();
                    reader.problem(line, Some(&place), "name", What::Duplicate { name, first_line });
                }
                None => {
                    first_use.insert(channel.name.clone(), line);
                }
            }
        }
        rig.channels.push(channel);
        read.push(stated);
    }
    effects::neighbours(reader, &rig.channels, &read);
    read
}

fn array<'n>(reader: &mut Reader<'_>, node: Option<&'n Node>) -> Option<&'n [Node]> {
    let (line, what) = match node {
        Some(Node { value: Tree::Array(nodes), .. }) if !nodes.is_empty() => return Some(nodes),
        Some(Node { value: Tree::Array(_), line }) => {
            (*line, What::Missing { expected: "at least one [[channel]]".into() })
        }
        None => (1, What::Missing { expected: "at least one [[channel]]".into() }),
        Some(Node { value, line }) => {
            let found = match value {
                Tree::Table(_) => "a single table [channel]".into(),
                other => other.describe(),
            };
            let expected = "an array of tables: [[channel]], with two brackets".into();
            (*line, What::WrongType { found, expected })
        }
    };
    reader.problem(line, None, "channel", what);
    None
}

fn channel<'n>(
    reader: &mut Reader<'_>,
    place: &str,
    header: usize,
    table: &'n Table,
    rig: &Rig,
) -> (Channel, Stated<'n>) {
    let before = reader.found();
    let mut channel = Channel::unread(rig.ambient_c);
    // The name first: every message about the channel carries it.
    let label = match table.get("name").map(|n| &n.value) {
        Some(Tree::Text(name)) if is_name(name, MAX_CHANNEL_NAME) => name,
        _ => place,
    };
    let paths: Vec<&str> = of_channel().map(Section::local).chain(OTHER_TABLES).collect();
    let mut given = Given::new();
    for section in of_channel() {
        let name = section.local();
        let others = within(&paths, name);
        given.extend(if name.is_empty() {
            reader.keys(section, table, &others, Some(label), header, &mut channel)
        } else {
            reader.section(section, descend(table, name), &others, Some(label), header, &mut channel)
        });
    }
    let mut stated = Stated { given, header, label: Some(label.to_string()), table, right: false };
    if let Some(joint) = joint_of(&rig.joints, &channel) {
        load::in_joint(reader, &mut channel, joint, &mut stated);
    }
    if let Some(node) = table.get("priors") {
        channel.priors = parameters::priors(reader, node, label);
    }
    if let Some(node) = table.get("effects") {
        effects::read(reader, node, label, &mut channel);
    }
    for section in of_channel() {
        reader.belonging(section, &channel, &stated);
    }
    stated.right = reader.found() == before;
    (channel, stated)
}

fn joint_of<'a>(joints: &'a [Joint], channel: &Channel) -> Option<&'a Joint> {
    joints.iter().find(|joint| joint.side(&channel.name).is_some())
}

/// Computed defaults and cross-checks, which only make sense of channels that are right key by key, and of those in a
/// joint only if that is right too.
pub(crate) fn complete(reader: &mut Reader<'_>, read: &[Stated<'_>], rig: &mut Rig) {
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
