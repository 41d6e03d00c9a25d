//! Outside the catalogue: a closed form for what no mechanism explains.

use std::collections::BTreeMap;

use sinew_physics::effects::Effect;

use crate::answer::{EffectSize, Unknown};
use crate::data::Data;
use crate::explanation::{Explanation, Turns};
use crate::intervals::Interval;
use crate::numbers::number;
use crate::residuals::Score;
use crate::select::{self, TAKEN};
use crate::space::What;

/// Terms of a closed form at most.
const MOST_TERMS: usize = 3;
/// Terms that are refitted at every step.
const FINALISTS: usize = 3;

/// A sparse closed form of terms of one equation.
#[derive(Debug, Clone)]
pub(crate) struct Outside {
    /// The library its terms are from.
    pub(crate) library: &'static Effect,
    pub(crate) explanation: Explanation,
}

impl Outside {
    /// The closed form beyond `base` that raises the evidence most, its terms added while each raises it enough; the first
    /// has to do so against all terms of all equations.
    pub(crate) fn search(data: &Data, base: &Explanation) -> Option<Outside> {
        let mut best: Option<Outside> = None;
        for _ in 0..MOST_TERMS {
            let from = best.as_ref().map_or(base, |best| &best.explanation);
            let library = best.as_ref().map(|best| best.library);
            let next = select::next_term(data, from, library, FINALISTS)?;
            if next.1.evidence - from.evidence < TAKEN {
                break;
            }
            best = Some(Outside { library: next.0, explanation: next.1 });
        }
        let mut found = best?;
        let Explanation { fit, discrepancy, .. } = &found.explanation;
        if let Some(settled) = Explanation::of(data, &fit.space, &fit.z, discrepancy, Turns::ALL)
            && settled.evidence > found.explanation.evidence
        {
            found.explanation = settled;
        }
        Some(found)
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
                && effect.id == self.library.id
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
            equation: self.library.equation.name().to_string(),
            form,
            unit,
            coefficients,
            holdout_chi_before: before.chi_kept(),
            holdout_chi_after: after.chi_kept(),
        }
    }
}
