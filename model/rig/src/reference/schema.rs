//! The JSON Schema of a rig file, from the same description of keys as everything else: editors complete and check by it.

use serde_json::{Map, Value as Json, json};
use sinew_physics::effects::{self, Home};

use crate::effects::words;
use crate::key::{Default, Kind, Section};
use crate::parameters::default_priors;
use crate::tables::{FileFormat, JOINT, RIG, of_channel, of_rig};

/// The schema (draft 7, which taplo and VS Code read). What keys need of each other it cannot say: `sinew check` does.
pub fn schema() -> Json {
    let mut root = object("A rig: what is on the bench. docs/rig.md has every key.");
    insert(&mut root, "rig", table(&RIG));
    let mut channel = object("One wire with its output, its sensors and its control.");
    for section in of_channel() {
        place(&mut channel, section.local(), section);
    }
    insert(&mut channel, "effects", effects_table());
    insert(&mut channel, "priors", priors_table());
    insert(&mut root, "channel", json!({ "type": "array", "minItems": 1, "items": channel }));
    insert(&mut root, "joint", json!({ "type": "array", "items": table(&JOINT) }));
    for section in of_rig() {
        place(&mut root, section.table, section);
    }
    let columns = json!({
        "type": "object",
        "description": "Foreign names and units of a recording's columns, by the contract's own name.",
        "additionalProperties": {
            "type": "object",
            "properties": {
                "column": { "type": "string", "description": "Its name in the file." },
                "scale": { "type": "number", "description": "What its numbers are multiplied by." },
                "offset": { "type": "number", "description": "What is then added." },
            },
            "additionalProperties": false,
        },
    });
    insert(part(&mut root, "recording"), "columns", columns);
    let mut format = object("How a foreign recording is written; what is not given is found out: docs/import.md.");
    for (name, takes) in FileFormat::KEYS {
        let kind = if name.ends_with("_line") { "integer" } else { "string" };
        insert(&mut format, name, json!({ "type": kind, "description": takes }));
    }
    insert(part(&mut root, "recording"), "format", format);
    let fault = json!({
        "type": "array",
        "items": { "type": "object", "required": ["kind", "start_s"] },
        "description": "Something that breaks in the simulation, and when: docs/simulated-rig.md.",
    });
    insert(part(&mut root, "simulation"), "fault", fault);
    root["$schema"] = "http://json-schema.org/draft-07/schema#".into();
    root["title"] = "sinew rig file".into();
    root["required"] = json!(["rig", "channel"]);
    root
}

/// A table without keys so far, which takes no other ones.
fn object(about: &str) -> Json {
    json!({ "type": "object", "description": about, "properties": {}, "additionalProperties": false })
}

fn insert(of: &mut Json, name: &str, what: Json) {
    of["properties"][name] = what;
}

/// The table of this name inside another one; made where there is none yet.
fn part<'a>(of: &'a mut Json, name: &str) -> &'a mut Json {
    let there = of["properties"].as_object_mut();
    // `of` is one of `object`'s, which have properties
    there
        .map_or_else(|| unreachable!("a table has properties"), |there| there.entry(name).or_insert_with(|| object("")))
}

/// Puts a section where its header says: `backend.serial` is a table inside a table.
fn place<T: 'static>(root: &mut Json, header: &str, section: &'static Section<T>) {
    let mut at = root;
    for name in header.split('.').filter(|name| !name.is_empty()) {
        at = part(at, name);
    }
    at["description"] = section.about.into();
    let Json::Object(keys) = table(section)["properties"].take() else { return };
    for (name, key) in keys {
        insert(at, &name, key);
    }
    let required: Vec<Json> = required(section).map(Json::from).collect();
    if !required.is_empty() {
        at["required"] = required.into();
    }
}

fn required<T: 'static>(section: &'static Section<T>) -> impl Iterator<Item = &'static str> {
    let must = |key: &&'static crate::key::Key<T>| matches!(key.default, Default::Required(_));
    section.keys().filter(must).map(|key| key.name)
}

/// A table with its keys.
fn table<T: 'static>(section: &'static Section<T>) -> Json {
    let mut out = object(section.about);
    for key in section.keys() {
        let (mut what, unit) = match &key.takes {
            Kind::Number { unit, low, high } => {
                (json!({ "type": "number", "minimum": low, "maximum": high }), unit.name)
            }
            Kind::Integer { low, high, .. } => (json!({ "type": "integer", "minimum": low, "maximum": high }), ""),
            Kind::Boolean => (json!({ "type": "boolean" }), ""),
            Kind::Choice(words) => (json!({ "enum": words }), ""),
            Kind::Name { longest } | Kind::Text { longest, .. } => {
                (json!({ "type": "string", "maxLength": longest }), "")
            }
        };
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        let computed = match key.default {
            Default::Computed(words) => format!(" Default: {words}."),
            _ => String::new(),
        };
        what["description"] = format!("{}{unit}.{computed}", key.about()).into();
        match key.default {
            Default::Number(n) => what["default"] = n.into(),
            Default::Integer(i) => what["default"] = i.into(),
            Default::Boolean(on) => what["default"] = on.into(),
            Default::Text(text) => what["default"] = text.into(),
            Default::Required(_) | Default::Computed(_) => {}
        }
        insert(&mut out, key.name, what);
    }
    let required: Vec<Json> = required(section).map(Json::from).collect();
    if !required.is_empty() {
        out["required"] = required.into();
    }
    out
}

/// The catalogue's tables, and laws of one's own, which are any.
fn effects_table() -> Json {
    let mut out = object("Physics beyond the reference model: docs/effects.md, docs/own-physics.md.");
    for effect in effects::catalogue().filter(|effect| effect.home == Home::Table) {
        let mut keys = object(effect.says);
        for p in effect.parameters {
            let unit = if p.unit.is_empty() { String::new() } else { format!(" [{}]", p.unit) };
            let about = format!("{}{unit}.", p.about);
            insert(
                &mut keys,
                p.key,
                json!({ "type": "number", "minimum": p.low, "maximum": p.high, "description": about }),
            );
        }
        for word in words(effect) {
            insert(&mut keys, word.key, json!({ "type": "string", "description": word.about }));
        }
        insert(&mut out, effect.id, keys);
    }
    out["patternProperties"] = json!({ "^own\\.": { "type": "object" } });
    out
}

/// How far each parameter may be off.
fn priors_table() -> Json {
    let names: Map<String, Json> =
        default_priors().keys().map(|key| (key.to_string(), json!({ "type": ["string", "number"] }))).collect();
    json!({
        "type": "object",
        "description": "How far a parameter may be off, as 1 σ: \"20 %\" or a number in its key's unit; 0 holds it.",
        "properties": names,
        "additionalProperties": { "type": ["string", "number"] },
    })
}
