//! A robot program: a torso with two arms balances a ball on the paddle in its right hand, lifts and lowers it all the while, and waves with its left.
//!
//! ```text
//! sinew demo torso                                       # the driver, the torso, and this program, which is in `sinew` too
//! cargo run -p sinew-ipc --example torso < /dev/ttyACM0  # with potentiometers and a camera of your own
//! ```
//!
//! It reads a line for each picture of the camera: eight angles, as the potentiometers had them then, and where the ball is on the paddle, ahead of
//! its middle and to the left, `NaN` where the camera sees none:
//!
//! ```text
//! right_shoulder_deg: 0.312 … left_roll_deg: -1.203 ahead_mm: 12.340 left_mm: -3.210
//! ```
//!
//! The driver's laws hold the wires' lengths, and this program says which. How the paddle is tilted is the sum of what shoulder, elbow and wrist are
//! turned by: the wrist makes up for the arm, wherever that is. It knows what its builder has measured: the lever, where the joints are
//! level, how a ball rolls. It sees nothing else.

use std::error::Error;
use std::f64::consts::TAU;
use std::io::BufRead;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use sinew_ipc::{Client, CommandKind, Wanted};

/// The wires, as the rig file calls them.
pub const WIRES: [&str; WIRE_COUNT] = [
    "right_shoulder",
    "right_elbow",
    "right_pitch",
    "right_roll",
    "left_shoulder",
    "left_elbow",
    "left_pitch",
    "left_roll",
];
const WIRE_COUNT: usize = 8;
/// Lever they pull at, m.
const LEVER_M: f64 = 0.015;
/// Stroke at which a joint is level: what is wrong with it the potentiometers tell.
const LEVEL: f64 = 0.5;
/// Strokes that are asked for: the ends of the way are slow.
const STROKES: [f64; 2] = [0.08, 0.92];
/// Acceleration of a solid ball down a slope, m/s² per rad: 5/7 g.
const ROLLS: f64 = 5.0 / 7.0 * 9.80665;
/// Between two pictures, s.
const PICTURE_S: f64 = 0.02;
/// The ball's motion is to swing in so fast, rad/s, with this damping …
const SWING_RAD_S: f64 = 4.0;
const DAMPING: f64 = 0.9;
/// … from where it will be so much later, s: a picture is old, and a wire takes its time.
const AHEAD_S: f64 = 0.08;
/// The most the paddle is tilted, rad.
const MOST_TILT_RAD: f64 = 0.12;
/// Share of a surprise that is believed of place and speed, and of what the potentiometers of the arm say.
const BELIEVES: [f64; 2] = [0.3, 0.03];
const BELIEVES_ARM: f64 = 0.1;
/// A joint that is not where it was asked to be is asked for more, at this rate, 1/s, and by no more than this, rad.
const TRIM_PER_S: f64 = 0.5;
const MOST_TRIM_RAD: f64 = 0.05;
/// What the arms do besides: by so much, rad, in so much time, s.
const LIFTS_RAD: [f64; 2] = [0.03, 0.04];
const LIFTS_IN_S: f64 = 15.0;
const WAVES_RAD: [f64; 4] = [0.1, 0.15, 0.0, 0.1];
const WAVES_IN_S: f64 = 8.0;
/// The camera says nothing for so long: everything stays where it is.
const SILENCE: Duration = Duration::from_millis(300);
/// How long a setpoint holds: if this program dies, the wires go off so much later, and the arms sink.
const LEASE: Duration = Duration::from_millis(500);

/// Runs it as a program of its own.
#[allow(dead_code, reason = "`sinew demo` calls `run`")]
fn main() {
    let rig = std::env::args().nth(1).unwrap_or_else(|| "torso".into());
    if let Err(error) = run(&rig) {
        eprintln!("torso: {error}");
        std::process::exit(1);
    }
}

/// Balances the ball of this rig until the camera's lines end.
pub fn run(rig: &str) -> Result<(), Box<dyn Error>> {
    let client = Client::connect(rig)?;
    let (mut channels, mut travels_m) = ([0; WIRE_COUNT], [0.0; WIRE_COUNT]);
    for (place, name) in WIRES.into_iter().enumerate() {
        let channel = client.channel(name)?;
        let wire = &client.channels()[channel];
        (channels[place], travels_m[place]) = (channel as u32, wire.cold_length_m - wire.hot_length_m);
    }
    let mut torso = Torso::new(travels_m);

    // Lines are read by a thread of their own: a camera that says nothing must not keep this program from noticing.
    let (seen, sees) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let numbers = line.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
            let Ok(said) = <[f64; WIRE_COUNT + 2]>::try_from(numbers.collect::<Vec<_>>()) else { continue };
            if seen.send(said).is_err() {
                return;
            }
        }
    });
    loop {
        let strokes = match sees.recv_timeout(SILENCE) {
            Ok(said) => torso.sees(said),
            Err(RecvTimeoutError::Timeout) => torso.strokes(),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        let wanted = channels.into_iter().zip(strokes);
        let wanted = wanted.map(|(channel, value)| Wanted { channel, kind: CommandKind::Stroke, value });
        client.set_many(&wanted.collect::<Vec<_>>(), LEASE)?;
    }
    for wire in WIRES {
        client.off(wire)?;
    }
    Ok(())
}

