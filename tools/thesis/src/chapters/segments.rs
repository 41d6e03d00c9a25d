//! Fig. 66 and 67: a wire in pieces of doubled lengths, each heated wholly or not at all, without a sensor.

use sinew_control::{
    Algorithm, AlgorithmKind, Controller, Demand, EstimatorKind, Observation, Segment, Settings, StateEstimator,
    StrokeRange,
};
use sinew_physics::{Geometry, Inputs, Wire, WireModel};
use sinew_plot::Ink;

use crate::axes::TIME;
use crate::found::{Found, Tried};
use crate::lab::Lab;
use crate::row::Computed;
use crate::wires::{STEP_S, hanging};

/// The prototype of fig. 67 has so many pieces.
const DIGITS: u32 = 5;
/// How long each length is asked for, s: the wire is cold again well within it.
const DWELL_S: f64 = 4.0;
/// Full power, W/m: heats a wire of 0.125 mm wholly in half a second.
const POWER_W_PER_M: f64 = 18.0;

/// One piece: its wire, what is believed of it, and its law. The weight pulls at all of them alike, so that each can be simulated
/// alone and the lengths add up.
struct Piece {
    wire: Wire,
    /// Unloaded, m.
    length_m: f64,
    range: StrokeRange,
    rest: Inputs,
    estimator: StateEstimator,
    law: Algorithm,
    duty: f64,
}

impl Piece {
    fn new(digit: u32, whole: &WireModel) -> Tried<Piece> {
        let share = f64::from(1u32 << digit) / f64::from((1u32 << DIGITS) - 1);
        let length_m = whole.geometry.length_m * share;
        let model = WireModel { geometry: Geometry { length_m, ..whole.geometry }, ..whole.clone() };
        let settings = Settings {
            kind: AlgorithmKind::BinarySegment,
            minimum_duty: 0.0,
            segment: Segment { digit, digits: DIGITS },
            ..Settings::default()
        };
        Ok(Piece {
            wire: Wire::new(&model)?,
            length_m,
            range: StrokeRange::of(&model)?,
            rest: model.rest_inputs(),
            estimator: StateEstimator::new(&model, EstimatorKind::Fused),
            law: Algorithm::new(&model, &settings),
            duty: 0.0,
        })
    }

    /// Under the weight, m.
    fn length_m(&self) -> f64 {
        self.length_m + self.wire.position_m()
    }

    /// A period at this stroke of the whole. Nothing is measured.
    fn step(&mut self, stroke: f64) {
        let full_w = POWER_W_PER_M * self.range.cold_m;
        let power_w = self.duty * full_w;
        let estimate = self.estimator.update(&Observation { power_w, ..Observation::nothing(self.duty, STEP_S) });
        let demand = Demand {
            reference_m: self.range.length_m(stroke),
            length_m: estimate.length_m,
            velocity_m_s: 0.0,
            acceleration_m_s2: 0.0,
            resistance_ohm: f64::NAN,
            dt_s: STEP_S,
            estimate: sinew_control::Estimate { full_power_w: full_w, ..estimate },
        };
        self.duty = self.law.duty(&demand);
        self.wire.step(&Inputs { drive: self.duty * full_w, ..self.rest }, STEP_S);
    }
}

/// All lengths in turn, up and down.
pub(super) fn all_lengths(_: &Lab, found: &mut Found) -> Computed {
    let whole = hanging();
    let range = StrokeRange::of(&whole)?;
    let mut pieces = (0..DIGITS).map(|digit| Piece::new(digit, &whole)).collect::<Tried<Vec<_>>>()?;
    let most = (1u32 << DIGITS) - 1;
    let levels: Vec<u32> = (0..=most).chain((0..most).rev()).collect();
    let (mut times, mut lengths, mut reached) = (Vec::new(), Vec::new(), Vec::new());
    let mut steps: u32 = 0;
    for level in &levels {
        let stroke = f64::from(*level) / f64::from(most);
        for _ in 0..(DWELL_S / STEP_S) as u32 {
            for piece in &mut pieces {
                piece.step(stroke);
            }
            steps += 1;
            if steps.is_multiple_of(100) {
                times.push(f64::from(steps) * STEP_S);
                lengths.push(1e3 * pieces.iter().map(|piece| piece.length_m()).sum::<f64>());
            }
        }
        reached.push((stroke, pieces.iter().map(|piece| piece.length_m()).sum::<f64>()));
    }
    let off = |(stroke, length_m): &(f64, f64)| (length_m - range.length_m(*stroke)).abs();
    let worst = reached.iter().map(off).fold(0.0, f64::max);
    let up_and_down =
        reached.iter().zip(reached.iter().rev()).map(|(up, down)| (up.1 - down.1).abs()).fold(0.0, f64::max);
    let step_m = range.stroke_m() / f64::from(most);
    let mut distinct: Vec<i64> =
        reached.iter().map(|(_, length_m)| ((range.cold_m - length_m) / step_m).round() as i64).collect();
    distinct.sort_unstable();
    distinct.dedup();
    found.equal("lengths of five pieces", "1", f64::from(most + 1), distinct.len() as f64);
    found.below("a step, of the stroke", "1", 0.04, step_m / range.stroke_m());
    found.below("worst length off the evenly spaced one, of a step", "1", 0.25, worst / step_m);
    found.below("the same length from above and from below, of a step", "1", 0.1, up_and_down / step_m);
    found.line(TIME, ("Length", "mm"), Ink::Series(0), (times, lengths));
    Ok(())
}
