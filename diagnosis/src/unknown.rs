//! Outside the catalogue: whether what its effects leave is noise of the sensors, nothing worth a name, or physics that
//! no effect describes.

use std::collections::BTreeMap;

use sinew_physics::effects::{Effect, Equation};

use crate::answer::{EffectSize, Unknown};
use crate::attempt::{Attempt, NAMED_SHARE, UNEXPLAINED};
use crate::closed_form::{self, ClosedForm};
use crate::data::Data;
use crate::fit::Fit;
use crate::forward::Selection;
use crate::intervals::Interval;
use crate::locate::{self, Located};
use crate::numbers::number;
use crate::residuals::{Residuals, Score};
use crate::settings::Settings;
use crate::significance::Colour;
use crate::space::What;
use crate::structure::{self, Structure};

/// chi under which nothing is left worth looking for.
const NOTHING_LEFT: f64 = 1.05;

/// chi up to which what is left may be taken for noise of the sensors that wanders.
const LOUDEST_NOISE: f64 = 4.0;

/// chi above which the sensors are so quiet that no model of a wire reaches their noise: what counts there is the share.
const BEYOND_MODELS: f64 = 10.0;

/// The same where no single free term does as much.
const MOST_OF_IT: f64 = 0.5;

/// A mechanism does as much as a free term if it leaves at most this many times its mean square: it has not the choice of
/// fifty forms.
const ALMOST: f64 = 1.25;

/// How much less a sample counts because its neighbours say the same.
pub(crate) fn inflation(colours: &[Colour]) -> f64 {
    let sum: f64 = colours.iter().map(Colour::inflation).sum();
    (sum / colours.len().max(1) as f64).max(1.0)
}

/// What the catalogue's effects leave.
pub(crate) struct Remainder {
    /// What is outside the catalogue, if anything is.
    pub(crate) unknown: Option<Outside>,
    pub(crate) structure: Structure,
    /// What is left is noise of the sensors.
    pub(crate) is_noise: bool,
}

impl Remainder {
    /// Decides what is left where an attempt has gone as far as it can; `left` are its residuals.
    pub(crate) fn new(
        data: &Data,
        Attempt { selection, located, .. }: &Attempt,
        left: &Residuals,
        colours: &[Colour],
        settings: &Settings<'_>,
    ) -> Remainder {
        let chi = selection.fit.score.chi();
        // with few samples noise alone goes further than that
        let by_chance = 1.0 + 3.0 * (2.0 * inflation(colours) / selection.fit.score.count().max(1.0)).sqrt();
        if chi <= NOTHING_LEFT || chi * chi <= by_chance {
            return Remainder { unknown: None, structure: Structure { p_value: 1.0 }, is_noise: false };
        }
        let structure = structure::test(data, &selection.fit, left, colours, settings.seed);
        let nothing = |is_noise| Remainder { unknown: None, structure, is_noise };
        let explained = selection.explained();
        let is_of_wire = structure.is_there() || (selection.steps.is_empty() && locate::is_physical(located));
        if !is_of_wire && chi < LOUDEST_NOISE {
            return nothing(true);
        }
        // A mechanism that is the right one leaves noise; others can be bent to explain most of anything, and leave more.
        let found = !selection.fit.space.effects.is_empty();
        if found && (chi <= UNEXPLAINED || chi > BEYOND_MODELS && explained >= NAMED_SHARE) {
            return nothing(false);
        }
        let progress = |share| (settings.progress)("beyond the catalogue", share);
        let form = closed_form::search(data, &selection.reference, &progress);
        // a mechanism that does most of it, and as much as any single term that is free to be anything, keeps its name
        let best_mechanism = selection.steps.first().and_then(|s| s.field.first()).map(|r| r.fit.score.sum());
        let no_term_is_better = match (&form, best_mechanism) {
            (Some(form), Some(left)) => left <= form.left_by_one * ALMOST,
            (None, Some(_)) => true,
            (_, None) => false,
        };
        if chi > BEYOND_MODELS && explained >= MOST_OF_IT && no_term_is_better {
            return nothing(false);
        }
        Remainder { unknown: Some(Outside::new(form, selection, located)), structure, is_noise: false }
    }

    /// The fit of everything that was found, in the catalogue or outside.
    pub(crate) fn fit<'a>(&'a self, selection: &'a Selection) -> &'a Fit {
        self.unknown.as_ref().map_or(&selection.fit, |u| &u.fit)
    }
}

/// Noise of every sensor where what is left does not depend on the wire: the sensors are noisier than their fast
/// fluctuations show. Those it concerns are named in `warnings`.
pub(crate) fn wandering_noise(data: &Data, colours: &[Colour], warnings: &mut Vec<String>) -> Vec<f64> {
    for (sensor, colour) in data.sensors.iter().zip(colours) {
        if colour.deviation > NOTHING_LEFT {
            warnings.push(format!(
                "{}: what is left is {} times the noise seen between neighbouring samples, wanders, and depends on \
                 nothing the wire does: taken as noise of the sensor",
                sensor.column.name(),
                number(colour.deviation)
            ));
        }
    }
    data.sensors.iter().zip(colours).map(|(sensor, colour)| sensor.noise * colour.deviation.max(1.0)).collect()
}

/// Something outside the catalogue.
pub(crate) struct Outside {
    pub(crate) equation: Equation,
    library: Option<&'static Effect>,
    fit: Fit,
}

impl Outside {
    /// The closed form, or where none is better than what the catalogue came to, that: it stands in for it, if there is
    /// anything.
    fn new(form: Option<ClosedForm>, selection: &Selection, located: &[Located]) -> Outside {
        match form {
            Some(form) if form.fit.score.kept <= selection.fit.score.kept => {
                Outside { equation: form.library.equation, library: Some(form.library), fit: form.fit }
            }
            _ => {
                let nearest = selection.steps.first().map(|step| step.effect.equation);
                let equation = nearest.or_else(|| located.first().map(|l| l.equation)).unwrap_or(Equation::Mechanical);
                Outside { equation, library: None, fit: selection.fit.clone() }
            }
        }
    }

    /// As the answer says it, with the score of the model without and with it.
    pub(crate) fn describe(&self, intervals: &[Interval], before: Score, after: Score) -> Unknown {
        let mut coefficients = BTreeMap::new();
        let mut form = String::new();
        let mut unit = String::new();
        if let Some(library) = self.library {
            for (coordinate, interval) in self.fit.space.coordinates.iter().zip(intervals) {
                if let What::Effect(effect, parameter) = coordinate.what
                    && effect.id == library.id
                {
                    unit = parameter.unit.to_string();
                    let sign = if interval.value < 0.0 {
                        "− "
                    } else if form.is_empty() {
                        ""
                    } else {
                        "+ "
                    };
                    let space = if form.is_empty() { "" } else { " " };
                    form.push_str(&format!("{space}{sign}{} · {}", number(interval.value.abs()), parameter.about));
                    let size = EffectSize {
                        value: interval.value,
                        low: interval.low,
                        high: interval.high,
                        unit: unit.clone(),
                    };
                    coefficients.insert(parameter.key.to_string(), size);
                }
            }
        }
        Unknown {
            equation: self.equation.name().to_string(),
            form,
            unit,
            coefficients,
            holdout_chi_before: before.chi_kept(),
            holdout_chi_after: after.chi_kept(),
        }
    }
}
