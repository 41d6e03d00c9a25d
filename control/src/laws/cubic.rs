//! PID with a cubic proportional term (table 5: "PID-P³").
//!
//! D = K_P e + K_P3 e³ + ∫K_I e dt + K_D ẋ, after Shameli, Alasty and Salaarieh, *Stability analysis and nonlinear control of a miniature
//! shape memory alloy actuator for precise applications*, Mechatronics 15 (2005): the cube answers large errors, and near
//! the reference, where it vanishes, the linear gains are what counts. Ours is its size: it equals the linear term at a tenth of the
//! stroke, what the fuzzy rules call a big error. And the integrator is that of PID alone: if it were taken back by what a limit cuts
//! off of the cube, every large step would fill it the wrong way.

use super::pid::{Pid, PidGains};
use crate::demand::{Demand, Law, Range};

/// Error at which the cubic term is as large as the linear one, in strokes.
const EQUAL_AT: f64 = 0.1;

/// PID with a cubic proportional term.
#[derive(Debug, Clone)]
pub struct PidP3 {
    pid: Pid,
    gains: PidGains,
    range: Range,
    /// K_P3, 1/m³.
    cubic: f64,
}

impl PidP3 {
    pub(crate) fn new(gains: PidGains, stroke_m: f64, range: Range) -> PidP3 {
        let equal_at = EQUAL_AT * stroke_m;
        let cubic = gains.proportional_per_m / (equal_at * equal_at);
        PidP3 { pid: Pid::new(gains, false, range), gains, range, cubic }
    }
}

impl Law for PidP3 {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            return None;
        }
        let error = demand.length_m - demand.reference_m;
        let linear = self.pid.answer(&self.gains, error, demand.velocity_m_s, demand.dt_s, 0.0).wanted;
        let wanted = linear + self.cubic * error * error * error;
        // in this order a NaN becomes the minimum
        Some(wanted.max(self.range.minimum).min(self.range.maximum))
    }

    fn reset(&mut self) {
        self.pid.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::standing;

    fn demand(error_m: f64) -> Demand {
        standing(0.16, 0.16 + error_m)
    }

    /// Twice the linear answer at a tenth of the stroke, an eighth more at half of that, hardly any near the reference; odd in the error.
    #[test]
    fn the_cube_answers_large_errors() {
        let gains = PidGains { integral_per_m_s: 0.0, proportional_per_m: 100.0, ..PidGains::for_stroke(5e-3) };
        let law = || PidP3::new(gains, 5e-3, Range::new(0.0, 1.0, Modulation::Switched));
        for (error, times) in [(0.5e-3, 2.0), (0.25e-3, 1.25), (0.05e-3, 1.01), (1e-3, 5.0)] {
            let duty = law().duty(&demand(error)).unwrap();
            assert!((duty / (100.0 * error) - times).abs() < 1e-9, "{error}: {duty}");
        }
        // below the reference it takes as much off
        let mut lifted = PidP3::new(gains, 5e-3, Range::new(0.3, 1.0, Modulation::Switched));
        assert!((lifted.duty(&demand(0.5e-3)).unwrap() - 0.4).abs() < 1e-9);
        assert_eq!(lifted.duty(&demand(-0.5e-3)), Some(0.3));
        assert_eq!(law().duty(&demand(f64::NAN)), None);
    }

    /// Its integrator is that of PID, whatever a limit cuts off of the cube.
    #[test]
    fn the_cube_does_not_wind_up() {
        let (gains, range) = (PidGains::for_stroke(5e-3), Range::new(0.02, 1.0, Modulation::Switched));
        let (mut law, mut pid) = (PidP3::new(gains, 5e-3, range), Pid::new(gains, false, range));
        for error in [4e-3, -2e-3, 3e-3] {
            for _ in 0..5000 {
                assert!((0.02..=1.0).contains(&law.duty(&demand(error)).unwrap()));
                pid.duty(&demand(error));
            }
            // at the reference there is no cube
            assert_eq!(law.clone().duty(&demand(0.0)), pid.clone().duty(&demand(0.0)));
        }
    }
}
