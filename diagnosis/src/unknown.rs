//! Outside the catalogue: what no mechanism explains, by the equation it acts in and, where there is one, a closed form.

use std::collections::BTreeMap;

use sinew_physics::effects::{self, Effect, Equation, Nature};

use crate::answer::{EffectSize, Unknown};
use crate::data::Data;
use crate::explanation::{Explanation, Turns};
use crate::intervals::Interval;
use crate::numbers::number;
use crate::residuals::{self, Score};
use crate::select::{self, TAKEN};
use crate::space::What;

/// Terms of a closed form at most.
const MOST_TERMS: usize = 3;
/// Terms that are refitted at every step.
const FINALISTS: usize = 3;

/// What acts in one equation, and a sparse closed form for it where there is one.
#[derive(Debug, Clone)]
pub(crate) struct Outside {
    pub(crate) equation: Equation,
    /// The library the form's terms are from; `None` where none of them helps.
    library: Option<&'static Effect>,
    /// With the form, where there is one.
    pub(crate) explanation: Explanation,
}

impl Outside {
    /// What `base` leaves out, which an unknown input shows best in the equation `suspect`. A closed form of any equation that
    /// explains the larger part says where better than that; else one is looked for there. A form that does not help where it
    /// was not fitted is none.
    pub(crate) fn search(data: &Data, base: &Explanation, suspect: Equation) -> Outside {
        let found = Form::search(data, base, |_| true)
            .filter(|form| form.explains_the_larger_part(data, base))
            .or_else(|| Form::search(data, base, |equation| equation == suspect))
            .filter(|form| form.explanation.rise_on_kept(data, base) > 0.0);
        match found {
            Some(Form { library, explanation }) => {
                Outside { equation: library.equation, library: Some(library), explanation }
            }
            None => Outside { equation: suspect, library: None, explanation: base.clone() },
        }
    }

    /// As the answer says it, with the score of the model without and with it.
    pub(crate) fn describe(
        &self,
        chosen: &Explanation,
        intervals: &[Interval],
        before: Score,
        after: Score,
    ) -> Unknown {
        let mut coefficients = BTreeMap::new();
        let mut form = String::new();
        let mut unit = String::new();
        for (coordinate, interval) in chosen.fit.space.coordinates.iter().zip(intervals) {
            if let What::Effect(effect, parameter) = coordinate.what
                && self.library.is_some_and(|library| library.id == effect.id)
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
                let size =
                    EffectSize { value: interval.value, low: interval.low, high: interval.high, unit: unit.clone() };
                coefficients.insert(parameter.key.to_string(), size);
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

/// A sparse closed form of terms of one library.
struct Form {
    library: &'static Effect,
    explanation: Explanation,
}

impl Form {
    /// The one of the equations `of` that raises the evidence most beyond `base`, its terms added while each raises it enough.
    fn search(data: &Data, base: &Explanation, of: impl Fn(Equation) -> bool) -> Option<Form> {
        let model = base.fit.space.model(&base.fit.z)?;
        let is_library = |e: &&'static Effect| e.nature == Nature::Empirical && of(e.equation);
        let mut libraries: Vec<&'static Effect> =
            effects::catalogue().filter(is_library).filter(|e| e.applies_to(&model) && e.is_null(&model)).collect();
        let mut found: Option<Form> = None;
        for _ in 0..MOST_TERMS {
            let from = found.as_ref().map_or(base, |form| &form.explanation);
            let Some((library, explanation)) = select::next_term(data, from, &libraries, FINALISTS) else { break };
            if explanation.evidence - from.evidence < TAKEN {
                break;
            }
            libraries = vec![library];
            found = Some(Form { library, explanation });
        }
        let mut found = found?;
        if let Some(settled) = found.explanation.again(data, Turns::ALL)
            && settled.evidence > found.explanation.evidence
        {
            found.explanation = settled;
        }
        Some(found)
    }

    /// Whether at most half of what `base` leaves beyond noise is left, where it is fitted.
    fn explains_the_larger_part(&self, data: &Data, base: &Explanation) -> bool {
        let beyond_noise = |x: &Explanation| {
            let left = residuals::plain_at(data, &x.fit.space, &x.fit.z)?;
            let score = residuals::score(data, &left);
            Some(score.fitted / score.fitted_count.max(1.0) - 1.0)
        };
        match (beyond_noise(&self.explanation), beyond_noise(base)) {
            (Some(with), Some(without)) => with < 0.5 * without,
            _ => false,
        }
    }
}
