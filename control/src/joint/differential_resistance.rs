//! The angle by the difference of both resistances (table 5: "fuzzy tuned PID" [173]; "SMC and PID" [123], both with "differential
//! resistance"): the lengths that are measured are not used.
//!
//! Of two wires of one joint one has the more martensite, and so the more resistance, the less the other has, and what both have in common,
//! as a draught, goes out of the difference. Chapter 7 says the rest: the hysteresis does not go out, nor do differing stresses. A
//! polynomial of third degree, fitted to the simulated pair of the rig file, makes an angle of the difference; both schemes move both
//! duties alike, one up and one down, about those that hold the pair in the middle of its hysteresis.
//!
//! [173] is fuzzy PID, here the one of [`crate::laws`] with its rules (Zhao, Tomizuka and Isaka 1993). [123] has a sliding mode and PID;
//! whether together, the table does not say. Here together: a smoothed switch on σ = ė + λe beside the PID. The papers were not at hand: no more than the
//! method is theirs.

use super::demand::{JointDemand, Motion, PairLaw};
use super::lesson::{Lesson, Point};
use super::setup::{JointSettings, Own, PairSetup};
use crate::demand::{Law, Range};
use crate::lambda;
use crate::laws::fuzzy::FuzzyPid;
use crate::laws::pid::{Pid, PidGains};
use crate::laws::{Polynomial, Scale};

/// Gains of both.
const FUZZY: Own = Own { proportional: 8.6, integral_s: 4.0, derivative_s: 0.009 };
const SLIDING: Own = Own { proportional: 26.0, integral_s: 5.9, derivative_s: 0.003 };
/// The switch's share of the duty, and its width, in λS.
const SWITCHED: f64 = 0.5;
const WIDTH: f64 = 0.1;
/// Terms of the polynomial.
const TERMS: usize = 4;
/// Time in which readings are averaged, s.
pub(super) const FILTER_S: f64 = 0.01;

/// Readings of an angle, averaged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Readings {
    /// Angle and rate; `None` before the first.
    now: Option<Motion>,
}

impl Readings {
    pub const NONE: Readings = Readings { now: None };

    /// Takes a cycle's reading in; one that there is none of changes nothing.
    #[inline]
    pub fn take(&mut self, angle_rad: Option<f64>, dt_s: f64) -> Option<Motion> {
        if let Some(read) = angle_rad {
            self.now = Some(match self.now {
                None => Motion { angle_rad: read, rate_rad_s: 0.0 },
                Some(before) => {
                    let rate_rad_s = (read - before.angle_rad) / (FILTER_S + dt_s);
                    Motion { angle_rad: before.angle_rad + rate_rad_s * dt_s, rate_rad_s }
                }
            });
        }
        self.now
    }
}

/// Both duties about the middle ones, apart by a difference.
#[derive(Debug, Clone, Copy)]
pub(super) struct Split {
    settings: JointSettings,
    middle: [f64; 2],
}

impl Split {
    pub fn new(settings: &JointSettings, middle: [f64; 2]) -> Split {
        Split { settings: *settings, middle }
    }

    #[inline]
    pub fn duties(&self, difference: f64) -> [f64; 2] {
        let apart = [difference, -difference];
        [0, 1].map(|side| self.settings.within(side, self.middle[side] + apart[side]))
    }
}

/// An angle of the difference of two resistances.
#[derive(Debug, Clone, Copy)]
struct Gauge {
    curve: Polynomial<TERMS>,
    ohm: Scale,
    angle: Scale,
}

impl Gauge {
    /// Fitted to a lesson; `None` of a pair whose resistances do not tell.
    fn fitted(points: &[Point]) -> Option<Gauge> {
        let ohm = Scale::of(points.iter().map(difference))?;
        let angle = Scale::of(points.iter().map(|point| point.angle_rad))?;
        let curve = Polynomial::fitted(points.iter().map(|p| (ohm.down(difference(p)), angle.down(p.angle_rad))))?;
        Some(Gauge { curve, ohm, angle })
    }

    /// The angle, rad; beyond what was shown nothing is known: the end of it.
    #[inline]
    fn angle_rad(&self, resistance_ohm: [f64; 2]) -> Option<f64> {
        let known = resistance_ohm.iter().all(|ohm| (0.0..1e9).contains(ohm));
        known.then(|| {
            let at = self.ohm.down(resistance_ohm[0] - resistance_ohm[1]).clamp(-1.0, 1.0);
            self.angle.up(self.curve.at(at).clamp(-1.0, 1.0))
        })
    }
}

fn difference(point: &Point) -> f64 {
    point.resistance_ohm[0] - point.resistance_ohm[1]
}

/// What is done with the angle.
#[derive(Debug, Clone)]
enum Feedback {
    Fuzzy(FuzzyPid),
    Sliding { pid: Pid, gains: PidGains, lambda: f64, per_width: f64 },
}

/// See the module.
#[derive(Debug, Clone)]
pub struct DifferentialResistance {
    /// None of a pair whose resistances do not tell its angle.
    gauge: Option<Gauge>,
    readings: Readings,
    feedback: Feedback,
    split: Split,
    radius_m: f64,
}

