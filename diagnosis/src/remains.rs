//! What is left with everything that was found in the model: how much, in which equation, when, and what it looks like.

use std::collections::BTreeMap;

use sinew_physics::effects::{Equation, Nature};

use crate::answer::{LooksLike, Remains, SensorRemains};
use crate::conditions;
use crate::data::Data;
use crate::explanation::Explanation;
use crate::locate::{self, Located};
use crate::stages::Compared;

/// Where an unknown input explains more than this share of what it explained beside the parameters alone, what was found has not
/// explained the larger part.
const LARGER_PART: f64 = 0.5;

/// Where an unknown shift of the transformation explains this share of what the best unknown input does, it may be that.
const AS_WELL: f64 = 0.85;

/// What an explanation of `data` leaves, by what would explain it: noise comes in each sensor by itself and is no larger than it was
/// estimated to be, a mechanism comes in an equation. An unknown shift of the transformation is what curves of another shape
/// come to. Where such curves were found, they are no closer to the wire's than any closed form is: what a shift explains as well is
/// theirs before it is a mechanism's. Where they were tried and did not help, it is not.
pub(crate) fn looks_like(data: &Data, chosen: &Explanation, left: &[Located]) -> LooksLike {
    if chosen.leaves_rounding(data) || chosen.leaves_little() && !locate::is_physical(left) {
        return LooksLike::Noise;
    }
    let has_curves = chosen.fit.space.effects.iter().any(|effect| effect.nature == Nature::Shape);
    let kinetic = left.iter().filter(|l| l.equation == Equation::Kinetic).map(|l| l.evidence).fold(0.0, f64::max);
    match left.first() {
        Some(most) if has_curves && kinetic > 0.0 && kinetic >= AS_WELL * most.evidence => LooksLike::Curves,
        _ => LooksLike::MissingMechanism,
    }
}

/// Whether what was found explains the smaller part only: `located` is what an unknown input explains beside the parameters
/// alone, `left` beside what was found, too.
pub(crate) fn is_the_larger_part(located: &[Located], left: &[Located]) -> bool {
    let most = |located: &[Located]| located.first().map_or(0.0, |most| most.evidence);
    most(left) > LARGER_PART * most(located).max(0.0)
}

/// What the chosen model leaves; `left` is where. Where curves of another shape were found, they are what remains of a wire that
/// follows no closed form, unless a mechanism is missing beside them.
pub(crate) fn remains(data: &Data, compared: &Compared, left: &[Located], has_curves: bool) -> Remains {
    let Compared { chosen, improved, .. } = compared;
    let looks_like = match looks_like(data, chosen, left) {
        LooksLike::Noise if compared.errs_where_kept_back_only => LooksLike::MissingMechanism,
        looks_like => looks_like,
    };
    let is_noise = looks_like == LooksLike::Noise;
    Remains {
        chi: improved.score.chi_kept(),
        looks_like: if has_curves && looks_like != LooksLike::MissingMechanism {
            LooksLike::Curves
        } else {
            looks_like
        },
        sensors: by_sensor(data, chosen),
        equations: locate::scores(left),
        windows: if is_noise { Vec::new() } else { conditions::windows(data, &improved.residuals) },
        conditions: if is_noise { Vec::new() } else { conditions::conditions(data, &chosen.fit, &improved.residuals) },
    }
}

/// The error of the model in every sensor, over all recordings.
fn by_sensor(data: &Data, chosen: &Explanation) -> BTreeMap<String, SensorRemains> {
    data.sensors
        .iter()
        .enumerate()
        .map(|(s, sensor)| {
            let wanders = || chosen.discrepancy.wanders.iter().map(|by_sensor| by_sensor[s]);
            let count = chosen.discrepancy.wanders.len().max(1) as f64;
            let over_noise = (wanders().map(|w| w.size * w.size).sum::<f64>() / count).sqrt();
            let memory_s = wanders().max_by(|a, b| a.size.total_cmp(&b.size)).map_or(0.0, |w| w.memory_s);
            (sensor.column.name().to_string(), SensorRemains { rms: over_noise * sensor.noise, over_noise, memory_s })
        })
        .collect()
}
