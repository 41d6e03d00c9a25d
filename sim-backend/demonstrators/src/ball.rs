//! A ball that rolls on a beam without slipping.
//!
//! With x along the beam from its pivot, positive towards the end that the wire lifts, θ the angle, m the ball's mass, c = I/(m r²) and
//! μ its rolling resistance:
//!
//! ```text
//! (1 + c) ẍ = x θ̇² − g sin θ − μ g sgn ẋ
//! ```
//!
//! and it turns the beam back by m g x cos θ + 2 m x ẋ θ̇. Left out: the ball's own moment of inertia about the pivot, m x², which is
//! small beside the beam's while the ball is near the middle.

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2 as G;
use sinew_rig::Demonstrator;

/// What a ball is put on counts as level within this, rad …
const LEVEL_RAD: f64 = 0.02;
/// … once it has been so for this long, s: then a hand puts the ball down.
const LEVEL_S: f64 = 1.0;

/// A hand that has a ball.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hand {
    level_s: f64,
}

impl Hand {
    /// Whether it puts the ball down in this period, on what leans so far, rad.
    pub fn puts_down(&mut self, leans_rad: f64, period_s: f64) -> bool {
        self.level_s = if leans_rad.abs() < LEVEL_RAD { self.level_s + period_s } else { 0.0 };
        let puts_down = self.level_s >= LEVEL_S;
        if puts_down {
            self.level_s = 0.0;
        }
        puts_down
    }
}

/// What the ball rolls on and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// From pivot to end, m.
    pub half_m: f64,
    /// Mass of the ball, kg.
    pub ball_kg: f64,
    /// Its moment of inertia over m r².
    pub inertia: f64,
    /// Rolling resistance, share of its weight.
    pub rolling: f64,
}

impl Beam {
    /// That of a rig file.
    pub fn of(declared: &Demonstrator) -> Beam {
        Beam {
            half_m: declared.half_beam_m,
            ball_kg: declared.ball_kg,
            inertia: declared.ball_inertia,
            rolling: declared.rolling_resistance,
        }
    }
}

/// A ball in motion on a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// From the pivot, m.
    pub at_m: f64,
    /// Along the beam, m/s.
    pub speed_m_s: f64,
}

impl Ball {
    /// At rest.
    pub fn put_down(at_m: f64) -> Ball {
        Ball { at_m, speed_m_s: 0.0 }
    }

    /// Lets `dt_s` pass at an angle θ, rad, that turns with θ̇, rad/s (semi-implicit Euler: no drift of energy).
    pub fn roll(&mut self, beam: &Beam, angle_rad: f64, rate_rad_s: f64, dt_s: f64) {
        let pull = self.at_m * rate_rad_s * rate_rad_s - G * angle_rad.sin();
        let most = beam.rolling * G;
        let push = if self.speed_m_s == 0.0 {
            // resistance holds what pulls less
            if pull.abs() <= most { 0.0 } else { pull - most * pull.signum() }
        } else {
            pull - most * self.speed_m_s.signum()
        };
        let speed = self.speed_m_s + push * dt_s / (1.0 + beam.inertia);
        let stops = self.speed_m_s != 0.0 && speed.signum() != self.speed_m_s.signum() && pull.abs() <= most;
        self.speed_m_s = if stops { 0.0 } else { speed };
        self.at_m += self.speed_m_s * dt_s;
    }

    /// Torque that turns the beam back, N m.
    pub fn torque_n_m(&self, beam: &Beam, angle_rad: f64, rate_rad_s: f64) -> f64 {
        beam.ball_kg * self.at_m * (G * angle_rad.cos() + 2.0 * self.speed_m_s * rate_rad_s)
    }