impl DifferentialResistance {
    pub(super) fn fuzzy(setup: &PairSetup<'_>) -> DifferentialResistance {
        let gains = setup.gains(FUZZY);
        let feedback = Feedback::Fuzzy(FuzzyPid::new(gains, setup.stroke_m(), Range::difference(1.0)));
        DifferentialResistance::new(setup, feedback)
    }

    pub(super) fn sliding(setup: &PairSetup<'_>) -> DifferentialResistance {
        let (gains, map) = (setup.gains(SLIDING), &setup.maps[0]);
        let lambda = lambda::limits(map, map.full_power * setup.settings.maximum_duty[0]).value;
        let per_width = 1.0 / (WIDTH * lambda * setup.stroke_m());
        let pid = Pid::new(gains, false, Range::difference(1.0));
        DifferentialResistance::new(setup, Feedback::Sliding { pid, gains, lambda, per_width })
    }

    fn new(setup: &PairSetup<'_>, feedback: Feedback) -> DifferentialResistance {
        let lesson = Lesson::of(setup);
        DifferentialResistance {
            gauge: lesson.as_ref().and_then(|lesson| Gauge::fitted(&lesson.points)),
            readings: Readings::NONE,
            feedback,
            split: Split::new(&setup.settings, lesson.map_or([0.0; 2], |lesson| lesson.middle)),
            radius_m: setup.settings.joint.radius_m,
        }
    }
}

impl PairLaw for DifferentialResistance {
    #[inline]
    fn duties(&mut self, demand: &JointDemand) -> Option<[f64; 2]> {
        if !demand.is_usable() {
            return None;
        }
        let read = self.gauge.as_ref().and_then(|gauge| gauge.angle_rad(demand.resistance_ohm));
        let Some(motion) = self.readings.take(read, demand.dt_s) else { return Some(self.split.duties(0.0)) };
        let agonist = demand.by(motion, self.radius_m);
        let difference = match &mut self.feedback {
            Feedback::Fuzzy(law) => law.duty(&agonist)?,
            Feedback::Sliding { pid, gains, lambda, per_width } => {
                let surface = agonist.velocity_m_s + *lambda * (agonist.length_m - agonist.reference_m);
                pid.give_with(gains, &agonist, SWITCHED * (surface * *per_width).tanh())
            }
        };
        Some(self.split.duties(difference))
    }

    fn reset(&mut self) {
        self.readings = Readings::NONE;
        match &mut self.feedback {
            Feedback::Fuzzy(law) => law.reset(),
            Feedback::Sliding { pid, .. } => pid.reset(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::testing::{athermal, pair, standing};

    /// RMS of what a gauge is off along the lesson, in strokes.
    fn off(setup: &PairSetup<'_>) -> f64 {
        let lesson = Lesson::of(setup).unwrap();
        let gauge = Gauge::fitted(&lesson.points).unwrap();
        let square = |point: &Point| {
            let read = gauge.angle_rad(point.resistance_ohm).unwrap();
            ((read - point.angle_rad) / setup.stroke_rad).powi(2)
        };
        (lesson.points.iter().map(square).sum::<f64>() / lesson.points.len() as f64).sqrt()
    }

    /// A difference of resistances is an angle as far as a resistance is a phase. Of the thesis' alloy it is not: the wires of a pair that
    /// moves are a hysteresis apart in temperature, and the difference has that twice.
    #[test]
    fn the_difference_tells_the_angle_where_heat_does_not_change_the_resistivity() {
        let (without, with) = (pair(athermal, off), pair(|_| (), off));
        assert!(without < 0.03 && with > 0.2, "{without} {with}");
    }

    /// Nothing but the resistances counts; without them it goes on with the last, and before the first both wires are in their middle.
    #[test]
    fn only_the_resistances_count() {
        pair(athermal, |setup| {
            let lesson = Lesson::of(setup).unwrap();
            let (low, high) = (lesson.points[0].resistance_ohm, lesson.points[200].resistance_ohm);
            for new in [DifferentialResistance::fuzzy, DifferentialResistance::sliding] {
                let mut law = new(setup);
                let mut answer = |angle_rad: f64, resistance_ohm: [f64; 2]| {
                    law.duties(&JointDemand { resistance_ohm, ..standing(0.0, angle_rad, [0.4; 2]) })
                };
                assert_eq!(answer(0.3, [f64::NAN; 2]), Some(lesson.middle));
                let first = answer(0.3, low).unwrap();
                assert!(first[0] != first[1], "{first:?}");
                // the integral goes on, as slowly as it does
                let again = answer(-0.3, [f64::NAN, 1.0]).unwrap();
                assert!((again[0] - first[0]).abs() < 0.01, "{first:?} {again:?}");
                assert_eq!(answer(f64::NAN, high), None);
                law.reset();
                assert_eq!(law.duties(&standing(0.0, 0.3, [0.4; 2])), Some(lesson.middle));
            }
        });
    }
}
