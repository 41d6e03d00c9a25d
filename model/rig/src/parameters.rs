//! The numbers a fit may move, by their rig-file keys, and how sure one is of each beforehand.

use std::collections::BTreeMap;

use sinew_physics::WireModel;
use sinew_physics::effects::Home;

use crate::effects;
use crate::error::{Error, Problem, What};
use crate::key::{Key, Kind, Prior, Section, Unit, Value};
use crate::notes::Reader;
use crate::suggest::nearest;
use crate::tables::{Channel, RIG, Rig, of_channel};
use crate::tree::{Node, Tree};
use crate::value::number;

/// The priors that hold where the rig file says nothing, by key.
/// Keys not listed have none: a fit leaves them alone unless the rig file says otherwise.
pub fn default_priors() -> BTreeMap<&'static str, Prior> {
    let of_rig = RIG.keys().filter_map(|key| Some((key.name, key.prior?)));
    let of_channel = tables_of_model().flat_map(Section::keys).filter_map(|key| Some((key.name, key.prior?)));
    of_rig.chain(of_channel).chain(effects::SENSOR_TOLERANCES).collect()
}

/// A number a fit may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Key in the rig file, unique among the parameters.
    pub key: &'static str,
    /// Table the key lives in, such as `channel.material`; `rig` for the ambient temperature.
    pub table: &'static str,
    /// Unit of the key.
    pub unit: &'static str,
    /// Least value allowed, in the key's unit.
    pub low: f64,
    /// Largest value allowed, in the key's unit.
    pub high: f64,
    /// What it is.
    pub about: &'static str,
}

/// The tables whose numbers are parameters of the model.
pub(crate) const MODEL_TABLES: [&str; 6] =
    ["channel.wire", "channel.taps", "channel.drive", "channel.load", "channel.initial", "channel.material"];

/// Every parameter of the model: the numbers of wire, taps, drive, load, initial state and material, and the ambient
/// temperature, in the order of the reference.
pub fn parameters() -> impl Iterator<Item = Parameter> {
    let of_rig = describe(&RIG).filter(|parameter| parameter.key == "ambient_c");
    of_rig.chain(tables_of_model().flat_map(describe))
}

fn tables_of_model() -> impl Iterator<Item = &'static Section<Channel>> {
    of_channel().filter(|section| MODEL_TABLES.contains(&section.table))
}

/// The numbers of a table.
fn describe<T: 'static>(section: &'static Section<T>) -> impl Iterator<Item = Parameter> {
    section.keys().filter_map(|key| match key.takes {
        Kind::Number { unit, low, high } => {
            Some(Parameter { key: key.name, table: section.table, unit: unit.name, low, high, about: key.about() })
        }
        _ => None,
    })
}

/// Whether a fit may move this key only as far as tools and sensors err: what a rig file states as known, and what a sensor
/// is off by.
pub fn is_tolerance(key: &str) -> bool {
    const KNOWN: [&str; 4] = ["channel.wire", "channel.taps", "channel.drive", "channel.load"];
    // the damping of a load is estimated, not measured
    let is_known = |p: &Parameter| p.key == key && KNOWN.contains(&p.table) && key != "damping_n_s_per_m";
    parameters().any(|p| is_known(&p)) || effects::SENSOR_TOLERANCES.iter().any(|(name, _)| *name == key)
}

impl Channel {
    /// Unit, least and largest value of what a prior may stand for: a parameter, or a number of an effect by its full name,
    /// such as `thermal.draught.gain`.
    pub fn range_of(&self, key: &str) -> Option<(&'static str, f64, f64)> {
        let of_model = parameters().find(|p| p.key == key).map(|p| (p.unit, p.low, p.high));
        of_model.or_else(|| effects::number(&self.model, key).map(|number| (number.unit, number.low, number.high)))
    }

    /// The priors in force: the defaults, with the rig file's own in their place, of the parameters this channel has.
    pub fn priors_in_force(&self) -> BTreeMap<String, Prior> {
        let mut priors: BTreeMap<String, Prior> =
            default_priors().into_iter().map(|(key, prior)| (key.to_string(), prior)).collect();
        priors.extend(self.priors.iter().map(|(key, prior)| (key.clone(), *prior)));
        priors.retain(|key, _| key == "ambient_c" || self.parameter(key).is_some());
        priors
    }

