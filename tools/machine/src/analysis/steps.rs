//! Steps of the reference: settling, overshoot, and steady-state error.

use super::finding::{Estimate, Finding, mean};
use super::run::{AtRest, Run};
use crate::run::Row;
use crate::stage::Part;

/// A place is reached within this share of the way.
const BAND: f64 = 0.02;
/// A step that is outside in this last part of its time did not settle.
const LAST: f64 = 0.1;
/// Where a sensor's noise is no small share of that band, the band is so many σ of it: one row in 10⁶ is outside by chance.
const BAND_SIGMA: f64 = 5.0;
/// Motion that is less than so many times what a wire at rest shows is not told from it.
const SEEN: f64 = 2.0;
/// Half of what is between the extremes of some hundred rows of noise, σ.
const EXTREMES_SIGMA: f64 = 3.0;

/// What became of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Elongation it came from, m.
    pub from_m: f64,
    /// Elongation it was to go to, m.
    pub to_m: f64,
    /// Last moment outside ± 2 % of the way, or of what the sensor can tell, s; `None` where that is in the last tenth.
    pub settle_s: Option<f64>,
    /// Farthest beyond, share of the way.
    pub overshoot: f64,
    /// Mean error of the last third, m.
    pub mean_m: Estimate,
    /// Half of what is between the extremes of the last third, m: the limit cycle.
    pub swing_m: f64,
    /// RMS velocity in the last third, m/s: twitching.
    pub twitch_m_s: f64,
}

/// The steps of a run.
pub fn steps(run: &Run<'_>) -> Vec<Step> {
    let period_s = 1.0 / run.spec.rate_hz;
    run.stretches()
        .filter_map(|(stage, rows)| match stage.part {
            Part::Hold { from_m, to_m } => step(rows, from_m, to_m, period_s, run.at_rest),
            _ => None,
        })
        .collect()
}

/// How near to its end a way counts as done, m.
fn band_m(way_m: f64, at_rest: Option<AtRest>) -> f64 {
    (BAND * way_m.abs()).max(at_rest.map_or(0.0, |at_rest| BAND_SIGMA * at_rest.noise_m))
}

fn step(rows: &[Row], from_m: f64, to_m: f64, period_s: f64, at_rest: Option<AtRest>) -> Option<Step> {
    let way = to_m - from_m;
    let start_s = rows.first()?.time_s;
    let length_s = rows.len() as f64 * period_s;
    let errors: Vec<f64> = rows.iter().map(|row| row.reading.position_m - to_m).collect();
    let outside = errors.iter().rposition(|error| error.abs() > band_m(way, at_rest));
    let settle_s = outside.map_or(0.0, |at| rows[at].time_s + period_s - start_s);
    let overshoot = errors.iter().map(|error| error / way).fold(0.0, f64::max);
    let late = &errors[2 * errors.len() / 3..];
    let count = late.len().max(1) as f64;
    let mean_m = late.iter().sum::<f64>() / count;
    let variance = late.iter().map(|error| (error - mean_m).powi(2)).sum::<f64>() / count;
    let (low, high) = late.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), e| (a.min(*e), b.max(*e)));
    let speed = late.windows(2).map(|w| ((w[1] - w[0]) / period_s).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    // what oscillates for a few turns only gives its mean no better than a few independent samples
    let turns = late.windows(2).filter(|w| (w[0] - mean_m) * (w[1] - mean_m) < 0.0).count().max(1) as f64;
    Some(Step {
        from_m,
        to_m,
        settle_s: (settle_s <= (1.0 - LAST) * length_s).then_some(settle_s),
        overshoot,
        mean_m: Estimate { value: mean_m, sigma: (variance / turns).sqrt() },
        swing_m: 0.5 * (high - low),
        twitch_m_s: speed.sqrt(),
    })
}

