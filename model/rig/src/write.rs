//! From a rig back to text: the user's own text with the changed values in their places.

use sinew_physics::effects::Nature;
use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike};

use crate::effects;
use crate::parameters::{MODEL_TABLES, Prior};
use crate::read;
use crate::schema::{CHANNEL, JOINT, Kind, OF_RIG, RIG, Section, Value, local};
use crate::types::*;

impl Rig {
    /// The rig as the text of a rig file. It is the text the rig came from: comments, order and what was not changed
    /// stay as they are, changed values stand in their places, and keys that were not written before are added to
    /// their table. Defaults are not written out; limits and ranges computed from values that were changed are computed
    /// anew by whoever reads the text.
    pub fn to_toml(&self) -> String {
        // A rig is only ever made from text that reads well, so both of these succeed.
        let (base, mut document) = match (read::rig(&self.source.text, ""), self.source.text.parse::<DocumentMut>()) {
            (Ok(base), Ok(document)) => (Some(base), document),
            _ => (None, DocumentMut::new()),
        };
        let base = base.as_ref();
        if base.is_some_and(|base| self == base) {
            return self.source.text.clone();
        }
        for section in [&RIG].into_iter().chain(OF_RIG) {
            let path: Vec<&str> = section.table.split('.').collect();
            write_section(document.as_table_mut(), &path, section, self, base);
        }
        self.write_channels(&mut document, base);
        self.write_joints(&mut document, base);
        self.write_columns(&mut document, base);
        self.write_faults(&mut document, base);
        // A model is what it is to the last number. Where one was a default computed from another that has changed
        // (the preload of a hanging mass), it has to be written out to stay.
        if let Ok(again) = read::rig(&document.to_string(), "") {
            for (index, (channel, read)) in self.channels.iter().zip(&again.channels).enumerate() {
                if channel.model == read.model {
                    continue;
                }
                let Some(table) = table_in(&mut document, "channel", index) else { continue };
                for section in CHANNEL.iter().filter(|s| MODEL_TABLES.contains(&s.table)) {
                    write_section(table, &[local(section.table)], section, channel, Some(read));
                }
                write_effects(table, channel, Some(read));
            }
        }
        document.to_string()
    }

    fn write_channels(&self, document: &mut DocumentMut, base: Option<&Rig>) {
        let old = base.map_or(&[][..], |b| &b.channels);
        let places = arrange(document, "channel", old, &self.channels, |channel| &channel.name);
        for (index, (channel, place)) in self.channels.iter().zip(places).enumerate() {
            let Some(table) = table_in(document, "channel", index) else { continue };
            write_channel(table, channel, place.map(|place| &old[place]));
            // What was its joint's to say before has to be said now.
            let left = place.is_some_and(|place| base.is_some_and(|b| b.joint_of(place).is_some()))
                && self.joint_of(index).is_none();
            if let Some(load) = CHANNEL.iter().find(|section| left && section.table == "channel.load") {
                write_section(table, &[local(load.table)], load, channel, None);
            }
        }
    }

    fn write_joints(&self, document: &mut DocumentMut, base: Option<&Rig>) {
        let old = base.map_or(&[][..], |b| &b.joints);
        let places = arrange(document, "joint", old, &self.joints, |joint| &joint.name);
        for (index, (joint, place)) in self.joints.iter().zip(places).enumerate() {
            if let Some(table) = table_in(document, "joint", index) {
                write_section(table, &[], &JOINT, joint, place.map(|place| &old[place]));
            }
        }
    }

    fn write_columns(&self, document: &mut DocumentMut, base: Option<&Rig>) {
        let root = document.as_table_mut();
        let path = ["recording", "columns"];
        let nothing = ColumnMap::new();
        let old = base.map_or(&nothing, |b| &b.columns);
        for name in old.keys().filter(|name| !self.columns.contains_key(*name)) {
            remove(root, &path, name);
        }
        for (name, column) in self.columns.iter().filter(|(name, column)| old.get(*name) != Some(column)) {
            let mut table = InlineTable::new();
            table.insert("column", column.column.as_str().into());
            table.insert("scale", column.scale.into());
            table.insert("offset", column.offset.into());
            put(root, &path, name, table.into());
        }
    }

