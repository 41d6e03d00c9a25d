//! What the laws of a joint are made from: its mechanics, its wires, their limits, and the rig file's numbers with their defaults.

use super::stroke::stroke_rad;
use crate::laws::PidGains;
use crate::wire_map::WireMap;
use sinew_physics::{Error, Joint, WireModel};

/// Numbers of a joint's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSettings {
    /// Gains of the PID that some laws are built on.
    pub gains: JointGains,
    /// The joint.
    pub joint: Joint,
    /// Tension below which both wires are heated, in N.
    pub minimum_tension_n: f64,
    /// Tension that is kept where the motion leaves it free, in N.
    pub tension_n: f64,
    /// Tension at which nothing is heated any more, in N.
    pub maximum_tension_n: f64,
    /// Least duty of each wire, agonist first: its sensing pulse.
    pub minimum_duty: [f64; 2],
    /// Most duty of each wire.
    pub maximum_duty: [f64; 2],
}

/// Gains of the PID on the angle, as an error of the wires' length; `None` = the law's own. Its output is how much more duty the agonist
/// is to have than the antagonist, or, of laws that command a difference of tension, that difference in shares of the tension kept.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointGains {
    /// Per metre, 1/m.
    pub proportional_per_m: Option<f64>,
    /// Per metre and second, 1/(m s).
    pub integral_per_m_s: Option<f64>,
    /// Per metre a second, s/m.
    pub derivative_s_per_m: Option<f64>,
}

impl JointSettings {
    /// The same with duties that are duties.
    fn sane(mut self) -> JointSettings {
        for side in [0, 1] {
            let sane = |duty: f64, other: f64| if duty.is_finite() { duty.clamp(0.0, 1.0) } else { other };
            self.maximum_duty[side] = sane(self.maximum_duty[side], 1.0);
            self.minimum_duty[side] = sane(self.minimum_duty[side], 0.0).min(self.maximum_duty[side]);
        }
        self
    }

    /// The tension to keep, N: what is asked for within the limits.
    pub(super) fn set_tension_n(&self, asked_n: f64) -> f64 {
        let most = MOST_TENSION * self.maximum_tension_n;
        // in this order a NaN is the settings' own
        if asked_n.is_finite() { asked_n.max(self.minimum_tension_n).min(most) } else { self.tension_n }
    }

    /// A duty of a side's wire, within its limits.
    #[inline]
    pub(super) fn within(&self, side: usize, duty: f64) -> f64 {
        // in this order a NaN becomes the least
        duty.max(self.minimum_duty[side]).min(self.maximum_duty[side])
    }
}

/// Share of the upper limit of the tension within which heating is cut.
pub(super) const LIMIT_SHARE: f64 = 0.1;
/// Share of the maximum tension that can be asked for: above it less is heated.
pub(super) const MOST_TENSION: f64 = 1.0 - LIMIT_SHARE;

/// One joint's wires and numbers, as a row of the table of joint laws takes them.
pub(crate) struct PairSetup<'a> {
    pub settings: JointSettings,
    pub models: [&'a WireModel; 2],
    pub maps: [WireMap; 2],
    /// The whole way, rad.
    pub stroke_rad: f64,
}

/// Gains that a law has for any joint, by the whole way of its wires.
#[derive(Debug, Clone, Copy)]
pub(super) struct Own {
    /// What an error of the whole way is answered with.
    pub proportional: f64,
    /// Integral and derivative time, s.
    pub integral_s: f64,
    pub derivative_s: f64,
}

impl<'a> PairSetup<'a> {
    pub fn new(models: [&'a WireModel; 2], settings: &JointSettings) -> Result<PairSetup<'a>, Error> {
        Ok(PairSetup {
            settings: settings.sane(),
            models,
            maps: models.map(WireMap::new),
            stroke_rad: stroke_rad(&settings.joint, models)?,
        })
    }

    /// The whole way of a wire, m.
    pub fn stroke_m(&self) -> f64 {
        self.stroke_rad * self.settings.joint.radius_m
    }

    /// The gains of the settings, else the law's own.
    pub(super) fn gains(&self, own: Own) -> PidGains {
        let (per_m, given) = (own.proportional / self.stroke_m(), &self.settings.gains);
        PidGains {
            proportional_per_m: given.proportional_per_m.unwrap_or(per_m),
            integral_per_m_s: given.integral_per_m_s.unwrap_or(per_m / own.integral_s),
            derivative_s_per_m: given.derivative_s_per_m.unwrap_or(per_m * own.derivative_s),
            filter_s: PidGains::FILTER_S,
            tracking_s: PidGains::TRACKING_S,
        }
    }
}
