//! A robot program: walks a hexapod straight ahead, in a tripod gait, by the word of a compass.
//!
//! ```text
//! sinew demo walker                                      # the driver, the hexapod, and this program, which is in `sinew` too
//! cargo run -p sinew-ipc --example walker < /dev/ttyACM0 # with a compass of your own
//! ```
//!
//! It reads a line for each word of a compass with a level, `heading_deg: 4.9 leans_deg: 0.6`: where the machine looks, to the left of where it is
//! to go, and how far it leans. Where its feet are it knows from the lengths its builder has measured, and that the driver has the wires where they
//! were asked to be; how far it has come it reckons from its own steps.
//!
//! Legs of a tripod (front and rear of one side with the middle of the other) step together, the two tripods in turn. A wire shortens as
//! fast as it is heated and lengthens only as fast as it cools: so a leg swings forward by heating and takes the whole of the other tripod's step to
//! draw back, and a lifted foot has most of its step to come down.

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::io::BufRead;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use sinew_ipc::{Client, CommandKind, Wanted};

/// The wires, as the rig file calls them: coxa, femur and tibia of each leg, the left one of a row before the right one.
pub const WIRES: [&str; WIRE_COUNT] = [
    "front_left_coxa",
    "front_left_femur",
    "front_left_tibia",
    "front_right_coxa",
    "front_right_femur",
    "front_right_tibia",
    "middle_left_coxa",
    "middle_left_femur",
    "middle_left_tibia",
    "middle_right_coxa",
    "middle_right_femur",
    "middle_right_tibia",
    "rear_left_coxa",
    "rear_left_femur",
    "rear_left_tibia",
    "rear_right_coxa",
    "rear_right_femur",
    "rear_right_tibia",
];
const WIRE_COUNT: usize = 18;
/// Wires of a leg.
const JOINTS: usize = 3;

/// What its builder has measured: coxa, femur and tibia, m; how far the femur rises and the tibia leans outwards with their wires at [`LEVEL`], rad;
/// the lever of every wire, m.
const LENGTHS_M: [f64; JOINTS] = [0.012, 0.030, 0.050];
const FEMUR_RAD: f64 = 0.349;
const TIBIA_RAD: f64 = 0.175;
const LEVER_M: f64 = 0.010;
/// Stroke at which a joint's angle is zero, and those that are asked for: the ends of the way are slow.
const LEVEL: f64 = 0.5;
const STROKES: [f64; 2] = [0.06, 0.94];

/// Where a foot stands: so far outside of its hip and below it, m; and how high it is lifted.
const OUT_M: f64 = 0.049;
const BELOW_M: f64 = 0.041;
const LIFT_M: f64 = 0.006;
/// How far a foot draws back, m, in a step of this time, s.
const STROKE_M: f64 = 0.024;
const STEP_S: f64 = 1.2;
/// Of a leg's step: until when it is lifted, from when to when it swings, and from when it is set down.
const LIFTED: f64 = 0.3;
const SWINGS: [f64; 2] = [0.15, 0.6];
const SET_DOWN: f64 = 0.55;

/// Words of the compass a second.
const WORDS_HZ: f64 = 25.0;
/// Share of a word that is believed.
const BELIEVES: f64 = 0.05;
/// It is to look so much back to its line, rad for each m beside it, and no more than that, rad …
const TO_LINE_RAD_PER_M: f64 = 3.0;
const MOST_TO_LINE_RAD: f64 = 0.2;
/// … and turns by making one side's strokes longer and the other's shorter by this share, for each rad that it looks beside that.
const STEERS_PER_RAD: f64 = 3.0;
const MOST_STEERED: f64 = 0.4;
/// Before it begins it stands for so long, s; again where it leans by more than this, rad: somebody has to set it up.
const STANDS_S: f64 = 3.0;
const LIES_RAD: f64 = 0.4;
/// The compass says nothing for so long: it stops where it is.
const SILENCE: Duration = Duration::from_millis(300);
/// How long a setpoint holds: if this program dies, the wires go off so much later, and the legs' springs carry the body.
const LEASE: Duration = Duration::from_millis(500);

/// Runs it as a program of its own.
#[allow(dead_code, reason = "`sinew demo` calls `run`")]
fn main() {
    let rig = std::env::args().nth(1).unwrap_or_else(|| "walker".into());
    if let Err(error) = run(&rig) {
        eprintln!("walker: {error}");
        std::process::exit(1);
    }
}

