//! Physics that users write: terms of their own, as formulas over the wire's quantities, with parameters, a null and, where
//! they remember, first-order states.
//!
//! A law enters one equation ([`Entry`]) and vanishes where its switches are at their null, as every effect of the catalogue.
//! It is read, checked for units, and tried at many states of a wire before it is taken. [`Own`] is a group of effects as the
//! others, but that its rows are made when a law is.

use std::sync::Mutex;

use sinew_formula::{Dimension, Formula, Quantity, Unit};

/// What laws may use of the wire: name, unit, meaning. In formulas all are in SI, temperatures in °C.
pub const QUANTITIES: [(&str, &str, &str); 20] = [
    ("temperature", "°C", "T of the wire"),
    ("ambient", "°C", "T∞ around it"),
    ("martensite", "1", "ξ, 0 to 1"),
    ("austenite", "1", "1 − ξ"),
    ("stress", "Pa", "σ in the wire"),
    ("tension", "N", "A_c σ"),
    ("position", "m", "x = L − L_0, positive longer"),
    ("velocity", "m/s", "ẋ, mean over 20 ms; in a `force` as it is"),
    ("warming", "K/s", "Ṫ, mean over 20 ms"),
    ("transforming", "1/s", "ξ̇, mean over 20 ms"),
    ("resistance", "Ω", "R of the wire"),
    ("current", "A", "I in the on-phase"),
    ("power", "W", "mean electrical power"),
    ("duty", "1", "of the heating, 0 to 1"),
    ("supply", "V", "V_s"),
    ("time", "s", "since the first sample"),
    ("length", "m", "L_0"),
    ("diameter", "m", "of the wire"),
    ("surface", "m²", "A_s = π d L_0"),
    ("wire_mass", "kg", "m of the wire"),
];

/// Parameters and states that a law may have, together.
pub(crate) const MOST_KEYS: usize = 12;

/// Values of the [`QUANTITIES`], in SI.
pub(crate) type Quantities = [f64; QUANTITIES.len()];

/// Places among the [`QUANTITIES`] of those that a term is solved together with.
pub(crate) const TEMPERATURE: usize = 0;
pub(crate) const MARTENSITE: usize = 2;
pub(crate) const STRESS: usize = 4;
pub(crate) const POSITION: usize = 6;
pub(crate) const VELOCITY: usize = 7;
pub(crate) const CURRENT: usize = 11;

/// Where a law enters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entry {
    /// Heat into the wire, in W.
    Heat,
    /// Shift of the driving temperature the phase sees, in K, positive hotter.
    DrivingTemperature,
    /// Strain without stress.
    Strain,
    /// Force on the load, in N, positive making the wire longer.
    Force,
    /// Relative change of resistivity.
    Resistivity,
    /// What the position sensor shows too much, in m.
    ShownPosition,
    /// What the force sensor shows too much, in N.
    ShownForce,
    /// What the current sensor shows too much, in A.
    ShownCurrent,
    /// What the first tap shows too much, in V.
    ShownV1,
    /// What the second tap shows too much, in V.
    ShownV2,
    /// What the moving end shows too much, in V.
    ShownV3,
}

impl Entry {
    /// All of them: word in the rig file, unit, the largest it comes to, meaning.
    pub const ALL: [(Entry, &'static str, &'static str, f64, &'static str); 11] = [
        (Entry::Heat, "heat", "W", 1e4, "heat into the wire"),
        (Entry::DrivingTemperature, "driving_temperature", "K", 1e3, "what the phase sees hotter than the wire is"),
        (Entry::Strain, "strain", "1", 0.5, "strain without stress"),
        (Entry::Force, "force", "N", 1e5, "force on the load, positive making the wire longer"),
        (Entry::Resistivity, "resistivity", "1", 20.0, "relative change of resistivity"),
        (Entry::ShownPosition, "shown_position", "m", 10.0, "what the position sensor shows too much"),
        (Entry::ShownForce, "shown_force", "N", 1e5, "what the force sensor shows too much"),
        (Entry::ShownCurrent, "shown_current", "A", 1e3, "what the current sensor shows too much"),
        (Entry::ShownV1, "shown_v1", "V", 1e3, "what the first tap shows too much"),
        (Entry::ShownV2, "shown_v2", "V", 1e3, "what the second tap shows too much"),
        (Entry::ShownV3, "shown_v3", "V", 1e3, "what the moving end shows too much"),
    ];

    fn row(self) -> &'static (Entry, &'static str, &'static str, f64, &'static str) {
        // listed in the order of the declaration, which a test holds
        &Entry::ALL[self as usize]
    }

