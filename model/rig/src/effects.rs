//! Effects of the catalogue in a rig file.
//!
//! What they are is said once, in [`sinew_physics::effects`]. Here is how they stand in the text: the few keys that
//! take a word instead of a number, names of their numbers for priors and how they are read.

use sinew_physics::WireModel;
use sinew_physics::effects::{self, DelayedSensor, Effect, EffectParameter, Home};

use crate::error::What;
use crate::key::{Prior, shortest};
use crate::notes::{Reader, Stated};
use crate::own::{self, Catalogue, DEFINITION, OWN};
use crate::suggest::nearest;
use crate::tables::Channel;
use crate::tree::{Node, Table, Tree};
use crate::value::{channel_choices, in_range, not_a_choice, number as any_number, unknown_hint};

/// The effect that needs to be told when it acts.
pub(crate) const DRAUGHT: &str = "thermal.draught";
/// The comment above a table that the writer adds for an effect that is no mechanism.
pub(crate) const EMPIRICAL: &str = "# empirical: fitted to a recording, not a mechanism";

/// How far sensors as they are bought and mounted are off, by the full name of the effect's number: every fit has these
/// as nuisances. Amplifiers on one board agree better than a load cell's or an encoder's scale.
pub(crate) const SENSOR_TOLERANCES: [(&str, Prior); 10] = [
    ("sensing.gain.v3", Prior::Absolute(0.002)),
    ("sensing.gain.current", Prior::Absolute(0.005)),
    ("sensing.gain.force", Prior::Absolute(0.01)),
    ("sensing.gain.position", Prior::Absolute(0.01)),
    ("sensing.offset.v1_v", Prior::Absolute(0.001)),
    ("sensing.offset.v2_v", Prior::Absolute(0.001)),
    ("sensing.offset.v3_v", Prior::Absolute(0.001)),
    ("sensing.offset.current_a", Prior::Absolute(0.0005)),
    ("sensing.offset.force_n", Prior::Absolute(0.01)),
    ("sensing.offset.position_m", Prior::Absolute(5e-5)),
];

/// The effects of the catalogue that stand in `[channel.effects."ID"]`.
pub(crate) fn in_tables() -> impl Iterator<Item = &'static Effect> + Clone {
    effects::catalogue().filter(|effect| effect.home == Home::Table)
}

/// The same of one wire, with the laws its users wrote.
pub(crate) fn in_tables_of(model: &WireModel) -> impl Iterator<Item = &'static Effect> + '_ {
    model.catalogue().filter(|effect| effect.home == Home::Table)
}

/// The number of an effect of one wire in a table by its full name, such as `thermal.draught.gain`.
pub(crate) fn number(model: &WireModel, name: &str) -> Option<&'static EffectParameter> {
    let (id, key) = name.rsplit_once('.')?;
    let effect = in_tables_of(model).find(|effect| effect.id == id)?;
    effect.parameters.iter().find(|p| p.key == key)
}

/// A number of an effect as the shortest decimal that reads back as the same model.
pub(crate) fn in_file(parameter: &EffectParameter, model: &WireModel) -> f64 {
    let mut again = model.clone();
    shortest(parameter.get(model), |decimal| {
        parameter.set(&mut again, decimal);
        again.effects == model.effects
    })
}

/// A key of an effect that takes a word.
pub(crate) struct Word {
    pub effect: &'static str,
    pub key: &'static str,
    /// What it is, for the page.
    pub about: &'static str,
    /// What holds where it is not given, for the page.
    pub default: &'static str,
    /// `None` where the file need not say it.
    pub get: fn(&Channel) -> Option<String>,
    /// `None` for the default.
    pub set: fn(&mut Channel, Option<&str>) -> Result<(), What>,
}

