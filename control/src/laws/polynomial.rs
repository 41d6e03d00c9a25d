//! Feedback linearisation on a polynomial model (table 5: "feedback linearization polynomial model").
//!
//! Arai, Aramaki and Yanagisawa (*Feedback linearization for SMA (shape memory alloy)*, SICE 1995) take a shape-memory actuator
//! for a differential equation in its output alone, ẋ = f(x) + g(x) P with polynomials that are fitted to what it does, and invert
//! it: P = (v − f(x))/g(x) leaves ẋ = v. No temperature, no phase, no estimator: only the length is needed.
//!
//! Ours: the polynomials are those of 1/g and −f/g, the power per speed and the power that stands still, so that nothing is divided by; of
//! fourth degree, one pair for shortening and one for lengthening, because a loop has two sides; fitted, when the law is made, to the
//! simulated wire of the rig file under six constant powers. v = −λ(x − x_ref), as in [`super::linearised`], whose inverse is that of
//! the estimated state instead.

use super::simulated::{Moving, least_squares, reference};
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;
use sinew_physics::{Initial, Inputs, Wire, WireModel};
use sinew_state_space::{DMatrix, DVector};

/// Terms of each polynomial: of fourth degree.
const TERMS: usize = 5;
/// Share of the stroke at both ends that is not fitted: there 1/g grows without bound.
const EDGE: f64 = 0.04;
/// Pieces of the stroke, over each of which speed is measured.
const PIECES: usize = 60;
/// Powers of the ways up, in losses of the hot wire, and of the ways down, in losses of the wire just before it is wholly martensite.
const UP: [f64; 3] = [1.2, 2.0, 4.0];
const DOWN: [f64; 3] = [0.0, 0.3, 0.6];
/// How far beyond a curve's centre is hot, or cold, in widths.
const BEYOND_WIDTHS: f64 = 4.0;
/// Steps of the simulation in a thermal time constant, and after how many of these a wire that has not arrived never will.
const STEPS: f64 = 2000.0;
const PATIENCE: f64 = 60.0;

/// One side of the loop: the power at a stroke (0 cold, 1 hot) and a speed, shortening positive, strokes/s.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    /// 1/g, W s.
    per_speed: [f64; TERMS],
    /// −f/g, W.
    standing: [f64; TERMS],
}

fn polynomial(terms: &[f64; TERMS], at: f64) -> f64 {
    terms.iter().rev().fold(0.0, |sum, term| sum * at + term)
}

impl Side {
    #[inline]
    fn power(&self, stroke: f64, speed: f64) -> f64 {
        let at = stroke.clamp(EDGE, 1.0 - EDGE);
        // more speed is never less power, whatever a fit may say
        polynomial(&self.per_speed, at).max(0.0) * speed + polynomial(&self.standing, at)
    }

    /// By least squares from (stroke, speed, power).
    fn fitted(samples: &[(f64, f64, f64)]) -> Option<Side> {
        if samples.len() < 4 * TERMS {
            return None;
        }
        // in units of its own, so that both polynomials weigh alike
        let unit = samples.iter().fold(0.0, |most: f64, (_, speed, _)| most.max(speed.abs()));
        let rows = DMatrix::from_fn(samples.len(), 2 * TERMS, |i, j| {
            let (stroke, speed, _) = samples[i];
            let term = stroke.powi((j % TERMS) as i32);
            if j < TERMS { term * speed / unit } else { term }
        });
        let powers = DVector::from_fn(samples.len(), |i, _| samples[i].2);
        let found = least_squares(rows, &powers)?;
        found.iter().all(|term| term.is_finite()).then(|| Side {
            per_speed: std::array::from_fn(|k| found[k] / unit),
            standing: std::array::from_fn(|k| found[TERMS + k]),
        })
    }
}

/// The polynomial model of a wire, and where its stroke lies.
#[derive(Debug, Clone, Copy)]
struct Polynomials {
    shortening: Side,
    lengthening: Side,
    /// Length when cold, and stroke, m.
    cold_m: f64,
    stroke_m: f64,
}

impl Polynomials {
    /// By simulation; `None` of a wire that does not move both ways.
    fn simulated(model: &WireModel, map: &WireMap) -> Option<Polynomials> {
        let moving = Moving::of(WireModel { initial: Initial::default(), ..reference(model, map) })?;
        let Moving { ref model, cold_m, hot_m, stroke_m } = moving;
        let shifts = [hot_m, cold_m].map(|length| map.stress(length - map.length, 0.0) * map.shift);
        let hot_c = map.heating_centre + shifts[0] + BEYOND_WIDTHS * map.heating_width;
        let cold_c = map.cooling_centre + shifts[1] - BEYOND_WIDTHS * map.cooling_width;
        let (hot_w, cold_w) = (map.loss * (hot_c - map.ambient), map.loss * (cold_c - map.ambient));
        if hot_w.partial_cmp(&0.0)? != std::cmp::Ordering::Greater || cold_w <= 0.0 {
            return None;
        }
        let constant_s = map.heat_capacity / map.loss;
        let dt_s = constant_s / STEPS;
        let most = (PATIENCE * STEPS) as usize;
        let run = |wire: &mut Wire, power: f64, until: &mut dyn FnMut(&Wire, f64) -> bool| {
            let inputs = Inputs { drive: power, ..model.rest_inputs() };
            for step in 0..most {
                wire.step(&inputs, dt_s);
                if until(wire, step as f64 * dt_s) {
                    break;
                }
            }
        };
        let stroke = |wire: &Wire| moving.stroke(wire.position_m());
        // each piece of a way is one sample: its middle, the mean speed over it, the power
        let along = |wire: &mut Wire, power: f64, up: bool, samples: &mut Vec<(f64, f64, f64)>| {
            let width = (1.0 - 2.0 * EDGE) / PIECES as f64;
            let mut entered: Option<(f64, f64)> = None;
            run(wire, power, &mut |wire, t| {
                let now = stroke(wire);
                let done = if up { now } else { 1.0 - now };
                if done < EDGE {
                    return false;
                }
                match entered {
                    None => entered = Some((now, t)),
                    Some((from, since)) if (now - from).abs() >= width => {
                        samples.push((0.5 * (now + from), (now - from) / (t - since), power));
                        entered = Some((now, t));
                    }
                    Some(_) => (),
                }
                done > 1.0 - EDGE
            });
        };
        let mut up = Vec::new();
        for losses in UP {
            along(&mut Wire::new(model).ok()?, losses * hot_w, true, &mut up);
        }
        let mut hot = Wire::new(model).ok()?;
        run(&mut hot, 2.0 * hot_w, &mut |wire, _| wire.temperature_c() > hot_c && stroke(wire) > 1.0 - EDGE);
        let mut down = Vec::new();
        for losses in DOWN {
            along(&mut hot.clone(), losses * cold_w, false, &mut down);
        }
        Some(Polynomials { shortening: Side::fitted(&up)?, lengthening: Side::fitted(&down)?, cold_m, stroke_m })
    }

