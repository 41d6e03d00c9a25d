//! Whether what was kept back asks for an effect at the size it has where it was fitted: what has bent to something else is there of
//! another size, or of none.

use nalgebra::{DMatrix, DVector};
use sinew_physics::effects::Effect;

use crate::answer::SizeAsked;
use crate::data::{Data, Part, Run};
use crate::explanation::Explanation;
use crate::fit::Known;
use crate::products;
use crate::residuals;
use crate::space::What;

/// The size that what was kept back asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Asked {
    /// Over the size where it was fitted.
    pub(crate) factor: f64,
    /// Standard deviation of that.
    pub(crate) deviation: f64,
}

/// Half-width of a 90 % interval, in standard deviations.
const Z90: f64 = 1.6449;

impl Asked {
    /// As the answer says it.
    pub(crate) fn says(self) -> SizeAsked {
        let reach = Z90 * self.deviation;
        SizeAsked { value: self.factor, low: self.factor - reach, high: self.factor + reach }
    }

    /// With one size for what is fitted and one for what was kept back, and all else in common: one Newton step from where everything
    /// was fitted, so that what the parameters make up for counts neither here nor there. The likelihood is that of an error which
    /// each part has by itself. `None` where the recording kept back has a zero of its own, or the model cannot be built.
    pub(crate) fn of(data: &Data, with: &Explanation, effect: &Effect) -> Option<Asked> {
        let space = &with.fit.space;
        let z = &with.fit.z;
        let has_held_out = data.runs.iter().any(|run| run.held_out);
        if has_held_out && data.free_zero {
            return None;
        }
        let (seen, known) = if has_held_out {
            let seen = |run: &Run| Run { held_out: false, ..run.clone() };
            let data = Data { runs: data.runs.iter().map(seen).collect(), ..data.clone() };
            let known = Known::at(&data, space, z)?;
            (data, known)
        } else {
            (data.clone(), with.derivatives(data)?)
        };
        let left = residuals::plain_at(&seen, space, z)?;
        let part = |judged: Data, part: Part| {
            let columns = products::matrix(&judged, part, &known.white(&judged).iter().collect::<Vec<_>>());
            let left = DVector::from_vec(products::flat(&judged, part, &judged.white(&left)));
            (products::square(&columns), products::product(&columns, &left))
        };
        let fitted = part(with.discrepancy.whitened(&seen, &left), Part::Fitted);
        let kept = part(with.discrepancy.on_kept(&seen, &left).whitened(&seen, &left), Part::KeptBack);
        // the effect's switches go together, from their null to where they are
        let is_switch = |i: &usize| match space.coordinates[*i].what {
            What::Effect(e, p) => e.id == effect.id && p.is_switch(),
            _ => false,
        };
        let (switches, others): (Vec<usize>, Vec<usize>) = (0..space.len()).partition(is_switch);
        let n = others.len();
        let onto = |rows: usize, along: usize| {
            let mut onto = DMatrix::zeros(space.len(), rows);
            others.iter().enumerate().for_each(|(k, i)| onto[(*i, k)] = 1.0);
            // 0 is the null
            switches.iter().for_each(|i| onto[(*i, along)] = z[*i]);
            onto
        };
        let (of_fitted, of_kept) = (onto(n + 2, n), onto(n + 2, n + 1));
        let mut information =
            of_fitted.tr_mul(&(fitted.0 * &of_fitted)) + of_kept.tr_mul(&(kept.0 * &of_kept));
        let mut gradient = of_fitted.tr_mul(&fitted.1) + of_kept.tr_mul(&kept.1);
        for (k, i) in others.iter().enumerate() {
            let pull = space.coordinates[*i].pull;
            information[(k, k)] += pull + 1e-9;
            gradient[k] += pull * z[*i];
        }
        let factor = information.cholesky()?;
        let step = -factor.solve(&gradient);
        let covariance = factor.inverse();
        let on_fitted = 1.0 + step[n];
        let asked = Asked { factor: (1.0 + step[n + 1]) / on_fitted, deviation: covariance[(n + 1, n + 1)].sqrt() };
        (asked.factor.is_finite() && asked.deviation.is_finite()).then_some(asked)
    }
}