    /// Whether it is beside the beam.
    pub fn has_fallen(&self, beam: &Beam) -> bool {
        self.at_m.abs() > beam.half_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEAM: Beam = Beam { half_m: 1.0, ball_kg: 3e-3, inertia: 0.4, rolling: 0.0 };

    fn rolled(beam: &Beam, mut ball: Ball, seconds: f64, angle: impl Fn(f64) -> (f64, f64)) -> Ball {
        let dt = 1e-4;
        for step in 0..(seconds / dt).round() as u64 {
            let (angle_rad, rate_rad_s) = angle((step as f64 + 0.5) * dt);
            ball.roll(beam, angle_rad, rate_rad_s, dt);
        }
        ball
    }

    #[test]
    fn down_a_slope_it_goes_as_galilei_says() {
        let angle = 0.05_f64;
        let fall = |inertia| {
            let beam = Beam { inertia, ..BEAM };
            rolled(&beam, Ball::put_down(0.0), 1.0, |_| (angle, 0.0)).at_m
        };
        for inertia in [0.0, 0.4, 2.0 / 3.0] {
            let exact = -0.5 * G * angle.sin() / (1.0 + inertia);
            assert!((fall(inertia) / exact - 1.0).abs() < 2e-4, "{inertia}");
        }
    }

    #[test]
    fn in_a_turning_trough_it_neither_gains_nor_loses() {
        // The beam swings about level; without gravity's part (no slope) what is left is the centrifugal term, ẍ = k² x: x = x0 cosh kt
        let beam = Beam { inertia: 0.0, half_m: 10.0, ..BEAM };
        let k = 2.0_f64;
        let ball = rolled(&beam, Ball::put_down(0.01), 1.0, |_| (0.0, k));
        assert!((ball.at_m / (0.01 * k.cosh()) - 1.0).abs() < 1e-3, "{ball:?}");
    }

    #[test]
    fn its_weight_does_on_the_beam_what_it_loses_itself() {
        // Tilted up and down again while it rolls: kinetic and potential energy of the ball change by the work of the beam, −∫ τ dθ.
        let beam = BEAM;
        let angle = |t: f64| 0.1 * (3.0 * t).sin();
        let rate = |t: f64| 0.3 * (3.0 * t).cos();
        let energy = |ball: &Ball, t: f64| {
            let (v, w) = (ball.speed_m_s, rate(t));
            // height x sin θ; the rotation of the beam carries the ball along with x θ̇
            beam.ball_kg
                * (0.5 * (1.0 + beam.inertia) * v * v + 0.5 * (ball.at_m * w).powi(2) + G * ball.at_m * angle(t).sin())
        };
        let dt = 1e-5;
        let mut ball = Ball { at_m: 0.2, speed_m_s: 0.1 };
        let (mut work, before) = (0.0, energy(&ball, 0.0));
        for step in 0..100_000 {
            let t = (f64::from(step) + 0.5) * dt;
            let (a, w) = (angle(t), rate(t));
            // what the beam does on the ball: the torque it is given back, and what m x² takes to turn
            let turning = beam.ball_kg * ball.at_m * ball.at_m * (-9.0 * angle(t));
            work += (ball.torque_n_m(&beam, a, w) + turning) * w * dt;
            ball.roll(&beam, a, w, dt);
        }
        let gained = energy(&ball, 1.0) - before;
        assert!((gained - work).abs() < 1e-3 * work.abs(), "{gained} {work}");
    }

    #[test]
    fn rolling_resistance_stops_it_and_holds_it() {
        let beam = Beam { rolling: 0.01, ..BEAM };
        let stopped = rolled(&beam, Ball { at_m: 0.0, speed_m_s: 0.05 }, 3.0, |_| (0.0, 0.0));
        assert_eq!(stopped.speed_m_s, 0.0);
        let exact = 0.05 * 0.05 * 1.4 / (2.0 * 0.01 * G);
        assert!((stopped.at_m / exact - 1.0).abs() < 0.01, "{} {exact}", stopped.at_m);
        assert_eq!(rolled(&beam, Ball::put_down(0.1), 1.0, |_| (0.009, 0.0)).at_m, 0.1, "a slope less than it");
        assert!(rolled(&beam, Ball::put_down(0.1), 1.0, |_| (0.011, 0.0)).at_m < 0.1);
    }
}
