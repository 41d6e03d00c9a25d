//! What the laws of a channel are made from: the wire, its limits, and the rig file's numbers with their defaults.

use super::pid::PidGains;
use super::segment::Segment;
use crate::demand::Range;
use crate::lambda;
use crate::wire_map::WireMap;
use sinew_physics::WireModel;

/// Half width of the band in which a wire is left standing, by default, in strokes.
const HOLD_BAND: f64 = 0.0025;
/// Half width of the relay's band by default, in strokes.
const RELAY_BAND: f64 = 0.01;

/// One channel's wire and numbers, as a row of the table of laws takes them.
pub(crate) struct Setup<'a> {
    pub model: &'a WireModel,
    pub map: WireMap,
    pub range: Range,
    /// λ, 1/s: given, or the default of [`lambda::limits`].
    pub lambda: f64,
    /// The whole stroke, m.
    pub stroke: f64,
    /// Which piece of a wire it is.
    pub segment: Segment,
    hold_band_m: Option<f64>,
    relay_band_m: Option<f64>,
    gains: Option<PidGains>,
    heat_loss_feedforward: Option<bool>,
}

/// What a rig file may say of a law; `None` = from the wire.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Given {
    /// λ, 1/s; what is not within 0.001 and 10 000 counts as none.
    pub lambda_per_s: Option<f64>,
    pub hold_band_m: Option<f64>,
    pub relay_band_m: Option<f64>,
    pub gains: Option<PidGains>,
    pub heat_loss_feedforward: Option<bool>,
    pub segment: Segment,
}

impl<'a> Setup<'a> {
    pub fn new(model: &'a WireModel, range: Range, given: Given) -> Setup<'a> {
        let map = WireMap::new(model);
        let lambda = match given.lambda_per_s {
            Some(value) if (1e-3..=1e4).contains(&value) => value,
            _ => lambda::limits(&map, map.full_power * range.maximum).value,
        };
        Setup {
            model,
            map,
            range,
            lambda,
            stroke: lambda::speeds(&map, map.full_power).stroke,
            segment: given.segment,
            hold_band_m: given.hold_band_m,
            relay_band_m: given.relay_band_m,
            gains: given.gains,
            heat_loss_feedforward: given.heat_loss_feedforward,
        }
    }

    /// Half width of the band around the reference in which a wire is left standing, m.
    pub fn hold_band(&self) -> f64 {
        self.band(self.hold_band_m, HOLD_BAND)
    }

    /// Half width of the relay's band, m.
    pub fn relay_band(&self) -> f64 {
        self.band(self.relay_band_m, RELAY_BAND)
    }

    fn band(&self, given: Option<f64>, strokes: f64) -> f64 {
        match given {
            Some(value) if value >= 0.0 && value.is_finite() => value,
            _ => strokes * self.stroke,
        }
    }

    /// Gains of PID.
    pub fn pid_gains(&self) -> PidGains {
        self.gains.unwrap_or_else(|| PidGains::for_stroke(self.stroke))
    }

    /// Gains of PI: those of PID without the derivative's.
    pub fn pi_gains(&self) -> PidGains {
        PidGains { derivative_s_per_m: 0.0, ..self.pid_gains() }
    }

    /// Whether the estimated loss to the air is fed forward.
    pub fn feeds_loss_forward(&self, by_default: bool) -> bool {
        self.heat_loss_feedforward.unwrap_or(by_default)
    }

    /// The integral gain with which an error of the whole stroke reaches full power in 1/λ, W/(m s).
    pub fn integral_w_per_m_s(&self) -> f64 {
        self.lambda * self.map.full_power * self.range.maximum / self.stroke
    }
}
