//! Which law runs on a channel, with which numbers; chosen once, dispatched without indirection.

use crate::demand::Range;
use crate::wire_map::WireMap;
use crate::{Controller, Demand, Law, Modulation, Pi, PiGains, SlidingMode1, SlidingMode2, lambda};
use sinew_physics::WireModel;

/// The laws to choose from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlgorithmKind {
    /// Second-order surface, eq. 70's equivalent control (the default).
    SlidingMode2,
    /// Second-order surface, the thesis' switching law on measured derivatives.
    SlidingMode2Plain,
    /// First-order surface.
    SlidingMode1,
    /// Proportional-integral with anti-windup.
    Pi,
}

/// Numbers of a channel's law. `None` = from the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which law.
    pub kind: AlgorithmKind,
    /// Bandwidth λ of the surface, in 1/s.
    pub lambda_per_s: Option<f64>,
    /// Least duty: the sensing pulse.
    pub minimum_duty: f64,
    /// Most duty.
    pub maximum_duty: f64,
    /// Half width of the band around the reference in which the wire is left standing, in m; default 0.25 % of the stroke.
    pub hold_band_m: Option<f64>,
    /// When power is switched; the plain second-order and the first-order law always switch whole periods.
    pub modulation: Modulation,
    /// PI gains.
    pub pi: Option<PiGains>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            kind: AlgorithmKind::SlidingMode2,
            lambda_per_s: None,
            minimum_duty: 0.02,
            maximum_duty: 1.0,
            hold_band_m: None,
            modulation: Modulation::Switched,
            pi: None,
        }
    }
}

/// A channel's law.
// Lies by value in the channel's struct, where the loop touches it: a box would cost more than the bytes.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
pub enum Algorithm {
    /// Second-order sliding mode.
    SlidingMode2(SlidingMode2),
    /// First-order sliding mode.
    SlidingMode1(SlidingMode1),
    /// Proportional-integral.
    Pi(Pi),
}

impl Algorithm {
    /// The law for a wire.
    pub fn new(model: &WireModel, settings: &Settings) -> Algorithm {
        let map = WireMap::new(model);
        let range = Range::new(settings.minimum_duty, settings.maximum_duty, settings.modulation);
        let limits = lambda::limits(&map, map.full_power * range.maximum);
        let lambda = match settings.lambda_per_s {
            Some(value) if value > 0.0 && value.is_finite() => value,
            _ => limits.value,
        };
        let stroke = lambda::speeds(&map, map.full_power).stroke;
        let hold = match settings.hold_band_m {
            Some(value) if value >= 0.0 && value.is_finite() => value,
            _ => 0.0025 * stroke,
        };
        match settings.kind {
            AlgorithmKind::SlidingMode2 => {
                Algorithm::SlidingMode2(SlidingMode2::new(map, lambda, Law::Equivalent, hold, range))
            }
            AlgorithmKind::SlidingMode2Plain => {
                Algorithm::SlidingMode2(SlidingMode2::new(map, lambda, Law::Plain, hold, range))
            }
            AlgorithmKind::SlidingMode1 => Algorithm::SlidingMode1(SlidingMode1::new(lambda, range)),
            AlgorithmKind::Pi => {
                let gains = settings.pi.unwrap_or(PiGains {
                    proportional_per_m: 1.0 / (0.3 * stroke.max(1e-9)),
                    integral_per_m_s: 1.0 / (0.3 * stroke.max(1e-9)),
                    tracking_s: 0.3,
                });
                Algorithm::Pi(Pi::new(gains, range))
            }
        }
    }
}

impl Controller for Algorithm {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        match self {
            Algorithm::SlidingMode2(law) => law.duty(demand),
            Algorithm::SlidingMode1(law) => law.duty(demand),
            Algorithm::Pi(law) => law.duty(demand),
        }
    }

    fn reset(&mut self) {
        match self {
            Algorithm::SlidingMode2(law) => law.reset(),
            Algorithm::SlidingMode1(law) => law.reset(),
            Algorithm::Pi(law) => law.reset(),
        }
    }

    fn surface(&self) -> f64 {
        match self {
            Algorithm::SlidingMode2(law) => law.surface(),
            Algorithm::SlidingMode1(law) => law.surface(),
            Algorithm::Pi(law) => law.surface(),
        }
    }

    fn is_blind(&self) -> bool {
        match self {
            Algorithm::SlidingMode2(law) => law.is_blind(),
            Algorithm::SlidingMode1(law) => law.is_blind(),
            Algorithm::Pi(law) => law.is_blind(),
        }
    }
}
