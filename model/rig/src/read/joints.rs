//! Reading `[[joint]]`, key by key; what depends on the joints' channels is left to [`crate::complete`].

use crate::error::What;
use crate::notes::{Reader, Stated};
use crate::tables::{JOINT, Joint};
use crate::tree::{Node, Tree};

/// Reads the joints key by key.
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
        let given = reader.section(&JOINT, Some(node), &[], None, node.line, &mut joint);
        if let Tree::Table(table) = &node.value {
            let stated = Stated { given, header: node.line, label: None, table, right: true };
            reader.belonging(&JOINT, &joint, &stated);
        }
        joints.push(joint);
    }
    joints
}