    /// Its word in the rig file.
    pub fn word(self) -> &'static str {
        self.row().1
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        self.row().2
    }

    /// The largest a term comes to, in SI: what a formula gives beyond is cut off there.
    pub(crate) fn most(self) -> f64 {
        self.row().3
    }
}

/// A law as it was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// Its name, behind `own.`.
    pub name: String,
    /// One sentence: what it does.
    pub says: String,
    /// Where it enters.
    pub enters: Entry,
    /// The term.
    pub formula: String,
    /// Its parameters, by key.
    pub parameters: Vec<OwnParameter>,
    /// What it remembers, by key.
    pub states: Vec<OwnState>,
}

/// A parameter of a law, in its own unit.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnParameter {
    /// Its name in formulas and in the rig file.
    pub key: String,
    /// Its unit.
    pub unit: String,
    /// Switch or shape.
    pub role: OwnRole,
    /// Least and largest value allowed.
    pub range: (f64, f64),
    /// What rigs show where the law acts.
    pub plausible: (f64, f64),
    /// What it is.
    pub about: String,
}

/// What a parameter of a law does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OwnRole {
    /// The law vanishes where all its switches are at their null.
    Switch {
        /// The null.
        null: f64,
    },
    /// Says how it acts.
    Shape {
        /// Where none is given.
        default: f64,
    },
}

/// What a law remembers: ds/dt = rate.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnState {
    /// Its name in formulas.
    pub key: String,
    /// Its unit.
    pub unit: String,
    /// At the first sample, in its unit.
    pub start: f64,
    /// Its rate, in its unit per second.
    pub rate: String,
}

/// Why a definition is none: which part, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Undefined {
    /// The part, such as `formula` or `parameters.gain.unit`.
    pub part: String,
    /// What is wrong with it.
    pub what: String,
}

/// A law that was checked. Formulas are over the [`QUANTITIES`], then the parameters, then the states.
#[derive(Debug)]
pub struct Law {
    /// As it was written.
    pub definition: Definition,
    pub(crate) id: String,
    pub(crate) formula: Formula,
    /// SI per unit of each parameter.
    pub(crate) parameters_si: Vec<f64>,
    /// SI per unit of each state, and its rate in SI.
    pub(crate) states: Vec<(f64, Formula)>,
}

/// Every law there is. A row of the catalogue is static wherever one is used, so laws stay as long as the program; a rig has a
/// handful, and the same law is kept once.
static LAWS: Mutex<Vec<&'static Law>> = Mutex::new(Vec::new());

