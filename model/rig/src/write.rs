//! From a rig back to text: the user's own text with the changed values in their places.

use sinew_physics::effects::{Nature, row_of};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike};

use crate::edit::{put, remove, table_if};
use crate::effects;
use crate::error::Error;
use crate::key::{Kind, Prior, Section, Value, shortest};
use crate::own;
use crate::parameters::MODEL_TABLES;
use crate::tables::simulation::NamedFault;
use crate::tables::{Channel, JOINT, RIG, Rig, of_channel, of_rig, recording, simulation};

impl Rig {
    /// The rig as the text of a rig file. It is the text the rig came from: comments, order and what was not changed
    /// stay as they are, changed values stand in their places, and keys that were not written before are added to
    /// their table. Defaults are not written out; limits and ranges computed from values that were changed are computed
    /// anew by whoever reads the text.
    pub fn to_toml(&self) -> String {
        // A rig is only ever made from text that reads well, so both of these succeed.
        let (base, mut document) = match (self.read_again(&self.source.text), self.source.text.parse::<DocumentMut>()) {
            (Ok(base), Ok(document)) => (Some(base), document),
            _ => (None, DocumentMut::new()),
        };
        let base = base.as_ref();
        let acts = |channel: &Channel| channel.model.effects.own.laws().any(|law| !row_of(law).is_null(&channel.model));
        // a law that acts is written with its definition, which may stand in a catalogue
        if base.is_some_and(|base| self == base) && !self.channels.iter().any(acts) {
            return self.source.text.clone();
        }
        for section in [&*RIG].into_iter().chain(of_rig()) {
            let path: Vec<&str> = section.table.split('.').collect();
            write_section(document.as_table_mut(), &path, section, self, base);
        }
        self.write_channels(&mut document, base);
        self.write_joints(&mut document, base);
        recording::write_mapping(document.as_table_mut(), &self.recording, base.map(|base| &base.recording));
        let old_faults = base.map(Rig::named_faults).unwrap_or_default();
        simulation::write_faults(document.as_table_mut(), self.named_faults(), &old_faults);
        // A model is what it is to the last number. Where one was a default computed from another that has changed
        // (the preload of a hanging mass), it has to be written out to stay.
        if let Ok(again) = self.read_again(&document.to_string()) {
            for (index, (channel, read)) in self.channels.iter().zip(&again.channels).enumerate() {
                if channel.model == read.model {
                    continue;
                }
                let Some(table) = table_in(&mut document, "channel", index) else { continue };
                for section in of_channel().filter(|s| MODEL_TABLES.contains(&s.table)) {
                    write_section(table, &[section.local()], section, channel, Some(read));
                }
                write_effects(table, channel, Some(read));
            }
        }
        document.to_string()
    }

    /// The rig as its file would be read again: computed limits and ranges follow parameters that were changed.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a field was set to something no rig file may say.
    pub fn refreshed(&self) -> Result<Rig, Error> {
        Rig::parse_with(&self.to_toml(), &self.source.file, &self.source.catalogue)
    }

    /// A text read as this rig's was.
    fn read_again(&self, text: &str) -> Result<Rig, Error> {
        Rig::parse_with(text, "", &self.source.catalogue)
    }

    /// The simulated faults by the names of the channels they strike.
    fn named_faults(&self) -> Vec<NamedFault> {
        let name = |index: usize| self.channels.get(index).map(|channel| channel.name.as_str());
        self.simulation.faults.iter().map(|fault| fault.named(name)).collect()
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
            if let Some(load) = of_channel().find(|section| left && section.table == "channel.load") {
                write_section(table, &[load.local()], load, channel, None);
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
    for section in of_channel() {
        let name = section.local();
        if section.optional && section.keys().all(|k| k.get(channel).is_none()) {
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
    for effect in effects::in_tables_of(&channel.model) {
        let path = ["effects", effect.id];
        let model = &channel.model;
        let acts = !effect.is_null(model);
        let begins = acts && base.is_none_or(|b| effect.is_null(&b.model));
        let is_new = table_if(table, &path).is_none();
        if let Some(law) = channel.model.effects.own.laws().find(|law| law.id() == effect.id)
            && acts
        {
            // whoever reads it may not have the catalogue it came from
            own::write(table, &path, law);
        }
        for p in effect.parameters {
            let (now, default) = (p.get(model), p.default(model));
            let changed = now != base.map_or(default, |b| p.get(&b.model));
            let written = table_if(table, &path).is_some_and(|t| t.contains_key(p.key));
            if changed && now == default && (!acts || p.is_switch()) {
                remove(table, &path, p.key);
            } else if changed || (begins && !written && p.is_shape()) {
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
fn write_section<T: 'static>(
    root: &mut dyn TableLike,
    path: &[&str],
    section: &'static Section<T>,
    target: &T,
    base: Option<&T>,
) {
    for key in section.keys() {
        let now = key.get(target);
        if base.is_some_and(|base| key.get(base) == now) {
            continue;
        }
        let value = match (now, &key.takes) {
            (Some(Value::Number(si)), Kind::Number { unit, .. }) => unit.to_file(si).into(),
            (Some(Value::Number(n)), _) => n.into(),
            (Some(Value::Integer(i)), Kind::Integer { times, .. }) => (i / times).into(),
            (Some(Value::Integer(i)), _) => i.into(),
            (Some(Value::Boolean(on)), _) => on.into(),
            (Some(Value::Text(text)), _) => text.into(),
            (None, _) => {
                remove(root, path, key.name);
                continue;
            }
        };
        put(root, path, key.name, value);
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

/// A fraction in percent, as the decimal that reads back as the same fraction.
fn percent(fraction: f64) -> f64 {
    shortest(fraction * 100.0, |percent| percent / 100.0 == fraction)
}
