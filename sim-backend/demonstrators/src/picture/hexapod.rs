//! A hexapod from above and, beside that, from its right; the ground passes beneath it.

use sinew_rig::Demonstrator;

use super::shapes::{Ink, Picture, Shape};
use crate::hexapod::{LEGS, Leg, Parts, Stance};
use crate::space::{Turn, Vector, sum};

/// From one mark on the ground to the next, m; each twentieth is a metre.
const MARK_M: f64 = 0.05;
const MARKS_A_METRE: f64 = 20.0;

/// What of a rig file there is to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drawn {
    legs: [Leg; LEGS],
    /// Half of the body's length and width, and how far its belly is below the hips, m.
    body_m: [f64; 3],
    /// Half of the width of either view, m.
    half_m: f64,
}

impl Drawn {
    pub fn of(declared: &Demonstrator) -> Drawn {
        let Demonstrator { leg_spacing_m, hip_width_m, belly_m, coxa_m, femur_m, tibia_m, .. } = *declared;
        Drawn {
            legs: Leg::all(declared),
            body_m: [leg_spacing_m, 0.5 * hip_width_m, belly_m],
            half_m: leg_spacing_m + 0.5 * (coxa_m + femur_m + tibia_m),
        }
    }

    pub fn draw(&self, stance: &Stance) -> Picture {
        let half = self.half_m;
        let mut shapes = Vec::new();
        self.ground(stance.at_m[0], [-stance.at_m[1], SIDE_FLOOR * half], &mut shapes);
        self.machine(stance, &mut shapes);
        let [heading, pitch, roll] = stance.turned_rad.map(f64::to_degrees);
        let feet = stance.stands.map(|stands| if stands { '●' } else { '○' });
        let says = format!(
            "{:.3} m ahead, {:+.0} mm left of its line, heading {heading:+.1}°, leans {:.1}°, feet {}",
            stance.at_m[0],
            stance.at_m[1] * 1e3,
            pitch.hypot(roll),
            feet.iter().collect::<String>()
        );
        Picture { shapes, half_size: [2.0 * half, 0.95 * half], says }
    }

    /// The line it is to follow, from above, and the ground, from the side, each at a height of the picture, with marks that stay where they are.
    fn ground(&self, ahead_m: f64, heights: [f64; 2], shapes: &mut Vec<Shape>) {
        let half = self.half_m;
        let width = 0.01 * half;
        for (middle, height) in [-half, half].into_iter().zip(heights) {
            let across = |x: f64, below: f64, above: f64, ink| Shape::Line {
                from: [middle + x, height - below],
                to: [middle + x, height + above],
                width,
                ink,
            };
            let [from, to] = [[middle - 0.95 * half, height], [middle + 0.95 * half, height]];
            shapes.push(Shape::Line { from, to, width, ink: Ink::Frame });
            let mut mark = ((ahead_m - 0.95 * half) / MARK_M).ceil();
            while mark * MARK_M - ahead_m < 0.95 * half {
                let x = mark * MARK_M - ahead_m;
                let is_metre = mark % MARKS_A_METRE == 0.0;
                shapes.push(match is_metre {
                    true => across(x, 0.12 * half, 0.12 * half, Ink::Goal),
                    false => across(x, 0.04 * half, 0.0, Ink::Frame),
                });
                mark += 1.0;
            }
        }
    }

    fn machine(&self, stance: &Stance, shapes: &mut Vec<Shape>) {
        let half = self.half_m;
        let turn = Turn::of(stance.turned_rad);
        let up_m = stance.at_m[2];
        let above = |place: Vector| {
            let [ahead, left, _] = turn.out(place);
            [ahead - half, left]
        };
        let beside = |place: Vector| {
            let [ahead, _, up] = turn.out(place);
            [ahead + half, SIDE_FLOOR * half + up_m + up]
        };
        let views: [&dyn Fn(Vector) -> [f64; 2]; 2] = [&above, &beside];
        let [length, width, belly] = self.body_m;
        for place in views {
            let line = |from, to, share: f64| Shape::Line {
                from: place(from),
                to: place(to),
                width: share * half,
                ink: Ink::Body,
            };
            // the left legs are behind the body, seen from the right
            let legs = self
                .legs
                .iter()
                .zip(stance.angles_rad)
                .zip(stance.stands)
                .map(|((leg, angles), stands)| (leg.parts(angles), stands));
            for (Parts { hip, coxa, knee, foot }, stands) in legs {
                shapes.extend([line(hip, coxa, 0.02), line(coxa, knee, 0.03), line(knee, foot, 0.02)]);
                let ink = if stands { Ink::Load } else { Ink::Frame };
                shapes.push(Shape::Disc { at: place(foot), radius: 0.035 * half, ink });
            }
            let corner = |ahead: f64, left: f64| [ahead * length, left * width, 0.0];
            let corners = [corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0), corner(-1.0, 1.0)];
            for (index, from) in corners.into_iter().enumerate() {
                shapes.push(line(from, corners[(index + 1) % corners.len()], 0.03));
                let below = [0.0, 0.0, -belly];
                shapes.push(line(sum(from, below), sum(corners[(index + 1) % corners.len()], below), 0.03));
            }
            // where it looks
            shapes.push(line([length, 0.0, 0.0], [length + 0.5 * width, 0.0, 0.0], 0.03));
        }
    }
}

/// Where the ground is in the view from the side, over half of its width.
const SIDE_FLOOR: f64 = -0.3;
