//! A machine around simulated wires, period by period.

use std::fmt;

use sinew_backend::Backend as _;
use sinew_rig::{Channel, DemonstratorKind, Rig};
use sinew_sim_backend::{SimulatedRig, World};

use crate::arm::Links;
use crate::ball::{Ball, Beam, Hand};
use crate::chance::{Draughts, Noise};
use crate::hexapod::{Hexapod, JOINTS, LEGS};
use crate::picture::Drawn;
use crate::pose::Pose;
use crate::sensor::{SAID, Sensor};
use crate::torso::{TORSO_JOINTS, Torso};
use crate::watch::{Tally, Watch};

/// So long a ball has to get to the middle before its way is counted, s.
const BALL_SETTLES_S: f64 = 10.0;
/// So long a servo has to get to its angle before its error is counted, s …
const SERVO_SETTLES_S: f64 = 2.5;
/// … and so long it is asked for one, s.
const ASKED_FOR_S: f64 = 5.0;
/// A servo is asked for angles within this share of the wire's stroke to either side of the middle, and an arm for places that it reaches
/// with such angles.
const ASKED_SHARE: f64 = 0.3;
/// So long an arm has one target at first, to find out how it moves, and so long each of the others, s …
const FIRST_TARGET_S: f64 = 20.0;
const TARGET_S: f64 = 15.0;
/// … and so long it has to get there before its distance is counted, s.
const ARM_SETTLES_S: f64 = 8.0;

/// Most wires that move a machine.
const MOST_WIRES: usize = JOINTS * LEGS;

/// Why there is no demonstrator: the physics does not accept the parameters of its wire.
#[derive(Debug, Clone, PartialEq)]
pub struct Error(sinew_physics::Error);

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Error {}

/// A machine that wires of a simulated rig move.
#[derive(Debug)]
pub struct Demonstrator {
    /// One, of an arm two, of a torso eight, of a hexapod [`MOST_WIRES`].
    wires: Vec<Turning>,
    period_s: f64,
    body: Body,
    sensor: Sensor,
    draughts: Draughts,
    score: Score,
    watch: Watch,
}

/// A wire at its lever.
#[derive(Debug, Clone, Copy)]
struct Turning {
    channel: usize,
    lever_m: f64,
    /// Elongation L − L_0 at which the angle is zero, and L_0, m.
    level_m: f64,
    length_m: f64,
    /// Way from cold to hot, m.
    travel_m: f64,
    /// Angle it turns to where it is hot.
    most_rad: f64,
}

impl Turning {
    fn of(rig: &Rig, (channel, wire): (usize, &Channel)) -> Result<Turning, Error> {
        let cold_m = sinew_physics::cold_length_m(&wire.model).map_err(Error)?;
        let hot_m = sinew_physics::hot_length_m(&wire.model).map_err(Error)?;
        let (travel_m, length_m) = (cold_m - hot_m, wire.model.geometry.length_m);
        let level_m = cold_m - rig.demonstrator.level_stroke * travel_m - length_m;
        let lever_m = rig.demonstrator.lever_m;
        let most_rad = (1.0 - rig.demonstrator.level_stroke) * travel_m / lever_m;
        Ok(Turning { channel, lever_m, level_m, length_m, travel_m, most_rad })
    }

    fn angle_rad(&self, position_m: f64) -> f64 {
        (self.level_m - position_m) / self.lever_m
    }
}

#[derive(Debug)]
enum Body {
    Beam {
        beam: Beam,
        start_m: f64,
        ball: Option<Ball>,
        hand: Hand,
    },
    Servo {
        asked_rad: f64,
        until_s: f64,
        most_rad: f64,
        centre_s: f64,
        rad_per_s: f64,
        pilot: Noise,
    },
    Arm {
        links: Links,
        target_m: [f64; 2],
        until_s: f64,
        /// Largest angles at which there is a target.
        most_rad: [f64; 2],
        whim: Noise,
    },
    Hexapod(Box<Hexapod>),
    Torso {
        torso: Box<Torso>,
        hand: Hand,
    },
}