/// Walks the hexapod of this rig until the compass' lines end.
pub fn run(rig: &str) -> Result<(), Box<dyn Error>> {
    let client = Client::connect(rig)?;
    let mut channels = [0; WIRE_COUNT];
    for (channel, wire) in channels.iter_mut().zip(WIRES) {
        *channel = client.channel(wire)? as u32;
    }
    let wire = &client.channels()[channels[0] as usize];
    let mut walk = Walk::new(wire.cold_length_m - wire.hot_length_m);

    // Lines are read by a thread of their own: a compass that says nothing must not keep this program from noticing.
    let (felt, feels) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let mut numbers = line.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
            let (Some(heading), Some(leans)) = (numbers.next(), numbers.next()) else { continue };
            if felt.send([heading, leans]).is_err() {
                return;
            }
        }
    });
    loop {
        let strokes = match feels.recv_timeout(SILENCE) {
            Ok(degrees) => walk.feels(degrees.map(f64::to_radians)),
            Err(RecvTimeoutError::Timeout) => walk.strokes(),
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
pub struct Walk {
    /// Stroke of a wire for each rad of its joint.
    stroke_per_rad: f64,
    /// So long it has stood, and so many steps it has gone since then.
    stood_s: f64,
    steps: f64,
    heading_rad: Option<f64>,
    /// How far it is to the left of its line, m, by its own reckoning.
    beside_m: f64,
    /// By what share the right side's strokes are longer and the left side's shorter: that turns it to the left.
    steered: f64,
}

impl Walk {
    /// Of wires that have this way from cold to hot, m.
    pub fn new(travel_m: f64) -> Walk {
        Walk {
            stroke_per_rad: LEVER_M / travel_m,
            stood_s: 0.0,
            steps: 0.0,
            heading_rad: None,
            beside_m: 0.0,
            steered: 0.0,
        }
    }

    /// The compass says where it looks, to the left, and the level how far it leans, rad: the strokes to ask for.
    pub fn feels(&mut self, [heading_rad, leans_rad]: [f64; 2]) -> [f64; WIRE_COUNT] {
        let believed = self.heading_rad.get_or_insert(heading_rad);
        *believed += BELIEVES * (heading_rad - *believed);
        let heading_rad = *believed;
        if leans_rad > LIES_RAD {
            (self.stood_s, self.steps) = (0.0, 0.0);
        } else if self.stood_s < STANDS_S {
            self.stood_s += 1.0 / WORDS_HZ;
        } else {
            let steps = 1.0 / WORDS_HZ / STEP_S;
            self.steps += steps;
            self.beside_m += STROKE_M * steps * heading_rad.sin();
            let to_line_rad = (-TO_LINE_RAD_PER_M * self.beside_m).clamp(-MOST_TO_LINE_RAD, MOST_TO_LINE_RAD);
            let off_rad = to_line_rad - heading_rad;
            self.steered = (STEERS_PER_RAD * off_rad).clamp(-MOST_STEERED, MOST_STEERED);
        }
        self.strokes()
    }

    /// The strokes it asks for.
    pub fn strokes(&self) -> [f64; WIRE_COUNT] {
        // the first step begins from the middle of the strokes: they grow to what they are
        let grown = (0.5 * self.steps).min(1.0);
        let mut strokes = [LEVEL; WIRE_COUNT];
        for (leg, strokes) in strokes.chunks_exact_mut(JOINTS).enumerate() {
            let (row, is_left) = (leg / 2, leg % 2 == 0);
            let tripod = (row + usize::from(is_left)) % 2;
            let stroke_m = STROKE_M * grown * if is_left { 1.0 - self.steered } else { 1.0 + self.steered };
            let (forward, lifted) = step((self.steps + tripod as f64).rem_euclid(2.0));
            let angles = Foot { ahead_m: forward * stroke_m, lifted_m: lifted * LIFT_M }.angles_rad();
            for (stroke, angle_rad) in strokes.iter_mut().zip(angles) {
                *stroke = (LEVEL + angle_rad * self.stroke_per_rad).clamp(STROKES[0], STROKES[1]);
            }
        }
        strokes
    }
}

/// Where a foot is so many steps into its leg's gait, of which the first is in the air and the second on the ground: shares of its stroke, ahead of
/// the middle, and of its lift.
fn step(steps: f64) -> (f64, f64) {
    if steps >= 1.0 {
        return (1.5 - steps, 0.0);
    }
    let forward = ramp(steps, SWINGS[0], SWINGS[1]) - 0.5;
    (forward, ramp(steps, 0.0, LIFTED) - ramp(steps, SET_DOWN, 1.0))
}

/// From 0 to 1 between two times, without a jerk at either end.
fn ramp(t: f64, from: f64, to: f64) -> f64 {
    let x = ((t - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Where a foot is to be, from where it stands in the middle of its stroke, m.
struct Foot {
    ahead_m: f64,
    lifted_m: f64,
}

impl Foot {
    /// The angles of coxa, femur and tibia at which it is there, rad.
    fn angles_rad(&self) -> [f64; JOINTS] {
        let [coxa, femur, tibia] = LENGTHS_M;
        // on a straight line along the body, whatever arc the coxa draws
        let out_m = self.ahead_m.hypot(OUT_M);
        let on_ground = knee(out_m - coxa, -BELOW_M, femur, tibia);
        // lifted by the femur alone: the tibia has nothing to hold then
        let lift_rad = self.lifted_m / (out_m - coxa);
        [
            self.ahead_m.atan2(OUT_M),
            on_ground[0] + lift_rad - FEMUR_RAD,
            on_ground[1] + FRAC_PI_2 - TIBIA_RAD - (on_ground[0] - FEMUR_RAD),
        ]
    }
}

/// The angles from the horizontal, rad, at which femur and tibia reach so far out and up, m.
fn knee(out_m: f64, up_m: f64, femur_m: f64, tibia_m: f64) -> [f64; 2] {
    let far_m = out_m.hypot(up_m);
    let bent = (femur_m * femur_m + far_m * far_m - tibia_m * tibia_m) / (2.0 * femur_m * far_m);
    let femur_rad = up_m.atan2(out_m) + bent.clamp(-1.0, 1.0).acos();
    [femur_rad, (up_m - femur_m * femur_rad.sin()).atan2(out_m - femur_m * femur_rad.cos())]
}
