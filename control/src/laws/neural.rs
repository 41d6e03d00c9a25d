//! A neural network's inverse of the wire as feed-forward, with PID or with a sliding mode for what it leaves (table 5).
//!
//! After Song, Chaudhry and Batur (*A neural network inverse model for a shape memory alloy wire actuator*, J. Intelligent Material Systems and
//! Structures 14, 2003, and *Precision tracking control of shape memory alloy actuators using neural networks and a sliding-mode based robust
//! controller*, Smart Materials and Structures 12, 2003): a small network learns which input makes which length, told beside the length
//! wanted on which side of the loop it is; its answer is fed forward, and proportional-derivative action with a smoothed switch on a sliding surface
//! makes it robust.
//!
//! Ours: the third input, the stroke of the last reversal, so that inner loops are known as well; an output in kelvins, of which the
//! loss to the air makes power; and the teacher, the simulated wire of the rig file, taken slowly to and fro between turning
//! points that a fixed seed chooses, when the law is made. So there is no file of weights, and every wire has its own. A reference that
//! steps is one that turned where it was.

use super::network::{Network, Numbers, Sample};
use super::pid::{Pid, PidGains};
use super::simulated::{Moving, reference, slowly};
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;
use sinew_physics::{Initial, Wire, WireModel};

/// Neurons of the hidden layer.
const NEURONS: usize = 10;
/// Seed of the turning points and of the training's start.
const SEED: u64 = 1;
/// Turning points of the lesson, besides both ends.
const TURNS: usize = 14;
/// Samples of the lesson are so far from each other, and turning points from both ends and each other, in strokes.
const SPACING: f64 = 0.01;
const FROM_ENDS: f64 = 0.04;
const APART: f64 = 0.15;
/// How far beyond both curves' centres the lesson goes, in widths.
const BEYOND_WIDTHS: f64 = 5.0;
/// A reference has turned when it has come back by that, in strokes.
const TURNED: f64 = 0.002;
/// Power of the smoothed switch as a share of full power, and the layer in which it is proportional, in strokes times λ: those of
/// [`super::sliding_first_order`].
const SWITCHED: f64 = 0.5;
const LAYER: f64 = 0.1;

/// Where a reference is on the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Course {
    shortening: bool,
    /// Stroke of the last reversal, and the farthest since.
    turn: f64,
    farthest: f64,
}

impl Course {
    /// Of a wire that was cold.
    const COLD: Course = Course { shortening: true, turn: 0.0, farthest: 0.0 };

    #[inline]
    fn follow(&mut self, stroke: f64) {
        let ahead = if self.shortening { stroke - self.farthest } else { self.farthest - stroke };
        if ahead >= 0.0 {
            self.farthest = stroke;
        } else if ahead < -TURNED {
            *self = Course { shortening: !self.shortening, turn: self.farthest, farthest: stroke };
        }
    }

    /// As the network is told it: all of the order of 1.
    #[inline]
    fn inputs(&self, stroke: f64) -> [f64; 3] {
        let centred = |stroke: f64| 2.0 * stroke.clamp(0.0, 1.0) - 1.0;
        [centred(stroke), if self.shortening { 1.0 } else { -1.0 }, centred(self.turn)]
    }
}

/// The learned inverse of a wire at rest.
#[derive(Debug, Clone, Copy)]
struct Inverse {
    network: Network<3, NEURONS>,
    /// The network's 0, °C, and 1, K.
    middle_c: f64,
    span_k: f64,
    /// Length when cold, and stroke, m.
    cold_m: f64,
    stroke_m: f64,
    course: Course,
}

/// What the wire showed: inputs of the network with the temperature, °C.
fn lesson(moving: &Moving, map: &WireMap) -> Option<Vec<Sample<3>>> {
    let model = &moving.model;
    let [low, high] = moving.beyond_c(map, BEYOND_WIDTHS);
    let mut numbers = Numbers(SEED);
    let mut turns = vec![1.0, 0.0];
    while turns.len() < TURNS {
        // up and down by turns, and far enough for there to be a way
        let before = turns[turns.len() - 1];
        let up = turns.len() % 2 == 0;
        let (from, to) = if up { (before + APART, 1.0 - FROM_ENDS) } else { (FROM_ENDS, before - APART) };
        turns.push(if from < to { from + (to - from) * numbers.next() } else { 0.5 * (from + to) });
    }
    let mut wire = Wire::new(model).ok()?;
    let (mut samples, mut turn) = (Vec::new(), 0.0);
    for (k, to) in turns.into_iter().enumerate() {
        let shortening = k % 2 == 0;
        let there = |stroke: f64| if shortening { stroke >= to } else { stroke <= to };
        let way = slowly(&mut wire, model, map.loss, if shortening { high } else { low }, |wire| {
            there(moving.stroke(wire.position_m()))
        });
        let mut last = turn;
        for (temperature, elongation) in way {
            let stroke = moving.stroke(elongation);
            let ahead = if shortening { stroke - last } else { last - stroke };
            if ahead >= SPACING {
                let course = Course { shortening, turn, farthest: stroke };
                samples.push((course.inputs(stroke), temperature));
                last = stroke;
            }
        }
        turn = moving.stroke(wire.position_m()).clamp(0.0, 1.0);
    }
    Some(samples)
}

