//! A robot program: an arm that looks at a target with a camera at its tip, and neither knows its own angles nor its lengths.
//!
//! ```text
//! sinew demo arm                             # the driver, the arm, and this program, which is in `sinew` too
//! cargo run -p sinew-ipc --example arm < /dev/ttyACM0    # with a camera of your own
//! ```
//!
//! It reads a line for each picture of the camera, `x_mm: 1.2 y_mm: -3.4`: where the target is seen, in the camera's own directions, which turn with
//! the arm. What a wire does to that picture it finds out by moving each of them a little; what it has seen then is all the kinematics
//! it has. From there on it moves the wires against what it sees.

use std::error::Error;
use std::io::BufRead;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use sinew_ipc::{Client, CommandKind, Wanted};

/// The wires, as the rig file calls them.
const WIRES: [&str; 2] = ["shoulder", "elbow"];
/// Strokes it begins with, and those that are asked for at all.
const MIDDLE: f64 = 0.5;
const STROKES: [f64; 2] = [0.08, 0.92];
/// Pictures of the camera a second.
const PICTURES_HZ: f64 = 25.0;
/// So long a wire has to get somewhere before it is believed to be there, pictures, and so many pictures are averaged then.
const SETTLES: u32 = 75;
const AVERAGED: u32 = 25;
/// By so much of its stroke each wire is moved to see what it does.
const PROBE: f64 = 0.15;
/// What is seen is made up for at this rate, 1/s.
const GAIN_PER_S: f64 = 0.5;
/// The camera says nothing for so long: the arm stands still.
const SILENCE: Duration = Duration::from_millis(300);
/// How long a setpoint holds: if this program dies, the wires go off so much later.
const LEASE: Duration = Duration::from_millis(500);

/// Runs it as a program of its own.
#[allow(dead_code, reason = "`sinew demo` calls `run`")]
fn main() {
    let rig = std::env::args().nth(1).unwrap_or_else(|| "arm".into());
    if let Err(error) = run(&rig) {
        eprintln!("arm: {error}");
        std::process::exit(1);
    }
}

/// Keeps the camera of this rig on its target until the camera's lines end.
pub fn run(rig: &str) -> Result<(), Box<dyn Error>> {
    let client = Client::connect(rig)?;
    let channels = [client.channel(WIRES[0])? as u32, client.channel(WIRES[1])? as u32];
    let mut gaze = Gaze::default();

    // Lines are read by a thread of their own: a camera that says nothing must not keep this program from noticing.
    let (seen, sees) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let mut numbers = line.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
            let (Some(x), Some(y)) = (numbers.next(), numbers.next()) else { continue };
            if seen.send([x, y]).is_err() {
                return;
            }
        }
    });
    loop {
        let strokes = match sees.recv_timeout(SILENCE) {
            Ok(target_mm) => gaze.sees(target_mm),
            Err(RecvTimeoutError::Timeout) => gaze.strokes(),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        let wanted =
            [0, 1].map(|wire| Wanted { channel: channels[wire], kind: CommandKind::Stroke, value: strokes[wire] });
        client.set_many(&wanted, LEASE)?;
    }
    for wire in WIRES {
        client.off(wire)?;
    }
    Ok(())
}

/// What it does just now.
#[derive(Clone, Copy, PartialEq)]
enum Doing {
    /// Stands in the middle, then with one wire moved, then with the other; where the target was seen then.
    Probes(usize),
    Follows,
}

/// What this program knows, and what it asks for.
pub struct Gaze {
    strokes: [f64; 2],
    doing: Doing,
    pictures: u32,
    sum_mm: [f64; 2],
    /// Where the target was seen in the middle, mm.
    middle_mm: [f64; 2],
    /// By how much what is seen moves with each stroke, mm: a column for each wire.
    moves_mm: [[f64; 2]; 2],
}

impl Default for Gaze {
    /// One that knows nothing.
    fn default() -> Gaze {
        Gaze {
            strokes: [MIDDLE; 2],
            doing: Doing::Probes(0),
            pictures: 0,
            sum_mm: [0.0; 2],
            middle_mm: [0.0; 2],
            moves_mm: [[0.0; 2]; 2],
        }
    }
}

impl Gaze {
    /// The strokes it asks for.
    pub fn strokes(&self) -> [f64; 2] {
        self.strokes
    }

    /// The camera sees the target here, mm: the strokes to ask for.
    pub fn sees(&mut self, target_mm: [f64; 2]) -> [f64; 2] {
        match self.doing {
            Doing::Probes(step) => self.probe(step, target_mm),
            Doing::Follows => self.follow(target_mm),
        }
        self.strokes
    }

    fn probe(&mut self, step: usize, target_mm: [f64; 2]) {
        self.pictures += 1;
        if self.pictures > SETTLES {
            self.sum_mm = [0, 1].map(|axis| self.sum_mm[axis] + target_mm[axis]);
        }
        if self.pictures < SETTLES + AVERAGED {
            return;
        }
        let seen = self.sum_mm.map(|sum| sum / f64::from(AVERAGED));
        match step {
            0 => self.middle_mm = seen,
            wire => self.moves_mm[wire - 1] = [0, 1].map(|axis| (seen[axis] - self.middle_mm[axis]) / PROBE),
        }
        (self.pictures, self.sum_mm, self.strokes) = (0, [0.0; 2], [MIDDLE; 2]);
        self.doing = if step < 2 { Doing::Probes(step + 1) } else { Doing::Follows };
        if step < 2 {
            self.strokes[step] += PROBE;
        }
    }

    /// Moves the wires so that what is seen goes to the middle of the picture: the inverse of what was seen when they moved.
    fn follow(&mut self, [x, y]: [f64; 2]) {
        let [[a, c], [b, d]] = self.moves_mm;
        let determinant = a * d - b * c;
        if determinant.abs() < 1.0 {
            return;
        }
        let share = -GAIN_PER_S / PICTURES_HZ / determinant;
        let by = [share * (d * x - b * y), share * (a * y - c * x)];
        self.strokes = [0, 1].map(|wire| (self.strokes[wire] + by[wire]).clamp(STROKES[0], STROKES[1]));
    }
}
