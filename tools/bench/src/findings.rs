//! The thesis' findings, checked on the bench's rows.

use serde::Serialize;

use crate::row::{Figures, Row};

/// A finding of the thesis beside what the rows say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What the thesis found, and where.
    pub finding: &'static str,
    /// What the rows say, with their numbers.
    pub here: String,
    /// When it counts as reproduced.
    pub criterion: &'static str,
    /// Whether it is; null where the rows it takes were not run.
    pub reproduced: Option<bool>,
}

/// Which rows a finding looks at; `""` is any word.
struct Wanted<'a> {
    plant: &'a str,
    controller: &'a str,
    estimator: &'a str,
    sensing: &'a str,
}

struct Rows<'a> {
    rows: &'a [Row],
    /// The estimator that a finding about laws takes: the rig file's default where it was run.
    estimator: &'a str,
}

impl<'a> Rows<'a> {
    fn find(&self, wanted: &Wanted<'_>) -> Option<&'a Figures> {
        let is = |word: &str, of: &str| word.is_empty() || word == of;
        let row = self.rows.iter().find(|row| {
            is(wanted.plant, &row.plant)
                && is(wanted.controller, &row.controller)
                && is(wanted.estimator, &row.estimator)
                && is(wanted.sensing, &row.sensing)
                && row.figures.is_some()
        })?;
        row.figures.as_ref()
    }

    /// A law on a plant, measuring by two taps, with the usual estimator.
    fn law(&self, plant: &str, controller: &str) -> Option<&'a Figures> {
        self.find(&Wanted { plant, controller, estimator: self.estimator, sensing: "dual" })
    }

    fn estimator(&self, plant: &str, estimator: &str) -> Option<&'a Figures> {
        // what drives the wire is the same for all: a law that needs no estimate
        self.find(&Wanted { plant, controller: "pi", estimator, sensing: "dual" })
    }
}

fn seconds(value: Option<f64>) -> String {
    value.map_or("never".into(), |value| format!("{value:.2} s"))
}

/// Every finding, in the thesis' order.
pub fn findings(rows: &[Row], estimator: &str) -> Vec<Finding> {
    let rows = Rows { rows, estimator };
    vec![
        resistance_feedback(&rows),
        constant_observer(&rows),
        feed_forward(&rows),
        servo_overshoot(&rows),
        settling_on_three_watts(&rows),
        surface_on_one_watt(&rows),
        first_order_limit_cycle(&rows),
    ]
}

/// Chapter 7: feedback of the resistance.
fn resistance_feedback(rows: &Rows<'_>) -> Finding {
    let by = |sensing: &str| {
        rows.find(&Wanted { plant: "figure", controller: "sliding_mode", estimator: rows.estimator, sensing })
    };
    let (dual, alone) = (by("dual"), by("resistance"));
    Finding {
        finding: "Feedback of the resistance leaves an error that the dual measurement does not (chapter 7)",
        here: both(dual, alone, |dual, alone| {
            format!(
                "steady-state error {:.2} % of the stroke by two taps, {:.1} % by resistance (sliding mode, RMS)",
                dual.steady_rms_percent, alone.steady_rms_percent
            )
        }),
        criterion: "by resistance more than three times as much",
        reproduced: dual.zip(alone).map(|(dual, alone)| alone.steady_rms_percent > 3.0 * dual.steady_rms_percent),
    }
}

/// Chapter 9: observers with constant and with scheduled gains.
fn constant_observer(rows: &Rows<'_>) -> Finding {
    let (constant, scheduled) =
        (rows.estimator("thesis_3w", "luenberger"), rows.estimator("thesis_3w", "luenberger_scheduled"));
    Finding {
        finding: "A constant observer gets martensite right and temperature wrong; a gain-scheduled one both (chapter 9)",
        here: both(constant, scheduled, |constant, scheduled| {
            format!(
                "constant: martensite off by {:.3}, temperature by {:.1} K; scheduled: {:.3} and {:.1} K (RMS, PI, 3 W)",
                constant.martensite_rms,
                constant.temperature_rms_k,
                scheduled.martensite_rms,
                scheduled.temperature_rms_k
            )
        }),
        criterion: "constant: martensite within 0.1, temperature off by 5 K and by twice what the scheduled one is",
        reproduced: constant.zip(scheduled).map(|(constant, scheduled)| {
            constant.martensite_rms < 0.1
                && constant.temperature_rms_k > 5.0
                && constant.temperature_rms_k > 2.0 * scheduled.temperature_rms_k
        }),
    }
}