/// Keeps the tally.
#[derive(Debug, Default)]
struct Score {
    tally: Tally,
    /// What is counted begins after this, s.
    settled_s: f64,
    counted: f64,
}

impl Score {
    /// The machine begins to be judged anew, `settles_s` from now.
    fn begin(&mut self, time_s: f64, settles_s: f64) {
        self.settled_s = time_s + settles_s;
    }

    fn count(&mut self, time_s: f64, period_s: f64, error: f64) {
        self.tally.seconds += period_s;
        if time_s >= self.settled_s {
            self.counted += 1.0;
            self.tally.worst = self.tally.worst.max(error.abs());
            self.tally.mean_square += (error * error - self.tally.mean_square) / self.counted;
        }
    }
}

impl Demonstrator {
    /// The machine of a rig file, its wires cold; `None` where it has none.
    ///
    /// # Errors
    /// [`Error`] where the physics does not accept a wire.
    pub fn of(rig: &Rig) -> Result<Option<Demonstrator>, Error> {
        let declared = &rig.demonstrator;
        let channels = rig.demonstrator_channels().flatten();
        let wires = channels.map(|channel| Turning::of(rig, channel)).collect::<Result<Vec<_>, Error>>()?;
        let Some(first) = wires.first() else { return Ok(None) };
        let seed = rig.simulation.seed;
        let asked_rad = |wire: &Turning| ASKED_SHARE * wire.travel_m / wire.lever_m;
        let mut score = Score::default();
        let (body, noise, pose) = match declared.kind {
            DemonstratorKind::None => return Ok(None),
            DemonstratorKind::BallOnBeam => {
                let body = Body::Beam {
                    beam: Beam::of(declared),
                    start_m: declared.start_m,
                    ball: None,
                    hand: Hand::default(),
                };
                (body, vec![declared.camera_noise_m; 2], Pose::Beam { angle_rad: 0.0, ball_m: f64::NAN })
            }
            DemonstratorKind::Servo => {
                let body = Body::Servo {
                    asked_rad: 0.0,
                    until_s: 0.0,
                    most_rad: asked_rad(first),
                    centre_s: declared.centre_pulse_s,
                    rad_per_s: declared.rad_per_s,
                    pilot: Noise::new(seed, 3),
                };
                (body, vec![declared.jitter_s; 2], Pose::Servo { angle_rad: 0.0, asked_rad: 0.0 })
            }
            DemonstratorKind::Arm => {
                let [shoulder, elbow] = wires[..] else { return Ok(None) };
                let links = Links::of(declared);
                let target_m = links.tip([0.0; 2]).at_m;
                score.begin(0.0, FIRST_TARGET_S + ARM_SETTLES_S);
                let body = Body::Arm {
                    links,
                    target_m,
                    until_s: FIRST_TARGET_S,
                    most_rad: [asked_rad(&shoulder), asked_rad(&elbow)],
                    whim: Noise::new(seed, 3),
                };
                (body, vec![declared.camera_noise_m; 2], Pose::Arm { angles_rad: [0.0; 2], target_m })
            }
            DemonstratorKind::Hexapod => {
                let body = Hexapod::new(declared, seed, 1.0 / rig.rate_hz);
                let pose = Pose::Hexapod(body.stance(&[[0.0; JOINTS]; LEGS]));
                (Body::Hexapod(Box::new(body)), vec![declared.compass_noise_rad; 2], pose)
            }
            DemonstratorKind::Torso => {
                let body = Body::Torso { torso: Box::new(Torso::new(declared, seed)), hand: Hand::default() };
                let mut noise = vec![declared.potentiometer_noise_rad; TORSO_JOINTS];
                noise.resize(SAID, declared.camera_noise_m);
                (body, noise, Pose::Torso { angles_rad: [0.0; TORSO_JOINTS], ball_m: [f64::NAN; 2] })
            }
        };
        Ok(Some(Demonstrator {
            period_s: 1.0 / rig.rate_hz,
            body,
            sensor: Sensor::new(declared.sensor_hz, declared.sensor_delay_s, noise, seed),
            draughts: Draughts::new(declared, seed),
            score,
            watch: Watch::new(Drawn::of(declared), pose),
            wires,
        }))
    }

