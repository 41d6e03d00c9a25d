//! PID whose gains a fuzzy rule base tunes from the error and its speed (table 5).
//!
//! Table 5 names the method and gives no rules. These are the best known: Zhao, Tomizuka and Isaka, *Fuzzy gain scheduling of PID
//! controllers*, IEEE Trans. Systems, Man, and Cybernetics 23 (1993). Seven triangular sets each on the error and on its change, 49 rules with
//! product inference; K'_P and K'_D, 0 to 1 within their ranges, are "small" or "big" with the paper's logarithmic membership, and the
//! reset time is 2 to 5 derivative times.
//!
//! Ours are the ranges, since nobody has brought a wire to its ultimate gain for us: the paper's 0.32 to 0.6 of it is K_P to 1.9 K_P of
//! [`super::pid`], its 0.08 to 0.15 of K_u T_u is K_D to 1.9 K_D, and its "2" stands for the integral time of the rig file, so that
//! it is that to 2.5 times as long. And the error is scaled by a tenth of the stroke, its speed by a stroke in two seconds.

use super::pid::{Pid, PidGains};
use crate::demand::{Demand, Law, Range};

/// Sets on each input: from negative big to positive big.
const SETS: usize = 7;
/// How far the ranges of K_P and K_D reach above their least: 0.6/0.32 and 0.15/0.08.
const REACH: f64 = 1.875;
/// What counts as a big error, in strokes, and as a big speed, in strokes per second.
const BIG_ERROR: f64 = 0.1;
const BIG_SPEED: f64 = 0.5;
/// K' of "small" and of "big": where μ = 1, −ln(K')/4 and −ln(1 − K')/4.
const SMALL: f64 = 0.018_315_638_888_734_18;
const BIG: f64 = 1.0 - SMALL;

/// "Big" is 1, "small" 0; rows by the error, columns by its change.
const PROPORTIONAL: [[u8; SETS]; SETS] = [
    [1, 1, 1, 1, 1, 1, 1],
    [0, 1, 1, 1, 1, 1, 0],
    [0, 0, 1, 1, 1, 0, 0],
    [0, 0, 0, 1, 0, 0, 0],
    [0, 0, 1, 1, 1, 0, 0],
    [0, 1, 1, 1, 1, 1, 0],
    [1, 1, 1, 1, 1, 1, 1],
];
const DERIVATIVE: [[u8; SETS]; SETS] = [
    [0, 0, 0, 0, 0, 0, 0],
    [1, 1, 0, 0, 0, 1, 1],
    [1, 1, 1, 0, 1, 1, 1],
    [1, 1, 1, 1, 1, 1, 1],
    [1, 1, 1, 0, 1, 1, 1],
    [1, 1, 0, 0, 0, 1, 1],
    [0, 0, 0, 0, 0, 0, 0],
];
/// Integral over derivative time.
const RESET: [[u8; SETS]; SETS] = [
    [2, 2, 2, 2, 2, 2, 2],
    [3, 3, 2, 2, 2, 3, 3],
    [4, 3, 3, 2, 3, 3, 4],
    [5, 4, 3, 3, 3, 4, 5],
    [4, 3, 3, 2, 3, 3, 4],
    [3, 3, 2, 2, 2, 3, 3],
    [2, 2, 2, 2, 2, 2, 2],
];

/// In how far `value`, −1 to 1 and beyond, is in two neighbouring of the sets: the lower one, and the share of the upper one.
#[inline]
fn sets(value: f64) -> (usize, f64) {
    let place = (0.5 * (value + 1.0)).clamp(0.0, 1.0) * (SETS - 1) as f64;
    let lower = (place as usize).min(SETS - 2);
    (lower, place - lower as f64)
}

/// The weighted mean of a table at an error and a change: triangular sets that add up to 1, product inference.
#[inline]
fn infer(table: &[[u8; SETS]; SETS], error: (usize, f64), change: (usize, f64), of: impl Fn(u8) -> f64) -> f64 {
    let row = |i: usize| {
        let row = &table[i];
        of(row[change.0]) * (1.0 - change.1) + of(row[change.0 + 1]) * change.1
    };
    row(error.0) * (1.0 - error.1) + row(error.0 + 1) * error.1
}

/// PID with scheduled gains.
#[derive(Debug, Clone)]
pub struct FuzzyPid {
    pid: Pid,
    least: PidGains,
    /// 1/(a big error), 1/m, and 1/(a big speed), s/m.
    per_error: f64,
    per_speed: f64,
    speed: f64,
}

