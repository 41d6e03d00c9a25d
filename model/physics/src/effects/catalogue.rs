//! The catalogue as it is of a [`WireModel`]: every row, what it does to a model, and the check of a model's effects.

use std::sync::{LazyLock, Mutex, PoisonError};

use super::all::Effects;
use super::electrical::Electrical;
use super::empirical::Empirical;
use super::kinetic::Kinetic;
use super::mechanical::Mechanical;
use super::own::{Entry, Law, Own, OwnRole};
use super::row::{self, Equation, Group, Has, Home, Nature, Needs, Null, Place};
use super::sensing::Sensing;
use super::thermal::Thermal;
use crate::error::Error;
use crate::model::WireModel;
use crate::params::{Criterion, DriveKind, Kinetics, Load, Material};

/// A row of the catalogue; see `row::Effect` for its fields.
pub type Effect = row::Effect<WireModel>;
/// A parameter of an effect; see `row::EffectParameter` for its fields.
pub type EffectParameter = row::EffectParameter<WireModel>;
/// What a parameter does for its effect: switch, shape, or a shape that is held; see `row::Role`.
pub type Role = row::Role<WireModel>;

/// The catalogue by group: the reference model's own coefficients, the mechanisms by equation, the empirical forms.
static GROUPS: [&[Effect]; 7] = [
    <Material as Group<WireModel>>::ROWS,
    <Thermal as Group<WireModel>>::ROWS,
    <Electrical as Group<WireModel>>::ROWS,
    <Kinetic as Group<WireModel>>::ROWS,
    <Mechanical as Group<WireModel>>::ROWS,
    <Sensing as Group<WireModel>>::ROWS,
    <Empirical as Group<WireModel>>::ROWS,
];

/// Says where a [`WireModel`] has a group of effects.
macro_rules! has {
    ($group:ty, $($at:ident).+) => {
        impl Has<$group> for WireModel {
            fn part(&self) -> &$group {
                &self.$($at).+
            }

            fn part_mut(&mut self) -> &mut $group {
                &mut self.$($at).+
            }
        }
    };
}
has!(Material, material);
has!(Thermal, effects.thermal);
has!(Electrical, effects.electrical);
has!(Kinetic, effects.kinetic);
has!(Mechanical, effects.mechanical);
has!(Sensing, effects.sensing);
has!(Empirical, effects.empirical);
has!(Own, effects.own);

/// Every row of the catalogue: the reference model's own coefficients first, the empirical forms last. What users wrote
/// themselves is a model's own: see [`WireModel::catalogue`].
pub fn catalogue() -> impl Iterator<Item = &'static Effect> + Clone {
    GROUPS.iter().flat_map(|group| group.iter())
}

/// The row with this id.
pub fn effect(id: &str) -> Option<&'static Effect> {
    catalogue().find(|effect| effect.id == id)
}

impl WireModel {
    /// Every effect there is for this wire: the catalogue, then the laws its users wrote.
    pub fn catalogue(&self) -> impl Iterator<Item = &'static Effect> + '_ {
        catalogue().chain(self.effects.own.laws().map(row_of))
    }

    /// The row with this id.
    pub fn effect(&self, id: &str) -> Option<&'static Effect> {
        self.catalogue().find(|effect| effect.id == id)
    }
}

/// The row of a law that users wrote.
pub fn row_of(law: &'static Law) -> &'static Effect {
    static ROWS: Mutex<Vec<(&'static Law, &'static Effect)>> = Mutex::new(Vec::new());
    let mut rows = ROWS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, row)) = rows.iter().find(|(of, _)| std::ptr::eq(*of, law)) {
        return row;
    }
    // as static as the law is, and once for each
    let row: &'static Effect = Box::leak(Box::new(new_row(law)));
    rows.push((law, row));
    row
}

fn new_row(law: &'static Law) -> Effect {
    let definition = &law.definition;
    let (equation, needs) = match definition.enters {
        Entry::Heat => (Equation::Thermal, Needs::Heating),
        Entry::DrivingTemperature => (Equation::Kinetic, Needs::Nothing),
        Entry::Strain | Entry::Force => (Equation::Mechanical, Needs::Nothing),
        Entry::Resistivity => (Equation::Electrical, Needs::Nothing),
        Entry::ShownPosition => (Equation::Sensing, Needs::FreeEnd),
        Entry::ShownForce => (Equation::Sensing, Needs::Nothing),
        Entry::ShownCurrent | Entry::ShownV3 => (Equation::Sensing, Needs::Heating),
        Entry::ShownV1 | Entry::ShownV2 => (Equation::Sensing, Needs::Taps),
    };
    let parameter = |(index, of): (usize, &'static super::own::OwnParameter)| EffectParameter {
        key: &of.key,
        unit: &of.unit,
        role: match of.role {
            OwnRole::Switch { null } => Role::Switch { null: Null::At(null) },
            OwnRole::Shape { default } => Role::Shape { default },
        },
        low: of.range.0,
        high: of.range.1,
        plausible: of.plausible,
        about: &of.about,
        place: Place::Law { law, index },
    };
    let term = format!("{} + {}", definition.enters.word(), definition.formula);
    let parameters: Vec<EffectParameter> = definition.parameters.iter().enumerate().map(parameter).collect();
    Effect {
        id: law.id(),
        equation,
        nature: Nature::Mechanism,
        home: Home::Table,
        needs,
        term: term.leak(),
        says: &definition.says,
        parameters: parameters.leak(),
    }
}

