//! `[[joint]]`: two channels whose wires turn one joint.

use std::collections::BTreeMap;

use sinew_physics::WireModel;

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, tidy};
use crate::read::value::channel_choices;
use crate::tables::{Channel, MAX_CHANNEL_NAME, Rig};
use crate::tree::{Node, Table, Tree};

/// A joint that two channels turn against each other. Their wires have no other load.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique among joints and channels.
    pub name: String,
    /// Name of the channel whose wire turns it forward.
    pub agonist: String,
    /// Name of the channel whose wire turns it back.
    pub antagonist: String,
    /// What the wires pull at.
    pub mechanics: sinew_physics::Joint,
    /// Tension below which a wire counts as about to go slack, in N.
    pub min_tension_n: f64,
    /// Tension that is kept where the motion leaves it free, in N.
    pub tension_n: f64,
    /// Tension no wire is driven above, in N.
    pub max_tension_n: f64,
}

impl Joint {
    /// Which of the joint's two wires a channel is, 0 = agonist; `None` where it is neither.
    pub fn side(&self, channel: &str) -> Option<usize> {
        [&self.agonist, &self.antagonist].into_iter().position(|name| name == channel)
    }

    /// A joint before anything is read.
    fn unread() -> Joint {
        Joint {
            name: String::UNREAD,
            agonist: String::UNREAD,
            antagonist: String::UNREAD,
            mechanics: sinew_physics::Joint {
                radius_m: f64::UNREAD,
                inertia_kg_m2: f64::UNREAD,
                damping_n_m_s: f64::UNREAD,
                spring_n_m: f64::UNREAD,
                torque_n_m: f64::UNREAD,
                pretension_n: f64::UNREAD,
            },
            min_tension_n: f64::UNREAD,
            tension_n: f64::UNREAD,
            max_tension_n: f64::UNREAD,
        }
    }
}

/// Keys of `[[joint]]`.
pub(crate) static SECTION: Section<Joint> = Section {
    table: "joint",
    about: "Two channels whose wires turn one joint against each other: J θ̈ + B θ̇ + K θ = r (agonist − antagonist) + torque, θ in rad, \
            positive where the agonist is shorter. Their wires have no load of their own: leave `[channel.load]` out.",
    optional: false,
    check: None,
    keys: &[keys! {
        Joint;
        /// Name of the joint, as unique as a channel's.
        "name" = at(name), name(MAX_CHANNEL_NAME), Required("a name such as \"knee\"");
        /// Channel whose wire turns it forward.
        "agonist" = at(agonist), name(MAX_CHANNEL_NAME), Required("the name of a channel");
        /// Channel whose wire turns it back.
        "antagonist" = at(antagonist), name(MAX_CHANNEL_NAME), Required("the name of a channel");
        /// Lever r of both wires.
        "radius_mm" = at(mechanics.radius_m), number(milli("mm"), 0.01, 10_000.0),
            Required("the lever the wires pull at in mm, such as 8.0");
        /// Moment of inertia J; at least so much that the joint swings on its wires with no more than 3 kHz.
        "inertia_kg_mm2" = at(mechanics.inertia_kg_m2), number(micro("kg mm²"), 1e-6, 1e9),
            Required("the moment of inertia in kg mm², such as 2.5");
        /// Damping B, torque per rad/s.
        "damping_n_mm_s" = at(mechanics.damping_n_m_s), number(milli("N mm s"), 0.0, 1e9),
            Computed("0.3 of critical damping on both wires at their stiffest");
        /// Spring K towards θ = 0, torque per rad.
        "spring_n_mm" = at(mechanics.spring_n_m), number(milli("N mm"), 0.0, 1e9), Number(0.0);
        /// A torque that always acts, positive in the agonist's direction.
        "torque_n_mm" = at(mechanics.torque_n_m), number(milli("N mm"), -1e9, 1e9), Number(0.0);
        /// How taut the pair is mounted: tension at the ends of its way, where one wire is wholly hot and the other
        /// wholly cold.
        "pretension_n" = at(mechanics.pretension_n), number(si("N"), 0.0, 1e5), Computed("100 MPa in the thinner wire");
        /// Anti-slack: a wire whose estimated tension falls below it is heated.
        "minimum_tension_n" = at(min_tension_n), number(si("N"), 0.0, 1e5), Computed("half of `pretension_n`");
        /// Tension that is kept where the motion leaves it free.
        "tension_n" = at(tension_n), number(si("N"), 0.0, 1e5),
            Computed("twice `pretension_n`, or `maximum_tension_n` where that is less");
        /// Anti-overload: neither wire is heated further while the estimated tension is above it.
        "maximum_tension_n" = at(max_tension_n), number(si("N"), 0.0, 1e5), Computed("500 MPa in the thinner wire");
    }],
};