    /// The angle one of its wires holds it at with its end at an elongation L − L_0, in m: rad.
    pub(crate) fn angle_rad(&self, wire: usize, position_m: f64) -> f64 {
        self.wires.get(wire).map_or(f64::NAN, |wire| wire.angle_rad(position_m))
    }

    /// The angle its first wire turns it to with its end hot, rad.
    pub(crate) fn most_rad(&self) -> f64 {
        self.wires.first().map_or(f64::NAN, |wire| wire.most_rad)
    }

    /// Who sees it from another thread.
    pub fn watch(&self) -> Watch {
        self.watch.clone()
    }

    /// Lets its wires make room for a draught now: the first one allocates, and the loop is no place for that.
    pub(crate) fn make_room(&self, wires: &mut SimulatedRig) {
        for Turning { channel, .. } in &self.wires {
            wires.disturb(*channel, &World { draught: 1.0, ..World::CALM });
            wires.disturb(*channel, &World::CALM);
        }
    }

    /// Follows the wires through the period just past, and acts on them in the next.
    pub fn pass(&mut self, wires: &mut SimulatedRig) {
        let time_s = wires.time_s();
        let draught = self.draughts.at(time_s);
        // how each joint stands and turns
        let mut joints = [(0.0, 0.0); MOST_WIRES];
        for (joint, wire) in joints.iter_mut().zip(&self.wires) {
            let Some(truth) = wires.truth(wire.channel) else { return };
            *joint = (wire.angle_rad(truth.length_m - wire.length_m), -truth.velocity_m_s / wire.lever_m);
        }
        let Passed { sees, pose, torques_n_m } = self.body.pass(&joints, time_s, self.period_s, &mut self.score);
        // a camera that sees nothing says nothing
        let said = self.sensor.look(time_s, sees.unwrap_or([f64::NAN; SAID]));
        if let Some(said) = said.filter(|said| said[0].is_finite()) {
            self.watch.say(said);
        }
        for (wire, torque_n_m) in self.wires.iter().zip(torques_n_m) {
            wires.disturb(wire.channel, &World { draught, pull_n: torque_n_m / wire.lever_m, ..World::CALM });
        }
        self.watch.set_pose(&pose, draught);
        self.watch.set_tally(&self.score.tally);
    }
}

/// What has come of a period.
struct Passed {
    /// What its sensor has before it, if anything.
    sees: Option<[f64; SAID]>,
    pose: Pose,
    /// What turns each joint back.
    torques_n_m: [f64; MOST_WIRES],
}

/// What is said where there are two numbers of it.
fn two([first, second]: [f64; 2]) -> [f64; SAID] {
    let mut all = [0.0; SAID];
    (all[0], all[1]) = (first, second);
    all
}

/// What turns the one joint there is.
fn only(torque_n_m: f64) -> [f64; MOST_WIRES] {
    let mut all = [0.0; MOST_WIRES];
    all[0] = torque_n_m;
    all
}

