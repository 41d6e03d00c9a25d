//! The machines there are: what is shown of each, and what is claimed.

use sinew_demonstrators::{ARM, BALL_ON_BEAM, BOWDEN_SERVO, Reading, SAID, SERVO, TORSO, Tally, WALKER};
use sinew_rig::Rig;

use crate::args;
use crate::driving::robots::{arm, ball_on_beam, servo, torso, walker};
use crate::failure::Failure;

/// What a robot program is when nothing stands between it and its sensor: from what that says (`None`: nothing for
/// [`Demo::silence_s`]) to the strokes it asks for.
pub type Mind = Box<dyn FnMut(Option<[f64; SAID]>) -> Vec<f64>>;

/// One of them.
pub struct Demo {
    /// By which it is asked for.
    pub name: &'static str,
    /// What it is, for a person.
    pub about: &'static str,
    /// Text of the rig file, and of the robot program with its file's name.
    pub rig: &'static str,
    pub program: (&'static str, &'static str),
    /// The wires it commands.
    pub wires: &'static [&'static str],
    /// What its sensor says, each by name and in a unit over SI's.
    pub says: &'static [(&'static str, f64)],
    /// After so long a robot program takes notice that its sensor is silent, s.
    pub silence_s: f64,
    /// The robot program, on the rig of this name.
    pub run: fn(&str) -> Result<(), Box<dyn std::error::Error>>,
    /// Of wires with these ways from cold to hot, m.
    pub mind: fn(&[f64]) -> Mind,
    /// Whether something can fall off it.
    pub falls: bool,
    /// What is claimed: no larger error than this, in the unit of [`Demo::error`] …
    pub claim: f64,
    /// … and of one that walks, how far it comes.
    pub walks: Option<Walks>,
    /// The unit an error is told in, and that unit over SI's.
    pub error: (&'static str, f64),
}

/// So far, and in so much time.
#[derive(Clone, Copy)]
pub struct Walks {
    pub metres: f64,
    pub within_s: f64,
}

/// How long a trial lasts of a machine that stays where it is, s.
const LASTS_S: f64 = 600.0;

/// All of them.
pub const DEMOS: [Demo; 6] = [
    Demo {
        name: "ball-on-beam",
        about: "one wire tilts a beam on which a ball rolls, and a camera sees the ball",
        rig: BALL_ON_BEAM,
        program: ("ball_on_beam.rs", include_str!("../robots/ball_on_beam.rs")),
        wires: &["tilt"],
        says: &[("ball_mm", MM)],
        silence_s: 0.3,
        run: ball_on_beam::run,
        mind: |travels_m| {
            let mut balance = ball_on_beam::Balance::new(travels_m[0]);
            Box::new(move |said| match said {
                Some([ball_mm, ..]) => vec![balance.sees(ball_mm * 1e-3)],
                None => vec![balance.sees_nothing()],
            })
        },
        falls: true,
        claim: 10.0,
        walks: None,
        error: ("mm", MM),
    },
    servo(
        "servo",
        "one wire that measures itself turns a horn as the pulses of a radio's receiver ask",
        SERVO,
        |rig| servo::run(rig, MICRO),
        |travels_m| mind_of_servo(MICRO, travels_m[0]),
    ),
    servo(
        "bowden-servo",
        "the same with half a metre of wire in a Bowden tube, which takes its heat and holds it back",
        BOWDEN_SERVO,
        |rig| servo::run(rig, BOWDEN),
        |travels_m| mind_of_servo(BOWDEN, travels_m[0]),
    ),
    Demo {
        name: "arm",
        about: "two wires point a camera at a target, by a program that knows neither angles nor lengths",
        rig: ARM,
        program: ("arm.rs", include_str!("../robots/arm.rs")),
        wires: &["shoulder", "elbow"],
        says: &[("x_mm", MM), ("y_mm", MM)],
        silence_s: f64::INFINITY,
        run: arm::run,
        mind: |_| {
            let mut gaze = arm::Gaze::default();
            Box::new(move |said| said.map_or(gaze.strokes(), |[x, y, ..]| gaze.sees([x, y])).to_vec())
        },
        falls: false,
        claim: 10.0,
        walks: None,
        error: ("mm", MM),
    },
    Demo {
        name: "walker",
        about: "eighteen wires walk a hexapod straight ahead over uneven ground, by the word of a compass",
        rig: WALKER,
        program: ("walker.rs", include_str!("../robots/walker.rs")),
        wires: &walker::WIRES,
        says: &[("heading_deg", DEGREES), ("leans_deg", DEGREES)],
        silence_s: f64::INFINITY,
        run: walker::run,
        mind: |travels_m| {
            let mut walk = walker::Walk::new(travels_m[0]);
            Box::new(move |said| match said {
                Some([heading, leans, ..]) => walk.feels([heading, leans].map(f64::to_radians)).to_vec(),
                None => walk.strokes().to_vec(),
            })
        },
        falls: true,
        claim: 30.0,
        walks: Some(Walks { metres: 1.0, within_s: 75.0 }),
        error: ("mm", MM),
    },
    Demo {
        name: "torso",
        about: "eight wires move two arms; a ball is balanced on the paddle in the right hand, while that is lifted and lowered",
        rig: TORSO,
        program: ("torso.rs", include_str!("../robots/torso.rs")),
        wires: &torso::WIRES,
        says: &[
            ("right_shoulder_deg", DEGREES),
            ("right_elbow_deg", DEGREES),
            ("right_pitch_deg", DEGREES),
            ("right_roll_deg", DEGREES),
            ("left_shoulder_deg", DEGREES),
            ("left_elbow_deg", DEGREES),
            ("left_pitch_deg", DEGREES),
            ("left_roll_deg", DEGREES),
            ("ahead_mm", MM),
            ("left_mm", MM),
        ],
        silence_s: f64::INFINITY,
        run: torso::run,
        mind: |travels_m| {
            let mut torso = torso::Torso::new(std::array::from_fn(|wire| travels_m[wire]));
            Box::new(move |said| said.map_or(torso.strokes(), |said| torso.sees(said)).to_vec())
        },
        falls: true,
        claim: 30.0,
        walks: None,
        error: ("mm", MM),
    },
];