/// Reads the joints key by key; what depends on their channels waits for [`complete`].
pub(crate) fn joints(reader: &mut Reader<'_>, node: &Node) -> Vec<Joint> {
    let Tree::Array(nodes) = &node.value else {
        let found = match &node.value {
            Tree::Table(_) => "a single table [joint]".into(),
            other => other.describe(),
        };
        let expected = "an array of tables: [[joint]], with two brackets".into();
        reader.problem(node.line, None, "joint", What::WrongType { found, expected });
        return Vec::new();
    };
    let mut joints = Vec::new();
    for node in nodes {
        let mut joint = Joint::unread();
        reader.section(&SECTION, Some(node), &[], None, node.line, &mut joint);
        joints.push(joint);
    }
    joints
}

/// Names that were used by joints read before: of joints with their lines, and of their wires with joint and line.
#[derive(Default)]
struct Used {
    joints: BTreeMap<String, usize>,
    wires: BTreeMap<String, (String, usize)>,
}

/// Who turns which joint, then the joints' computed defaults and what the physics says to them.
pub(crate) fn complete(reader: &mut Reader<'_>, node: &Node, rig: &mut Rig) {
    let Tree::Array(nodes) = &node.value else { return };
    let mut used = Used::default();
    for (index, node) in nodes.iter().enumerate() {
        let Tree::Table(table) = &node.value else { continue };
        let before = reader.found();
        let stated = Lines { table, header: node.line };
        let joint = &rig.joints[index];
        name_is_its_own(reader, joint, &rig.channels, &mut used, &stated);
        wires_are_its_own(reader, joint, &rig.channels, &mut used, &stated);
        let right = reader.found() == before && is_read(reader, table);
        let (Some([agonist, antagonist]), true) = (rig.channels_of(joint), right) else { continue };
        let models = [&rig.channels[agonist].model, &rig.channels[antagonist].model];
        if models.iter().all(|model| model.geometry.area_m2().is_finite()) {
            let joint = &mut rig.joints[index];
            fill(joint, models, &stated);
            relations(reader, joint, models, &stated);
        }
    }
}

/// Where the file says what of a joint.
struct Lines<'n> {
    table: &'n Table,
    header: usize,
}

impl Lines<'_> {
    fn gives(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    fn of(&self, key: &str) -> usize {
        self.table.get(key).map_or(self.header, |node| node.line)
    }
}

fn name_is_its_own(reader: &mut Reader<'_>, joint: &Joint, channels: &[Channel], used: &mut Used, stated: &Lines<'_>) {
    if joint.name.is_empty() {
        return;
    }
    let line = stated.of("name");
    if channels.iter().any(|channel| channel.name == joint.name) {
        let message = format!("\"{}\" is a channel's; expected a name of its own", joint.name);
        reader.problem(line, None, "joint.name", What::Contradiction { message });
    }
    if let Some(&first_line) = used.joints.get(&joint.name) {
        let name = joint.name.clone();
        reader.problem(line, None, "joint.name", What::Duplicate { name, first_line });
    }
    used.joints.entry(joint.name.clone()).or_insert(line);
}