impl Body {
    /// Lets a period pass with each joint at an angle, rad, that turns at a rate, rad/s.
    fn pass(&mut self, joints: &[(f64, f64); MOST_WIRES], time_s: f64, period_s: f64, score: &mut Score) -> Passed {
        let [(angle_rad, rate_rad_s), (elbow_rad, _), ..] = *joints;
        match self {
            Body::Beam { beam, start_m, ball, hand } => {
                if let Some(rolling) = ball {
                    rolling.roll(beam, angle_rad, rate_rad_s, period_s);
                    score.count(time_s, period_s, rolling.at_m);
                    if rolling.has_fallen(beam) {
                        score.tally.falls += 1;
                        *ball = None;
                    }
                } else if hand.puts_down(angle_rad, period_s) {
                    *ball = Some(Ball::put_down(*start_m));
                    score.begin(time_s, BALL_SETTLES_S);
                }
                Passed {
                    sees: ball.map(|ball| two([ball.at_m, 0.0])),
                    pose: Pose::Beam { angle_rad, ball_m: ball.map_or(f64::NAN, |ball| ball.at_m) },
                    torques_n_m: only(ball.map_or(0.0, |ball| ball.torque_n_m(beam, angle_rad, rate_rad_s))),
                }
            }
            Body::Servo { asked_rad, until_s, most_rad, centre_s, rad_per_s, pilot } => {
                if time_s >= *until_s {
                    *until_s = time_s + ASKED_FOR_S;
                    *asked_rad = *most_rad * (2.0 * pilot.even() - 1.0);
                    score.begin(time_s, SERVO_SETTLES_S);
                }
                score.count(time_s, period_s, angle_rad - *asked_rad);
                Passed {
                    sees: Some(two([*centre_s + *asked_rad / *rad_per_s, 0.0])),
                    pose: Pose::Servo { angle_rad, asked_rad: *asked_rad },
                    torques_n_m: only(0.0),
                }
            }
            Body::Arm { links, target_m, until_s, most_rad, whim } => {
                if time_s >= *until_s {
                    *until_s = time_s + TARGET_S;
                    // wherever it can look
                    let there = most_rad.map(|most| most * (2.0 * whim.even() - 1.0));
                    *target_m = links.tip(there).at_m;
                    score.begin(time_s, ARM_SETTLES_S);
                }
                let angles_rad = [angle_rad, elbow_rad];
                let tip = links.tip(angles_rad);
                score.count(time_s, period_s, tip.distance_m(*target_m));
                Passed {
                    sees: Some(two(tip.sees(*target_m))),
                    pose: Pose::Arm { angles_rad, target_m: *target_m },
                    torques_n_m: only(0.0),
                }
            }
            Body::Hexapod(body) => {
                let angles = std::array::from_fn(|leg| std::array::from_fn(|joint| joints[JOINTS * leg + joint].0));
                let torques = body.pass(&angles, period_s);
                let stance = body.stance(&angles);
                score.count(time_s, period_s, stance.at_m[1]);
                score.tally.walked_m = stance.at_m[0];
                let leans_rad = body.leans_rad();
                if body.has_fallen() {
                    score.tally.falls += 1;
                    body.set_up();
                }
                Passed {
                    sees: Some(two([stance.turned_rad[0], leans_rad])),
                    pose: Pose::Hexapod(stance),
                    torques_n_m: std::array::from_fn(|wire| -torques[wire / JOINTS][wire % JOINTS]),
                }
            }
            Body::Torso { torso, hand } => {
                let joints = std::array::from_fn(|joint| joints[joint]);
                let torques = torso.pass(&joints, period_s);
                if let Some(off_m) = torso.off_m() {
                    score.count(time_s, period_s, off_m);
                    if torso.has_dropped() {
                        score.tally.falls += 1;
                        torso.take_ball();
                    }
                } else if hand.puts_down(torso.leans_rad(&joints), period_s) {
                    torso.put_ball();
                    score.begin(time_s, BALL_SETTLES_S);
                }
                let (angles_rad, ball_m) = (joints.map(|(angle, _)| angle), torso.ball_m());
                let said = angles_rad.into_iter().chain(ball_m);
                let mut sees = [0.0; SAID];
                sees.iter_mut().zip(said).for_each(|(number, said)| *number = said);
                let mut torques_n_m = [0.0; MOST_WIRES];
                torques_n_m.iter_mut().zip(torques).for_each(|(back, torque)| *back = -torque);
                Passed { sees: Some(sees), pose: Pose::Torso { angles_rad, ball_m }, torques_n_m }
            }
        }
    }
}