/// All of them.
pub(crate) static WORDS: [Word; 3] = [
    Word {
        effect: "thermal.neighbour",
        key: "channel",
        about: "Name of the channel whose wire is the neighbour, as the simulated backend and `diagnose --whole-rig` \
                have it. \
                `simulate` and fits of one channel know one wire: there the neighbour is at ambient temperature",
        default: "a body at ambient temperature",
        get: |channel| channel.neighbour.clone(),
        set: |channel, name| {
            channel.neighbour = name.map(str::to_string);
            Ok(())
        },
    },
    Word {
        effect: "electrical.supply_sag",
        key: "supply",
        about: "Name of the supply. It sags under the sum of the currents of all channels that name it, as the \
                simulated backend and `diagnose --whole-rig` have it; `simulate` and fits of one channel know that \
                wire's current only",
        default: "a supply of its own",
        get: |channel| channel.supply.clone(),
        set: |channel, name| {
            channel.supply = name.map(str::to_string);
            Ok(())
        },
    },
    Word {
        effect: "sensing.delay",
        key: "sensor",
        about: "Which sensor lags: `position_m`, `force_n`, `current_a`, or `voltages`",
        default: "`position_m`",
        get: |channel| {
            let sensor = channel.model.effects.sensing.delay.sensor;
            (sensor != DelayedSensor::default()).then(|| sensor.name().to_string())
        },
        set: |channel, name| {
            let found = name.map_or(Some(DelayedSensor::default()), DelayedSensor::from_name);
            let words = DelayedSensor::ALL.map(DelayedSensor::name);
            let wrong = || not_a_choice(name.unwrap_or(""), &words);
            channel.model.effects.sensing.delay.sensor = found.ok_or_else(wrong)?;
            Ok(())
        },
    },
];

