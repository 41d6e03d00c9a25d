//! A torso with two alike arms of four joints: shoulder, elbow, and the pitch and the roll of a wrist. In its right hand lies a paddle, and on that
//! a ball.
//!
//! Shoulder, elbow and pitch turn about axes that point to the left, upwards where their wires are shorter; the roll about the hand's own, to the
//! right. With q their angles from where the strokes are level the hand is turned by
//!
//! ```text
//! R = R_y(−(q_shoulder + q_elbow + q_pitch)) R_x(q_roll)
//! ```
//!
//! and the wrist's axes cross in the middle of the paddle. Arms, paddle and ball weigh on the joints: τ = Σ (∂p/∂q) · F over all that weighs, which
//! their wires have to hold besides their own loads. Left out: that joints drive each other by their inertia, which is each wire's own load.

mod paddle;

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2 as G;
use sinew_rig::Demonstrator;

use crate::arm::{Links, Tip};
use crate::chance::Noise;
use crate::space::{Turn, Vector, cross, difference, dot, sum, times};

use paddle::{Ball, Carried, Paddle};

/// Joints of an arm …
pub(crate) const ARM_JOINTS: usize = 4;
/// … and of both, the right one's first.
pub(crate) const TORSO_JOINTS: usize = 2 * ARM_JOINTS;

/// The wires of the right wrist among them: those that the paddle is tilted by.
pub(crate) const RIGHT_WRIST: [usize; 2] = [2, 3];

/// About which shoulder, elbow and pitch turn upwards.
const UPWARDS: Vector = [0.0, -1.0, 0.0];

/// What a joint does: its angle, rad, and how fast it turns, rad/s.
pub(crate) type Joint = (f64, f64);

/// One arm, from its shoulder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arm {
    links: Links,
    /// Of upper arm and forearm, each in its middle, and of what the hand holds, kg.
    masses_kg: [f64; 3],
}

/// Where an arm is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reached {
    pub elbow_m: Vector,
    pub wrist_m: Vector,
    /// How its hand is turned.
    pub turn: Turn,
}

impl Arm {
    /// The right one and the left one of a rig file.
    pub fn both(declared: &Demonstrator) -> [Arm; 2] {
        let Demonstrator { upper_link_kg, lower_link_kg, paddle_kg, .. } = *declared;
        [paddle_kg, 0.0]
            .map(|held_kg| Arm { links: Links::of(declared), masses_kg: [upper_link_kg, lower_link_kg, held_kg] })
    }

    /// How far it reaches, m.
    pub fn reach_m(&self) -> f64 {
        self.links.reach_m()
    }

    /// Where it is with its joints at these angles, rad.
    pub fn reached(&self, [shoulder, elbow, pitch, roll]: [f64; ARM_JOINTS]) -> Reached {
        let Tip { elbow_m, at_m, .. } = self.links.tip([shoulder, elbow]);
        let beside = |[ahead, up]: [f64; 2]| [ahead, 0.0, up];
        Reached {
            elbow_m: beside(elbow_m),
            wrist_m: beside(at_m),
            turn: Turn::of([0.0, -(shoulder + elbow + pitch), roll]),
        }
    }

    /// How its own weight turns its joints, N m.
    pub fn weighs_n_m(&self, angles_rad: [f64; ARM_JOINTS]) -> [f64; ARM_JOINTS] {
        let reached = self.reached(angles_rad);
        let Reached { elbow_m, wrist_m, .. } = reached;
        let places = [times(0.5, elbow_m), times(0.5, sum(elbow_m, wrist_m)), wrist_m];
        let mut torques = [0.0; ARM_JOINTS];
        for (place, (mass_kg, at_m)) in self.masses_kg.into_iter().zip(places).enumerate() {
            let weighs = reached.torques_n_m(at_m, [0.0, 0.0, -mass_kg * G]);
            // what is in the upper arm does not turn with the elbow, and nothing of this is beside the wrist's axes
            for (torque, weighs) in torques.iter_mut().zip(weighs).take(if place == 0 { 1 } else { 2 }) {
                *torque += weighs;
            }
        }
        torques
    }
}

impl Reached {
    /// How a force on its hand at a place, N and m from the shoulder, turns its joints, N m.
    fn torques_n_m(&self, at_m: Vector, force_n: Vector) -> [f64; ARM_JOINTS] {
        let about = |pivot_m: Vector, axis: Vector| dot(axis, cross(difference(at_m, pivot_m), force_n));
        [
            about([0.0; 3], UPWARDS),
            about(self.elbow_m, UPWARDS),
            about(self.wrist_m, UPWARDS),
            about(self.wrist_m, self.turn.out([1.0, 0.0, 0.0])),
        ]
    }