impl Law {
    /// Checks a definition, and keeps it.
    ///
    /// # Errors
    /// The part that is wrong.
    pub fn new(definition: Definition) -> Result<&'static Law, Undefined> {
        // a panic elsewhere leaves the list as it was
        let mut laws = LAWS.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(law) = laws.iter().find(|law| law.definition == definition) {
            return Ok(law);
        }
        let law: &'static Law = Box::leak(Box::new(Law::checked(definition)?));
        laws.push(law);
        Ok(law)
    }

    fn checked(definition: Definition) -> Result<Law, Undefined> {
        let wrong = |part: &str, what: String| Undefined { part: part.into(), what };
        if !is_name(&definition.name) {
            return Err(wrong("", format!("a name has small letters, digits and _, such as own.slipstream{}", BEGINS)));
        }
        let unit_of = |part: String, unit: &str| {
            Unit::parse(unit).map_err(|error| wrong(&part, format!("{error}\n{}", error.marked(unit))))
        };
        let mut names: Vec<(String, Dimension)> = Vec::new();
        for (name, unit, _) in QUANTITIES {
            names.push((name.into(), unit_of("quantity".into(), unit)?.dimension));
        }
        if definition.parameters.len() + definition.states.len() > MOST_KEYS {
            return Err(wrong("", format!("a law has at most {MOST_KEYS} parameters and states")));
        }
        let mut parameters_si = Vec::new();
        for parameter in &definition.parameters {
            let part = format!("parameters.{}", parameter.key);
            let unit = unit_of(format!("{part}.unit"), &parameter.unit)?;
            parameter.check().map_err(|(key, what)| wrong(&format!("{part}{key}"), what))?;
            names.push((parameter.key.clone(), unit.dimension));
            parameters_si.push(unit.si);
        }
        let mut state_units = Vec::new();
        for state in &definition.states {
            let part = format!("states.{}", state.key);
            let unit = unit_of(format!("{part}.unit"), &state.unit)?;
            if !state.start.is_finite() {
                return Err(wrong(&format!("{part}.start"), "expected a number".into()));
            }
            names.push((state.key.clone(), unit.dimension));
            state_units.push(unit);
        }
        for (at, (name, _)) in names.iter().enumerate().skip(QUANTITIES.len()) {
            let part = if at < QUANTITIES.len() + parameters_si.len() { "parameters" } else { "states" };
            if !is_name(name) || RESERVED.contains(&name.as_str()) {
                let what =
                    format!("a key has small letters, digits and _{BEGINS}, and is none of {}", RESERVED.join(", "));
                return Err(wrong(&format!("{part}.{name}"), what));
            }
            if names[..at].iter().any(|(other, _)| other == name) {
                return Err(wrong(&format!("{part}.{name}"), "this name is something else already".into()));
            }
        }
        if !definition.parameters.iter().any(|parameter| matches!(parameter.role, OwnRole::Switch { .. })) {
            let what = "at least one parameter needs a `null`: its value where the effect vanishes";
            return Err(wrong("parameters", what.into()));
        }
        let quantities: Vec<Quantity<'_>> =
            names.iter().map(|(name, dimension)| Quantity { name, dimension: *dimension }).collect();
        let read = |part: &str, text: &str, dimension: Dimension| {
            Formula::new(text, &quantities, dimension)
                .map_err(|error| wrong(part, format!("{error}\n{}", error.marked(text))))
        };
        let enters = unit_of("enters".into(), definition.enters.unit())?;
        let formula = read("formula", &definition.formula, enters.dimension)?;
        let mut states = Vec::new();
        let second = unit_of("states".into(), "s")?.dimension;
        for (state, unit) in definition.states.iter().zip(&state_units) {
            let rate = read(&format!("states.{}.rate", state.key), &state.rate, unit.dimension / second)?;
            states.push((unit.si, rate));
        }
        let unused = (QUANTITIES.len()..names.len())
            .find(|at| !formula.uses(*at) && !states.iter().any(|(_, rate)| rate.uses(*at)));
        if let Some(at) = unused {
            return Err(wrong("formula", format!("does not use `{}`: take that out, or use it", names[at].0)));
        }
        let id = format!("own.{}", definition.name);
        let law = Law { definition, id, formula, parameters_si, states };
        law.tried()?;
        Ok(law)
    }

    /// Tries the formulas at many states of a wire: they have to be defined there, and the term to vanish at its null.
    fn tried(&self) -> Result<(), Undefined> {
        const TRIES: u32 = 400;
        let wrong = |part: String, what: String| Err(Undefined { part, what });
        let parameters = &self.definition.parameters;
        for turn in 1..=TRIES {
            // points of a lattice that fills the box evenly, whatever its dimension (Weyl's, by roots of primes)
            let part = |axis: usize| {
                (f64::from(turn) * (f64::from(PRIMES[axis % PRIMES.len()]).sqrt() + axis as f64 * 0.1)).fract()
            };
            let mut values: Vec<f64> =
                TRIED.iter().enumerate().map(|(i, (low, high))| low + (high - low) * part(i)).collect();
            values[MARTENSITE + 1] = 1.0 - values[MARTENSITE];
            let off = turn % 2 == 0;
            for (i, (parameter, si)) in parameters.iter().zip(&self.parameters_si).enumerate() {
                let (low, high) = parameter.plausible;
                let within = low + (high - low) * part(TRIED.len() + i);
                values.push(
                    si * match parameter.role {
                        OwnRole::Switch { null } if off => null,
                        _ => within,
                    },
                );
            }
            values.extend(self.definition.states.iter().zip(&self.states).map(|(state, (si, _))| state.start * si));
            let at = || {
                let names = QUANTITIES.iter().map(|(name, ..)| *name).chain(parameters.iter().map(|p| p.key.as_str()));
                let used = names.zip(&values).enumerate().filter(|(i, _)| self.formula.uses(*i));
                used.map(|(_, (name, value))| format!("{name} = {value:.3}")).collect::<Vec<_>>().join(", ")
            };
            for (state, (_, rate)) in self.definition.states.iter().zip(&self.states) {
                if !rate.value(&values).is_finite() {
                    return wrong(
                        format!("states.{}.rate", state.key),
                        format!("is no number everywhere: {NO_NUMBER}"),
                    );
                }
            }
            let term = self.formula.value(&values);
            if !term.is_finite() {
                return wrong("formula".into(), format!("is no number where (SI) {}: {NO_NUMBER}", at()));
            }
            if off && term.abs() > 1e-9 * self.definition.enters.most() {
                let what = format!(
                    "is {term:.3e} {} where all switches are at their null, and has to be 0 there (SI: {})",
                    self.definition.enters.unit(),
                    at()
                );
                return wrong("formula".into(), what);
            }
        }
        Ok(())
    }

    /// Its id among the effects, such as `own.slipstream`.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// The value of a parameter where none is given.
    fn default(&self, index: usize) -> f64 {
        match self.definition.parameters[index].role {
            OwnRole::Switch { null } => null,
            OwnRole::Shape { default } => default,
        }
    }

    fn defaults(&self) -> Vec<f64> {
        (0..self.definition.parameters.len()).map(|index| self.default(index)).collect()
    }

    /// Whether the term vanishes at these values.
    fn is_null(&self, values: &[f64]) -> bool {
        self.definition.parameters.iter().zip(values).all(|(parameter, value)| match parameter.role {
            // a NaN is not at the null: validation must meet it
            OwnRole::Switch { null } => (value - null).abs() <= 1e-12 * null.abs(),
            OwnRole::Shape { .. } => true,
        })
    }
}

