//! What page and terminal both draw from a diagnosis: overall errors, and how far parameters moved.

use sinew_diagnosis::{Diagnosis, FittedParameter};

/// A parameter further from the rig file than this many σ of its prior is worth a remark.
pub(crate) const FAR_SIGMAS: f64 = 2.0;

/// chi over all sensors on kept-back data, by stage.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Overall {
    pub(crate) as_given: f64,
    pub(crate) recalibrated: f64,
    pub(crate) improved: f64,
}

impl Overall {
    pub(crate) fn of(diagnosis: &Diagnosis) -> Overall {
        Overall {
            as_given: diagnosis.left.chi_as_given,
            recalibrated: diagnosis.left.chi,
            improved: diagnosis.left.chi_improved,
        }
    }
}

/// How far a parameter moved, in σ of its prior; NaN where it has none.
pub(crate) fn sigmas(parameter: &FittedParameter) -> f64 {
    in_sigmas(parameter, parameter.value)
}

/// A value of a parameter counted from the rig file's, in σ of its prior.
pub(crate) fn in_sigmas(parameter: &FittedParameter, value: f64) -> f64 {
    if parameter.prior_sigma > 0.0 { (value - parameter.given) / parameter.prior_sigma } else { f64::NAN }
}

/// The parameters that moved most, by at least one σ: at most `most` of them, the furthest first.
pub(crate) fn largest_changes(diagnosis: &Diagnosis, most: usize) -> Vec<(&str, &FittedParameter)> {
    let mut moved: Vec<(&str, &FittedParameter)> =
        diagnosis.parameters.iter().filter(|(_, p)| sigmas(p).abs() >= 1.0).map(|(key, p)| (key.as_str(), p)).collect();
    moved.sort_by(|(_, a), (_, b)| sigmas(b).abs().total_cmp(&sigmas(a).abs()));
    moved.truncate(most);
    moved
}