impl Inverse {
    /// Learned from the simulated wire; `None` of one that does not move.
    fn learned(model: &WireModel, map: &WireMap) -> Option<Inverse> {
        let moving = Moving::of(WireModel { initial: Initial::default(), ..reference(model, map) })?;
        let mut samples = lesson(&moving, map)?;
        let all = samples.iter().map(|(_, temperature)| *temperature);
        let (least, most) = (all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max));
        let (middle_c, span_k) = (0.5 * (least + most), 0.5 * (most - least));
        if span_k.partial_cmp(&1e-6)? != std::cmp::Ordering::Greater {
            return None;
        }
        samples.iter_mut().for_each(|(_, temperature)| *temperature = (*temperature - middle_c) / span_k);
        let network = Network::trained(&samples, SEED)?;
        let Moving { cold_m, stroke_m, .. } = moving;
        Some(Inverse { network, middle_c, span_k, cold_m, stroke_m, course: Course::COLD })
    }

    /// The temperature that brings the wire to its reference by the way that came, °C.
    #[inline]
    fn follow(&mut self, reference_m: f64) -> f64 {
        let stroke = (self.cold_m - reference_m) / self.stroke_m;
        self.course.follow(stroke.clamp(0.0, 1.0));
        self.middle_c + self.span_k * self.network.output(&self.course.inputs(stroke))
    }
}

/// What makes up for what the network leaves.
#[derive(Debug, Clone)]
enum Feedback {
    /// PID.
    Pid(Pid),
    /// K_P e + K_D ẋ + ρ tanh(σ/φ), σ = ẋ + λe.
    Sliding {
        gains: PidGains,
        lambda: f64,
        /// 1/φ, s/m.
        per_layer: f64,
        range: Range,
        /// ẋ, filtered, m/s.
        velocity: f64,
        surface: f64,
    },
}

/// The network's answer, and feedback.
#[derive(Debug, Clone)]
pub struct Neural {
    /// None of a wire that does not move.
    inverse: Option<Inverse>,
    feedback: Feedback,
    loss: f64,
    ambient: f64,
    full_power: f64,
}

impl Neural {
    fn new(model: &WireModel, map: &WireMap, feedback: Feedback) -> Neural {
        Neural {
            inverse: Inverse::learned(model, map),
            feedback,
            loss: map.loss,
            ambient: map.ambient,
            full_power: map.full_power,
        }
    }

    /// With PID.
    pub(crate) fn with_pid(model: &WireModel, map: WireMap, gains: PidGains, range: Range) -> Neural {
        Neural::new(model, &map, Feedback::Pid(Pid::new(gains, true, range)))
    }

    /// With the smoothed switch.
    pub(crate) fn with_sliding(
        model: &WireModel,
        map: WireMap,
        gains: PidGains,
        lambda: f64,
        stroke_m: f64,
        range: Range,
    ) -> Neural {
        let per_layer = 1.0 / (LAYER * lambda * stroke_m);
        let feedback = Feedback::Sliding { gains, lambda, per_layer, range, velocity: 0.0, surface: 0.0 };
        Neural::new(model, &map, feedback)
    }
}