/// Keys of a law's table that no parameter can have.
const RESERVED: [&str; 6] = ["says", "enters", "formula", "parameters", "states", "pi"];
const BEGINS: &str = ", beginning with a letter";
const NO_NUMBER: &str = "use abs, max or clamp where a root, a logarithm or a division needs it";

/// Where formulas are tried, by quantity in SI: somewhat beyond what wires show.
const TRIED: [(f64, f64); QUANTITIES.len()] = [
    (-20.0, 250.0),
    (-20.0, 60.0),
    (0.0, 1.0),
    (0.0, 1.0),
    (0.0, 6e8),
    (0.0, 20.0),
    (-0.02, 0.02),
    (-0.2, 0.2),
    (-500.0, 500.0),
    (-10.0, 10.0),
    (0.1, 50.0),
    (0.0, 3.0),
    (0.0, 30.0),
    (0.0, 1.0),
    (0.0, 24.0),
    (0.0, 3600.0),
    (0.02, 1.0),
    (2.5e-5, 5e-4),
    (1e-6, 1e-3),
    (1e-7, 1e-3),
];
const PRIMES: [u32; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];

fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.len() <= 40
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

impl OwnParameter {
    /// The key that is wrong, and why.
    fn check(&self) -> Result<(), (&'static str, String)> {
        let (low, high) = self.range;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err((".range", "expected two numbers, the smaller first".into()));
        }
        let (least, most) = self.plausible;
        if !(low <= least && least < most && most <= high) {
            return Err((
                ".plausible",
                format!("expected two numbers within the range {low} to {high}, the smaller first"),
            ));
        }
        let (key, value) = match self.role {
            OwnRole::Switch { null } => (".null", null),
            OwnRole::Shape { default } => (".default", default),
        };
        if !(low..=high).contains(&value) {
            return Err((key, format!("is {value}, outside the range {low} to {high}")));
        }
        Ok(())
    }
}

/// The laws of a wire, each with the values of its parameters in their own units. A law at its null is one to look for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Own {
    laws: Vec<Given>,
}

/// A law with its values.
#[derive(Debug, Clone)]
struct Given {
    law: &'static Law,
    values: Vec<f64>,
}

impl PartialEq for Given {
    fn eq(&self, other: &Given) -> bool {
        // the same law is kept once
        std::ptr::eq(self.law, other.law) && self.values == other.values
    }
}

impl Own {
    /// Adds a law at its null, in the order of names; one of the same name goes.
    pub fn declare(&mut self, law: &'static Law) {
        let new = Given { law, values: law.defaults() };
        match self.laws.binary_search_by(|there| there.law.id.cmp(&law.id)) {
            Ok(there) if std::ptr::eq(self.laws[there].law, law) => {}
            Ok(there) => self.laws[there] = new,
            Err(place) => self.laws.insert(place, new),
        }
    }

    /// The laws, in the order of their names.
    pub fn laws(&self) -> impl Iterator<Item = &'static Law> + '_ {
        self.laws.iter().map(|there| there.law)
    }

    /// The value of a parameter, in its own unit; its default where the wire has no such law.
    pub(crate) fn get(&self, law: &'static Law, index: usize) -> f64 {
        let found = self.laws.iter().find(|there| std::ptr::eq(there.law, law));
        found.map_or_else(|| law.default(index), |there| there.values[index])
    }

    /// Sets it.
    pub(crate) fn set(&mut self, law: &'static Law, index: usize, value: f64) {
        self.declare(law);
        if let Some(there) = self.laws.iter_mut().find(|there| std::ptr::eq(there.law, law)) {
            there.values[index] = value;
        }
    }

