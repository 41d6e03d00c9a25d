//! Polynomials of both resistances, inverse hysteresis fed forward, and PID (table 5: "polynomial strain-resistance model, FF hysteresis
//! compensation, PID" [172]): the lengths that are measured are not used.
//!
//! After Wang, Shi, Liu, Ma and Zhang (*An accurately controlled antagonistic shape memory alloy actuator with self-sensing*, Sensors 12, 2012), by
//! its abstract the paper of the table's 1.093 % and 0.15 Hz: under a certain pre-strain and duty the stress of both wires becomes constant, and
//! strain over resistance nearly one curve; polynomials are fitted to both wires' curves, and the hysteresis of the strain over the difference of both
//! duties is compensated. Ours are the degrees (fifth for the resistances, third for each side of the loop), the mean of what both wires say, the
//! gains, and the pair that both are fitted to: the simulated one of the rig file.

use super::demand::{JointDemand, PairLaw};
use super::differential_resistance::{Readings, Split};
use super::lesson::{Lesson, Point};
use super::setup::{Own, PairSetup};
use crate::demand::{Law, Range};
use crate::laws::pid::{Pid, PidGains};
use crate::laws::{Polynomial, Scale, Side};

/// Gains of the PID.
const GAINS: Own = Own { proportional: 6.6, integral_s: 6.8, derivative_s: 0.022 };
/// Terms of a wire's polynomial, and of one side of the loop.
const TERMS: usize = 6;
const SIDE_TERMS: usize = 4;

/// What was fitted to a pair.
#[derive(Debug, Clone, Copy)]
struct Fitted {
    angle: Scale,
    /// The angle by the resistance of each wire.
    ohm: [Scale; 2],
    by_ohm: [Polynomial<TERMS>; 2],
    /// The difference of both duties by the angle, rising and falling.
    rising: Polynomial<SIDE_TERMS>,
    falling: Polynomial<SIDE_TERMS>,
}

impl Fitted {
    /// To a lesson; `None` of a pair whose resistances do not tell.
    fn to(points: &[Point]) -> Option<Fitted> {
        let angle = Scale::of(points.iter().map(|point| point.angle_rad))?;
        let share = |point: &Point| angle.down(point.angle_rad);
        let by_ohm = |side: usize| {
            let ohm = Scale::of(points.iter().map(|point| point.resistance_ohm[side]))?;
            let curve = points.iter().map(|point| (ohm.down(point.resistance_ohm[side]), share(point)));
            Some((ohm, Polynomial::fitted(curve)?))
        };
        let loop_side = |falling: bool| {
            let on_it = points.iter().filter(move |point| point.falling == falling);
            Polynomial::fitted(on_it.map(|point| (share(point), point.difference)))
        };
        let ((first, by_first), (second, by_second)) = (by_ohm(0)?, by_ohm(1)?);
        Some(Fitted {
            angle,
            ohm: [first, second],
            by_ohm: [by_first, by_second],
            rising: loop_side(false)?,
            falling: loop_side(true)?,
        })
    }