impl FuzzyPid {
    pub(crate) fn new(gains: PidGains, stroke_m: f64, range: Range) -> FuzzyPid {
        FuzzyPid {
            pid: Pid::new(gains, false, range),
            least: gains,
            per_error: 1.0 / (BIG_ERROR * stroke_m),
            per_speed: 1.0 / (BIG_SPEED * stroke_m),
            speed: 0.0,
        }
    }

    /// The gains at an error, m, and its speed, m/s.
    #[inline]
    fn gains(&self, error: f64, speed: f64) -> PidGains {
        let (error, change) = (sets(error * self.per_error), sets(speed * self.per_speed));
        let share = |big: u8| if big == 1 { BIG } else { SMALL };
        let within = |share: f64| 1.0 + (REACH - 1.0) * share;
        let proportional = within(infer(&PROPORTIONAL, error, change, share));
        let derivative = within(infer(&DERIVATIVE, error, change, share));
        let reset = 0.5 * infer(&RESET, error, change, f64::from);
        let least = &self.least;
        PidGains {
            proportional_per_m: least.proportional_per_m * proportional,
            integral_per_m_s: least.integral_per_m_s * proportional / reset,
            derivative_s_per_m: least.derivative_s_per_m * derivative,
            ..*least
        }
    }
}

impl Law for FuzzyPid {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            return None;
        }
        self.speed += (demand.velocity_m_s - self.speed) * demand.dt_s / (self.least.filter_s + demand.dt_s);
        let gains = self.gains(demand.length_m - demand.reference_m, self.speed);
        Some(self.pid.give_with(&gains, demand, 0.0))
    }

    fn reset(&mut self) {
        self.pid.reset();
        self.speed = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::standing;

    fn law() -> FuzzyPid {
        FuzzyPid::new(PidGains::for_stroke(7e-3), 7e-3, Range::new(0.02, 1.0, Modulation::Switched))
    }

    /// At the middle of a set its rule alone speaks; between two, both by their shares.
    #[test]
    fn rules_are_interpolated() {
        let (law, least) = (law(), PidGains::for_stroke(7e-3));
        let gains = |error: f64, speed: f64| {
            let g = law.gains(error * BIG_ERROR * 7e-3, speed * BIG_SPEED * 7e-3);
            let proportional = g.proportional_per_m / least.proportional_per_m;
            let reset = g.proportional_per_m / g.integral_per_m_s * least.integral_per_m_s / least.proportional_per_m;
            [proportional, g.derivative_s_per_m / least.derivative_s_per_m, reset]
        };
        let close = |found: [f64; 3], expected: [f64; 3]| {
            assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-9), "{found:?} {expected:?}");
        };
        let (small, big) = (1.0 + 0.875 * SMALL, 1.0 + 0.875 * BIG);
        close(gains(1.0, 0.0), [big, small, 1.0]);
        close(gains(7.0, -9.0), [big, small, 1.0]);
        close(gains(0.0, 0.0), [big, big, 1.5]);
        close(gains(0.0, 1.0), [small, big, 2.5]);
        // a quarter of the way from "zero" to "positive small", at rest
        close(gains(0.25 / 3.0, 0.0), [big, 0.75 * big + 0.25 * small, 0.75 * 1.5 + 0.25]);
    }

    /// The same for a wire that is too long and one that is too short: the tables have no preference.
    #[test]
    fn rules_are_symmetric() {
        let law = law();
        for k in -40..40 {
            for l in -10..10 {
                let (error, speed) = (f64::from(k) * 3e-5, f64::from(l) * 5e-4);
                let (one, other) = (law.gains(error, speed), law.gains(-error, -speed));
                assert!((one.proportional_per_m / other.proportional_per_m - 1.0).abs() < 1e-12);
                assert!((one.integral_per_m_s / other.integral_per_m_s - 1.0).abs() < 1e-12);
                assert!((one.derivative_s_per_m / other.derivative_s_per_m - 1.0).abs() < 1e-12);
            }
        }
    }

    /// Far off it is the PID of the gains that its rule says.
    #[test]
    fn is_a_pid_of_its_gains() {
        let mut fuzzy = law();
        let gains = fuzzy.gains(2e-3, 0.0);
        let mut pid = Pid::new(gains, false, Range::new(0.02, 1.0, Modulation::Switched));
        let demand = standing(0.16, 0.162);
        for _ in 0..100 {
            assert_eq!(fuzzy.duty(&demand), pid.duty(&demand));
        }
    }
}
