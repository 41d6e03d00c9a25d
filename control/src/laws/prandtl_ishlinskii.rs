//! Inverse of a modified Prandtl–Ishlinskii operator as feed-forward, and PI for what it leaves (table 5).
//!
//! The operator takes the temperature of a wire at rest to its length: a weighted sum of play operators, P = Σ w_j F_{r_j}, and behind it
//! a monotone curve without memory, S (Kuhnen's modified operator), because a wire ends where it is wholly martensite or austenite.
//! Both inverses are known in closed form, so that the temperature that brings the wire to a length, by the way it came, is
//! P⁻¹(S⁻¹(x_ref)). The loss to the air at that temperature is what is fed forward.
//!
//! Nothing of it is measured or kept in a file: the wire of the rig file is simulated through its loop, slowly, when the law is made.
//! S is its way up from cold. From a reversal halfway, d kelvins back, S⁻¹ of the length has fallen by Σ w_j max(d − 2 r_j, 0): the
//! weights are the changes of that curve's slope.

use super::pid::{Pid, PidGains};
use super::simulated::{Moving, crossing, reference, slowly};
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;
use sinew_physics::{Wire, WireModel};

/// Play operators, the one without a threshold included.
const PLAYS: usize = 16;
/// Pieces of the curve without memory.
const PIECES: usize = 64;
/// Least weight of the play without threshold: without any there is no inverse.
const LEAST_WEIGHT: f64 = 0.02;
/// How far beyond both outer curves' centres the loop goes, in widths.
const BEYOND_WIDTHS: f64 = 6.0;
/// Share of the stroke at both ends that no temperature is asked for.
const EDGE: f64 = 0.01;

/// Σ w_j F_{r_j}: play operators with their thresholds, weights and what each has last put out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plays<const N: usize> {
    threshold: [f64; N],
    weight: [f64; N],
    state: [f64; N],
}

impl<const N: usize> Plays<N> {
    /// Plays that last came down to `input` from far above.
    fn new(threshold: [f64; N], weight: [f64; N], input: f64) -> Plays<N> {
        Plays { threshold, weight, state: threshold.map(|r| input + r) }
    }

    /// The sum once the input has come to `input`, by any monotone way.
    #[inline]
    fn follow(&mut self, input: f64) -> f64 {
        let mut sum = 0.0;
        for ((state, r), w) in self.state.iter_mut().zip(&self.threshold).zip(&self.weight) {
            *state = state.min(input + r).max(input - r);
            sum += w * *state;
        }
        sum
    }

    /// The operator that undoes this one from its present state on: of plays again (Krasnosel'skii and Pokrovskii; Kuhnen 2003). The
    /// thresholds rise, the first is 0 and its weight is not.
    fn inverse(&self) -> Plays<N> {
        let mut inverse = *self;
        let all: f64 = self.weight.iter().sum();
        let (mut sum, mut moment, mut states) = (0.0, 0.0, 0.0);
        for j in 0..N {
            let (w, r, z) = (self.weight[j], self.threshold[j], self.state[j]);
            let before = sum;
            sum += w;
            moment += w * r;
            states += w * z;
            inverse.threshold[j] = sum * r - moment;
            inverse.weight[j] = if j == 0 { 1.0 / w } else { -w / (sum * before) };
            inverse.state[j] = states + (all - sum) * z;
        }
        inverse
    }
}

/// S⁻¹: the output of the plays, K, at evenly spaced shares of the stroke between both edges.
#[derive(Debug, Clone, Copy)]
struct Curve {
    at: [f64; PIECES + 1],
}

impl Curve {
    #[inline]
    fn inverse(&self, stroke: f64) -> f64 {
        let place = ((stroke - EDGE) / (1.0 - 2.0 * EDGE)).clamp(0.0, 1.0) * PIECES as f64;
        let piece = (place as usize).min(PIECES - 1);
        let share = place - piece as f64;
        self.at[piece] + share * (self.at[piece + 1] - self.at[piece])
    }
}

/// The loop of a wire at rest, as operators.
#[derive(Debug, Clone, Copy)]
struct Loop {
    inverse: Plays<PLAYS>,
    /// What the plays of a cold wire have last put out.
    cold: [f64; PLAYS],
    curve: Curve,
    /// Length when cold, and stroke, m.
    cold_m: f64,
    stroke_m: f64,
}