/// Of a rad, of a metre, of a second.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
const MM: f64 = 1e3;
const US: f64 = 1e6;

/// A servo with this wire and horn.
const fn servo(
    name: &'static str,
    about: &'static str,
    rig: &'static str,
    run: fn(&str) -> Result<(), Box<dyn std::error::Error>>,
    mind: fn(&[f64]) -> Mind,
) -> Demo {
    Demo {
        name,
        about,
        rig,
        program: ("servo.rs", include_str!("../robots/servo.rs")),
        wires: &["horn"],
        says: &[("pulse_us", US)],
        silence_s: f64::INFINITY,
        run,
        mind,
        falls: false,
        claim: 3.0,
        walks: None,
        error: ("°", DEGREES),
    }
}

const MICRO: servo::Horn = servo::Horn { lever_m: 0.004, degrees_per_ms: 60.0 };
const BOWDEN: servo::Horn = servo::Horn { lever_m: 0.008, degrees_per_ms: 120.0 };

fn mind_of_servo(horn: servo::Horn, travel_m: f64) -> Mind {
    let mut servo = servo::Servo::new(horn, travel_m);
    Box::new(move |said| said.into_iter().map(|[us, ..]| servo.hears(us)).collect())
}

impl Demo {
    /// Its rig, with the seed that is asked for.
    pub fn rig(&self, args: &args::Demo) -> Result<Rig, Failure> {
        let mut rig = Rig::parse(self.rig, &format!("the rig file of {}", self.name)).map_err(Failure::own)?;
        if let Some(seed) = args.seed {
            rig.simulation.seed = seed.into();
        }
        Ok(rig)
    }

    /// What its sensor has said, in the units it says it in.
    pub fn said(&self, reading: &Reading) -> [f64; SAID] {
        let mut said = reading.values.map(f64::from);
        said.iter_mut().zip(self.says).for_each(|(value, (_, over_si))| *value *= over_si);
        said
    }

    /// How long a trial of it lasts unless it is said, s.
    pub fn lasts_s(&self) -> f64 {
        self.walks.map_or(LASTS_S, |walks| walks.within_s)
    }

    /// How it has done, for a person.
    pub fn says_of(&self, tally: &Tally) -> String {
        let (unit, over_si) = self.error;
        let Tally { seconds, falls, worst, mean_square, walked_m } = *tally;
        let fell = match falls {
            _ if !self.falls => String::new(),
            0 => "never fell; ".into(),
            1 => "fell once; ".into(),
            times => format!("fell {times} times; "),
        };
        let (worst, rms) = (worst * over_si, mean_square.sqrt() * over_si);
        let did = match self.walks {
            Some(_) => format!("walked {walked_m:.2} m, never further than {worst:.0} {unit} beside its line"),
            None if worst > 0.0 => {
                format!("once settled never off by more than {worst:.1} {unit}, {rms:.1} {unit} RMS")
            }
            None => "it had no time to settle".into(),
        };
        format!("{}, {seconds:.0} s: {fell}{did}", self.name)
    }

    /// Whether that is what is claimed.
    pub fn succeeds(&self, tally: &Tally) -> bool {
        let has_arrived = self.walks.is_none_or(|walks| tally.walked_m >= walks.metres);
        let stayed = tally.worst > 0.0 && tally.worst * self.error.1 <= self.claim;
        tally.falls == 0 && tally.seconds > 0.0 && stayed && has_arrived
    }
}