    /// A parameter of the model in the unit of its key; `None` where there is no such key or this channel has no
    /// such thing (taps, or a mass at an imposed position). The ambient temperature is asked of the [`Rig`].
    /// The number of an effect goes by its full name, such as `thermal.draught.gain`.
    pub fn parameter(&self, key: &str) -> Option<f64> {
        if let Some(number) = effects::number(&self.model, key) {
            return Some(number.get(&self.model));
        }
        let (key, unit) = find(key)?;
        match key.get(self) {
            Some(Value::Number(si)) => Some(unit.to_file(si)),
            _ => None,
        }
    }
}

impl Rig {
    /// A parameter of one channel's model, or `ambient_c` of the rig, in the unit of its key.
    /// `None` where there is no such channel, key or thing.
    pub fn parameter(&self, channel: usize, key: &str) -> Option<f64> {
        let channel = self.channels.get(channel)?;
        if key == "ambient_c" { Some(self.ambient_c) } else { channel.parameter(key) }
    }

    /// Changes a parameter of one channel's model, or `ambient_c` for the whole rig, in the unit of its key; the number
    /// of an effect by its full name, such as `thermal.draught.gain`.
    /// Limits and ranges that were computed from the old value stay as they are until [`Rig::refreshed`].
    ///
    /// # Errors
    /// [`Error::Invalid`] where there is no such channel or key, or the value is out of its range; nothing is
    /// changed then.
    pub fn set_parameter(&mut self, channel: usize, key: &str, value: f64) -> Result<(), Error> {
        let wrong = |rig: &Rig, what: What| {
            let name = rig.channels.get(channel).map_or_else(|| format!("#{}", channel + 1), |c| c.name.clone());
            let file = rig.source.file.clone();
            Error::Invalid { problems: vec![Problem { file, line: 1, channel: Some(name), key: key.into(), what }] }
        };
        let number = self.channels.get(channel).and_then(|c| effects::number(&c.model, key));
        if let (Some(number), Some(c)) = (number, self.channels.get_mut(channel)) {
            let (found, low, high) = (value, number.low, number.high);
            if !(low..=high).contains(&found) {
                return Err(wrong(self, What::OutOfRange { found, low, high, defaulted: false }));
            }
            number.set(&mut c.model, value);
            return Ok(());
        }
        // The initial temperature may be left open and can be given all the same; taps or a mass that are not there
        // cannot be given one number at a time.
        let open = key == "temperature_c" && channel < self.channels.len();
        let there = open || self.parameter(channel, key).is_some();
        let Some(parameter) = parameters().find(|p| p.key == key).filter(|_| there) else {
            return Err(wrong(self, What::Unknown { hint: ": this channel's model has no such parameter".into() }));
        };
        if !(parameter.low..=parameter.high).contains(&value) {
            let (low, high) = (parameter.low, parameter.high);
            return Err(wrong(self, What::OutOfRange { found: value, low, high, defaulted: false }));
        }
        if key == "ambient_c" {
            self.ambient_c = value;
            for c in &mut self.channels {
                c.model.ambient_c = value;
            }
        } else if let Some((key, unit)) = find(key) {
            key.set(&mut self.channels[channel], Value::Number(unit.to_si(value)));
        }
        Ok(())
    }
}

impl Rig {
    /// A number of an effect of one channel, in the unit of its key; `None` where there is no such channel, effect or key.
    pub fn effect_parameter(&self, channel: usize, id: &str, key: &str) -> Option<f64> {
        self.parameter(channel, &name_of(&self.channels.get(channel)?.model, id, key)?)
    }

    /// Changes a number of an effect of one channel, in the unit of its key, wherever in the file the effect has its home.
    /// A coefficient of the reference model (`thermal.latent_heat`) is one too.
    ///
    /// # Errors
    /// As [`Rig::set_parameter`].
    pub fn set_effect(&mut self, channel: usize, id: &str, key: &str, value: f64) -> Result<(), Error> {
        // what is no number of the catalogue is refused under the name it was asked for
        let model = self.channels.get(channel).map(|channel| &channel.model);
        let name = model.and_then(|model| name_of(model, id, key)).unwrap_or_else(|| format!("{id}.{key}"));
        self.set_parameter(channel, &name, value)
    }
}

/// What a number of the catalogue is called among the parameters.
fn name_of(model: &WireModel, id: &str, key: &str) -> Option<String> {
    let effect = model.effect(id)?;
    effect.parameters.iter().find(|p| p.key == key)?;
    Some(match effect.home {
        Home::Material => key.to_string(),
        Home::Table => format!("{id}.{key}"),
    })
}

