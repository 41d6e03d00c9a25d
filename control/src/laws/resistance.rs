//! Self-sensing by resistance alone (table 5): the length that a law is given is not used, only what the wire's resistance says of it.
//!
//! - "Polynomial strain-resistance model, fuzzy-tuned PID": the length is a polynomial of the resistance, of fifth degree, after Lan and Fan
//!   (*An accurate self-sensing method for the control of shape memory alloy actuated flexures*, Sensors and Actuators A 163, 2010), under the
//!   fuzzy PID of [`super::fuzzy`].
//! - "Neural network resistance feedback": a network takes the resistance to the length, after Ma, Song and Lee (*Position control of shape
//!   memory alloy actuators with internal electrical resistance feedback using neural networks*, Smart Materials and Structures 13, 2004), which is told
//!   besides on which side of the loop the wire is; under PID.
//!
//! Both papers calibrate on a bench. Ours: both are fitted, when the law is made, to the simulated wire of the rig file, taken slowly to and fro;
//! the side of the loop is that to which the resistance last moved by more than its noise. What they cannot know is the temperature
//! of a wire that stands still or does not transform, which changes its resistance as well (chapter 7).

use super::curve::{Polynomial, Scale, Side};
use super::fuzzy::FuzzyPid;
use super::network::{Network, Sample};
use super::pid::{Pid, PidGains};
use super::simulated::{Moving, reference, slowly};
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;
use sinew_physics::{Initial, Wire, WireModel};

/// Terms of the polynomial.
const TERMS: usize = 6;
/// Neurons of the network, and the seed of its training.
const NEURONS: usize = 8;
const SEED: u64 = 1;
/// Strokes at which the lesson turns round; between them it goes to and fro.
const TURNS: [f64; 6] = [0.99, 0.01, 0.7, 0.2, 0.85, 0.01];
/// How far beyond both curves' centres it goes, in widths.
const BEYOND_WIDTHS: f64 = 6.0;
/// Samples of the lesson.
const SAMPLES: usize = 600;
/// Time in which readings are averaged, s.
const FILTER_S: f64 = 0.01;

/// What makes a length of a resistance.
// By value: it lies in the channel's struct, where the loop touches it.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy)]
enum Curve {
    Polynomial(Polynomial<TERMS>),
    Network(Network<2, NEURONS>),
}

/// A reading of the length, and how fast it changes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Reading {
    length_m: f64,
    rate_m_s: f64,
}

/// A wire's resistance as its length.
#[derive(Debug, Clone, Copy)]
struct Gauge {
    curve: Curve,
    resistance: Scale,
    length: Scale,
    side: Side,
    /// The resistance, averaged, in half ranges, and the last reading; `None` before the first.
    now: Option<(f64, Reading)>,
}

/// Resistance, Ω, and length, m, of the simulated wire on its ways.
fn lesson(model: &WireModel, map: &WireMap) -> Option<Vec<(f64, f64)>> {
    let moving = Moving::of(WireModel { initial: Initial::default(), ..reference(model, map) })?;
    let stroke = |wire: &Wire| moving.stroke(wire.position_m());
    let [low, high] = moving.beyond_c(map, BEYOND_WIDTHS);
    let mut wire = Wire::new(&moving.model).ok()?;
    let seen = std::cell::RefCell::new(Vec::new());
    for (k, to) in TURNS.into_iter().enumerate() {
        let up = k % 2 == 0;
        slowly(&mut wire, &moving.model, map.loss, if up { high } else { low }, |wire| {
            seen.borrow_mut().push((wire.resistance_ohm(), map.length + wire.position_m()));
            if up { stroke(wire) >= to } else { stroke(wire) <= to }
        });
    }
    let seen = seen.into_inner();
    let each = (seen.len() / SAMPLES).max(1);
    Some(seen.into_iter().step_by(each).collect())
}

impl Gauge {
    /// Fitted to the simulated wire; `None` of one that does not move, or whose resistance does not tell.
    fn fitted(model: &WireModel, map: &WireMap, with_network: bool) -> Option<Gauge> {
        let seen = lesson(model, map)?;
        let resistance = Scale::of(seen.iter().map(|(resistance, _)| *resistance))?;
        let length = Scale::of(seen.iter().map(|(_, length)| *length))?;
        let mut side = Side::COLD;
        let samples: Vec<Sample<2>> = seen
            .iter()
            .map(|(r, l)| {
                side.follow(resistance.down(*r));
                ([resistance.down(*r), side.sign()], length.down(*l))
            })
            .collect();
        let curve = if with_network {
            Curve::Network(Network::trained(&samples, SEED)?)
        } else {
            Curve::Polynomial(Polynomial::fitted(
                samples.iter().map(|([resistance, _], length)| (*resistance, *length)),
            )?)
        };
        Some(Gauge { curve, resistance, length, side: Side::COLD, now: None })
    }

    /// The length at a resistance, in half ranges, m. Beyond what was shown nothing is known: the end of it.
    #[inline]
    fn length_m(&self, resistance: f64) -> f64 {
        let at = resistance.clamp(-1.0, 1.0);
        let share = match &self.curve {
            Curve::Polynomial(polynomial) => polynomial.at(at),
            Curve::Network(network) => network.output(&[at, self.side.sign()]),
        };
        self.length.up(share.clamp(-1.0, 1.0))
    }

