//! What a row of the catalogue is: an effect and its parameters, of whatever model `M` holds the effect's group.
//!
//! A group of effects (a file of this folder) knows its own struct only. That a [`WireModel`](crate::WireModel) has it is
//! said in the catalogue, so that no group knows the model and the model can be made of the groups.

use super::own::{Law, Own};

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
    /// The shape of a curve that the reference model has: no physics is missing where it differs, so that it is no
    /// candidate of a search for mechanisms.
    Shape,
}

/// What a rig has to have for an effect to show on it: no probe gives way where there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Nothing: it shows on every rig.
    Nothing,
    /// A heat balance, or a current: an imposed temperature has neither.
    Heating,
    /// A supply that is switched: a given current or power is given.
    Supply,
    /// Taps.
    Taps,
    /// Outer curves with a skew.
    SkewedCurves,
    /// An end whose position is not imposed.
    FreeEnd,
}

/// One row of the catalogue.
#[derive(Debug)]
pub struct Effect<M: 'static> {
    /// Stable id, such as `thermal.draught`.
    pub id: &'static str,
    /// The equation it is a term of; the first word of the id, or of what follows `empirical.`.
    pub equation: Equation,
    /// A named mechanism or an empirical form.
    pub nature: Nature,
    /// Where its parameters stand.
    pub home: Home,
    /// What a rig has to have for the effect to show on it.
    pub needs: Needs,
    /// The term as an equation, such as `h → h (1 + gain) from start_s to end_s`.
    pub term: &'static str,
    /// One sentence: what it does, in a reader's words.
    pub says: &'static str,
    /// Its parameters, switches first.
    pub parameters: &'static [EffectParameter<M>],
}

/// A parameter of an effect.
#[derive(Debug)]
pub struct EffectParameter<M> {
    /// Key in the rig file; carries its unit where the contract lets it.
    pub key: &'static str,
    /// Its unit, `1` where it has none.
    pub unit: &'static str,
    /// Switch or shape.
    pub role: Role<M>,
    /// Least value allowed.
    pub low: f64,
    /// Largest value allowed.
    pub high: f64,
    /// What rigs show where the effect acts: least and largest. A fit starts from inside and is drawn to it.
    pub plausible: (f64, f64),
    /// What it is.
    pub about: &'static str,
    /// Where its value is.
    pub(crate) place: Place<M>,
}

/// Where the value of a parameter is, in the rig file's unit.
#[derive(Debug)]
pub(crate) enum Place<M> {
    /// In a field of its group.
    Field { get: fn(&M) -> f64, set: fn(&mut M, f64) },
    /// Among the parameters of a law that users wrote.
    Law { law: &'static Law, index: usize },
}

impl<M: Has<Own>> EffectParameter<M> {
    /// Its value in the rig file's unit.
    pub fn get(&self, model: &M) -> f64 {
        match self.place {
            Place::Field { get, .. } => get(model),
            Place::Law { law, index } => model.part().get(law, index),
        }
    }

    /// Sets it, in the rig file's unit.
    pub fn set(&self, model: &mut M, value: f64) {
        match self.place {
            Place::Field { set, .. } => set(model, value),
            Place::Law { law, index } => model.part_mut().set(law, index, value),
        }
    }
}

/// What a parameter does for its effect.
#[derive(Debug)]
pub enum Role<M> {
    /// The effect vanishes where all its switches are at their null, which is also their default.
    Switch {
        /// The null in the rig file's unit.
        null: Null<M>,
    },
    /// Says how the effect acts; means nothing while the switches are at their null.
    Shape {
        /// Its value where the rig file gives none.
        default: f64,
    },
    /// The same, but nothing of one recording tells it: a search leaves it where the rig file has it.
    Held {
        /// Its value where the rig file gives none.
        default: f64,
    },
}

/// Where a switch leaves its effect out.
#[derive(Debug)]
pub enum Null<M> {
    /// Always here.
    At(f64),
    /// Where this model has something else: a modulus is null where it equals another.
    Of(fn(&M) -> f64),
}

// not derived: the model need not be copied for the functions that read it
impl<M> Clone for Role<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Role<M> {}

impl<M> Clone for Null<M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M> Copy for Null<M> {}

impl<M> Null<M> {
    /// The value, on this model.
    pub fn of(&self, model: &M) -> f64 {
        match self {
            Null::At(value) => *value,
            Null::Of(of) => of(model),
        }
    }
}

/// A model that has the group `T`.
pub trait Has<T>: 'static {
    /// Its group.
    fn part(&self) -> &T;
    /// Its group, to change it.
    fn part_mut(&mut self) -> &mut T;
}

/// A group of effects that a model `M` may have.
pub(crate) trait Group<M: 'static> {
    /// Its rows, in the order of the catalogue.
    const ROWS: &'static [Effect<M>];
}

/// A row's parameter of the model `M` in scope: range and plausible range in the rig file's unit, field of the group, SI per
/// rig-file unit.
macro_rules! parameter {
    ($role:expr, $key:literal, $unit:literal, $range:expr, $plausible:expr, $si:literal, $($at:ident).+, $about:literal) => {
        $crate::effects::row::EffectParameter {
            key: $key,
            unit: $unit,
            role: $role,
            low: $range.0,
            high: $range.1,
            plausible: $plausible,
            about: $about,
            place: $crate::effects::row::Place::Field {
                get: |model: &M| model.part().$($at).+ / $si,
                set: |model: &mut M, value| model.part_mut().$($at).+ = value * $si,
            },
        }
    };
}
/// A switch with the given null: see `parameter`.
macro_rules! switch {
    ($null:literal, $($rest:tt)+) => {
        $crate::effects::row::parameter!($crate::effects::row::Role::Switch { null: $crate::effects::row::Null::At($null) }, $($rest)+)
    };
}
/// A shape with the given default: see `parameter`.
macro_rules! shape {
    ($default:expr, $($rest:tt)+) => {
        $crate::effects::row::parameter!($crate::effects::row::Role::Shape { default: $default }, $($rest)+)
    };
}
/// A shape that no search moves: see `parameter`.
macro_rules! held {
    ($default:expr, $($rest:tt)+) => {
        $crate::effects::row::parameter!($crate::effects::row::Role::Held { default: $default }, $($rest)+)
    };
}
pub(crate) use {held, parameter, shape, switch};