impl Loop {
    /// By simulation; `None` of a wire that does not move.
    fn simulated(model: &WireModel, map: &WireMap) -> Option<Loop> {
        let moving = Moving::of(reference(model, map))?;
        let Moving { ref model, cold_m, stroke_m, .. } = moving;
        let mut wire = Wire::new(model).ok()?;
        let share = |x: f64| moving.stroke(x);
        let [low, high] = moving.beyond_c(map, BEYOND_WIDTHS);
        // up: the curve. Its zero is halfway.
        let up = slowly(&mut wire, model, map.loss, high, |_| false);
        let middle = crossing(&up, |x| share(x) - 0.5)?;
        let mut at = [0.0; PIECES + 1];
        for (k, at) in at.iter_mut().enumerate() {
            let wanted = EDGE + (1.0 - 2.0 * EDGE) * k as f64 / PIECES as f64;
            // where the wire hardly moves the way up does not reach
            let reached = crossing(&up, |x| share(x) - wanted);
            *at = reached.unwrap_or(if wanted < 0.5 { low } else { high }) - middle;
        }
        for k in 1..=PIECES {
            at[k] = at[k].max(at[k - 1] + 1e-6);
        }
        let curve = Curve { at };
        // down, up again to halfway, and back from there: the plays
        slowly(&mut wire, model, map.loss, low, |_| false);
        slowly(&mut wire, model, map.loss, high, |wire| share(wire.position_m()) >= 0.5);
        let (turn, turned) = (wire.temperature_c(), curve.inverse(share(wire.position_m())));
        let back = slowly(&mut wire, model, map.loss, low, |_| false);
        let fallen = |d: f64| {
            let x = back.iter().find(|(t, _)| turn - t >= d).map(|(_, x)| *x);
            x.map(|x| turned - curve.inverse(share(x).max(EDGE)))
        };
        // to where the wire has gone half of what is left: beyond, its curve has its end
        let most = turn - back.iter().find(|(_, x)| share(*x) < 0.2).or(back.last())?.0;
        let step = most / PLAYS as f64;
        let (mut threshold, mut weight) = ([0.0; PLAYS], [0.0; PLAYS]);
        let mut slope_before = 0.0;
        for j in 0..PLAYS {
            threshold[j] = 0.5 * step * j as f64;
            let slope = (fallen(step * (j + 1) as f64)? - fallen(step * j as f64)?) / step;
            // a sum of plays can only become steeper on its way, and ends as steep as the curve it was counted on
            let slope = slope.clamp(slope_before, 1.0f64.max(slope_before));
            weight[j] = if j == 0 { slope.max(LEAST_WEIGHT) } else { slope - slope_before };
            slope_before = slope.max(slope_before).max(weight[0]);
        }
        // on its way up from cold the sum is the input less Σ w r: counted from the middle as the curve is
        let sum: f64 = weight.iter().sum();
        let weight = weight.map(|w| w / sum);
        let offset: f64 = weight.iter().zip(&threshold).map(|(w, r)| w * r).sum();
        let mut curve = curve;
        for at in &mut curve.at {
            *at += middle - offset;
        }
        let inverse = Plays::new(threshold, weight, model.ambient_c).inverse();
        Some(Loop { inverse, cold: inverse.state, curve, cold_m, stroke_m })
    }
}

/// D = loss(P⁻¹(S⁻¹(x_ref)))/P_max + K_P e + ∫K_I e dt.
#[derive(Debug, Clone)]
pub struct PrandtlIshlinskii {
    /// None of a wire that does not move.
    hysteresis: Option<Loop>,
    pid: Pid,
    loss: f64,
    ambient: f64,
    full_power: f64,
}

impl PrandtlIshlinskii {
    pub(crate) fn new(model: &WireModel, map: WireMap, gains: PidGains, range: Range) -> PrandtlIshlinskii {
        PrandtlIshlinskii {
            hysteresis: Loop::simulated(model, &map),
            pid: Pid::new(gains, true, range),
            loss: map.loss,
            ambient: map.ambient,
            full_power: map.full_power,
        }
    }
}

