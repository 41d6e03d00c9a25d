//! The test sequence of one session, and its measurements.

use sinew_driver::Ask;
use sinew_sim_backend::World;

use crate::bound::{Aim, swing_s, time_optimal};
use crate::{Moment, Session};

/// Half width of the band a wire has settled in, share of the stroke.
pub const BAND: f64 = 0.005;

/// What became of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Where it began, share of the stroke.
    pub from: f64,
    /// Where it went.
    pub to: f64,
    /// Last moment outside ±0.5 % of the stroke, s after the step; `None` where that is in the last tenth of the watch.
    pub settle_s: Option<f64>,
    /// As fast as physics allows from the state the wire was in, s; `None` where it was not computed or does not get there.
    pub bound_s: Option<f64>,
    /// Farthest beyond the reference, share of the stroke, ≥ 0.
    pub overshoot: f64,
    /// Mean error of the last third, share of the stroke, positive longer.
    pub mean: f64,
    /// RMS error of the last third.
    pub rms: f64,
    /// Half of the distance between the extremes of the last third: the limit cycle.
    pub cycle: f64,
    /// First moment at which the sliding surface is reached, s; `None` where the law has none, or never gets there.
    pub surface_s: Option<f64>,
    /// Last moment outside ±2 % of the stroke, s, what a figure shows as settled; as `settle_s`.
    pub settle_2_percent_s: Option<f64>,
    /// Electrical energy, J.
    pub energy_j: f64,
    /// Full switchings a second: the way of the duty, there and back, over its range.
    pub switchings_per_s: f64,
    /// RMS error of the estimated temperature, K.
    pub temperature_rms_k: f64,
    /// RMS error of the estimated martensite fraction.
    pub martensite_rms: f64,
    /// RMS error of the length as the driver has it, share of the stroke.
    pub length_rms: f64,
    /// How long it was watched, s.
    pub watched_s: f64,
}

impl Step {
    /// Settling time over the bound; a step that did not settle counts as if it had at the end of the watch.
    pub fn ratio(&self) -> Option<f64> {
        self.bound_s.filter(|bound| *bound > 0.0).map(|bound| self.settle_s.unwrap_or(self.watched_s) / bound)
    }

    /// Whether it was a step to a shorter wire.
    pub fn is_up(&self) -> bool {
        self.to > self.from
    }
}

/// Sensing pulses only.
pub fn idle(session: &mut Session, seconds: f64) {
    session.ask(Ask::Off);
    for _ in 0..cycles(session, seconds) {
        session.cycle();
    }
}

fn cycles(session: &Session, seconds: f64) -> usize {
    (seconds / session.period_s()).round() as usize
}

/// The bound for a step to `length_m` from where the wire is now.
fn bound_s(session: &Session, length_m: f64, band_m: f64) -> Option<f64> {
    let (wire, inputs) = (session.wire()?, session.inputs()?);
    let model = session.model();
    let aim = Aim {
        target_m: length_m - model.geometry.length_m,
        band_m,
        max_duty: session.max_duty(),
        inputs,
        swing_s: swing_s(model),
    };
    Some(time_optimal(wire, &aim)?.settle_s)
}

/// A step to a stroke (0..1), watched for `seconds`; `watch` gets every cycle and its error as a share of the stroke.
pub fn step(
    session: &mut Session,
    to: f64,
    seconds: f64,
    with_bound: bool,
    mut watch: impl FnMut(&Moment, f64),
) -> Step {
    let range = session.stroke();
    let (reference_m, stroke_m) = (range.length_m(to), range.stroke_m());
    let initial = session.truth().length_m;
    let from = range.stroke(initial);
    let heating = to > from;
    let bound_s = if with_bound { bound_s(session, reference_m, BAND * stroke_m) } else { None };
    let count = cycles(session, seconds);
    let range_of_duty = session.max_duty().max(1e-9);
    let before_j = session.energy_j();
    session.ask(Ask::Length(reference_m));
    let (mut last_outside_s, mut last_far_s) = (0.0, 0.0);
    let mut surface_s = None;
    let mut overshoot = 0.0f64;
    let (mut all, mut late) = (Sums::default(), Sums::default());
    let mut duty = None;
    let mut duty_way = 0.0;
    for k in 0..count {
        let moment = session.cycle();
        let error = (moment.truth.length_m - reference_m) / stroke_m;
        let time_s = (k + 1) as f64 * session.period_s();
        if error.is_nan() || error.abs() > BAND {
            last_outside_s = time_s;
            last_far_s = if error.abs() <= 4.0 * BAND { last_far_s } else { time_s };
        }
        // positive heats
        if surface_s.is_none() && (if heating { moment.surface < 0.0 } else { moment.surface > 0.0 }) {
            surface_s = Some(time_s);
        }
        overshoot = overshoot.max(if heating { -error } else { error });
        duty_way += f64::abs(moment.duty - duty.unwrap_or(moment.duty));
        duty = Some(moment.duty);
        all.add(&moment, error, stroke_m);
        if 3 * k >= 2 * count {
            late.add(&moment, error, stroke_m);
        }
        watch(&moment, error);
    }
    let settled = |last_s: f64| (last_s <= 0.9 * seconds).then_some(last_s);
    Step {
        from,
        to,
        settle_s: settled(last_outside_s),
        settle_2_percent_s: settled(last_far_s),
        surface_s,
        bound_s,
        overshoot,
        mean: late.error / late.count,
        rms: (late.square / late.count).sqrt(),
        cycle: 0.5 * (late.high - late.low),
        energy_j: session.energy_j() - before_j,
        switchings_per_s: 0.5 * duty_way / range_of_duty / seconds,
        temperature_rms_k: (all.temperature / all.count).sqrt(),
        martensite_rms: (all.martensite / all.count).sqrt(),
        length_rms: (all.length / all.count).sqrt(),
        watched_s: seconds,
    }
}

