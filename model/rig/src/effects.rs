//! Effects of the catalogue in a rig file.
//!
//! What they are is said once, in [`sinew_physics::effects`]. Here is how they stand in the text: the few keys that take
//! a word instead of a number, names of their numbers for priors, how they are read, and the page `docs/effects.md`.

use std::fmt::Write as _;

use sinew_physics::WireModel;
use sinew_physics::effects::{self, DelayedSensor, Effect, EffectParameter, Equation, Home, Nature, Role};

use crate::error::{Plain, What};
use crate::key::shortest;
use crate::notes::{Reader, Stated};
use crate::parameters::parameters;
use crate::read::value::{channel_choices, in_range, not_a_choice, number as any_number, unknown_hint};
use crate::suggest::nearest;
use crate::tables::{Channel, Rig};
use crate::tree::{Node, Table, Tree};

/// The effect that needs to be told when it acts.
pub(crate) const DRAUGHT: &str = "thermal.draught";
/// The comment above a table that the writer adds for an effect that is no mechanism.
pub(crate) const EMPIRICAL: &str = "# empirical: fitted to a recording, not a mechanism";

/// The effects that stand in `[channel.effects."ID"]`.
pub(crate) fn in_tables() -> impl Iterator<Item = &'static Effect> + Clone {
    effects::catalogue().filter(|effect| effect.home == Home::Table)
}

/// The number of an effect in a table by its full name, such as `thermal.draught.gain`.
pub(crate) fn number(name: &str) -> Option<(&'static Effect, &'static EffectParameter)> {
    let (id, key) = name.rsplit_once('.')?;
    let effect = in_tables().find(|effect| effect.id == id)?;
    Some((effect, effect.parameters.iter().find(|p| p.key == key)?))
}

/// A number of an effect as the shortest decimal that reads back as the same model.
pub(crate) fn in_file(parameter: &EffectParameter, model: &WireModel) -> f64 {
    let mut again = model.clone();
    shortest((parameter.get)(model), |decimal| {
        (parameter.set)(&mut again, decimal);
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
pub(crate) static WORDS: [Word; 2] = [
    Word {
        effect: "thermal.neighbour",
        key: "channel",
        about: "Name of the channel whose wire is the neighbour, as the simulated backend has it. \
                `simulate` and fits know one wire at a time: there the neighbour is at ambient temperature",
        default: "a body at ambient temperature",
        get: |channel| channel.neighbour.clone(),
        set: |channel, name| {
            channel.neighbour = name.map(str::to_string);
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
pub(crate) fn read(reader: &mut Reader<'_>, node: &Node, label: &str, channel: &mut Channel) {
    let Some(table) = reader.table(node, Some(label), "effects", "[channel.effects.\"ID\"]") else { return };
    for (id, node) in table {
        let path = format!("effects.\"{id}\"");
        let Some(effect) = in_tables().find(|e| e.id == id) else {
            reader.problem(node.line, Some(label), path, What::Unknown { hint: unknown_effect(id) });
            continue;
        };
        let Some(keys) = reader.table(node, Some(label), &path, &format!("[channel.effects.\"{id}\"]")) else {
            continue;
        };
        let before = reader.found();
        for (key, node) in keys {
            let result = if let Some(p) = effect.parameters.iter().find(|p| p.key == key) {
                in_range(node, p.low, p.high).map(|value| (p.set)(&mut channel.model, value))
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
            let message = "has nothing to act on with this drive, load and taps; take it out".into();
            reader.problem(node.line, Some(label), path, What::Contradiction { message });
        }
    }
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
            What::NotAChoice { found: name.clone(), expected: channel_choices(name, channels) }
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

/// The catalogue as Markdown, by equation: every effect with its term and its keys.
/// `docs/effects.md` carries it word for word.
pub fn catalogue() -> String {
    let mut out = String::new();
    for equation in Equation::ALL {
        heading(&mut out, equation);
        let of_equation = |e: &&Effect| e.equation == equation && e.nature == Nature::Mechanism;
        effects::catalogue().filter(of_equation).for_each(|effect| describe(&mut out, effect));
    }
    out += "## Empirical forms\n\nNo mechanisms: closed forms fitted to what none of the above explains. A fit that needs one says that \
            something is missing, in which equation, and how it goes.\n\n";
    effects::catalogue().filter(|e| e.nature == Nature::Empirical).for_each(|effect| describe(&mut out, effect));
    out
}

fn heading(out: &mut String, equation: Equation) {
    let mut name = equation.name().to_string();
    name[..1].make_ascii_uppercase();
    // writing to a String cannot fail
    let _ = write!(out, "## {name}\n\n");
}

fn describe(out: &mut String, effect: &'static Effect) {
    let table = match effect.home {
        Home::Material => "[channel.material]".to_string(),
        Home::Table => format!("[channel.effects.\"{}\"]", effect.id),
    };
    let _ = write!(out, "### `{}`\n\n{}.\n\n", effect.id, effect.says);
    let _ = write!(out, "> {}\n\n`{table}`\n\n", effect.term);
    out.push_str("| key | unit | null | default | range | rigs show | |\n|---|---|---|---|---|---|---|\n");
    for p in effect.parameters {
        let null = null(p);
        let default = match (effect.home, p.role) {
            (Home::Table, Role::Shape { .. }) if effect.id == DRAUGHT => "**required** where it acts".to_string(),
            (Home::Table, Role::Shape { default }) => Plain(default).to_string(),
            (Home::Table, Role::Switch { .. }) => null.clone(),
            (Home::Material, _) => (p.get)(&Rig::hexapod().channels[0].model).to_string(),
        };
        let (least, most) = p.plausible;
        let _ = writeln!(
            out,
            "| `{}` | {} | {null} | {default} | {} to {} | {} to {} | {} |",
            p.key,
            p.unit,
            Plain(p.low),
            Plain(p.high),
            Plain(least),
            Plain(most),
            p.about.replace('|', "\\|")
        );
    }
    for word in words(effect) {
        let _ = writeln!(out, "| `{}` | | | {} | | | {} |", word.key, word.default, word.about);
    }
    out.push('\n');
}

/// The null in words: a number, or the key it has to equal; nothing for what has none.
fn null(parameter: &EffectParameter) -> String {
    let rig = Rig::hexapod();
    let model = &rig.channels[0].model;
    let Some(null) = parameter.null(model) else { return String::new() };
    let follows = |key: &str| {
        let mut other = rig.clone();
        let Some(value) = rig.parameter(0, key) else { return false };
        let moved = 1.1 * value + 1e-3;
        value == null
            && other.set_parameter(0, key, moved).is_ok()
            && parameter.null(&other.channels[0].model).is_some_and(|n| (n - moved).abs() <= 1e-9 * moved.abs())
    };
    match parameters().find(|p| follows(p.key)) {
        Some(p) => format!("= `{}`", p.key),
        None => Plain(null).to_string(),
    }
}