impl Law for PrandtlIshlinskii {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            return None;
        }
        let fed_forward = self.hysteresis.as_mut().map_or(0.0, |wire| {
            let stroke = (wire.cold_m - demand.reference_m) / wire.stroke_m;
            let temperature = wire.inverse.follow(wire.curve.inverse(stroke));
            self.loss * (temperature - self.ambient).max(0.0) / self.full_power
        });
        Some(self.pid.give(demand, fed_forward))
    }

    fn reset(&mut self) {
        if let Some(wire) = &mut self.hysteresis {
            wire.inverse.state = wire.cold;
        }
        self.pid.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{standing, wire};

    /// A way with many reversals, within and beyond all thresholds.
    fn wandering() -> impl Iterator<Item = f64> {
        (0..4000).map(|k| {
            let t = f64::from(k) * 1e-2;
            60.0 + 25.0 * t.sin() + 20.0 * (2.7 * t).sin() * (0.11 * t).cos()
        })
    }

    #[test]
    fn the_inverse_undoes_the_plays() {
        let mut forward = Plays::new([0.0, 2.0, 5.0, 13.0], [0.2, 0.1, 0.3, 0.4], 25.0);
        let mut inverse = forward.inverse();
        let mut farthest = 0f64;
        for input in wandering() {
            let out = forward.follow(input);
            farthest = farthest.max((out - input).abs());
            assert!((inverse.follow(out) - input).abs() < 1e-9, "{input}");
        }
        assert!(farthest > 5.0, "{farthest}");
    }

    /// And the other way round: what the inverse asks for brings the operator to what was wanted.
    #[test]
    fn the_plays_undo_the_inverse() {
        let mut forward = Plays::new([0.0, 2.0, 5.0, 13.0], [0.2, 0.1, 0.3, 0.4], 25.0);
        let mut inverse = forward.inverse();
        for wanted in wandering() {
            let input = inverse.follow(wanted);
            assert!((forward.follow(input) - wanted).abs() < 1e-9, "{wanted}");
        }
    }

    /// The temperature that the operators ask for brings the wire of the reference model, taken there slowly, to where it was to be:
    /// up from cold, and after a reversal.
    #[test]
    fn the_wire_goes_where_its_inverse_says() {
        let model = wire();
        let map = WireMap::new(&model);
        let mut operators = Loop::simulated(&model, &map).unwrap();
        let by_power = WireModel { drive: crate::testing::by_power(), ..model.clone() };
        let mut wire = Wire::new(&by_power).unwrap();
        let mut without_memory = 0f64;
        for stroke in [0.2, 0.5, 0.8, 0.5, 0.3, 0.6] {
            let temperature = operators.inverse.follow(operators.curve.inverse(stroke));
            slowly(&mut wire, &by_power, map.loss, temperature, |_| false);
            let reached = (operators.cold_m - model.geometry.length_m - wire.position_m()) / operators.stroke_m;
            assert!((reached - stroke).abs() < 0.08, "{stroke}: {reached} at {temperature} °C");
        }
        // the temperature of the way up from cold alone leaves a wire that comes down from 80 % where it is
        let mut wire = Wire::new(&by_power).unwrap();
        let fresh = Loop::simulated(&model, &map).unwrap();
        for stroke in [0.8, 0.4] {
            let from_cold = fresh.inverse;
            let temperature = { from_cold }.follow(fresh.curve.inverse(stroke));
            slowly(&mut wire, &by_power, map.loss, temperature, |_| false);
            let reached = (fresh.cold_m - model.geometry.length_m - wire.position_m()) / fresh.stroke_m;
            without_memory = without_memory.max((reached - stroke).abs());
        }
        assert!(without_memory > 0.2, "{without_memory}");
    }

    /// Without a stroke there is nothing to invert: PI alone is left.
    #[test]
    fn a_wire_that_does_not_move_is_left_to_pi() {
        let mut model = wire();
        model.material.transformation_strain = 0.0;
        model.material.martensite_modulus_pa = model.material.austenite_modulus_pa;
        let range = Range::new(0.02, 1.0, crate::demand::Modulation::Switched);
        let gains = PidGains { derivative_s_per_m: 0.0, ..PidGains::for_stroke(1e-3) };
        let mut law = PrandtlIshlinskii::new(&model, WireMap::new(&model), gains, range);
        assert!(law.hysteresis.is_none());
        let mut pi = Pid::new(gains, true, range);
        let demand = standing(0.16, 0.1601);
        for _ in 0..10 {
            assert_eq!(law.duty(&demand), pi.duty(&demand));
        }
    }
}