/// A number of the model's tables, with its unit.
fn find(name: &str) -> Option<(&'static Key<Channel>, Unit)> {
    let key = tables_of_model().find_map(|section| section.key(name))?;
    match key.takes {
        Kind::Number { unit, .. } => Some((key, unit)),
        _ => None,
    }
}

/// Reads `[channel.priors]`.
pub(crate) fn priors(reader: &mut Reader<'_>, node: &Node, label: &str, channel: &Channel) -> BTreeMap<String, Prior> {
    let mut priors = BTreeMap::new();
    let Some(table) = reader.table(node, Some(label), "priors", "[channel.priors]") else { return priors };
    for (key, node) in table {
        let path = format!("priors.{key}");
        if channel.range_of(key).is_none() {
            let known: Vec<&str> = parameters().map(|p| p.key).collect();
            let hint = match nearest(key, known.iter().copied()) {
                Some(near) => format!(", did you mean {near}?"),
                None if effects::in_tables().any(|e| e.id.split('.').next() == Some(key)) => {
                    "; write the name of an effect's number in quotes, such as \"thermal.draught.gain\"".into()
                }
                None => "; expected a numeric key of wire, taps, drive, load, initial or material, ambient_c, \
                         or a number of an effect, such as \"thermal.draught.gain\""
                    .into(),
            };
            reader.problem(node.line, Some(label), path, What::Unknown { hint });
            continue;
        }
        match prior(node) {
            Ok(prior) => {
                priors.insert(key.clone(), prior);
            }
            Err(what) => reader.problem(node.line, Some(label), path, what),
        }
    }
    priors
}

fn prior(node: &Node) -> Result<Prior, What> {
    const EXPECTED: &str = "1 sigma, 0 or more: a number in the key's unit, or text such as \"20 %\"";
    let Tree::Text(text) = &node.value else {
        return match number(node, EXPECTED)? {
            found if found < 0.0 => Err(What::WrongType { found: node.value.describe(), expected: EXPECTED.into() }),
            sigma => Ok(Prior::Absolute(sigma)),
        };
    };
    let wrong = || What::WrongType { found: node.value.describe(), expected: EXPECTED.into() };
    let percent: f64 = text.strip_suffix('%').and_then(|t| t.trim().parse().ok()).ok_or_else(wrong)?;
    if !percent.is_finite() {
        return Err(What::NotFinite { found: format!("\"{text}\""), expected: EXPECTED.into() });
    }
    if !(0.0..=1000.0).contains(&percent) {
        return Err(What::OutOfRange { found: percent, low: 0.0, high: 1000.0, defaulted: false });
    }
    Ok(Prior::Relative(percent / 100.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_parameters_are_checked() {
        let text = "[rig]\nname = \"bench\"\n[[channel]]\nname = \"wire\"\ndrive.supply_v = 6.0\nload.mass_kg = 0.2\n\
                    wire = { diameter_mm = 0.125, length_mm = 160.0 }\nmaterial.latent_heat_j_per_kg = 24200\n";
        let mut rig = Rig::parse(text, "rig.toml").unwrap();
        let before = rig.clone();
        for (channel, id, key, value) in [
            (0, "kinetic.lag", "seconds", -1.0),
            (0, "kinetic.lag", "seconds", f64::NAN),
            (0, "kinetic.lag", "second", 1.0),
            (0, "kinetic.lagg", "seconds", 1.0),
            (1, "kinetic.lag", "seconds", 1.0),
            (0, "thermal.latent_heat", "latent_heat_j_per_kg", -1.0),
        ] {
            let error = rig.set_effect(channel, id, key, value).unwrap_err();
            assert!(matches!(error.problems()[0].what, What::OutOfRange { .. } | What::Unknown { .. }), "{error}");
            assert_eq!(rig, before);
        }
        assert_eq!(rig.effect_parameter(0, "thermal.latent_heat", "latent_heat_j_per_kg"), Some(24200.0));
        assert_eq!(rig.effect_parameter(0, "kinetic.lag", "seconds"), Some(0.0));
        assert_eq!(rig.effect_parameter(0, "kinetic.lag", "gain"), None);
        for (channel, key, value) in
            [(0, "mass_kg", -1.0), (0, "mass_kg", f64::NAN), (0, "colour", 1.0), (1, "mass_kg", 1.0)]
        {
            let error = rig.set_parameter(channel, key, value).unwrap_err();
            assert!(matches!(error.problems()[0].what, What::OutOfRange { .. } | What::Unknown { .. }));
            assert_eq!(rig, before);
        }
    }
}
