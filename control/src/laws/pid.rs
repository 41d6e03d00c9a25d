//! Proportional-integral-derivative control with anti-windup by back-calculation: the laws that need no model and no acceleration.
//!
//! PI is the one with a derivative gain of 0. Either may be told the power that the wire loses to the air, which its integral
//! would otherwise have to find anew at every length (chapter 10: the offset β of eq. 58 without its inversion α).

use crate::demand::Range;
use crate::{Controller, Demand};

/// Gains of PI and PID.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PidGains {
    /// Duty per metre too long, 1/m.
    pub proportional_per_m: f64,
    /// Duty per metre too long and second, 1/(m s).
    pub integral_per_m_s: f64,
    /// Duty per metre per second of lengthening, s/m; 0 = PI.
    pub derivative_s_per_m: f64,
    /// Time constant of the derivative's filter, in s.
    pub filter_s: f64,
    /// Time in which an integrator that pushes against a limit is taken back, in s.
    pub tracking_s: f64,
}

impl PidGains {
    /// Time constant of the derivative's filter by default, s: less than any wire takes to answer.
    pub const FILTER_S: f64 = 0.01;
    /// Tracking time by default, s.
    pub const TRACKING_S: f64 = 0.3;

    /// Gains for a wire of this stroke: full power at 30 % of it too long, T_i = 1 s, T_d = 50 ms.
    pub fn for_stroke(stroke_m: f64) -> PidGains {
        let proportional_per_m = 1.0 / (0.3 * stroke_m.max(1e-9));
        PidGains {
            proportional_per_m,
            integral_per_m_s: proportional_per_m,
            derivative_s_per_m: 0.05 * proportional_per_m,
            filter_s: PidGains::FILTER_S,
            tracking_s: PidGains::TRACKING_S,
        }
    }
}

/// Duty = K_P e + K_D v + ∫(K_I e + (given − wanted)/T_t) dt, with e = x − x_ref (too long: heat), and v = ẋ through a filter:
/// of the length alone, so that a step of the reference does not kick.
#[derive(Debug, Clone)]
pub struct Pid {
    gains: PidGains,
    /// Whether the loss to the air is added.
    feedforward: bool,
    range: Range,
    integral: f64,
    /// ẋ, filtered, m/s.
    velocity: f64,
    blind: bool,
}

impl Pid {
    pub(crate) fn new(gains: PidGains, feedforward: bool, range: Range) -> Pid {
        let integral = if feedforward { 0.0 } else { range.minimum };
        Pid { gains, feedforward, range, integral, velocity: 0.0, blind: false }
    }
}

impl Controller for Pid {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        self.blind = !demand.is_usable();
        if self.blind {
            return self.range.minimum;
        }
        let g = &self.gains;
        let error = demand.length_m - demand.reference_m;
        self.velocity += (demand.velocity_m_s - self.velocity) * demand.dt_s / (g.filter_s + demand.dt_s);
        let mut wanted = g.proportional_per_m * error + g.derivative_s_per_m * self.velocity + self.integral;
        if self.feedforward && demand.estimate.is_usable() {
            wanted += demand.estimate.loss_w / demand.estimate.full_power_w;
        }
        // in this order a NaN becomes the minimum
        let given = wanted.max(self.range.minimum).min(self.range.maximum);
        let dt = demand.dt_s.min(g.tracking_s);
        let rate = g.integral_per_m_s * error + (given - wanted) / g.tracking_s;
        self.integral = (self.integral + rate * dt).clamp(-10.0, 10.0);
        given
    }

    fn reset(&mut self) {
        *self = Pid::new(self.gains, self.feedforward, self.range);
    }

    fn surface(&self) -> f64 {
        0.0
    }

    fn is_blind(&self) -> bool {
        self.blind
    }
}
