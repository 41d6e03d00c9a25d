//! Changes in the text of a rig file that leave everything else of it as it is.

use toml_edit::{Item, Table, TableLike};

/// The table at a path, made where it is not there yet.
pub(crate) fn table_at<'a>(root: &'a mut dyn TableLike, path: &[&str]) -> Option<&'a mut dyn TableLike> {
    let mut at = root;
    for (depth, part) in path.iter().enumerate() {
        let item = at.entry(part).or_insert_with(|| {
            let mut table = Table::new();
            // Tables that only hold tables need no header of their own.
            table.set_implicit(depth + 1 < path.len());
            Item::Table(table)
        });
        at = item.as_table_like_mut()?;
    }
    Some(at)
}

/// The table at a path, where there is one.
pub(crate) fn table_if<'a>(root: &'a dyn TableLike, path: &[&str]) -> Option<&'a dyn TableLike> {
    path.iter().try_fold(root, |at, part| at.get(part)?.as_table_like())
}

/// Sets a value, keeping the spaces and the comment around the one it replaces.
pub(crate) fn put(root: &mut dyn TableLike, path: &[&str], key: &str, mut value: toml_edit::Value) {
    let Some(table) = table_at(root, path) else { return };
    match table.get_mut(key) {
        Some(Item::Value(old)) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        _ => {
            table.insert(key, Item::Value(value));
        }
    }
}

/// Takes a key out of the table at a path, where there is one.
pub(crate) fn remove(root: &mut dyn TableLike, path: &[&str], key: &str) {
    let mut at = root;
    for part in path {
        let Some(next) = at.get_mut(part).and_then(Item::as_table_like_mut) else { return };
        at = next;
    }
    at.remove(key);
}
