//! The joints: whose wires turn them, their computed defaults, and what the physics says to them.

use std::collections::BTreeMap;

use sinew_physics::WireModel;

use crate::error::What;
use crate::key::Default::Required;
use crate::notes::{Reader, tidy};
use crate::tables::{Channel, JOINT, Joint, Rig};
use crate::tree::{Node, Table, Tree};
use crate::value::channel_choices;

/// Names that were used by joints read before: of joints with their lines, and of their wires with joint and line.
#[derive(Default)]
struct Used {
    joints: BTreeMap<String, usize>,
    wires: BTreeMap<String, (String, usize)>,
}

/// Who turns which joint, then the joints' computed defaults and what the physics says to them.
pub(crate) fn joints(reader: &mut Reader<'_>, node: &Node, rig: &mut Rig) {
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
            What::NotAChoice {
                found: name.clone(),
                expected: channel_choices(name, channels.iter().map(|c| c.name.as_str())),
            }
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
    let mut required = JOINT.keys().filter(|key| matches!(key.default, Required(_)));
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