/// Chapter 10: what input–output linearisation owes to feeding the loss forward, and what to inverting the slope.
fn feed_forward(rows: &Rows<'_>) -> Finding {
    let inverted = rows.law("thesis_3w", "input_output_linearised");
    let constant = rows.law("thesis_3w", "input_output_linearised_constant");
    let no_loss = rows.law("thesis_no_feedforward", "input_output_linearised");
    let error = |figures: &Figures| figures.steady_rms_percent;
    let all = inverted.zip(constant).zip(no_loss).map(|((a, b), c)| [a, b, c].map(error));
    Finding {
        finding: "Feeding forward the heat loss matters more than inverting the slope of the transformation (chapter 10)",
        here: all.map_or(NOT_RUN.into(), |[both, constant, no_loss]| {
            format!(
                "steady-state error of input–output linearisation {both:.1} % of the stroke, {constant:.1} % with a constant \
                 slope, {no_loss:.1} % with the slope inverted but the loss not fed forward"
            )
        }),
        criterion: "leaving out the loss costs more than twice what leaving out the inversion costs",
        reproduced: all.map(|[both, constant, no_loss]| no_loss - both > 2.0 * (constant - both)),
    }
}

/// Chapter 10: the servo with static gains.
fn servo_overshoot(rows: &Rows<'_>) -> Finding {
    let found = rows.law("thesis_3w", "velocity_servo");
    Finding {
        finding: "The exact-velocity-linearised servo with static gains overshoots by about a quarter, 26 % (chapter 10)",
        here: found.map_or(NOT_RUN.into(), |figures| {
            format!("worst overshoot {:.0} % of the step it happened on", figures.overshoot_of_step_percent)
        }),
        criterion: "15 to 40 % of the step",
        reproduced: found.map(|figures| (15.0..=40.0).contains(&figures.overshoot_of_step_percent)),
    }
}

/// Figure 110: sliding mode of second order on 3 W.
fn settling_on_three_watts(rows: &Rows<'_>) -> Finding {
    let found = rows.law("thesis_3w", "sliding_mode");
    let plain = rows.law("thesis_3w", "sliding_mode_plain");
    Finding {
        finding: "Second-order sliding mode on 3 W settles near 1 s, heating and cooling, without overshoot (figure 110)",
        here: found.map_or(NOT_RUN.into(), |figures| {
            let [up, down] = figures.settling_2_percent_s.map(seconds);
            let plain = plain.map_or(String::new(), |plain| {
                format!(
                    "; the plain switching law on the observer's derivatives overshoots by {:.1} % and cycles by ±{:.1} %",
                    plain.overshoot_percent, plain.limit_cycle_percent
                )
            });
            format!(
                "first steps within ±2 % after {up} up and {down} down, overshoot {:.2} %{plain}",
                figures.overshoot_percent
            )
        }),
        criterion: "0.5 to 1.5 s to ±2 % both ways, overshoot at most 0.5 % of the stroke",
        reproduced: found.map(|figures| {
            let near = |value: Option<f64>| value.is_some_and(|value| (0.5..=1.5).contains(&value));
            figures.settling_2_percent_s.into_iter().all(near) && figures.overshoot_percent <= 0.5
        }),
    }
}

/// Figure 111: the same on 1 W.
fn surface_on_one_watt(rows: &Rows<'_>) -> Finding {
    let surface = |plant: &str| rows.law(plant, "sliding_mode").and_then(|figures| figures.surface_reached_s);
    let (strong, weak) = (surface("thesis_3w"), surface("thesis_1w"));
    Finding {
        finding: "On 1 W the sliding surface is reached late (figure 111)",
        here: match strong.zip(weak) {
            Some((strong, weak)) => format!("reached after {strong:.2} s on 3 W, {weak:.2} s on 1 W (first step)"),
            None => NOT_RUN.into(),
        },
        criterion: "at least twice as late as on 3 W",
        reproduced: strong.zip(weak).map(|(strong, weak)| weak >= 2.0 * strong),
    }
}

/// Figure 113: sliding mode of first order.
fn first_order_limit_cycle(rows: &Rows<'_>) -> Finding {
    let second = rows.law("thesis_3w", "sliding_mode");
    let first = rows.law("thesis_3w", "sliding_mode_first_order");
    Finding {
        finding: "A first-order sliding surface ends in a limit cycle (figure 113)",
        here: both(first, second, |first, second| {
            format!(
                "±{:.2} % of the stroke, for good; second order ±{:.2} %",
                first.limit_cycle_percent, second.limit_cycle_percent
            )
        }),
        criterion: "more than ±0.5 %, and three times what the second order leaves",
        reproduced: first.zip(second).map(|(first, second)| {
            first.limit_cycle_percent > 0.5 && first.limit_cycle_percent > 3.0 * second.limit_cycle_percent
        }),
    }
}

const NOT_RUN: &str = "not in this run";

fn both(a: Option<&Figures>, b: Option<&Figures>, say: impl Fn(&Figures, &Figures) -> String) -> String {
    a.zip(b).map_or(NOT_RUN.into(), |(a, b)| say(a, b))
}