    /// Takes a cycle's resistance in, Ω; one that was not measured changes nothing.
    #[inline]
    fn read(&mut self, resistance_ohm: f64, dt_s: f64) -> Option<Reading> {
        if (0.0..1e9).contains(&resistance_ohm) {
            let seen = self.resistance.down(resistance_ohm);
            let averaged = match self.now {
                None => seen,
                Some((before, _)) => before + (seen - before) * dt_s / (FILTER_S + dt_s),
            };
            self.side.follow(averaged);
            let length_m = self.length_m(averaged);
            let rate_m_s = self.now.map_or(0.0, |(_, before)| (length_m - before.length_m) / dt_s);
            self.now = Some((averaged, Reading { length_m, rate_m_s }));
        }
        self.now.map(|(_, reading)| reading)
    }
}

/// What is done with the length.
#[derive(Debug, Clone)]
enum Feedback {
    Fuzzy(FuzzyPid),
    Pid(Pid),
}

/// Feedback of a length that is read off the resistance.
#[derive(Debug, Clone)]
pub struct ResistanceFeedback {
    /// None of a wire whose resistance does not tell its length.
    gauge: Option<Gauge>,
    feedback: Feedback,
    minimum: f64,
}

impl ResistanceFeedback {
    /// Fuzzy PID on a polynomial of the resistance.
    pub(crate) fn polynomial(model: &WireModel, map: &WireMap, gains: PidGains, stroke_m: f64, range: Range) -> Self {
        ResistanceFeedback {
            gauge: Gauge::fitted(model, map, false),
            feedback: Feedback::Fuzzy(FuzzyPid::new(gains, stroke_m, range)),
            minimum: range.minimum,
        }
    }

    /// PID on a network's length.
    pub(crate) fn network(model: &WireModel, map: &WireMap, gains: PidGains, range: Range) -> Self {
        ResistanceFeedback {
            gauge: Gauge::fitted(model, map, true),
            feedback: Feedback::Pid(Pid::new(gains, false, range)),
            minimum: range.minimum,
        }
    }
}

impl Law for ResistanceFeedback {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            return None;
        }
        let reading = self.gauge.as_mut().and_then(|gauge| gauge.read(demand.resistance_ohm, demand.dt_s));
        let Some(Reading { length_m, rate_m_s }) = reading else { return Some(self.minimum) };
        let read = Demand { length_m, velocity_m_s: rate_m_s, ..*demand };
        match &mut self.feedback {
            Feedback::Fuzzy(law) => law.duty(&read),
            Feedback::Pid(law) => law.duty(&read),
        }
    }

    fn reset(&mut self) {
        if let Some(gauge) = &mut self.gauge {
            (gauge.side, gauge.now) = (Side::COLD, None);
        }
        match &mut self.feedback {
            Feedback::Fuzzy(law) => law.reset(),
            Feedback::Pid(law) => law.reset(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::{standing, wire};

    fn demand(reference_m: f64, resistance_ohm: f64) -> Demand {
        Demand { resistance_ohm, ..standing(reference_m, f64::from(u8::MAX)) }
    }

    /// RMS of what a gauge is off along the lesson, in strokes.
    fn off(gauge: &mut Gauge, seen: &[(f64, f64)]) -> f64 {
        let square = |(resistance, length): &(f64, f64)| {
            let at = gauge.resistance.down(*resistance);
            gauge.side.follow(at);
            ((gauge.length_m(at) - length) / (2.0 * gauge.length.half)).powi(2)
        };
        (seen.iter().map(square).sum::<f64>() / seen.len() as f64).sqrt()
    }

    /// Each reads the wire that it was fitted to; the network, which knows the side, more closely than one curve for both sides.
    #[test]
    fn the_gauges_read_the_wire() {
        let model = wire();
        let map = WireMap::new(&model);
        let seen = lesson(&model, &map).unwrap();
        let polynomial = off(&mut Gauge::fitted(&model, &map, false).unwrap(), &seen);
        let network = off(&mut Gauge::fitted(&model, &map, true).unwrap(), &seen);
        assert!(polynomial < 0.35 && network < 0.5 * polynomial, "{polynomial} {network}");
    }

    /// The length that the law is given does not matter; without a resistance it goes on with the last, and before the first it gives the least.
    #[test]
    fn only_the_resistance_counts() {
        let model = wire();
        let map = WireMap::new(&model);
        let range = Range::new(0.02, 1.0, Modulation::Switched);
        let gains = PidGains::for_stroke(7e-3);
        let mut law = ResistanceFeedback::network(&model, &map, gains, range);
        assert_eq!(law.duty(&demand(0.163, f64::NAN)), Some(0.02));
        let gauge = law.gauge.unwrap();
        let cold = gauge.resistance.up(0.9);
        let mut pid = Pid::new(gains, false, range);
        for (resistance, read) in [(cold, cold), (f64::NAN, cold), (-1.0, cold), (cold, cold)] {
            let told = Demand { length_m: gauge.length_m(0.9), ..demand(0.163, read) };
            let (duty, expected) = (law.duty(&demand(0.163, resistance)).unwrap(), pid.duty(&told).unwrap());
            assert!((duty - expected).abs() < 1e-9, "{duty} {expected}");
        }
        law.reset();
        assert_eq!(law.duty(&demand(0.163, f64::NAN)), Some(0.02));
        assert_eq!(law.duty(&demand(f64::NAN, cold)), None);
    }
}
