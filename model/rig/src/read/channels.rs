//! Reading `[[channel]]`: each channel's tables key by key; what depends on several of them is left to
//! [`crate::complete`].

use std::collections::BTreeMap;

use crate::complete;
use crate::effects;
use crate::error::What;
use crate::key::Section;
use crate::notes::{Given, Reader, Stated};
use crate::own::Catalogue;
use crate::parameters;
use crate::read::walk::{descend, within};
use crate::tables::{Channel, MAX_CHANNEL_NAME, MAX_CHANNELS, Rig, of_channel};
use crate::tree::{Node, Table, Tree};
use crate::value::is_name;

/// Tables of a channel that are more than a plain list of keys.
const OTHER_TABLES: [&str; 2] = ["priors", "effects"];

/// Reads the channels; for each, what of it stood in the file and whether it is right key by key.
pub(crate) fn channels<'n>(
    reader: &mut Reader<'_>,
    node: Option<&'n Node>,
    catalogue: &Catalogue,
    rig: &mut Rig,
) -> Vec<Stated<'n>> {
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
        let (channel, stated) = channel(reader, &place, (node.line, table), catalogue, rig);
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
    (header, table): (usize, &'n Table),
    catalogue: &Catalogue,
    rig: &Rig,
) -> (Channel, Stated<'n>) {
    let before = reader.found();
    let mut channel = Channel::unread(rig.ambient_c);
    for law in &catalogue.laws {
        channel.model.effects.own.declare(law.0);
    }
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
    complete::of_its_kind(&mut channel, &stated);
    if let Some(joint) = rig.joints.iter().find(|joint| joint.side(&channel.name).is_some()) {
        complete::in_joint(reader, &mut channel, joint, &mut stated);
    }
    if let Some(node) = table.get("effects") {
        effects::read(reader, node, label, catalogue, &mut channel);
    }
    if let Some(node) = table.get("priors") {
        channel.priors = parameters::priors(reader, node, label, &channel);
    }
    for section in of_channel() {
        reader.belonging(section, &channel, &stated);
    }
    complete::channel(reader, &channel, &stated);
    stated.right = reader.found() == before;
    (channel, stated)
}