    /// Those that are not at their null.
    pub(crate) fn acting(&self) -> Own {
        Own { laws: self.laws.iter().filter(|there| !there.law.is_null(&there.values)).cloned().collect() }
    }

    /// The laws with the values of their parameters in SI.
    pub(crate) fn in_si(&self) -> impl Iterator<Item = (&'static Law, Vec<f64>)> + '_ {
        let si = |Given { law, values }: &Given| values.iter().zip(&law.parameters_si).map(|(x, si)| x * si).collect();
        self.laws.iter().map(move |there| (there.law, si(there)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) fn gain(unit: &str) -> OwnParameter {
        OwnParameter {
            key: "gain".into(),
            unit: unit.into(),
            role: OwnRole::Switch { null: 0.0 },
            range: (-10.0, 10.0),
            plausible: (0.1, 1.0),
            about: "how much".into(),
        }
    }

    fn definition(formula: &str) -> Definition {
        Definition {
            name: "slipstream".into(),
            says: "The moving wire stirs its own air".into(),
            enters: Entry::Heat,
            formula: formula.into(),
            parameters: vec![gain("mW s/(mm K)")],
            states: Vec::new(),
        }
    }

    #[test]
    fn entries_are_listed_in_their_order() {
        for (at, (entry, ..)) in Entry::ALL.iter().enumerate() {
            assert_eq!(*entry as usize, at);
        }
        for (name, place) in [
            ("temperature", TEMPERATURE),
            ("martensite", MARTENSITE),
            ("stress", STRESS),
            ("position", POSITION),
            ("velocity", VELOCITY),
            ("current", CURRENT),
        ] {
            assert_eq!(QUANTITIES[place].0, name);
        }
    }

    #[test]
    fn a_law_is_kept_once_and_is_off_until_it_is_set() {
        let text = "-gain * abs(velocity) * (temperature - ambient)";
        let law = Law::new(definition(text)).unwrap();
        assert!(std::ptr::eq(law, Law::new(definition(text)).unwrap()));
        let mut own = Own::default();
        assert_eq!(own.get(law, 0), 0.0);
        own.declare(law);
        assert_eq!(own.acting(), Own::default());
        own.set(law, 0, 2.0);
        assert_eq!(own.get(law, 0), 2.0);
        assert_eq!(own.acting(), own);
        // mW s/mm = W s/m
        assert_eq!(own.in_si().next().unwrap().1, [2.0]);
    }

    #[test]
    fn what_is_no_law_is_refused_with_its_part() {
        let refused = |change: &dyn Fn(&mut Definition)| {
            let mut definition = definition("-gain * abs(velocity) * (temperature - ambient)");
            change(&mut definition);
            Law::new(definition).unwrap_err()
        };
        type Change = Box<dyn Fn(&mut Definition)>;
        let cases: [(&str, &str, Change); 13] = [
            ("formula", "no `temprature`", Box::new(|d| d.formula = "gain * temprature".into())),
            ("formula", "should be in W", Box::new(|d| d.formula = "gain * velocity".into())),
            ("formula", "has to be 0 there", Box::new(|d| d.formula = "1 [W] + gain * velocity * ambient".into())),
            (
                "formula",
                "is no number",
                Box::new(|d| d.formula = "gain * velocity * ambient * sqrt(position / length)".into()),
            ),
            ("formula", "does not use `gain`", Box::new(|d| d.formula = "0".into())),
            (
                "enters",
                "",
                Box::new(|d| {
                    d.enters = Entry::Strain;
                    d.formula = "gain".into()
                }),
            ),
            ("parameters.gain.unit", "no unit `mWs`", Box::new(|d| d.parameters[0].unit = "mWs".into())),
            ("parameters.gain.range", "smaller first", Box::new(|d| d.parameters[0].range = (1.0, 0.0))),
            ("parameters.gain.plausible", "within the range", Box::new(|d| d.parameters[0].plausible = (0.0, 11.0))),
            (
                "parameters.gain.null",
                "outside the range",
                Box::new(|d| d.parameters[0].role = OwnRole::Switch { null: 11.0 }),
            ),
            ("parameters.stress", "something else already", Box::new(|d| d.parameters[0].key = "stress".into())),
            ("parameters", "needs a `null`", Box::new(|d| d.parameters[0].role = OwnRole::Shape { default: 1.0 })),
            ("", "a name has small letters", Box::new(|d| d.name = "Slip".into())),
        ];
        for (part, what, change) in cases {
            let found = refused(&*change);
            if part != "enters" {
                assert_eq!(found.part, part, "{found:?}");
            }
            assert!(found.what.contains(what), "{found:?}");
        }
    }
}