/// The words of one effect.
pub(crate) fn words(effect: &'static Effect) -> impl Iterator<Item = &'static Word> {
    WORDS.iter().filter(|word| word.effect == effect.id)
}

/// Reads `[channel.effects."ID"]`.
pub(crate) fn read(reader: &mut Reader<'_>, node: &Node, label: &str, catalogue: &Catalogue, channel: &mut Channel) {
    let Some(table) = reader.table(node, Some(label), "effects", "[channel.effects.\"ID\"]") else { return };
    for (id, node) in table {
        let path = format!("effects.\"{id}\"");
        let own = id.strip_prefix(OWN);
        if own.is_none() && !in_tables().any(|effect| effect.id == id) {
            reader.problem(node.line, Some(label), path, What::Unknown { hint: unknown_effect(id) });
            continue;
        }
        let Some(keys) = reader.table(node, Some(label), &path, &format!("[channel.effects.\"{id}\"]")) else {
            continue;
        };
        let before = reader.found();
        if let Some(name) = own
            && !declare(reader, label, (&path, name), (node.line, keys), catalogue, channel)
        {
            continue;
        }
        let Some(effect) = channel.model.effect(id) else { continue };
        for (key, node) in keys.iter().filter(|(key, _)| own.is_none() || !DEFINITION.contains(&key.as_str())) {
            let result = if let Some(p) = effect.parameters.iter().find(|p| p.key == key) {
                in_range(node, p.low, p.high).map(|value| p.set(&mut channel.model, value))
            } else if let Some(word) = words(effect).find(|word| word.key == key) {
                match &node.value {
                    Tree::Text(text) => (word.set)(channel, Some(text)),
                    other => Err(What::WrongType { found: other.describe(), expected: "a name in quotes".into() }),
                }
            } else {
                let known = effect.parameters.iter().map(|p| p.key).chain(words(effect).map(|w| w.key));
                Err(What::Unknown { hint: unknown_hint(key, "", known) })
            };
            if let Err(what) = result {
                reader.problem(node.line, Some(label), format!("{path}.{key}"), what);
            }
        }
        if reader.found() > before || effect.is_null(&channel.model) {
            continue;
        }
        if id == DRAUGHT {
            draught(reader, node.line, keys, label);
        }
        if !effect.applies_to(&channel.model) {
            let message = if effect.is_barred_by_detwinning(&channel.model) {
                "cannot be had beside detwinning_start_mpa in [channel.material]; take one of the two out"
            } else {
                "has nothing to act on with this drive, load, taps and criterion; take it out"
            };
            let message = message.into();
            reader.problem(node.line, Some(label), path, What::Contradiction { message });
        }
    }
}

/// Gives the channel a law its users wrote: the one defined in this table, or that of the catalogue. False where it is
/// neither.
fn declare(
    reader: &mut Reader<'_>,
    label: &str,
    (path, name): (&str, &str),
    (header, keys): (usize, &Table),
    catalogue: &Catalogue,
    channel: &mut Channel,
) -> bool {
    let given = channel.model.effects.own.laws().find(|law| law.definition.name == name);
    if !DEFINITION.iter().any(|key| keys.contains_key(*key)) {
        if given.is_none() {
            let expected = "a formula; or read the file with the catalogue that defines it, by --catalogue".into();
            reader.problem(header, Some(label), path, What::Missing { expected });
        }
        return given.is_some();
    }
    let Some(law) = own::law(reader, Some(label), path, name, header, keys) else { return false };
    if given.is_some_and(|given| !std::ptr::eq(given, law)) {
        reader.problem(header, Some(label), path, own::another(catalogue));
        return false;
    }
    channel.model.effects.own.declare(law);
    true
}

/// A draught that blows does so for a while, and only the file can say when.
fn draught(reader: &mut Reader<'_>, header: usize, keys: &Table, label: &str) {
    let path = |key: &str| format!("effects.\"{}\".{key}", DRAUGHT);
    let mut times = [0.0; 2];
    for (time, (key, moment)) in times.iter_mut().zip([("start_s", "begins"), ("end_s", "ends")]) {
        match keys.get(key).map(|node| any_number(node, "")) {
            Some(Ok(found)) => *time = found,
            _ => {
                let expected = format!("when it {moment}, in s from the first sample");
                return reader.problem(header, Some(label), path(key), What::Missing { expected });
            }
        }
    }
    let [start, end] = times;
    if end <= start {
        let message = format!("is {end}, expected more than start_s, {start}");
        let line = keys.get("end_s").map_or(header, |node| node.line);
        reader.problem(line, Some(label), path("end_s"), What::Contradiction { message });
    }
}

/// Neighbours named by effects must be other channels.
pub(crate) fn neighbours(reader: &mut Reader<'_>, channels: &[Channel], read: &[Stated<'_>]) {
    for (channel, stated) in channels.iter().zip(read) {
        let Some(name) = &channel.neighbour else { continue };
        let what = if *name == channel.name {
            What::Contradiction {
                message: "is the channel itself, expected another, or none for a body at ambient".into(),
            }
        } else if channels.iter().any(|c| c.name == *name) {
            continue;
        } else {
            What::NotAChoice {
                found: name.clone(),
                expected: channel_choices(name, channels.iter().map(|c| c.name.as_str())),
            }
        };
        let line = stated.line_at(&["effects", "thermal.neighbour", "channel"]);
        reader.problem(line, Some(&channel.name), "effects.\"thermal.neighbour\".channel", what);
    }
}

/// What an unknown effect was probably meant to be.
fn unknown_effect(id: &str) -> String {
    let known = effects::catalogue();
    if let Some(effect) = known.clone().find(|e| e.id == id && e.home == Home::Material) {
        let keys: Vec<&str> = effect.parameters.iter().map(|p| p.key).collect();
        return format!(" here: it is part of the reference model, set {} in [channel.material]", keys.join(" and "));
    }
    if known.clone().any(|e| e.id.split('.').next() == Some(id)) {
        // [channel.effects.thermal.draught] without quotes is a table in a table.
        return " as an effect; write its id in quotes, such as [channel.effects.\"thermal.draught\"]".into();
    }
    match nearest(id, known.map(|e| e.id)) {
        Some(near) => format!(", did you mean \"{near}\"?"),
        None => "; the effects are listed in docs/effects.md".into(),
    }
}
