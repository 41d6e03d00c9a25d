//! A ball that rolls without slipping on a paddle that is tilted and carried about.
//!
//! With ρ = (x, y, 0) the ball's place and v its speed along the paddle, ω how the paddle turns, a how its middle is accelerated and g gravity, all in
//! the paddle's own directions, m the ball's mass, c = I/(m r²), μ its rolling resistance and ∥ what is along the paddle:
//!
//! ```text
//! (1 + c) v̇ = [g − a − ω × (ω × ρ) − 2 ω × v]∥ − μ g v/|v|        F = m (g − v̇ − ω × (ω × ρ) − 2 ω × v)
//! ```
//!
//! F is what it does to the paddle. Left out: what there is of ω̇ × ρ along the paddle and what a turn about the paddle's upright axis does to the
//! spin, both small as its wires do not turn it that way; in F, that the ball is carried along with a and ω̇, which is a part of the arm's inertia; and
//! that its middle is a radius above the paddle.

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2 as G;
use sinew_rig::Demonstrator;

use crate::space::{Turn, Vector, cross, difference, sum, times};

/// What the ball rolls on and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Paddle {
    /// From its middle to its edge, m.
    pub radius_m: f64,
    /// Mass of the ball, kg.
    pub ball_kg: f64,
    /// Its moment of inertia over m r².
    inertia: f64,
    /// Rolling resistance, share of its weight.
    rolling: f64,
}

/// How a paddle moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Carried {
    pub turn: Turn,
    /// How it turns, rad/s, in its own directions.
    pub spin: Vector,
    /// How its middle is accelerated, m/s², in the world's.
    pub acceleration: Vector,
}

/// A ball in motion on a paddle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball {
    /// From the middle of the paddle, m: ahead and to the left.
    pub at_m: [f64; 2],
    /// Along the paddle, m/s.
    pub speed_m_s: [f64; 2],
}

impl Paddle {
    /// That of a rig file.
    pub fn of(declared: &Demonstrator) -> Paddle {
        Paddle {
            radius_m: declared.paddle_radius_m,
            ball_kg: declared.ball_kg,
            inertia: declared.ball_inertia,
            rolling: declared.rolling_resistance,
        }
    }
}

impl Ball {
    /// Lets `dt_s` pass on a paddle that moves like this (semi-implicit Euler); the force on the paddle, N, in the world's directions.
    pub fn roll(&mut self, paddle: &Paddle, carried: &Carried, dt_s: f64) -> Vector {
        let Carried { turn, spin, acceleration } = *carried;
        let ([x, y], [u, v]) = (self.at_m, self.speed_m_s);
        let turning = sum(cross(spin, cross(spin, [x, y, 0.0])), times(2.0, cross(spin, [u, v, 0.0])));
        let pull = difference(turn.back(difference([0.0, 0.0, -G], acceleration)), turning);
        let share_s = dt_s / (1.0 + paddle.inertia);
        let free = [u + pull[0] * share_s, v + pull[1] * share_s];
        // resistance takes of the speed what it can, and no more than there is
        let most_m_s = paddle.rolling * G * share_s;
        let left = (1.0 - most_m_s / free[0].hypot(free[1]).max(most_m_s).max(f64::MIN_POSITIVE)).max(0.0);
        self.speed_m_s = free.map(|speed| left * speed);
        self.at_m = [x + self.speed_m_s[0] * dt_s, y + self.speed_m_s[1] * dt_s];
        let gained = [(self.speed_m_s[0] - u) / dt_s, (self.speed_m_s[1] - v) / dt_s, 0.0];
        times(paddle.ball_kg, difference([0.0, 0.0, -G], turn.out(sum(gained, turning))))
    }

