//! What a machine looks like, for whoever draws it: straight lines and discs, in metres.

mod hexapod;
mod shapes;
mod torso;

use sinew_rig::Demonstrator;

use crate::arm::{Links, Tip};
use crate::pose::Pose;

pub use shapes::{Ink, Picture, Shape};

/// What of a rig file there is to draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drawn {
    lever_m: f64,
    half_beam_m: f64,
    links: Links,
    walking: hexapod::Drawn,
    torso: torso::Drawn,
}

/// Radius of a ball in a picture, share of half the beam.
const BALL: f64 = 0.05;

impl Drawn {
    pub fn of(declared: &Demonstrator) -> Drawn {
        let Demonstrator { lever_m, half_beam_m, .. } = *declared;
        let (walking, torso) = (hexapod::Drawn::of(declared), torso::Drawn::of(declared));
        Drawn { lever_m, half_beam_m, links: Links::of(declared), walking, torso }
    }

    /// The picture of a pose, in this draught.
    pub fn draw(&self, pose: &Pose, draught: f64) -> Picture {
        let mut picture = match *pose {
            Pose::Beam { angle_rad, ball_m } => self.beam(angle_rad, ball_m),
            Pose::Servo { angle_rad, asked_rad } => self.servo(angle_rad, asked_rad),
            Pose::Arm { angles_rad, target_m } => self.arm(angles_rad, target_m),
            Pose::Hexapod(ref stance) => self.walking.draw(stance),
            Pose::Torso { ref angles_rad, ball_m } => self.torso.draw(angles_rad, ball_m),
        };
        if draught > 0.0 {
            picture.says += &format!(", draught {:+.0} %", draught * 100.0);
        }
        picture
    }

    fn beam(&self, angle_rad: f64, ball_m: f64) -> Picture {
        let half = self.half_beam_m;
        let (sin, cos) = angle_rad.sin_cos();
        let along = |x: f64, up: f64| [x * cos - up * sin, x * sin + up * cos];
        let radius = BALL * half;
        let foot = -0.35 * half;
        let hook = along(self.lever_m, 0.0);
        let mut shapes = vec![
            Shape::Line { from: [0.0, 0.0], to: [0.0, foot], width: 0.02 * half, ink: Ink::Frame },
            Shape::Line { from: [-0.3 * half, foot], to: [0.5 * half, foot], width: 0.02 * half, ink: Ink::Frame },
            // the wire hangs from above: shorter, it lifts
            Shape::Line { from: [hook[0], 0.55 * half], to: hook, width: 0.008 * half, ink: Ink::Wire },
            Shape::Line { from: along(-half, 0.0), to: along(half, 0.0), width: 0.025 * half, ink: Ink::Body },
            Shape::Line { from: along(0.0, 0.0), to: along(0.0, 0.06 * half), width: 0.012 * half, ink: Ink::Goal },
        ];
        let degrees = angle_rad.to_degrees();
        let says = if ball_m.is_finite() {
            let lift = radius + 0.0125 * half;
            shapes.push(Shape::Disc { at: along(ball_m, lift), radius, ink: Ink::Load });
            format!("ball {:+.1} mm, beam {degrees:+.1}°", ball_m * 1e3)
        } else {
            format!("the ball waits for a level beam, now at {degrees:+.1}°")
        };
        Picture { shapes, half_size: [1.1 * half, 0.6 * half], says }
    }

    fn servo(&self, angle_rad: f64, asked_rad: f64) -> Picture {
        // twice as long as its lever: what one sees is the horn
        let horn = 2.0 * self.lever_m;
        let tip = |angle: f64, share: f64| [share * horn * angle.sin(), share * horn * angle.cos()];
        let shapes = vec![
            Shape::Disc { at: [0.0, 0.0], radius: 0.25 * horn, ink: Ink::Frame },
            Shape::Line { from: tip(asked_rad, 1.02), to: tip(asked_rad, 1.2), width: 0.04 * horn, ink: Ink::Goal },
            Shape::Line { from: [0.0, 0.0], to: tip(angle_rad, 1.0), width: 0.12 * horn, ink: Ink::Body },
        ];
        let says = format!("{:+.1}° of {:+.1}° that are asked for", angle_rad.to_degrees(), asked_rad.to_degrees());
        Picture { shapes, half_size: [1.6 * horn, 1.3 * horn], says }
    }

    fn arm(&self, angles_rad: [f64; 2], target_m: [f64; 2]) -> Picture {
        let reach = self.links.reach_m();
        let Tip { elbow_m, at_m, .. } = self.links.tip(angles_rad);
        // the arm reaches up and to the right: the picture's middle lies there
        let placed = |[x, y]: [f64; 2]| [x - 0.4 * reach, y - 0.45 * reach];
        let link = |from, to| Shape::Line { from: placed(from), to: placed(to), width: 0.03 * reach, ink: Ink::Body };
        let joint = |at| Shape::Disc { at: placed(at), radius: 0.03 * reach, ink: Ink::Frame };
        let shapes = vec![
            Shape::Line {
                from: placed([-0.15 * reach, 0.0]),
                to: placed([0.15 * reach, 0.0]),
                width: 0.02 * reach,
                ink: Ink::Frame,
            },
            Shape::Disc { at: placed(target_m), radius: 0.035 * reach, ink: Ink::Load },
            link([0.0, 0.0], elbow_m),
            link(elbow_m, at_m),
            joint([0.0, 0.0]),
            joint(elbow_m),
            Shape::Disc { at: placed(at_m), radius: 0.012 * reach, ink: Ink::Goal },
        ];
        let off_m = (at_m[0] - target_m[0]).hypot(at_m[1] - target_m[1]);
        let [shoulder, elbow] = angles_rad.map(f64::to_degrees);
        let says = format!("{:.1} mm off its target, shoulder {shoulder:+.1}°, elbow {elbow:+.1}°", off_m * 1e3);
        Picture { shapes, half_size: [0.75 * reach, 0.55 * reach], says }
    }
}