/// What this program knows, and what it asks for.
pub struct Torso {
    /// Stroke of each wire for a rad of its joint.
    strokes_per_rad: [f64; WIRE_COUNT],
    /// Since the first picture, s.
    time_s: f64,
    /// By how much more than was wanted the right arm turns the paddle before the wrist does, rad.
    strays_rad: f64,
    /// Ahead and to the left.
    ball: Option<[Rolling; 2]>,
    /// The angles that the joints are to have, and what is asked for more than that, rad.
    wanted_rad: [f64; WIRE_COUNT],
    trim_rad: [f64; WIRE_COUNT],
}

/// What is known of the ball in one direction.
#[derive(Clone, Copy)]
struct Rolling {
    at_m: f64,
    speed_m_s: f64,
}

impl Torso {
    /// Of wires that have these ways from cold to hot, m.
    pub fn new(travels_m: [f64; WIRE_COUNT]) -> Torso {
        Torso {
            strokes_per_rad: travels_m.map(|travel_m| LEVER_M / travel_m),
            time_s: 0.0,
            strays_rad: 0.0,
            ball: None,
            wanted_rad: [0.0; WIRE_COUNT],
            trim_rad: [0.0; WIRE_COUNT],
        }
    }

    /// The potentiometers say these angles, degrees, and the camera where the ball is, mm ahead and to the left, or not: the strokes to ask for.
    pub fn sees(&mut self, said: [f64; WIRE_COUNT + 2]) -> [f64; WIRE_COUNT] {
        let [angles @ .., ahead_mm, left_mm] = said;
        let angles_rad = angles.map(f64::to_radians);
        let [shoulder, elbow, pitch, roll, ..] = angles_rad;
        self.trim(&angles_rad);
        // that the arm is elsewhere than it was wanted changes slowly, what is wanted does not
        let strays_rad = shoulder + elbow - self.wanted_rad[0] - self.wanted_rad[1];
        self.strays_rad += BELIEVES_ARM * (strays_rad - self.strays_rad);

        let tilts_rad = [shoulder + elbow + pitch, roll];
        let tilts_rad = match ahead_mm.is_finite() {
            true => self.balance([ahead_mm, left_mm].map(|mm| mm * 1e-3), tilts_rad),
            // a level paddle is given a ball
            false => {
                self.ball = None;
                [0.0; 2]
            }
        };
        self.time_s += PICTURE_S;
        let lifts = (TAU * self.time_s / LIFTS_IN_S).sin();
        let waves = (TAU * self.time_s / WAVES_IN_S).sin();
        let [shoulder, elbow] = LIFTS_RAD.map(|most_rad| most_rad * lifts);
        let right = [shoulder, elbow, tilts_rad[0] - shoulder - elbow - self.strays_rad, tilts_rad[1]];
        let left = WAVES_RAD.map(|most_rad| most_rad * waves);
        self.wanted_rad = std::array::from_fn(|joint| if joint < 4 { right[joint] } else { left[joint - 4] });
        self.strokes()
    }

    /// The strokes it asks for.
    pub fn strokes(&self) -> [f64; WIRE_COUNT] {
        std::array::from_fn(|joint| {
            let angle_rad = self.wanted_rad[joint] + self.trim_rad[joint];
            (LEVEL + angle_rad * self.strokes_per_rad[joint]).clamp(STROKES[0], STROKES[1])
        })
    }

    /// Asks for more where a joint is not where it was wanted.
    fn trim(&mut self, angles_rad: &[f64; WIRE_COUNT]) {
        for ((trim, wanted), is) in self.trim_rad.iter_mut().zip(self.wanted_rad).zip(angles_rad) {
            let more = TRIM_PER_S * PICTURE_S * (wanted - is);
            *trim = (*trim + more).clamp(-MOST_TRIM_RAD, MOST_TRIM_RAD);
        }
    }

    /// The tilts, up ahead and to the right, that bring the ball to the middle, rad, where it is seen at this place, m, with the paddle tilted like this.
    fn balance(&mut self, seen_m: [f64; 2], tilted_rad: [f64; 2]) -> [f64; 2] {
        let ball = self.ball.get_or_insert(seen_m.map(|at_m| Rolling { at_m, speed_m_s: 0.0 }));
        std::array::from_fn(|way| ball[way].sees(seen_m[way], tilted_rad[way]))
    }
}

impl Rolling {
    /// Seen here on a slope, m and rad: the slope it is to have.
    fn sees(&mut self, seen_m: f64, tilted_rad: f64) -> f64 {
        // where it should be by now, and what of the difference is believed
        let speed_m_s = self.speed_m_s - PICTURE_S * ROLLS * tilted_rad;
        let at_m = self.at_m + PICTURE_S * 0.5 * (self.speed_m_s + speed_m_s);
        let surprise_m = seen_m - at_m;
        self.at_m = at_m + BELIEVES[0] * surprise_m;
        self.speed_m_s = speed_m_s + BELIEVES[1] / PICTURE_S * surprise_m;

        let speed_m_s = self.speed_m_s - AHEAD_S * ROLLS * tilted_rad;
        let at_m = self.at_m + AHEAD_S * self.speed_m_s;
        let wanted = SWING_RAD_S * SWING_RAD_S * at_m + 2.0 * DAMPING * SWING_RAD_S * speed_m_s;
        (wanted / ROLLS).clamp(-MOST_TILT_RAD, MOST_TILT_RAD)
    }
}