impl Law for Neural {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            if let Feedback::Sliding { surface, .. } = &mut self.feedback {
                *surface = 0.0;
            }
            return None;
        }
        let fed_forward = self.inverse.as_mut().map_or(0.0, |wire| {
            let temperature = wire.follow(demand.reference_m);
            self.loss * (temperature - self.ambient).max(0.0) / self.full_power
        });
        match &mut self.feedback {
            Feedback::Pid(pid) => Some(pid.give(demand, fed_forward)),
            Feedback::Sliding { gains, lambda, per_layer, range, velocity, surface } => {
                let error = demand.length_m - demand.reference_m;
                *velocity += (demand.velocity_m_s - *velocity) * demand.dt_s / (gains.filter_s + demand.dt_s);
                *surface = *velocity + *lambda * error;
                let proportional = gains.proportional_per_m * error + gains.derivative_s_per_m * *velocity;
                let switched = SWITCHED * range.maximum * (*surface * *per_layer).tanh();
                Some(range.give(fed_forward + proportional + switched))
            }
        }
    }

    fn reset(&mut self) {
        if let Some(wire) = &mut self.inverse {
            wire.course = Course::COLD;
        }
        match &mut self.feedback {
            Feedback::Pid(pid) => pid.reset(),
            Feedback::Sliding { range, velocity, surface, .. } => {
                range.reset();
                (*velocity, *surface) = (0.0, 0.0);
            }
        }
    }

    fn surface(&self) -> f64 {
        match self.feedback {
            Feedback::Pid(_) => 0.0,
            Feedback::Sliding { surface, .. } => {
                if surface.is_finite() {
                    surface
                } else {
                    0.0
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::{by_power, hanging, standing, wire};

    fn demand(reference_m: f64, error_m: f64, velocity_m_s: f64) -> Demand {
        Demand { velocity_m_s, ..standing(reference_m, reference_m + error_m) }
    }

    /// Taken slowly to what the network asks for, the wire of the reference model comes to where it was to be: up from cold and after
    /// reversals that it was not shown.
    #[test]
    fn the_wire_goes_where_its_network_says() {
        for model in [wire(), WireModel { load: hanging(0.08, 30.0, 150.0, 2.4), ..wire() }] {
            let map = WireMap::new(&model);
            let mut inverse = Inverse::learned(&model, &map).unwrap();
            let by_power = WireModel { drive: by_power(), ..model.clone() };
            let mut wire = Wire::new(&by_power).unwrap();
            for stroke in [0.25, 0.5, 0.8, 0.55, 0.3, 0.6, 0.45] {
                let temperature = inverse.follow(inverse.cold_m - stroke * inverse.stroke_m);
                slowly(&mut wire, &by_power, map.loss, temperature, |_| false);
                let reached = (inverse.cold_m - model.geometry.length_m - wire.position_m()) / inverse.stroke_m;
                assert!((reached - stroke).abs() < 0.07, "{stroke}: {reached} at {temperature} °C");
            }
        }
    }

    /// A reference turns where it was farthest, once it has come back by more than its noise.
    #[test]
    fn a_course_turns_where_it_was_farthest() {
        let mut course = Course::COLD;
        for stroke in [0.1, 0.4, 0.399, 0.4] {
            course.follow(stroke);
        }
        assert_eq!(course, Course { shortening: true, turn: 0.0, farthest: 0.4 });
        course.follow(0.3);
        assert_eq!(course, Course { shortening: false, turn: 0.4, farthest: 0.3 });
        course.follow(0.9);
        assert_eq!(course, Course { shortening: true, turn: 0.3, farthest: 0.9 });
        assert_eq!(course.inputs(0.9), [0.8, 1.0, -0.4]);
    }

    /// The terms of the sliding feedback, one by one, above what is fed forward.
    #[test]
    fn the_sliding_feedback_is_the_sum_of_its_terms() {
        let model = wire();
        let map = WireMap::new(&model);
        let gains = PidGains { proportional_per_m: 20.0, derivative_s_per_m: 2.0, ..PidGains::for_stroke(7e-3) };
        let law = || Neural::with_sliding(&model, map, gains, 10.0, 7e-3, Range::new(0.0, 1.0, Modulation::Switched));
        let at_rest = law().duty(&demand(0.163, 0.0, 0.0)).unwrap();
        assert!((0.05..0.4).contains(&at_rest), "{at_rest}");
        let more = law().duty(&demand(0.163, 5e-4, 0.0)).unwrap() - at_rest;
        let switched = 0.5 * f64::tanh(10.0 * 5e-4 / (0.1 * 10.0 * 7e-3));
        assert!((more - (20.0 * 5e-4 + switched)).abs() < 1e-12, "{more}");
        let mut moving = law();
        let duty = (0..200).map(|_| moving.duty(&demand(0.163, 0.0, 1e-3)).unwrap()).last().unwrap();
        let switched = 0.5 * f64::tanh(1e-3 / (0.1 * 10.0 * 7e-3));
        assert!((duty - at_rest - (2.0 * 1e-3 + switched)).abs() < 1e-8, "{duty}");
        assert!((moving.surface() - 1e-3).abs() < 1e-9);
        moving.reset();
        assert_eq!(moving.surface(), 0.0);
    }

    /// Without a stroke there is nothing to learn: PID alone is left.
    #[test]
    fn a_wire_that_does_not_move_is_left_to_pid() {
        let mut model = wire();
        model.material.transformation_strain = 0.0;
        model.material.martensite_modulus_pa = model.material.austenite_modulus_pa;
        let (range, gains) = (Range::new(0.02, 1.0, Modulation::Switched), PidGains::for_stroke(1e-3));
        let mut law = Neural::with_pid(&model, WireMap::new(&model), gains, range);
        assert!(law.inverse.is_none());
        let mut pid = Pid::new(gains, true, range);
        for _ in 0..10 {
            assert_eq!(law.duty(&demand(0.16, 1e-4, 0.0)), pid.duty(&demand(0.16, 1e-4, 0.0)));
        }
    }
}
