//! How far what was kept back bears out what was found.

use sinew_physics::effects::{Effect, Nature};

use crate::answer::Grade;
use crate::data::Data;
use crate::explanation::Explanation;
use crate::fit::Fit;
use crate::residuals;

/// Rise of the log density of what is kept back from which an effect is confirmed there.
pub(crate) const CONFIRMED: f64 = 3.0;

/// How far what was kept back bears an effect out, and by what.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BorneOut {
    pub(crate) grade: Grade,
    /// Rise of the log density of what was kept back.
    pub(crate) rise: f64,
}

/// How far what was kept back bears an effect out. Other curves are no finding that what is left could have bent.
pub(crate) fn grade(data: &Data, effect: &Effect, without: &Explanation, with: &Explanation) -> BorneOut {
    let is_shape = effect.nature == Nature::Shape;
    let rise = with.rise_on_kept(data, without);
    let explains = is_shape || explains_more_than_it_leaves(data, without, with);
    let grade = if rise < CONFIRMED || !explains {
        Grade::Suspected
    } else if data.runs.iter().any(|run| run.held_out) {
        Grade::ConfirmedOnAnotherProgramme
    } else {
        Grade::OnThisProgrammeOnly
    };
    BorneOut { grade, rise }
}

/// Whether an effect takes away more of the error on what is kept back than all that was found leaves there. What nobody explains
/// bends whatever it finds: something smaller beside it may be that alone.
fn explains_more_than_it_leaves(data: &Data, without: &Explanation, with: &Explanation) -> bool {
    let square = |x: &Explanation| chi_kept(data, &x.fit).powi(2);
    let left = square(with);
    with.leaves_noise() || square(without) - left > left - 1.0
}

/// chi on what is kept back, over the noise of the sensors.
pub(crate) fn chi_kept(data: &Data, fit: &Fit) -> f64 {
    let left = residuals::plain_at(data, &fit.space, &fit.z);
    left.map_or(f64::NAN, |left| residuals::score(data, &left).chi_kept())
}