    /// The power that makes a wire of this length shorten with `speed`, strokes/s, W.
    #[inline]
    fn power(&self, length_m: f64, speed: f64) -> f64 {
        let side = if speed > 0.0 { &self.shortening } else { &self.lengthening };
        side.power((self.cold_m - length_m) / self.stroke_m, speed)
    }
}

/// P = (v − f(x))/g(x), v = −λ(x − x_ref).
#[derive(Debug, Clone)]
pub struct PolynomialLinearised {
    /// None of a wire that does not move.
    polynomials: Option<Polynomials>,
    lambda: f64,
    full_power: f64,
    range: Range,
}

impl PolynomialLinearised {
    pub(crate) fn new(model: &WireModel, map: WireMap, lambda: f64, range: Range) -> PolynomialLinearised {
        PolynomialLinearised {
            polynomials: Polynomials::simulated(model, &map),
            lambda,
            full_power: map.full_power,
            range,
        }
    }
}

impl Law for PolynomialLinearised {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            return None;
        }
        let power = self.polynomials.as_ref().map_or(0.0, |wire| {
            let error = (demand.length_m - demand.reference_m) / wire.stroke_m;
            wire.power(demand.length_m, self.lambda * error)
        });
        Some(self.range.give(power / self.full_power))
    }

    fn reset(&mut self) {
        self.range.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::{by_power, hanging, standing, wire};

    /// What was made of polynomials is found again, whatever the powers.
    #[test]
    fn the_fit_finds_the_polynomials() {
        let side = Side { per_speed: [0.7, -1.0, 1.5, 0.0, 0.2], standing: [0.3, 0.4, -0.1, 0.05, 0.0] };
        let samples: Vec<_> = (0..300)
            .map(|k| {
                let (stroke, speed) = (0.05 + 0.9 * f64::from(k % 60) / 59.0, 0.2 + 0.4 * f64::from(k / 60));
                (stroke, speed, side.power(stroke, speed))
            })
            .collect();
        let found = Side::fitted(&samples).unwrap();
        for (found, true_one) in
            found.per_speed.iter().zip(side.per_speed).chain(found.standing.iter().zip(side.standing))
        {
            assert!((found - true_one).abs() < 1e-8, "{found} {true_one}");
        }
        assert_eq!(Side::fitted(&samples[..10]), None);
    }

    /// What the law is for: with its power the wire of the reference model moves, both ways, with about the speed that is asked for,
    /// which a constant power does not: its speed changes severalfold on the way.
    #[test]
    fn the_speed_is_about_the_one_asked_for() {
        let model = WireModel { drive: by_power(), load: hanging(0.2, 40.0, 60.0, 1.5), ..wire() };
        let map = WireMap::new(&model);
        let polynomials = Polynomials::simulated(&model, &map).unwrap();
        let mut wire = Wire::new(&model).unwrap();
        for asked in [0.8, -0.5] {
            // from where the polynomials begin
            let (mut speeds, mut before) = (Vec::new(), f64::NAN);
            for k in 0..100_000 {
                let stroke = (polynomials.cold_m - 0.16 - wire.position_m()) / polynomials.stroke_m;
                let power = polynomials.power(0.16 + wire.position_m(), asked).max(0.0);
                wire.step(&Inputs { drive: power, ..model.rest_inputs() }, 1e-4);
                if k % 1000 == 0 {
                    let on_its_way =
                        if asked > 0.0 { (0.2..0.85).contains(&stroke) } else { (0.15..0.75).contains(&stroke) };
                    if on_its_way {
                        speeds.push((stroke - before) / 0.1 / asked);
                    }
                    before = stroke;
                }
                if if asked > 0.0 { stroke > 0.96 } else { stroke < 0.1 } {
                    break;
                }
            }
            assert!(speeds.len() > 5, "{asked}: {speeds:?}");
            assert!(speeds.iter().all(|speed| (0.75..1.25).contains(speed)), "{asked}: {speeds:?}");
        }
    }

    /// Nothing to fit: nothing is given.
    #[test]
    fn a_wire_that_does_not_move_is_not_heated() {
        let mut model = wire();
        model.material.transformation_strain = 0.0;
        model.material.martensite_modulus_pa = model.material.austenite_modulus_pa;
        let map = WireMap::new(&model);
        let mut law = PolynomialLinearised::new(&model, map, 10.0, Range::new(0.02, 1.0, Modulation::Switched));
        let demand = standing(0.15, 0.16);
        assert_eq!(law.duty(&demand), Some(0.02));
    }
}