    /// How fast its wrist moves, m/s, and its hand turns, rad/s, in its own directions, when its joints turn so fast, rad/s.
    fn moves(&self, [shoulder, elbow, pitch, roll]: [f64; ARM_JOINTS]) -> (Vector, Vector) {
        let about = |pivot_m: Vector, rate: f64| cross(times(rate, UPWARDS), difference(self.wrist_m, pivot_m));
        let speed = sum(about([0.0; 3], shoulder), about(self.elbow_m, elbow));
        let spin = sum(self.turn.back(times(shoulder + elbow + pitch, UPWARDS)), [roll, 0.0, 0.0]);
        (speed, spin)
    }

    /// How far its hand is from level, rad.
    pub fn leans_rad(&self) -> f64 {
        self.turn.out([0.0, 0.0, 1.0])[2].clamp(-1.0, 1.0).acos()
    }
}

/// One of a rig file.
#[derive(Debug)]
pub(crate) struct Torso {
    arms: [Arm; 2],
    paddle: Paddle,
    /// So far from the middle a hand puts the ball down, m.
    start_m: f64,
    ball: Option<Ball>,
    /// How fast the paddle's middle moved in the last period, m/s.
    moved_m_s: Option<Vector>,
    whim: Noise,
}

impl Torso {
    /// Of a rig file, its paddle empty.
    pub fn new(declared: &Demonstrator, seed: u64) -> Torso {
        Torso {
            arms: Arm::both(declared),
            paddle: Paddle::of(declared),
            start_m: declared.start_m,
            ball: None,
            moved_m_s: None,
            whim: Noise::new(seed, 5),
        }
    }

    /// Where the ball is, from the middle of the paddle, ahead and to the left, m; NaN where there is none.
    pub fn ball_m(&self) -> [f64; 2] {
        self.ball.map_or([f64::NAN; 2], |ball| ball.at_m)
    }

    /// How far it is from the middle, m, while one is on the paddle or just beside it.
    pub fn off_m(&self) -> Option<f64> {
        self.ball.map(|ball| ball.off_m())
    }

    /// Whether it is beside the paddle.
    pub fn has_dropped(&self) -> bool {
        self.off_m().is_some_and(|off_m| off_m > self.paddle.radius_m)
    }

    /// Nothing lies on the paddle any more.
    pub fn take_ball(&mut self) {
        self.ball = None;
    }

    /// A ball lies on it, at rest, in a direction by chance.
    pub fn put_ball(&mut self) {
        let (sin, cos) = (std::f64::consts::TAU * self.whim.even()).sin_cos();
        self.ball = Some(Ball { at_m: [self.start_m * cos, self.start_m * sin], speed_m_s: [0.0; 2] });
    }

    /// How far the paddle is from level, rad.
    pub fn leans_rad(&self, joints: &[Joint; TORSO_JOINTS]) -> f64 {
        let [right, _] = arms_of(&joints.map(|(angle, _)| angle));
        self.arms[0].reached(right).leans_rad()
    }

    /// Lets a period pass with its joints like this: how weight turns each of them, N m.
    pub fn pass(&mut self, joints: &[Joint; TORSO_JOINTS], period_s: f64) -> [f64; TORSO_JOINTS] {
        let angles = arms_of(&joints.map(|(angle, _)| angle));
        let [rates, _] = arms_of(&joints.map(|(_, rate)| rate));
        let mut weigh = [0.0; TORSO_JOINTS];
        for ((weigh, arm), angles) in weigh.chunks_exact_mut(ARM_JOINTS).zip(&self.arms).zip(angles) {
            weigh.copy_from_slice(&arm.weighs_n_m(angles));
        }
        let reached = self.arms[0].reached(angles[0]);
        let (moves_m_s, spin) = reached.moves(rates);
        let moved_m_s = self.moved_m_s.replace(moves_m_s).unwrap_or(moves_m_s);
        if let Some(ball) = &mut self.ball {
            let acceleration = times(1.0 / period_s, difference(moves_m_s, moved_m_s));
            let [ahead, left] = ball.at_m;
            let at_m = sum(reached.wrist_m, reached.turn.out([ahead, left, 0.0]));
            let force = ball.roll(&self.paddle, &Carried { turn: reached.turn, spin, acceleration }, period_s);
            for (weigh, torque) in weigh.iter_mut().zip(reached.torques_n_m(at_m, force)) {
                *weigh += torque;
            }
        }
        weigh
    }
}