    fn write_faults(&self, document: &mut DocumentMut, base: Option<&Rig>) {
        // By name, not by index: channels may have moved.
        let named = |rig: &Rig| -> Vec<(Option<String>, SimulatedFault)> {
            let name = |f: &SimulatedFault| f.channel.and_then(|i| rig.channels.get(i)).map(|c| c.name.clone());
            let unplaced = |f: &SimulatedFault| SimulatedFault { channel: None, ..f.clone() };
            rig.simulation.faults.iter().map(|f| (name(f), unplaced(f))).collect()
        };
        let faults = named(self);
        if base.map(named).unwrap_or_default() == faults {
            return;
        }
        remove(document.as_table_mut(), &["simulation"], "fault");
        if faults.is_empty() {
            return;
        }
        let mut tables = ArrayOfTables::new();
        for (channel, fault) in faults {
            let mut table = Table::new();
            if let Some(name) = channel {
                table.insert("channel", toml_edit::value(name));
            }
            if let Some((word, _)) = FaultKind::ALL.iter().find(|(_, kind)| *kind == fault.kind) {
                table.insert("kind", toml_edit::value(*word));
            }
            table.insert("start_s", toml_edit::value(fault.start_s));
            if fault.end_s.is_finite() {
                table.insert("end_s", toml_edit::value(fault.end_s));
            }
            if let Some(value) = fault.value {
                table.insert("value", toml_edit::value(value));
            }
            tables.push(table);
        }
        if let Some(simulation) = table_at(document.as_table_mut(), &["simulation"]) {
            simulation.insert("fault", Item::ArrayOfTables(tables));
        }
    }
}

/// Gives every one of `new` a table in the array `name`, its old one where it had one; says which of `old` each was.
fn arrange<T>(
    document: &mut DocumentMut,
    name: &str,
    old: &[T],
    new: &[T],
    called: impl Fn(&T) -> &String,
) -> Vec<Option<usize>> {
    // The same number of them: one may have been renamed. Another number: go by name.
    if old.len() == new.len() {
        return (0..new.len()).map(Some).collect();
    }
    // Only headers can be moved about, so tables written as an inline array get headers.
    let tables = match document.remove(name).map(Item::into_array_of_tables) {
        Some(Ok(tables)) => tables,
        _ => ArrayOfTables::new(),
    };
    let places: Vec<_> = new.iter().map(|now| old.iter().position(|o| called(o) == called(now))).collect();
    let mut kept = ArrayOfTables::new();
    for place in &places {
        let mut table = place.and_then(|place| tables.get(place)).cloned().unwrap_or_default();
        forget_place(&mut table);
        kept.push(table);
    }
    if !kept.is_empty() {
        document.insert(name, Item::ArrayOfTables(kept));
    }
    places
}

/// A table of an array of them, whether it has a header of its own or stands in an inline array.
fn table_in<'a>(document: &'a mut DocumentMut, name: &str, index: usize) -> Option<&'a mut dyn TableLike> {
    match document.get_mut(name)? {
        Item::ArrayOfTables(tables) => tables.get_mut(index).map(|t| t as &mut dyn TableLike),
        Item::Value(toml_edit::Value::Array(array)) => {
            array.get_mut(index).and_then(|v| v.as_inline_table_mut()).map(|t| t as &mut dyn TableLike)
        }
        _ => None,
    }
}

fn write_channel(table: &mut dyn TableLike, channel: &Channel, base: Option<&Channel>) {
    for section in CHANNEL {
        let name = local(section.table);
        if section.optional && section.keys.iter().all(|k| (k.get)(channel).is_none()) {
            // Its required keys would be missed if the empty table stayed.
            table.remove(name);
        } else {
            let path: Vec<&str> = name.split('.').filter(|part| !part.is_empty()).collect();
            write_section(table, &path, section, channel, base);
        }
    }
    if channel.model.drive.kind != sinew_physics::DriveKind::Pwm {
        remove(table, &["limits"], "maximum_duty");
    }

    let nothing = Default::default();
    let old = base.map_or(&nothing, |b| &b.priors);
    for key in old.keys().filter(|key| !channel.priors.contains_key(*key)) {
        remove(table, &["priors"], key);
    }
    for (key, prior) in channel.priors.iter().filter(|(key, prior)| old.get(*key) != Some(prior)) {
        let value = match prior {
            Prior::Absolute(sigma) => (*sigma).into(),
            Prior::Relative(fraction) => format!("{} %", percent(*fraction)).into(),
        };
        put(table, &["priors"], key, value);
    }

    write_effects(table, channel, base);
}

