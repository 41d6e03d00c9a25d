//! A joint law's input of each cycle.

use super::observer::JointEstimate;
use crate::demand::Demand;
use crate::estimate::Estimate;

/// One cycle's question: which duties for the next PWM period?
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDemand {
    /// Angle wanted, in rad.
    pub reference_rad: f64,
    /// Tension wanted where the motion leaves it free, in N; NaN = that of the settings.
    pub tension_n: f64,
    /// Resistance of both wires, agonist first, in Ω; NaN where none was measured.
    pub resistance_ohm: [f64; 2],
    /// Time since the last call, in s.
    pub dt_s: f64,
    /// The estimate of joint and wires.
    pub estimate: JointEstimate,
}

impl JointDemand {
    /// Everything a law of a joint needs is a number, and one that does not overflow when squared.
    pub(super) fn is_usable(&self) -> bool {
        let usable = |value: f64| value.abs() < 1e9;
        let seen = &self.estimate;
        usable(self.reference_rad)
            && self.dt_s > 0.0
            && usable(self.dt_s)
            && usable(seen.angle_rad)
            && usable(seen.rate_rad_s)
            && seen.tension_n.iter().all(|tension| usable(*tension))
            && seen.wires.iter().all(|wire| usable(wire.temperature_c) && wire.full_power_w > 0.0)
    }

    /// What is asked of the wire of a side (0 = agonist) alone, at the end of a lever of `radius_m`, lengths counted from angle 0; with
    /// what is believed of it.
    pub(super) fn of_wire(&self, side: usize, radius_m: f64) -> Demand {
        Demand { estimate: self.estimate.wires[side], ..self.at(side, radius_m, Motion::of(&self.estimate)) }
    }

    /// The same of the agonist by another motion than that which is believed, and nothing else known.
    pub(super) fn by(&self, motion: Motion, radius_m: f64) -> Demand {
        self.at(0, radius_m, motion)
    }

    fn at(&self, side: usize, radius_m: f64, motion: Motion) -> Demand {
        let longer = if side == 0 { -radius_m } else { radius_m };
        Demand {
            reference_m: longer * self.reference_rad,
            length_m: longer * motion.angle_rad,
            velocity_m_s: longer * motion.rate_rad_s,
            acceleration_m_s2: 0.0,
            resistance_ohm: f64::NAN,
            dt_s: self.dt_s,
            estimate: Estimate::UNKNOWN,
        }
    }
}

/// An angle and how fast it changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub angle_rad: f64,
    pub rate_rad_s: f64,
}

impl Motion {
    fn of(seen: &JointEstimate) -> Motion {
        Motion { angle_rad: seen.angle_rad, rate_rad_s: seen.rate_rad_s }
    }
}

/// One of the laws from an angle to the duties of both wires, as a joint runs it.
pub(crate) trait PairLaw {
    /// The duties of agonist and antagonist for the next period, between least and most of each; `None` where the demand is not usable.
    fn duties(&mut self, demand: &JointDemand) -> Option<[f64; 2]>;

    /// Forgets the past: as newly made.
    fn reset(&mut self);

    /// Whether a limit of the tension had a say in the last cycle, where the law sees to it itself.
    fn is_limited(&self) -> bool {
        false
    }
}