    /// The mean of what those wires say whose resistance was measured, rad; beyond what was shown nothing is known: the end of it.
    #[inline]
    fn angle_rad(&self, resistance_ohm: [f64; 2]) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0.0);
        for (side, ohm) in resistance_ohm.into_iter().enumerate() {
            if (0.0..1e9).contains(&ohm) {
                sum += self.by_ohm[side].at(self.ohm[side].down(ohm).clamp(-1.0, 1.0)).clamp(-1.0, 1.0);
                count += 1.0;
            }
        }
        (count > 0.0).then(|| self.angle.up(sum / count))
    }

    /// The difference of both duties that brings the pair to an angle on a side of its loop.
    #[inline]
    fn difference(&self, angle_rad: f64, falling: bool) -> f64 {
        let at = self.angle.down(angle_rad).clamp(-1.0, 1.0);
        if falling { self.falling.at(at) } else { self.rising.at(at) }
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct ResistancePolynomials {
    /// None of a pair whose resistances do not tell its angle.
    fitted: Option<Fitted>,
    readings: Readings,
    /// The side of the loop that the reference is on.
    side: Side,
    pid: Pid,
    gains: PidGains,
    split: Split,
    radius_m: f64,
}

impl ResistancePolynomials {
    pub(super) fn new(setup: &PairSetup<'_>) -> ResistancePolynomials {
        let (gains, lesson) = (setup.gains(GAINS), Lesson::of(setup));
        ResistancePolynomials {
            fitted: lesson.as_ref().and_then(|lesson| Fitted::to(&lesson.points)),
            readings: Readings::NONE,
            side: Side::COLD,
            pid: Pid::new(gains, false, Range::difference(1.0)),
            gains,
            split: Split::new(&setup.settings, lesson.map_or([0.0; 2], |lesson| lesson.middle)),
            radius_m: setup.settings.joint.radius_m,
        }
    }
}

impl PairLaw for ResistancePolynomials {
    #[inline]
    fn duties(&mut self, demand: &JointDemand) -> Option<[f64; 2]> {
        if !demand.is_usable() {
            return None;
        }
        let read = self.fitted.as_ref().and_then(|fitted| fitted.angle_rad(demand.resistance_ohm));
        let (Some(fitted), Some(motion)) = (&self.fitted, self.readings.take(read, demand.dt_s)) else {
            return Some(self.split.duties(0.0));
        };
        self.side.follow(fitted.angle.down(demand.reference_rad));
        let fed_forward = fitted.difference(demand.reference_rad, self.side.falling);
        let agonist = demand.by(motion, self.radius_m);
        Some(self.split.duties(self.pid.give_with(&self.gains, &agonist, fed_forward)))
    }

    fn reset(&mut self) {
        (self.readings, self.side) = (Readings::NONE, Side::COLD);
        self.pid.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::testing::{athermal, pair, standing};

    /// Each wire's polynomial reads the pair it was fitted to, and one alone does where the other is not measured.
    #[test]
    fn the_polynomials_read_the_pair() {
        pair(athermal, |setup| {
            let lesson = Lesson::of(setup).unwrap();
            let fitted = Fitted::to(&lesson.points).unwrap();
            let off = |hide: [f64; 2]| {
                let square = |point: &Point| {
                    let ohm = [0, 1].map(|side| point.resistance_ohm[side] + hide[side]);
                    ((fitted.angle_rad(ohm).unwrap() - point.angle_rad) / setup.stroke_rad).powi(2)
                };
                (lesson.points.iter().map(square).sum::<f64>() / lesson.points.len() as f64).sqrt()
            };
            for hide in [[0.0, 0.0], [f64::NAN, 0.0], [0.0, f64::NAN]] {
                assert!(off(hide) < 0.05, "{hide:?}: {}", off(hide));
            }
            assert_eq!(fitted.angle_rad([f64::NAN, -1.0]), None);
        });
    }

    /// What is fed forward goes round the loop: on the way up the agonist is given more at the same angle. A reference turns when it has
    /// come back by more than noise.
    #[test]
    fn the_hysteresis_is_fed_forward() {
        pair(athermal, |setup| {
            let mut law = ResistancePolynomials::new(setup);
            let fitted = law.fitted.unwrap();
            for share in [-0.3, 0.0, 0.3] {
                let [up, down] = [false, true].map(|falling| fitted.difference(share * setup.stroke_rad, falling));
                assert!(up > down + 0.01, "{share}: {up} {down}");
            }
            let resistance_ohm = Lesson::of(setup).unwrap().points[300].resistance_ohm;
            let mut turned = |share: f64| {
                let reference_rad = share * setup.stroke_rad;
                law.duties(&JointDemand { resistance_ohm, ..standing(reference_rad, 0.0, [0.4; 2]) }).unwrap();
                law.side.falling
            };
            let found = [0.2, 0.1, 0.11, 0.14, 0.2, 0.19, 0.1].map(&mut turned);
            assert_eq!(found, [true, true, true, false, false, false, true]);
        });
    }
}