/// Effects that have parts of the wire, or a curve that stress moves, or a lag, follow eq. 12: a rival criterion knows one phase.
const ONE_PHASE_ONLY: [&str; 5] =
    ["kinetic.curves", "kinetic.unequal_slopes", "kinetic.distributed", "kinetic.lag", "thermal.end_conduction"];

/// Effects that part the phase or let it lag, or orient martensite without memory: detwinning follows one phase, and is what orients it.
const ALL_DETWINNED: [&str; 4] =
    ["kinetic.distributed", "kinetic.lag", "mechanical.stress_dependent_strain", "thermal.end_conduction"];

impl Effect {
    /// Whether the model leaves this effect out: all its switches are at their null.
    pub fn is_null(&self, model: &WireModel) -> bool {
        self.parameters.iter().all(|parameter| parameter.is_null(model))
    }

    /// Takes the effect out of the model: switches to their null, shapes to their default.
    pub fn set_null(&self, model: &mut WireModel) {
        for parameter in self.parameters {
            let value = parameter.default(model);
            parameter.set(model, value);
        }
    }

    /// Whether the effect cannot be had beside the model's detwinning.
    pub fn is_barred_by_detwinning(&self, model: &WireModel) -> bool {
        model.material.detwinning.is_some() && ALL_DETWINNED.contains(&self.id)
    }

    /// Whether the effect can show on such a rig at all.
    pub fn applies_to(&self, model: &WireModel) -> bool {
        let follows = model.material.criterion == Criterion::DrivingTemperature || !ONE_PHASE_ONLY.contains(&self.id);
        follows
            && !self.is_barred_by_detwinning(model)
            && match self.needs {
                Needs::Nothing => true,
                Needs::Heating => model.drive.kind != DriveKind::Temperature,
                Needs::Supply => model.drive.kind == DriveKind::Pwm,
                Needs::Taps => model.taps.is_some(),
                Needs::SkewedCurves => {
                    matches!(model.material.kinetics, Kinetics::Logistic | Kinetics::Richards { .. })
                }
                Needs::FreeEnd => model.load != Load::ImposedPosition,
            }
    }

    /// Checks the parameters of an effect that is on.
    fn check(&self, model: &WireModel) -> Result<(), Error> {
        if self.home == Home::Material || self.is_null(model) {
            return Ok(());
        }
        let rival = model.material.criterion != Criterion::DrivingTemperature && ONE_PHASE_ONLY.contains(&self.id);
        let barred = rival || self.is_barred_by_detwinning(model);
        for parameter in self.parameters {
            let found = parameter.get(model);
            if let Some(null) = parameter.null(model).filter(|null| barred && found != *null) {
                return Err(Error::OutOfRange { key: path(self.id, parameter.key), found, low: null, high: null });
            }
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

    /// Whether it says how its effect acts, and a recording tells it.
    pub fn is_shape(&self) -> bool {
        matches!(self.role, Role::Shape { .. })
    }

    /// A switch's null on this model, in the rig file's unit.
    pub fn null(&self, model: &WireModel) -> Option<f64> {
        match &self.role {
            Role::Switch { null } => Some(null.of(model)),
            Role::Shape { .. } | Role::Held { .. } => None,
        }
    }

    /// Its value where the rig file gives none, in the rig file's unit.
    pub fn default(&self, model: &WireModel) -> f64 {
        match &self.role {
            Role::Switch { null } => null.of(model),
            Role::Shape { default } | Role::Held { default } => *default,
        }
    }

    /// Not what keeps its effect on. A NaN is not at the null: validation must meet it.
    fn is_null(&self, model: &WireModel) -> bool {
        match self.null(model) {
            // a null that is another parameter comes back from SI with other last digits
            Some(null) => (self.get(model) - null).abs() <= 1e-12 * null.abs(),
            None => true,
        }
    }
}

/// Checks every effect of the model that is on.
pub(crate) fn validate(model: &WireModel) -> Result<(), Error> {
    if model.effects == Effects::default() {
        return Ok(());
    }
    model.catalogue().try_for_each(|effect| effect.check(model))
}

/// An effect's key as errors name it, such as `thermal.draught.gain`.
fn path(id: &'static str, key: &str) -> &'static str {
    static PATHS: LazyLock<Vec<String>> = LazyLock::new(|| {
        catalogue().flat_map(|e| e.parameters.iter().map(move |p| format!("{}.{}", e.id, p.key))).collect()
    });
    let at =
        catalogue().flat_map(|e| e.parameters.iter().map(move |p| (e.id, p.key))).position(|found| found == (id, key));
    // a law of its users' is named whole
    at.map_or(id, |at| &PATHS[at])
}
