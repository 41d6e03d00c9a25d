//! A wire that is known by name: what its data sheet says where the file says nothing.

use crate::notes::Stated;
use crate::tables::{Channel, key_of_channel};

/// Fills in what the kind of a wire says of it and of its material.
pub(crate) fn of_its_kind(channel: &mut Channel, stated: &Stated<'_>) {
    let Some(kind) = channel.wire_kind else { return };
    let mut like_it = channel.clone();
    (like_it.model.geometry.diameter_m, like_it.model.material) = (kind.diameter_m, kind.material());
    let places = [("wire", "diameter_mm")].into_iter().chain(kind.says().iter().map(|key| ("material", *key)));
    for (table, name) in places.filter(|(table, name)| !stated.gives(table, name)) {
        if let Some(key) = key_of_channel(if table == "wire" { "channel.wire" } else { "channel.material" }, name)
            && let Some(value) = key.get(&like_it)
        {
            key.set(channel, value);
        }
    }
}
