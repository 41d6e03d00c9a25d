//! The catalogue of physics a simulation may have left out: one table, from which the rig file, the documentation and
//! the diagnosis are made.
//!
//! Every effect is one term of the model with a null at which it vanishes, so the reference model is nested in every
//! extension of it. Adding an effect means adding its row and its term in the file of its equation.

use crate::params::WireModel;

/// The equation an effect belongs to: where a mismatch can sit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Equation {
    /// The heat balance (eq. 48).
    Thermal,
    /// Resistance and circuit (eq. 36–39).
    Electrical,
    /// The phase (eq. 20–26).
    Kinetic,
    /// Strain, load and friction (eq. 23, 51).
    Mechanical,
    /// What the sensors make of it (eq. 42–44).
    Sensing,
}

impl Equation {
    /// All of them.
    pub const ALL: [Equation; 5] =
        [Equation::Thermal, Equation::Electrical, Equation::Kinetic, Equation::Mechanical, Equation::Sensing];

    /// Its word in ids and in the diagnosis.
    pub const fn name(self) -> &'static str {
        match self {
            Equation::Thermal => "thermal",
            Equation::Electrical => "electrical",
            Equation::Kinetic => "kinetic",
            Equation::Mechanical => "mechanical",
            Equation::Sensing => "sensing",
        }
    }
}

/// Where an effect's parameters stand in a rig file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Home {
    /// Coefficients of the reference model, in `[channel.material]`.
    Material,
    /// A table of its own, `[channel.effects."ID"]`.
    Table,
}

/// What kind of statement an effect is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nature {
    /// Physics with a name.
    Mechanism,
    /// A closed form fitted to what no mechanism explains.
    Empirical,
}

/// One row of the catalogue.
#[derive(Debug)]
pub struct Effect {
    /// Stable id, such as `thermal.draught`.
    pub id: &'static str,
    /// The equation it is a term of; the first word of the id, or of what follows `empirical.`.
    pub equation: Equation,
    /// A named mechanism or an empirical form.
    pub nature: Nature,
    /// Where its parameters stand.
    pub home: Home,
    /// The term as an equation, such as `h → h (1 + gain) from start_s to end_s`.
    pub term: &'static str,
    /// One sentence: what it does, in a reader's words.
    pub says: &'static str,
    /// Its parameters, switches first.
    pub parameters: &'static [EffectParameter],
}

/// A parameter of an effect.
#[derive(Debug)]
pub struct EffectParameter {
    /// Key in the rig file; carries its unit where the contract lets it.
    pub key: &'static str,
    /// Its unit, `1` where it has none.
    pub unit: &'static str,
    /// Switch or shape.
    pub role: Role,
    /// Least value allowed.
    pub low: f64,
    /// Largest value allowed.
    pub high: f64,
    /// What rigs show where the effect acts: least and largest. A fit starts from inside and is drawn to it.
    pub plausible: (f64, f64),
    /// What it is.
    pub about: &'static str,
    /// Its value in the rig file's unit.
    pub get: fn(&WireModel) -> f64,
    /// Sets it, in the rig file's unit.
    pub set: fn(&mut WireModel, f64),
}

/// What a parameter does for its effect.
#[derive(Debug, Clone, Copy)]
pub enum Role {
    /// The effect vanishes where all its switches are at their null, which is also their default.
    Switch {
        /// The null in the rig file's unit (of this model: a modulus is null where it equals another).
        null: fn(&WireModel) -> f64,
    },
    /// Says how the effect acts; means nothing while the switches are at their null.
    Shape {
        /// Its value where the rig file gives none.
        default: f64,
    },
}
