//! A torso from before it and, beside that, from its right; between them its paddle from above.

use sinew_rig::Demonstrator;

use super::shapes::{Ink, Picture, Shape};
use crate::space::{Vector, sum};
use crate::torso::{Arm, Reached, TORSO_JOINTS, arms_of};

/// What of a rig file there is to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drawn {
    arms: [Arm; 2],
    radius_m: f64,
    /// Half of the width of either view, m.
    half_m: f64,
}

/// Straight pieces that a paddle's edge is drawn with.
const PIECES: usize = 24;
/// Where a paddle from above is drawn, over half of a view's width from the middle, and its radius.
const ABOVE: [f64; 2] = [0.0, -0.5];
const ABOVE_RADIUS: f64 = 0.42;
/// Radius of the ball, over the paddle's.
const BALL: f64 = 0.1;

impl Drawn {
    pub fn of(declared: &Demonstrator) -> Drawn {
        let arms = Arm::both(declared);
        let radius_m = declared.paddle_radius_m;
        Drawn { arms, radius_m, half_m: 0.55 * (arms[0].reach_m() + radius_m) }
    }

    pub fn draw(&self, angles_rad: &[f64; TORSO_JOINTS], ball_m: [f64; 2]) -> Picture {
        let half = self.half_m;
        let mut shapes = Vec::new();
        let arms = arms_of(angles_rad);
        let [right, left] = [0, 1].map(|arm: usize| self.arms[arm].reached(arms[arm]));
        // it looks at whoever looks at it: its right is at the left
        let before = |[_, left, up]: Vector| [left - 1.15 * half, up + 0.3 * half];
        let beside = |[ahead, _, up]: Vector| [ahead + 0.85 * half, up + 0.3 * half];
        let views: [&dyn Fn(Vector) -> [f64; 2]; 2] = [&before, &beside];
        for place in views {
            self.body(place, &mut shapes);
            self.arm(place, &left, -1.0, &mut shapes);
            self.arm(place, &right, 1.0, &mut shapes);
            self.paddle(place, &right, ball_m, &mut shapes);
        }
        self.above(ball_m, &mut shapes);
        let [_, _, across] = right.turn.angles();
        let pitch = right.turn.out([1.0, 0.0, 0.0])[2].clamp(-1.0, 1.0).asin();
        let leans = format!("paddle {:+.1}° up, {:+.1}° to the right", pitch.to_degrees(), across.to_degrees());
        let says = if ball_m[0].is_finite() {
            let [ahead, left] = ball_m.map(|m| m * 1e3);
            format!("ball {ahead:+.1} mm ahead, {left:+.1} mm left, {leans}")
        } else {
            format!("the ball waits for a level paddle: {leans}")
        };
        Picture { shapes, half_size: [2.1 * half, 1.02 * half], says }
    }

    /// Where a shoulder is, to the left, m; −1 is the left one, as seen from before.
    fn shoulder_m(&self, side: f64) -> f64 {
        -0.32 * side * self.half_m
    }

    fn line(&self, place: &dyn Fn(Vector) -> [f64; 2], from: Vector, to: Vector, share: f64, ink: Ink) -> Shape {
        Shape::Line { from: place(from), to: place(to), width: share * self.half_m, ink }
    }

    /// Head, shoulders, trunk.
    fn body(&self, place: &dyn Fn(Vector) -> [f64; 2], shapes: &mut Vec<Shape>) {
        let half = self.half_m;
        let at = |left: f64, up: f64| [0.0, left * half, up * half];
        let line = |from, to, share| self.line(place, from, to, share, Ink::Frame);
        shapes.extend([
            line(at(-0.32, 0.0), at(0.32, 0.0), 0.05),
            line(at(-0.3, 0.0), at(-0.2, -0.75), 0.04),
            line(at(0.3, 0.0), at(0.2, -0.75), 0.04),
            line(at(-0.2, -0.75), at(0.2, -0.75), 0.05),
            line(at(0.0, -0.75), at(0.0, -1.15), 0.08),
            line(at(0.0, 0.0), at(0.0, 0.25), 0.06),
        ]);
        shapes.push(Shape::Disc { at: place(at(0.0, 0.36)), radius: 0.15 * half, ink: Ink::Frame });
    }

