//! Proportional-integral-derivative control with anti-windup by back-calculation: the laws that need no model and no acceleration.
//!
//! PI has a derivative gain of 0. Either may get the wire's loss to the air as feed-forward, which its integral
//! would otherwise have to find again at every length (chapter 10: the offset β of eq. 58 without its inversion α).

use crate::demand::{Demand, Law, Range};

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
}

/// The duty that the sum of the terms asks for, and what of it is given.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer {
    pub wanted: f64,
    pub given: f64,
}

impl Pid {
    pub(crate) fn new(gains: PidGains, feedforward: bool, range: Range) -> Pid {
        // a difference of two duties begins with none
        let integral = if feedforward { 0.0 } else { range.minimum.max(0.0) };
        Pid { gains, feedforward, range, integral, velocity: 0.0 }
    }
}

impl Pid {
    /// The duty where `fed_forward` is added to the sum of the three terms; the demand is usable.
    #[inline]
    pub(crate) fn give(&mut self, demand: &Demand, fed_forward: f64) -> f64 {
        self.give_with(&{ self.gains }, demand, fed_forward)
    }

    /// The same with other gains than its own.
    #[inline]
    pub(crate) fn give_with(&mut self, g: &PidGains, demand: &Demand, fed_forward: f64) -> f64 {
        self.answer(g, demand.length_m - demand.reference_m, demand.velocity_m_s, demand.dt_s, fed_forward).given
    }

    /// The same of an error, m, and a velocity, m/s, that need not be those of the length, after `dt_s`.
    #[inline]
    pub(crate) fn answer(&mut self, g: &PidGains, error: f64, velocity: f64, dt_s: f64, fed_forward: f64) -> Answer {
        self.velocity += (velocity - self.velocity) * dt_s / (g.filter_s + dt_s);
        let wanted = g.proportional_per_m * error + g.derivative_s_per_m * self.velocity + self.integral + fed_forward;
        // in this order a NaN becomes the minimum
        let given = wanted.max(self.range.minimum).min(self.range.maximum);
        let dt = dt_s.min(g.tracking_s);
        let rate = g.integral_per_m_s * error + (given - wanted) / g.tracking_s;
        self.integral = (self.integral + rate * dt).clamp(-10.0, 10.0);
        Answer { wanted, given }
    }
}

impl Law for Pid {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            return None;
        }
        let seen = &demand.estimate;
        let loss = if self.feedforward && seen.is_usable() { seen.loss_w / seen.full_power_w } else { 0.0 };
        Some(self.give(demand, loss))
    }

    fn reset(&mut self) {
        *self = Pid::new(self.gains, self.feedforward, self.range);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::estimate::Estimate;
    use crate::testing::standing;

    const GAINS: PidGains = PidGains {
        proportional_per_m: 100.0,
        integral_per_m_s: 50.0,
        derivative_s_per_m: 4.0,
        filter_s: 0.02,
        tracking_s: 0.3,
    };

    fn pid(feedforward: bool) -> Pid {
        Pid::new(GAINS, feedforward, Range::new(0.02, 1.0, Modulation::Switched))
    }

    fn demand(error_m: f64, velocity_m_s: f64) -> Demand {
        Demand { velocity_m_s, ..standing(0.16, 0.16 + error_m) }
    }

    /// K_P e + K_I e t from the least duty on, and K_D v once the filter has it.
    #[test]
    fn is_the_sum_of_its_terms() {
        let mut law = pid(false);
        let (error, velocity) = (2e-3, 0.01);
        let duty = (0..1000).map(|_| law.duty(&demand(error, velocity)).unwrap()).last().unwrap();
        let expected = 0.02 + 100.0 * error + 50.0 * error * 0.999 + 4.0 * velocity;
        assert!((duty - expected).abs() < 1e-9, "{duty} {expected}");
        // the filter's own time: 1 − 1/e of the way after 20 ms
        let mut law = pid(false);
        let duty = (0..20).map(|_| law.duty(&demand(0.0, velocity)).unwrap()).last().unwrap();
        assert!(((duty - 0.02) / (4.0 * velocity) - 0.632).abs() < 0.02, "{duty}");
    }

    /// A step of the reference is answered by the proportional gain alone.
    #[test]
    fn a_step_of_the_reference_does_not_kick() {
        let mut law = pid(false);
        let before = law.duty(&demand(1e-3, 0.0)).unwrap();
        let after = law.duty(&demand(3e-3, 0.0)).unwrap();
        assert!((after - before - 100.0 * 2e-3).abs() < 1e-3, "{before} {after}");
    }

    /// Saturated, the integrator settles where it asks for K_I e T_t more than is given, and is off the limit at once after.
    #[test]
    fn does_not_wind_up() {
        let mut law = pid(false);
        (0..20_000).for_each(|_| assert!(law.duty(&demand(0.02, 0.0)).unwrap() <= 1.0));
        let wanted = 100.0 * 0.02 + law.integral;
        assert!((wanted - (1.0 + 50.0 * 0.02 * 0.3)).abs() < 1e-6, "{wanted}");
        assert!(law.duty(&demand(0.01, 0.0)).unwrap() < 1.0);
    }

    /// The loss is added as a duty; without an estimate nothing is.
    #[test]
    fn feeds_the_loss_forward() {
        let estimate = Estimate {
            temperature_c: 90.0,
            martensite: 0.5,
            length_m: 0.161,
            velocity_m_s: 0.0,
            loss_w: 0.6,
            full_power_w: 3.0,
            ..Estimate::UNKNOWN
        };
        let seen = Demand { estimate, ..demand(1e-3, 0.0) };
        assert!((pid(true).duty(&seen).unwrap() - (0.1 + 0.2)).abs() < 1e-12);
        assert!((pid(true).duty(&demand(1e-3, 0.0)).unwrap() - 0.1).abs() < 1e-12);
        assert!((pid(false).duty(&seen).unwrap() - (0.02 + 0.1)).abs() < 1e-12);
    }
}