/// What is of each arm.
pub(crate) fn arms_of(all: &[f64; TORSO_JOINTS]) -> [[f64; ARM_JOINTS]; 2] {
    std::array::from_fn(|arm| std::array::from_fn(|joint| all[ARM_JOINTS * arm + joint]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn declared() -> Demonstrator {
        Demonstrator {
            upper_link_m: 0.2,
            lower_link_m: 0.17,
            shoulder_rad: -95.0_f64.to_radians(),
            elbow_rad: 95.0_f64.to_radians(),
            upper_link_kg: 0.01,
            lower_link_kg: 0.008,
            paddle_kg: 0.008,
            paddle_radius_m: 0.08,
            ball_kg: 0.003,
            ball_inertia: 0.4,
            rolling_resistance: 0.0,
            start_m: 0.03,
            ..sinew_rig::Rig::parse(crate::TORSO, "torso.toml").unwrap().demonstrator
        }
    }

    fn near(a: Vector, b: Vector, within: f64) -> bool {
        (0..3).all(|axis| (a[axis] - b[axis]).abs() < within)
    }

    #[test]
    fn a_hand_is_turned_by_all_the_joints_before_it() {
        let [arm, _] = Arm::both(&declared());
        let level = arm.reached([0.0; 4]);
        let exact = [0.2 * (-95.0_f64).to_radians().cos() + 0.17, 0.0, 0.2 * (-95.0_f64).to_radians().sin()];
        assert!(near(level.wrist_m, exact, 1e-12) && level.leans_rad() < 1e-7, "{level:?}");
        // worked out by hand: after a roll to the right by r and a pitch upwards by p the hand's left is (sin p sin r, cos r, −cos p sin r), its
        // upright (−sin p cos r, sin r·−1, cos p cos r)
        let (p, r) = (0.06 - 0.1 + 0.2_f64, 0.15_f64);
        let turn = arm.reached([0.06, -0.1, 0.2, r]).turn;
        assert!(near(turn.out([1.0, 0.0, 0.0]), [p.cos(), 0.0, p.sin()], 1e-12));
        assert!(near(turn.out([0.0, 1.0, 0.0]), [-p.sin() * r.sin(), r.cos(), p.cos() * r.sin()], 1e-12));
        assert!(near(turn.out([0.0, 0.0, 1.0]), [-p.sin() * r.cos(), -r.sin(), p.cos() * r.cos()], 1e-12));
    }

    #[test]
    fn what_weighs_turns_the_joints_by_the_work_it_does() {
        let angles = [0.1, -0.15, 0.12, 0.2];
        let force = [0.02, -0.01, -0.03];
        let on_paddle = [0.03, -0.02, 0.0];
        for arm in Arm::both(&declared()) {
            let at = |angles| {
                let reached = arm.reached(angles);
                sum(reached.wrist_m, reached.turn.out(on_paddle))
            };
            let height = |angles| {
                let Reached { elbow_m, wrist_m, .. } = arm.reached(angles);
                let [upper, lower, held] = arm.masses_kg;
                0.5 * upper * elbow_m[2] + 0.5 * lower * (elbow_m[2] + wrist_m[2]) + held * wrist_m[2]
            };
            let torques = arm.reached(angles).torques_n_m(at(angles), force);
            let weighs = arm.weighs_n_m(angles);
            for joint in 0..ARM_JOINTS {
                let moved = |by: f64| {
                    let mut angles = angles;
                    angles[joint] += by;
                    angles
                };
                let work = dot(force, difference(at(moved(1e-6)), at(moved(-1e-6)))) / 2e-6;
                assert!((work - torques[joint]).abs() < 1e-10, "joint {joint}: {work} {}", torques[joint]);
                let falls = -G * (height(moved(1e-6)) - height(moved(-1e-6))) / 2e-6;
                assert!((falls - weighs[joint]).abs() < 1e-9, "joint {joint}: {falls} {}", weighs[joint]);
            }
        }
    }

    #[test]
    fn how_a_hand_moves_is_how_its_place_changes() {
        let [arm, _] = Arm::both(&declared());
        let (angles, rates) = ([0.1, -0.15, 0.12, 0.2], [0.5, -0.3, 0.8, -0.6]);
        let after = |t: f64| arm.reached(std::array::from_fn(|joint| angles[joint] + t * rates[joint]));
        let (speed, spin) = arm.reached(angles).moves(rates);
        let [before, later] = [after(-1e-6), after(1e-6)];
        assert!(near(speed, times(5e5, difference(later.wrist_m, before.wrist_m)), 1e-8), "{speed:?}");
        let corner = [0.3, -0.2, 0.1];
        let moved = times(5e5, difference(later.turn.out(corner), before.turn.out(corner)));
        assert!(near(arm.reached(angles).turn.out(cross(spin, corner)), moved, 1e-8), "{spin:?}");
    }

    #[test]
    fn the_ball_gains_what_the_joints_lose() {
        // All four joints swing while the ball rolls. Its energy changes by the work of the joints against it, to which belongs what the reaction leaves
        // out: that it is carried along, m (a + ω̇ × ρ).
        let declared = declared();
        let [arm, _] = Arm::both(&declared);
        let mut torso = Torso::new(&declared, 1);
        torso.put_ball();
        let dt_s = 2e-5;
        let joints = |t: f64| -> [Joint; 4] {
            [(0.1, 3.0), (0.08, 2.3), (0.1, 4.0), (0.12, 3.3)]
                .map(|(most, w): (f64, f64)| (most * (w * t).sin(), most * w * (w * t).cos()))
        };
        let split = |t: f64| {
            let both = joints(t);
            (both.map(|(angle, _)| angle), both.map(|(_, rate)| rate))
        };
        let energy = |ball: &Ball, t: f64| {
            let (angles, rates) = split(t);
            let reached = arm.reached(angles);
            let (speed, spin) = reached.moves(rates);
            let ([x, y], [u, v]) = (ball.at_m, ball.speed_m_s);
            let own = sum([u, v, 0.0], cross(spin, [x, y, 0.0]));
            let over = sum(speed, reached.turn.out(own));
            let up = sum(reached.wrist_m, reached.turn.out([x, y, 0.0]))[2];
            0.003 * (0.5 * dot(over, over) + 0.5 * 0.4 * (u * u + v * v) + G * up)
        };
        let (mut work, before) = (0.0, energy(&torso.ball.unwrap(), 0.0));
        for step in 0..50_000 {
            let t = (f64::from(step) + 0.5) * dt_s;
            let (angles, rates) = split(t);
            let reached = arm.reached(angles);
            let changes = |t: f64| {
                let (angles, rates) = split(t);
                arm.reached(angles).moves(rates)
            };
            let ((speed0, spin0), (speed1, spin1)) = (changes(t - 0.5 * dt_s), changes(t + 0.5 * dt_s));
            let per = 1.0 / dt_s;
            let [x, y] = torso.ball.unwrap().at_m;
            let carried = sum(
                times(per, difference(speed1, speed0)),
                reached.turn.out(cross(times(per, difference(spin1, spin0)), [x, y, 0.0])),
            );
            let at_m = sum(reached.wrist_m, reached.turn.out([x, y, 0.0]));
            let with_it = reached.torques_n_m(at_m, times(-0.003, carried));
            let mut all = [(0.0, 0.0); 8];
            all[..4].copy_from_slice(&joints(t));
            let weighs = torso.pass(&all, dt_s);
            let own = arm.weighs_n_m(angles);
            for joint in 0..4 {
                work -= (weighs[joint] - own[joint] + with_it[joint]) * rates[joint] * dt_s;
            }
        }
        let gained = energy(&torso.ball.unwrap(), 1.0) - before;
        assert!(work.abs() > 1e-5 && (gained - work).abs() < 1e-3 * work.abs(), "{gained} {work}");
    }

    #[test]
    fn a_ball_is_put_down_as_far_out_as_declared_wherever_chance_has_it() {
        let mut torso = Torso::new(&declared(), 7);
        let mut quarters = [false; 4];
        for _ in 0..40 {
            torso.put_ball();
            let [ahead, left] = torso.ball_m();
            assert!((ahead.hypot(left) - 0.03).abs() < 1e-12);
            quarters[usize::from(ahead > 0.0) + 2 * usize::from(left > 0.0)] = true;
        }
        assert_eq!(quarters, [true; 4]);
        assert!(!torso.has_dropped());
        torso.ball = Some(Ball { at_m: [0.06, -0.06], speed_m_s: [0.0; 2] });
        assert!(torso.has_dropped(), "beside the edge, which is round");
    }
}
