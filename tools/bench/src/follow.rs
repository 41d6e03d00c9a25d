//! The smallest possible tracking error of a wire on a sine.
//!
//! Searches the power over a period, piecewise constant and between zero and the largest, that minimises the RMS
//! error of the periodic motion, with wire, load and reference known exactly and in advance. It is a bounded least-squares
//! problem: Levenberg–Marquardt on the simulated wire, derivatives by differences, pieces at
//! their bounds held there; from several starts, of which the best is kept. The power found is feasible, but not proven
//! optimal: the result is achievable, and not a bound in the strict sense.

use nalgebra::{DMatrix, DVector};
use sinew_control::StrokeRange;
use sinew_physics::{Inputs, Wire};

/// Pieces of the power over a period.
const PIECES: usize = 48;
/// Steps of the simulated wire in a piece, at most so long, s.
const STEP_S: f64 = 1e-3;
/// Errors that count, in each period.
const ERRORS: usize = 96;
/// Periods that go by before the error counts …
const LEAD_PERIODS: f64 = 3.0;
/// … and time, at least, s.
const LEAD_S: f64 = 2.0;
/// Steps of the search.
const STEPS: usize = 24;
/// How much a piece is moved to see what it does, share of the largest duty.
const NUDGE: f64 = 1e-3;

/// A sine to follow.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    /// Strokes are counted in this.
    pub range: StrokeRange,
    /// L_0: lengths minus this are elongations, m.
    pub rest_m: f64,
    /// Middle of the sine, as a stroke.
    pub middle: f64,
    /// From peak to peak, as a stroke.
    pub swing: f64,
    /// Hz.
    pub frequency_hz: f64,
    /// Largest duty.
    pub max_duty: f64,
    /// What acts on the wire besides the drive.
    pub inputs: Inputs,
}

/// Least RMS error that was found for a wire that starts as `wire`, as a share of the stroke.
pub fn least_error(wire: &Wire, course: &Course) -> f64 {
    let starts = [0.15, 0.3, 0.5].map(|share| DVector::from_element(PIECES, share * course.max_duty));
    // heat while the sine shortens the wire, not while it lengthens it
    let half = DVector::from_fn(PIECES, |i, _| if (i + PIECES / 4) % PIECES < PIECES / 2 { 0.6 } else { 0.05 });
    let starts = starts.into_iter().chain([half * course.max_duty]);
    starts.map(|start| search(wire, course, start)).fold(f64::INFINITY, f64::min)
}

fn rms(errors: &DVector<f64>) -> f64 {
    errors.norm() / (errors.len() as f64).sqrt()
}

fn search(wire: &Wire, course: &Course, mut duty: DVector<f64>) -> f64 {
    let mut errors = errors(wire, course, &duty);
    let mut damping = 1e-2;
    for _ in 0..STEPS {
        let slopes = slopes(wire, course, &duty, &errors);
        let gradient = slopes.tr_mul(&errors);
        let free: Vec<usize> = (0..PIECES)
            .filter(|&i| !(duty[i] <= 0.0 && gradient[i] > 0.0 || duty[i] >= course.max_duty && gradient[i] < 0.0))
            .collect();
        let slopes = slopes.select_columns(&free);
        let normal = slopes.tr_mul(&slopes);
        let gradient = gradient.select_rows(&free);
        let scale = normal.trace() / free.len().max(1) as f64;
        let mut better = None;
        for _ in 0..6 {
            let damped = &normal + DMatrix::identity(free.len(), free.len()) * (damping * scale + 1e-18);
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&gradient)) else { break };
            let mut next = duty.clone();
            for (place, &i) in free.iter().enumerate() {
                next[i] = (next[i] - step[place]).clamp(0.0, course.max_duty);
            }
            let found = self::errors(wire, course, &next);
            if found.norm() < errors.norm() {
                better = Some((next, found));
                damping *= 0.3;
                break;
            }
            damping *= 4.0;
        }
        let Some((next, found)) = better else { break };
        let gained = 1.0 - found.norm() / errors.norm();
        (duty, errors) = (next, found);
        if gained < 1e-4 {
            break;
        }
    }
    rms(&errors)
}

fn slopes(wire: &Wire, course: &Course, duty: &DVector<f64>, errors: &DVector<f64>) -> DMatrix<f64> {
    let mut slopes = DMatrix::zeros(ERRORS, PIECES);
    for i in 0..PIECES {
        let by = if duty[i] > 0.5 * course.max_duty { -NUDGE } else { NUDGE } * course.max_duty;
        let mut nudged = duty.clone();
        nudged[i] += by;
        slopes.set_column(i, &((self::errors(wire, course, &nudged) - errors) / by));
    }
    slopes
}

/// Errors over the last period, as shares of the stroke.
fn errors(wire: &Wire, course: &Course, duty: &DVector<f64>) -> DVector<f64> {
    let mut wire = wire.clone();
    let period_s = 1.0 / course.frequency_hz;
    let periods = LEAD_PERIODS.max((LEAD_S / period_s).ceil()) as usize + 1;
    let pieces = (period_s / PIECES as f64 / STEP_S).ceil().max(1.0);
    // the wire is looked at a whole number of steps apart
    let every = (PIECES as f64 * pieces / ERRORS as f64).ceil().max(1.0);
    let steps = (every * ERRORS as f64 / PIECES as f64).ceil() as usize;
    let dt_s = period_s / (PIECES * steps) as f64;
    let mut errors = DVector::zeros(ERRORS);
    for period in 0..periods {
        for step in 0..PIECES * steps {
            wire.step(&Inputs { drive: duty[step / steps], ..course.inputs }, dt_s);
            if period + 1 == periods {
                let place = (step + 1) * ERRORS / (PIECES * steps);
                if ((step + 1) * ERRORS).is_multiple_of(PIECES * steps) {
                    let phase = (step + 1) as f64 / (PIECES * steps) as f64;
                    let stroke = course.middle + 0.5 * course.swing * (std::f64::consts::TAU * phase).sin();
                    errors[place - 1] = stroke - course.range.stroke(course.rest_m + wire.position_m());
                }
            }
        }
    }
    errors
}
