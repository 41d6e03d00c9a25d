//! The catalogue of physics a simulation may have left out: one table, from which the rig file, the documentation and
//! the diagnosis are made.
//!
//! Every effect is one term of the model with a null at which it vanishes, so the reference model is nested in every
//! extension of it. Adding an effect means adding its row and its term in the file of its equation.

mod coefficients;
mod electrical;
mod empirical;
mod ends;
mod kinetic;
mod mechanical;
mod sensing;
mod terms;
mod thermal;

pub use electrical::{Electrical, LeadResistance, PoissonArea, RPhase, ResistivityStress, SupplySag};
pub use empirical::{Empirical, Form, Term};
pub use kinetic::{Asymmetry, Distributed, Kinetic, Lag, TrainingDrift, UnequalSlopes};
pub(crate) use mechanical::Grip;
pub use mechanical::{Capstan, FrameCompliance, Friction, Mechanical, Ratcheting, StressDependentStrain, TwoWay};
pub use sensing::{ContactResistance, Delay, DelayedSensor, Gain, Offset, ProbeDeflection, Sensing};
pub use terms::Unknown;
pub(crate) use terms::{Ledger, Loss, MOST_STRESS, STRESS_PA, Terms};
pub use thermal::{AmbientDrift, Draught, EndConduction, NaturalConvection, Neighbour, Radiation, Sheath, Thermal};

use std::sync::LazyLock;

use crate::Error;
use crate::params::{DriveKind, Kinetics, Load, WireModel};

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

/// Every effect beyond the reference model, in SI, grouped by the equation it is a term of. The default has none of
/// them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effects {
    /// Terms of the heat balance.
    pub thermal: Thermal,
    /// Terms of resistance and circuit.
    pub electrical: Electrical,
    /// Terms of the phase.
    pub kinetic: Kinetic,
    /// Terms of strain and load.
    pub mechanical: Mechanical,
    /// What the sensors add.
    pub sensing: Sensing,
    /// Closed forms for what no mechanism explains.
    pub empirical: Empirical,
}

/// A row's parameter: range and plausible range in the rig file's unit, field of the model, SI per rig-file unit.
macro_rules! parameter {
    ($role:expr, $key:literal, $unit:literal, $range:expr, $plausible:expr, $si:literal, $($at:ident).+, $about:literal) => {
        $crate::effects::EffectParameter {
            key: $key,
            unit: $unit,
            role: $role,
            low: $range.0,
            high: $range.1,
            plausible: $plausible,
            about: $about,
            get: |model| model.$($at).+ / $si,
            set: |model, value| model.$($at).+ = value * $si,
        }
    };
}
/// A switch with the given null: see `parameter`.
macro_rules! switch {
    ($null:literal, $($rest:tt)+) => {
        $crate::effects::parameter!($crate::effects::Role::Switch { null: |_| $null }, $($rest)+)
    };
}
/// A shape with the given default: see `parameter`.
macro_rules! shape {
    ($default:expr, $($rest:tt)+) => {
        $crate::effects::parameter!($crate::effects::Role::Shape { default: $default }, $($rest)+)
    };
}
pub(crate) use {parameter, shape, switch};

/// The catalogue by group: the reference model's own coefficients, the mechanisms by equation, the empirical forms.
static GROUPS: [&[Effect]; 7] = [
    &coefficients::ROWS,
    &thermal::ROWS,
    &electrical::ROWS,
    &kinetic::ROWS,
    &mechanical::ROWS,
    &sensing::ROWS,
    &empirical::ROWS,
];

/// Every row of the catalogue: the reference model's own coefficients first, the empirical forms last.
pub fn catalogue() -> impl Iterator<Item = &'static Effect> + Clone {
    GROUPS.iter().flat_map(|group| group.iter())
}

/// The row with this id.
pub fn effect(id: &str) -> Option<&'static Effect> {
    catalogue().find(|effect| effect.id == id)
}