/// Writes what differs from `base`. An effect that begins to act has its shape written out with the switches that are on;
/// of one that does not act, only what is not at its default stays.
fn write_effects(table: &mut dyn TableLike, channel: &Channel, base: Option<&Channel>) {
    for effect in effects::in_tables() {
        let path = ["effects", effect.id];
        let model = &channel.model;
        let acts = !effect.is_null(model);
        let begins = acts && base.is_none_or(|b| effect.is_null(&b.model));
        let is_new = table_if(table, &path).is_none();
        for p in effect.parameters {
            let (now, default) = ((p.get)(model), p.default(model));
            let changed = now != base.map_or(default, |b| (p.get)(&b.model));
            let written = table_if(table, &path).is_some_and(|t| t.contains_key(p.key));
            if changed && now == default && (!acts || p.is_switch()) {
                remove(table, &path, p.key);
            } else if changed || (begins && !written && !p.is_switch()) {
                put(table, &path, p.key, effects::in_file(p, model).into());
            }
        }
        for word in effects::words(effect) {
            let now = (word.get)(channel);
            if now != base.and_then(word.get) {
                match now {
                    Some(now) => put(table, &path, word.key, now.into()),
                    None => remove(table, &path, word.key),
                }
            }
        }
        if is_new
            && effect.nature == Nature::Empirical
            && let Some(new) = table.get_mut("effects").and_then(|t| t.get_mut(effect.id)).and_then(Item::as_table_mut)
        {
            new.decor_mut().set_prefix(format!("\n{}\n", effects::EMPIRICAL));
        }
        let was_empty = base.is_some_and(|b| effect.is_null(&b.model));
        if !was_empty && table_if(table, &path).is_some_and(|t| t.is_empty()) {
            remove(table, &path[..1], effect.id);
        }
    }
}

/// Writes what differs from `base`; without one, everything.
fn write_section<T>(
    root: &mut dyn TableLike,
    path: &[&str],
    section: &'static Section<T>,
    target: &T,
    base: Option<&T>,
) {
    for key in section.keys {
        let now = (key.get)(target);
        if base.is_some_and(|base| (key.get)(base) == now) {
            continue;
        }
        match (now, &key.kind) {
            (Some(Value::Number(si)), Kind::Number { scale, .. }) => {
                put(root, path, key.name, scale.to_file(si).into())
            }
            (Some(Value::Number(n)), _) => put(root, path, key.name, n.into()),
            (Some(Value::Boolean(on)), _) => put(root, path, key.name, on.into()),
            (Some(Value::Integer(i)), _) => put(root, path, key.name, i.into()),
            (Some(Value::Text(text)), _) => put(root, path, key.name, text.into()),
            (None, _) => remove(root, path, key.name),
        }
    }
}

/// The table at a path, made where it is not there yet.
fn table_at<'a>(root: &'a mut dyn TableLike, path: &[&str]) -> Option<&'a mut dyn TableLike> {
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
fn table_if<'a>(root: &'a dyn TableLike, path: &[&str]) -> Option<&'a dyn TableLike> {
    path.iter().try_fold(root, |at, part| at.get(part)?.as_table_like())
}

/// Sets a value, keeping the spaces and the comment around the one it replaces.
fn put(root: &mut dyn TableLike, path: &[&str], key: &str, mut value: toml_edit::Value) {
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

/// Lets a table and those in it be printed where they now are, not where they once were.
fn forget_place(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(inner) => forget_place(inner),
            Item::ArrayOfTables(inner) => inner.iter_mut().for_each(forget_place),
            _ => {}
        }
    }
}

fn remove(root: &mut dyn TableLike, path: &[&str], key: &str) {
    let mut at = root;
    for part in path {
        let Some(next) = at.get_mut(part).and_then(Item::as_table_like_mut) else { return };
        at = next;
    }
    at.remove(key);
}

/// A fraction in percent, as the decimal that reads back as the same fraction.
fn percent(fraction: f64) -> f64 {
    let guess = fraction * 100.0;
    (0..17)
        .filter_map(|digits| format!("{guess:.digits$e}").parse::<f64>().ok())
        .find(|p| p / 100.0 == fraction)
        .unwrap_or(guess)
}