/// What a sine did to the length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// Hz.
    pub frequency_hz: f64,
    /// RMS error, share of the stroke.
    pub rms: f64,
}

/// Follows a sine of `swing` of the stroke from peak to peak around `middle`: a period or a second to get into it, then at least
/// two periods and two seconds in which the error counts.
pub fn sine(session: &mut Session, middle: f64, swing: f64, frequency_hz: f64) -> Sine {
    let range = session.stroke();
    let period_s = 1.0 / frequency_hz;
    let lead = period_s * (1.0 / period_s).ceil();
    let counted = period_s * (2.0 / period_s).ceil().max(2.0);
    let (lead, all) = (cycles(session, lead), cycles(session, lead + counted));
    let mut square = 0.0;
    for k in 0..all {
        // what is commanded now is to be reached at the end of the period
        let time_s = (k + 1) as f64 * session.period_s();
        let stroke = middle + 0.5 * swing * (std::f64::consts::TAU * frequency_hz * time_s).sin();
        let reference_m = range.length_m(stroke);
        session.ask(Ask::Length(reference_m));
        let moment = session.cycle();
        if k >= lead {
            square += ((moment.truth.length_m - reference_m) / range.stroke_m()).powi(2);
        }
    }
    Sine { frequency_hz, rms: (square / (all - lead) as f64).sqrt() }
}

/// What a disturbance did to a wire that was held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbed {
    /// Farthest from the reference, share of the stroke.
    pub deviation: f64,
    /// Error of the estimated temperature one second after it began, K, positive too hot.
    pub temperature_error_k: f64,
    /// RMS error of the last third, share of the stroke.
    pub rms: f64,
}

/// Changes the world around a held wire for `seconds`; `watch` as for [`step`].
pub fn disturb(
    session: &mut Session,
    stroke: f64,
    world: &World,
    seconds: f64,
    mut watch: impl FnMut(&Moment, f64),
) -> Disturbed {
    let range = session.stroke();
    let reference_m = range.length_m(stroke);
    session.ask(Ask::Length(reference_m));
    session.disturb(world);
    let (count, second) = (cycles(session, seconds), cycles(session, 1.0));
    let (mut deviation, mut temperature_error_k, mut square) = (0.0f64, f64::NAN, 0.0);
    for k in 0..count {
        let moment = session.cycle();
        let error = (moment.truth.length_m - reference_m) / range.stroke_m();
        deviation = deviation.max(error.abs());
        if k + 1 == second {
            temperature_error_k = moment.estimate.temperature_c - moment.truth.temperature_c;
        }
        if 3 * k >= 2 * count {
            square += error * error;
        }
        watch(&moment, error);
    }
    let late = (count - (2 * count).div_ceil(3)) as f64;
    Disturbed { deviation, temperature_error_k, rms: (square / late).sqrt() }
}

/// Sums over cycles.
#[derive(Debug, Clone, Copy)]
struct Sums {
    count: f64,
    error: f64,
    square: f64,
    low: f64,
    high: f64,
    temperature: f64,
    martensite: f64,
    length: f64,
}

impl Default for Sums {
    fn default() -> Sums {
        Sums {
            count: 0.0,
            error: 0.0,
            square: 0.0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            temperature: 0.0,
            martensite: 0.0,
            length: 0.0,
        }
    }
}

impl Sums {
    fn add(&mut self, moment: &Moment, error: f64, stroke_m: f64) {
        let (truth, believed) = (&moment.truth, &moment.estimate);
        self.count += 1.0;
        self.error += error;
        self.square += error * error;
        self.low = self.low.min(error);
        self.high = self.high.max(error);
        self.temperature += (believed.temperature_c - truth.temperature_c).powi(2);
        self.martensite += (believed.martensite - truth.martensite).powi(2);
        self.length += ((believed.length_m - truth.length_m) / stroke_m).powi(2);
    }
}