/// Every number of a run.
pub fn findings(run: &Run<'_>) -> Vec<Finding> {
    let steps = steps(run);
    let mut all = Vec::new();
    for (of, ways) in [("steps to shorter", true), ("steps to longer", false)] {
        let of_way: Vec<&Step> = steps.iter().filter(|step| (step.to_m < step.from_m) == ways).collect();
        if of_way.is_empty() {
            continue;
        }
        let list = |value: &dyn Fn(&Step) -> Option<Estimate>| -> Vec<Estimate> {
            of_way.iter().filter_map(|s| value(s)).collect()
        };
        let exact = |value: f64, sigma: f64| Some(Estimate { value, sigma });
        let settled = list(&|s| exact(s.settle_s?, 1.0 / run.spec.rate_hz));
        let repeated = format!("; mean of {}", of_way.len());
        let widest_m = of_way.iter().map(|s| band_m(s.to_m - s.from_m, run.at_rest)).fold(0.0, f64::max);
        let is_wider = of_way.iter().any(|s| band_m(s.to_m - s.from_m, run.at_rest) > BAND * (s.to_m - s.from_m).abs());
        let (settles, band) = match is_wider {
            false => ("Settling time to ± 2 % of the way", "2 % of the way".to_string()),
            true => (
                "Settling time to within the position's noise",
                format!(
                    "{} mm, five times the position's noise, which is more than 2 % of the way",
                    sinew_plot::quantity::number(1e3 * widest_m)
                ),
            ),
        };
        let settling = match mean(&settled) {
            Some(value) if settled.len() == of_way.len() => Ok(value),
            _ => Err(format!("{} of {} did not stay within {band}", of_way.len() - settled.len(), of_way.len())),
        };
        all.push(Finding::from(
            "settling_s",
            settles,
            "s",
            of,
            &settling,
            format!("last sample outside of {band}{repeated}"),
        ));
        let micro = 1e6;
        // what a sensor shows of a wire that stands still anyway
        let still = run.at_rest.unwrap_or(AtRest { noise_m: 0.0, speed_m_s: 0.0 });
        let extremes_m = EXTREMES_SIGMA * still.noise_m;
        let mut push = |key, label, unit: &'static str, values: Vec<Estimate>, how: &str, still: f64| {
            let Some(value) = mean(&values) else { return };
            let found = match value.value.abs() < SEEN * still {
                true => Err(format!(
                    "it is within what the position's sensor shows of a wire at rest, {} {unit}",
                    sinew_plot::quantity::number(still)
                )),
                false => Ok(value),
            };
            all.push(Finding::from(key, label, unit, of, &found, format!("{how}{repeated}")));
        };
        let least_way_m = of_way.iter().map(|s| (s.to_m - s.from_m).abs()).fold(f64::INFINITY, f64::min).max(1e-9);
        push(
            "overshoot_percent",
            "Overshoot",
            "% of the way",
            list(&|s| exact(100.0 * s.overshoot, 100.0 * 1e-6 / (s.to_m - s.from_m).abs().max(1e-9))),
            "farthest beyond the reference",
            100.0 * extremes_m / least_way_m,
        );
        // a mean of many rows, which says itself how sure it is
        push(
            "steady_error_um",
            "Steady-state error",
            "µm",
            list(&|s| Some(s.mean_m.scaled(micro))),
            "mean of the last third",
            0.0,
        );
        push(
            "limit_cycle_um",
            "Limit cycle, half of peak to peak",
            "µm",
            list(&|s| exact(micro * s.swing_m, 0.5)),
            "extremes of the last third",
            micro * extremes_m,
        );
        push(
            "twitch_mm_per_s",
            "Twitching, RMS velocity at rest",
            "mm/s",
            list(&|s| exact(1e3 * s.twitch_m_s, 1e-3)),
            "differences of the last third",
            1e3 * still.speed_m_s,
        );
    }
    if all.is_empty() {
        all.push(Finding::unknown("settling_s", "Settling time to ± 2 % of the way", "s", "", "no step was completed"));
    }
    all
}
