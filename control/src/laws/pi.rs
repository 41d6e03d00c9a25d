//! Proportional-integral control with anti-windup by back-calculation: the fallback that needs no estimate and no acceleration.

use crate::demand::Range;
use crate::{Controller, Demand};

/// Gains of the PI fallback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PiGains {
    /// Duty per metre too long, 1/m.
    pub proportional_per_m: f64,
    /// Duty per metre too long and second, 1/(m s).
    pub integral_per_m_s: f64,
    /// Time in which an integrator that pushes against a limit is taken back, in s.
    pub tracking_s: f64,
}

/// Duty = K_P e + ∫(K_I e + (given − wanted)/T_t) dt, with e = x − x_ref (too long: heat).
#[derive(Debug, Clone)]
pub struct Pi {
    gains: PiGains,
    range: Range,
    integral: f64,
    blind: bool,
}

impl Pi {
    pub(crate) fn new(gains: PiGains, range: Range) -> Pi {
        Pi { gains, range, integral: range.minimum, blind: false }
    }
}

impl Controller for Pi {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        self.blind = !demand.is_usable();
        if self.blind {
            return self.range.minimum;
        }
        let error = demand.length_m - demand.reference_m;
        let wanted = self.gains.proportional_per_m * error + self.integral;
        let given = wanted.clamp(self.range.minimum, self.range.maximum);
        let dt = demand.dt_s.min(self.gains.tracking_s);
        let rate = self.gains.integral_per_m_s * error + (given - wanted) / self.gains.tracking_s;
        self.integral = (self.integral + rate * dt).clamp(-10.0, 10.0);
        given
    }

    fn reset(&mut self) {
        self.integral = self.range.minimum;
        self.blind = false;
    }

    fn surface(&self) -> f64 {
        0.0
    }

    fn is_blind(&self) -> bool {
        self.blind
    }
}