fn wires_are_its_own(
    reader: &mut Reader<'_>,
    joint: &Joint,
    channels: &[Channel],
    used: &mut Used,
    stated: &Lines<'_>,
) {
    for (key, name) in [("agonist", &joint.agonist), ("antagonist", &joint.antagonist)] {
        if name.is_empty() {
            continue;
        }
        let what = if !channels.iter().any(|channel| channel.name == *name) {
            What::NotAChoice { found: name.clone(), expected: channel_choices(name, channels) }
        } else if key == "antagonist" && *name == joint.agonist {
            What::Contradiction { message: format!("is the agonist \"{name}\" itself, expected another channel") }
        } else if let Some((other, first)) = used.wires.get(name) {
            What::Contradiction {
                message: format!(
                    "is \"{name}\", which turns joint \"{other}\" already (line {first}); expected another channel"
                ),
            }
        } else {
            used.wires.insert(name.clone(), (joint.name.clone(), stated.of(key)));
            continue;
        };
        reader.problem(stated.of(key), None, format!("joint.{key}"), what);
    }
}

/// Whether nothing was found wrong in the lines of a joint's table.
fn is_read(reader: &Reader<'_>, table: &Table) -> bool {
    let mut required = SECTION.keys().filter(|key| matches!(key.default, Required(_)));
    required.all(|key| table.contains_key(key.name)) && !table.values().any(|node| reader.found_in(node.line, "joint."))
}

/// Stress at which wires are mounted and kept taut by default, in Pa.
const TAUT_PA: f64 = 100e6;
/// Stress in the thinner wire that is not exceeded by default, in Pa: short of what wears a wire out in a day.
const MOST_PA: f64 = 500e6;
/// Damping where nothing is said, as a share of what is critical on the wires at their stiffest.
const DAMPING: f64 = 0.3;

/// Fills in the computed defaults.
fn fill(joint: &mut Joint, wires: [&WireModel; 2], stated: &Lines<'_>) {
    let area = wires[0].geometry.area_m2().min(wires[1].geometry.area_m2());
    let mechanics = &mut joint.mechanics;
    if !stated.gives("damping_n_mm_s") {
        mechanics.damping_n_m_s = DAMPING * 2.0 * mechanics.inertia_kg_m2 * mechanics.fastest_rad_s(wires);
    }
    if !stated.gives("pretension_n") {
        mechanics.pretension_n = TAUT_PA * area;
    }
    if !stated.gives("minimum_tension_n") {
        joint.min_tension_n = 0.5 * mechanics.pretension_n;
    }
    if !stated.gives("maximum_tension_n") {
        joint.max_tension_n = MOST_PA * area;
    }
    if !stated.gives("tension_n") {
        joint.tension_n = (2.0 * mechanics.pretension_n).min(joint.max_tension_n);
    }
}

/// What the physics and its own tensions say to a joint that is complete.
fn relations(reader: &mut Reader<'_>, joint: &Joint, wires: [&WireModel; 2], stated: &Lines<'_>) {
    if let Err(sinew_physics::Error::OutOfRange { key, found, low, high }) = joint.mechanics.validate(wires) {
        let (found, low, high) = (tidy(found), tidy(low), tidy(high));
        let what = What::OutOfRange { found, low, high, defaulted: !stated.gives(key) };
        reader.problem(stated.of(key), None, format!("joint.{key}"), what);
    }
    let (least, kept, most) = (joint.min_tension_n, joint.tension_n, joint.max_tension_n);
    if !(least < kept && kept <= most) {
        let keys = ["tension_n", "minimum_tension_n", "maximum_tension_n", "pretension_n"];
        let key = keys.into_iter().find(|key| stated.gives(key)).unwrap_or("tension_n");
        let message = format!(
            "leaves no tension: minimum_tension_n {}, tension_n {}, maximum_tension_n {}; expected them in this order",
            tidy(least),
            tidy(kept),
            tidy(most)
        );
        reader.problem(stated.of(key), None, format!("joint.{key}"), What::Contradiction { message });
    }
}