    /// How far it is from the middle, m.
    pub fn off_m(&self) -> f64 {
        self.at_m[0].hypot(self.at_m[1])
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::space::dot;

    pub const PADDLE: Paddle = Paddle { radius_m: 1.0, ball_kg: 3e-3, inertia: 0.4, rolling: 0.0 };
    const DT_S: f64 = 1e-4;

    fn rolled(paddle: &Paddle, mut ball: Ball, seconds: f64, carried: impl Fn(f64) -> Carried) -> Ball {
        for step in 0..(seconds / DT_S).round() as u64 {
            ball.roll(paddle, &carried((step as f64 + 0.5) * DT_S), DT_S);
        }
        ball
    }

    fn still(turn: Turn) -> Carried {
        Carried { turn, spin: [0.0; 3], acceleration: [0.0; 3] }
    }

    const AT_REST: Ball = Ball { at_m: [0.0; 2], speed_m_s: [0.0; 2] };

    #[test]
    fn down_a_slope_it_goes_as_galilei_says_whichever_way_that_is() {
        let (pitch, roll) = (0.05_f64, -0.03_f64);
        for inertia in [0.0, 0.4, 2.0 / 3.0] {
            let paddle = Paddle { inertia, ..PADDLE };
            let fell = |turn| rolled(&paddle, AT_REST, 1.0, |_| still(turn)).at_m;
            let exact = |angle: f64| 0.5 * G * angle.sin() / (1.0 + inertia);
            // the nose down: ahead; to the right: not to the left
            let [ahead, beside] = fell(Turn::of([0.0, pitch, 0.0]));
            assert!((ahead / exact(pitch) - 1.0).abs() < 2e-4 && beside.abs() < 1e-12, "{ahead} {beside}");
            let [ahead, left] = fell(Turn::of([0.0, 0.0, roll]));
            assert!((left / -exact(roll) - 1.0).abs() < 2e-4 && ahead.abs() < 1e-12, "{ahead} {left}");
            // both: gravity's parts along the hand and across it
            let [ahead, left] = fell(Turn::of([0.0, pitch, roll]));
            let across = -0.5 * G * pitch.cos() * roll.sin() / (1.0 + inertia);
            assert!((ahead / exact(pitch) - 1.0).abs() < 2e-4 && (left / across - 1.0).abs() < 2e-4, "{ahead} {left}");
        }
    }

    #[test]
    fn on_a_paddle_that_precesses_it_circles() {
        // a small tilt a that goes round with W: x = r cos Wt with r = g a / ((1 + c) W²), if it starts on it
        let (tilt, round) = (0.02_f64, 3.0_f64);
        let radius = G * tilt / (1.4 * round * round);
        let ball = Ball { at_m: [radius, 0.0], speed_m_s: [0.0, radius * round] };
        // without the terms of a turning paddle, of second order in the tilt
        let lean = |t: f64| still(Turn::of([0.0, -tilt * (round * t).cos(), tilt * (round * t).sin()]));
        let full = 2.0 * std::f64::consts::PI / round;
        let quarter = rolled(&PADDLE, ball, 0.25 * full, lean);
        assert!(quarter.at_m[0].abs() < 0.01 * radius && (quarter.at_m[1] / radius - 1.0).abs() < 0.01, "{quarter:?}");
        let around = rolled(&PADDLE, ball, full, lean);
        assert!((around.at_m[0] / radius - 1.0).abs() < 0.01 && around.at_m[1].abs() < 0.01 * radius, "{around:?}");
    }

    #[test]
    fn on_a_turning_paddle_it_goes_out_along_the_turn_alone() {
        // about the axis that points left: x = x0 cosh kt, and what is on the axis stays
        let paddle = Paddle { inertia: 0.0, radius_m: 10.0, ..PADDLE };
        let k = 2.0_f64;
        let spun = Carried { turn: Turn::heading(0.0), spin: [0.0, k, 0.0], acceleration: [0.0; 3] };
        let ball = rolled(&paddle, Ball { at_m: [0.01, 0.02], ..AT_REST }, 1.0, |_| spun);
        assert!((ball.at_m[0] / (0.01 * k.cosh()) - 1.0).abs() < 1e-3 && ball.at_m[1] == 0.02, "{ball:?}");
    }

    #[test]
    fn carried_ahead_it_is_left_behind_and_falling_freely_it_stays() {
        let ahead = Carried { acceleration: [0.7, 0.0, 0.0], ..still(Turn::heading(0.0)) };
        let ball = rolled(&PADDLE, AT_REST, 1.0, |_| ahead);
        assert!((ball.at_m[0] / (-0.5 * 0.7 / 1.4) - 1.0).abs() < 2e-4 && ball.at_m[1] == 0.0, "{ball:?}");
        let falls = Carried { acceleration: [0.0, 0.0, -G], ..still(Turn::of([0.0, 0.2, 0.1])) };
        assert_eq!(rolled(&PADDLE, AT_REST, 1.0, |_| falls), AT_REST);
    }

    #[test]
    fn on_a_tilted_paddle_it_gains_what_it_falls() {
        let turn = Turn::of([0.3, 0.1, -0.07]);
        let height = |ball: &Ball| turn.out([ball.at_m[0], ball.at_m[1], 0.0])[2];
        let energy = |ball: &Ball| {
            let [u, v] = ball.speed_m_s;
            0.5 * 1.4 * (u * u + v * v) + G * height(ball)
        };
        let begun = Ball { at_m: [0.01, -0.02], speed_m_s: [0.1, 0.05] };
        let ended = rolled(&PADDLE, begun, 1.0, |_| still(turn));
        let fallen = G * (height(&begun) - height(&ended));
        assert!(fallen > 0.3 && (energy(&ended) - energy(&begun)).abs() < 1e-3 * fallen, "{ended:?} {fallen}");
    }

    #[test]
    fn at_rest_it_weighs_and_no_more() {
        let force = Ball { at_m: [0.02, 0.01], ..AT_REST }.roll(&PADDLE, &still(Turn::heading(0.0)), DT_S);
        assert_eq!(force, [0.0, 0.0, -PADDLE.ball_kg * G]);
        // rolling down it is held back by c/(1 + c) of what draws it along the slope, and by all that draws it across
        let (angle, mut ball) = (0.1_f64, AT_REST);
        let turn = Turn::of([0.0, angle, 0.0]);
        let force = ball.roll(&PADDLE, &still(turn), DT_S);
        let (along, across) = (dot(force, turn.out([1.0, 0.0, 0.0])), dot(force, turn.out([0.0, 0.0, 1.0])));
        let weight = PADDLE.ball_kg * G;
        assert!((along - weight * angle.sin() * 0.4 / 1.4).abs() < 1e-12, "{along}");
        assert!((across + weight * angle.cos()).abs() < 1e-12, "{across}");
    }

    #[test]
    fn rolling_resistance_stops_it_and_holds_it() {
        let paddle = Paddle { rolling: 0.01, ..PADDLE };
        let level = |_| still(Turn::heading(0.0));
        let stopped = rolled(&paddle, Ball { speed_m_s: [0.03, -0.04], ..AT_REST }, 3.0, level);
        assert_eq!(stopped.speed_m_s, [0.0; 2]);
        let exact = 0.05 * 0.05 * 1.4 / (2.0 * 0.01 * G);
        assert!((stopped.off_m() / exact - 1.0).abs() < 0.01, "{stopped:?} {exact}");
        assert!((stopped.at_m[0] / stopped.at_m[1] + 0.75).abs() < 1e-9, "straight ahead: {stopped:?}");
        let on = |angle: f64| rolled(&paddle, AT_REST, 1.0, |_| still(Turn::of([0.0, angle, 0.0])));
        assert_eq!(on(0.0099), AT_REST, "a slope less than it");
        assert!(on(0.0101).at_m[0] > 0.0);
    }
}