impl Effect {
    /// Whether the model leaves this effect out: all its switches are at their null.
    pub fn is_null(&self, model: &WireModel) -> bool {
        self.parameters.iter().all(|parameter| parameter.is_null(model))
    }

    /// Takes the effect out of the model: switches to their null, shapes to their default.
    pub fn set_null(&self, model: &mut WireModel) {
        for parameter in self.parameters {
            let value = parameter.default(model);
            (parameter.set)(model, value);
        }
    }

    /// Whether the effect can show on such a rig at all: no probe gives way where there is none.
    pub fn applies_to(&self, model: &WireModel) -> bool {
        let furnace = model.drive.kind == DriveKind::Temperature;
        match self.id {
            // an imposed temperature has no heat balance
            "thermal.ambient_drift" | "thermal.latent_heat" => !furnace,
            id if id.starts_with("thermal.") || id == "empirical.thermal" => !furnace,
            // a given current or power is given
            "electrical.supply_sag" | "electrical.lead_resistance" => model.drive.kind == DriveKind::Pwm,
            "sensing.contact_resistance" | "sensing.offset" | "sensing.gain" | "empirical.voltage" => !furnace,
            "sensing.probe_deflection" => model.taps.is_some(),
            "kinetic.asymmetry" => {
                matches!(model.material.kinetics, Kinetics::Logistic | Kinetics::Richards { .. })
            }
            "empirical.position" => model.load != Load::ImposedPosition,
            _ => true,
        }
    }

    /// Checks the parameters of an effect that is on.
    fn check(&self, model: &WireModel) -> Result<(), Error> {
        if self.home == Home::Material || self.is_null(model) {
            return Ok(());
        }
        for parameter in self.parameters {
            let found = (parameter.get)(model);
            let slack = 8.0 * f64::EPSILON * found.abs();
            if !(found >= parameter.low - slack && found <= parameter.high + slack) {
                return Err(Error::OutOfRange {
                    key: path(self.id, parameter.key),
                    found,
                    low: parameter.low,
                    high: parameter.high,
                });
            }
        }
        Ok(())
    }
}

impl EffectParameter {
    /// Whether it turns its effect on and off.
    pub fn is_switch(&self) -> bool {
        matches!(self.role, Role::Switch { .. })
    }

    /// A switch's null on this model, in the rig file's unit.
    pub fn null(&self, model: &WireModel) -> Option<f64> {
        match self.role {
            Role::Switch { null } => Some(null(model)),
            Role::Shape { .. } => None,
        }
    }

    /// Its value where the rig file gives none, in the rig file's unit.
    pub fn default(&self, model: &WireModel) -> f64 {
        match self.role {
            Role::Switch { null } => null(model),
            Role::Shape { default } => default,
        }
    }

    /// Not what keeps its effect on. A NaN is not at the null: validation must meet it.
    fn is_null(&self, model: &WireModel) -> bool {
        match self.null(model) {
            // a null that is another parameter comes back from SI with other last digits
            Some(null) => ((self.get)(model) - null).abs() <= 1e-12 * null.abs(),
            None => true,
        }
    }
}

/// Checks every effect of the model that is on.
pub(crate) fn validate(model: &WireModel) -> Result<(), Error> {
    if model.effects == Effects::default() {
        return Ok(());
    }
    catalogue().try_for_each(|effect| effect.check(model))
}

/// An effect's key as errors name it, such as `thermal.draught.gain`.
fn path(id: &str, key: &str) -> &'static str {
    static PATHS: LazyLock<Vec<String>> = LazyLock::new(|| {
        catalogue().flat_map(|e| e.parameters.iter().map(move |p| format!("{}.{}", e.id, p.key))).collect()
    });
    let at =
        catalogue().flat_map(|e| e.parameters.iter().map(move |p| (e.id, p.key))).position(|found| found == (id, key));
    at.map_or("effects", |at| &PATHS[at])
}