    fn arm(&self, place: &dyn Fn(Vector) -> [f64; 2], reached: &Reached, side: f64, shapes: &mut Vec<Shape>) {
        let half = self.half_m;
        let shoulder = [0.0, self.shoulder_m(side), 0.0];
        let [elbow, wrist] = [reached.elbow_m, reached.wrist_m].map(|place| sum(shoulder, place));
        // what pulls at an elbow runs along the upper arm
        let behind = [-0.05 * half, 0.0, 0.0];
        shapes.push(self.line(place, sum(shoulder, behind), sum(elbow, behind), 0.012, Ink::Wire));
        shapes.push(self.line(place, shoulder, elbow, 0.05, Ink::Body));
        shapes.push(self.line(place, elbow, wrist, 0.045, Ink::Body));
        for joint in [shoulder, elbow, wrist] {
            shapes.push(Shape::Disc { at: place(joint), radius: 0.04 * half, ink: Ink::Frame });
        }
        if side < 0.0 {
            // an empty hand, and its thumb
            let tip =
                |ahead: f64, left: f64, up: f64| sum(wrist, reached.turn.out([ahead * half, left * half, up * half]));
            shapes.push(self.line(place, wrist, tip(0.2, 0.0, 0.0), 0.05, Ink::Body));
            shapes.push(self.line(place, wrist, tip(0.08, 0.0, 0.1), 0.03, Ink::Body));
            shapes.push(self.line(place, tip(0.06, -0.08, 0.0), tip(0.06, 0.08, 0.0), 0.03, Ink::Body));
        }
    }

    fn paddle(&self, place: &dyn Fn(Vector) -> [f64; 2], reached: &Reached, ball_m: [f64; 2], shapes: &mut Vec<Shape>) {
        let wrist = sum([0.0, self.shoulder_m(1.0), 0.0], reached.wrist_m);
        let on = |[ahead, left]: [f64; 2], up: f64| sum(wrist, reached.turn.out([ahead, left, up]));
        for (from, to) in pieces(self.radius_m) {
            shapes.push(self.line(place, on(from, 0.0), on(to, 0.0), 0.03, Ink::Body));
        }
        if ball_m[0].is_finite() {
            let radius = BALL * self.radius_m;
            shapes.push(Shape::Disc { at: place(on(ball_m, radius)), radius, ink: Ink::Load });
        }
    }

    /// The paddle as the camera sees it: ahead is up.
    fn above(&self, ball_m: [f64; 2], shapes: &mut Vec<Shape>) {
        let half = self.half_m;
        let (scale, width) = (ABOVE_RADIUS * half / self.radius_m, 0.02 * half);
        let place = |[ahead, left]: [f64; 2]| [ABOVE[0] * half - scale * left, ABOVE[1] * half + scale * ahead];
        let line = |from, to, ink| Shape::Line { from: place(from), to: place(to), width, ink };
        shapes.extend(pieces(self.radius_m).map(|(from, to)| line(from, to, Ink::Body)));
        let mark = 0.12 * self.radius_m;
        shapes.push(line([-mark, 0.0], [mark, 0.0], Ink::Goal));
        shapes.push(line([0.0, -mark], [0.0, mark], Ink::Goal));
        if ball_m[0].is_finite() {
            shapes.push(Shape::Disc { at: place(ball_m), radius: scale * BALL * self.radius_m, ink: Ink::Load });
        }
    }
}

/// A circle of straight pieces.
fn pieces(radius_m: f64) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    let at = move |piece: usize| {
        let (sin, cos) = (std::f64::consts::TAU * piece as f64 / PIECES as f64).sin_cos();
        [radius_m * cos, radius_m * sin]
    };
    (0..PIECES).map(move |piece| (at(piece), at(piece + 1)))
}
