//! A machine around simulated wires, period by period.

use std::fmt;

use sinew_backend::Backend as _;
use sinew_rig::{DemonstratorKind, Rig};
use sinew_sim_backend::{SimulatedRig, World};

use crate::ball::{Ball, Beam};
use crate::chance::{Draughts, Noise};
use crate::picture::Drawn;
use crate::pose::Pose;
use crate::sensor::Sensor;
use crate::watch::{Tally, Watch};

/// The beam counts as level within this, rad …
const LEVEL_RAD: f64 = 0.02;
/// … once it has been so for this long, s: then a hand puts the ball down.
const LEVEL_S: f64 = 1.0;
/// So long a ball has to get to the middle before its way is counted, s.
const BALL_SETTLES_S: f64 = 10.0;
/// So long a servo has to get to its angle before its error is counted, s …
const SERVO_SETTLES_S: f64 = 2.5;
/// … and so long it is asked for one, s.
const ASKED_FOR_S: f64 = 5.0;
/// A servo is asked for angles within this share of the wire's stroke to either side of the middle.
const ASKED_SHARE: f64 = 0.3;

/// Why there is no demonstrator: the physics does not accept the parameters of its wire.
#[derive(Debug, Clone, PartialEq)]
pub struct Error(sinew_physics::Error);

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Error {}

/// A machine that one wire of a simulated rig moves.
#[derive(Debug)]
pub struct Demonstrator {
    channel: usize,
    lever_m: f64,
    /// Elongation L − L_0 of the wire at which the angle is zero, m.
    level_m: f64,
    /// L_0, m.
    length_m: f64,
    period_s: f64,
    body: Body,
    sensor: Sensor,
    draughts: Draughts,
    score: Score,
    watch: Watch,
}

#[derive(Debug)]
enum Body {
    Beam { beam: Beam, start_m: f64, ball: Option<Ball>, level_s: f64 },
    Servo { asked_rad: f64, until_s: f64, most_rad: f64, centre_s: f64, rad_per_s: f64, pilot: Noise },
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
    /// The machine of a rig file, its wire cold; `None` where it has none.
    ///
    /// # Errors
    /// [`Error`] where the physics does not accept the wire.
    pub fn of(rig: &Rig) -> Result<Option<Demonstrator>, Error> {
        let declared = &rig.demonstrator;
        let Some((channel, wire)) = rig.demonstrator_channel() else { return Ok(None) };
        let cold_m = sinew_physics::cold_length_m(&wire.model).map_err(Error)?;
        let hot_m = sinew_physics::hot_length_m(&wire.model).map_err(Error)?;
        let seed = rig.simulation.seed;
        let (body, noise) = match declared.kind {
            DemonstratorKind::None => return Ok(None),
            DemonstratorKind::BallOnBeam => {
                let beam = Beam {
                    half_m: declared.half_beam_m,
                    ball_kg: declared.ball_kg,
                    inertia: declared.ball_inertia,
                    rolling: declared.rolling_resistance,
                };
                let body = Body::Beam { beam, start_m: declared.start_m, ball: None, level_s: 0.0 };
                (body, declared.camera_noise_m)
            }
            DemonstratorKind::Servo => {
                let body = Body::Servo {
                    asked_rad: 0.0,
                    until_s: 0.0,
                    most_rad: ASKED_SHARE * (cold_m - hot_m) / declared.lever_m,
                    centre_s: declared.centre_pulse_s,
                    rad_per_s: declared.rad_per_s,
                    pilot: Noise::new(seed, 3),
                };
                (body, declared.jitter_s)
            }
        };
        Ok(Some(Demonstrator {
            channel,
            lever_m: declared.lever_m,
            level_m: cold_m - declared.level_stroke * (cold_m - hot_m) - wire.model.geometry.length_m,
            length_m: wire.model.geometry.length_m,
            period_s: 1.0 / rig.rate_hz,
            body,
            sensor: Sensor::new(declared.sensor_hz, declared.sensor_delay_s, noise, seed),
            draughts: Draughts::new(declared, seed),
            score: Score::default(),
            watch: Watch::new(Drawn::of(declared)),
        }))
    }

    /// The angle it stands at with the wire's end at an elongation L − L_0, in m: rad.
    pub fn angle_rad(&self, position_m: f64) -> f64 {
        (self.level_m - position_m) / self.lever_m
    }

    /// Who sees it from another thread.
    pub fn watch(&self) -> Watch {
        self.watch.clone()
    }

    /// Lets its wire make room for a draught now: the first one allocates, and the loop is no place for that.
    pub(crate) fn make_room(&self, wires: &mut SimulatedRig) {
        wires.disturb(self.channel, &World { draught: 1.0, ..World::CALM });
        wires.disturb(self.channel, &World::CALM);
    }

    /// Follows the wires through the period just past, and acts on them in the next.
    pub fn pass(&mut self, wires: &mut SimulatedRig) {
        let Some(truth) = wires.truth(self.channel) else { return };
        let time_s = wires.time_s();
        let angle_rad = self.angle_rad(truth.length_m - self.length_m);
        let rate_rad_s = -truth.velocity_m_s / self.lever_m;
        let draught = self.draughts.at(time_s);
        let (seen, other, torque_n_m) = match &mut self.body {
            Body::Beam { beam, start_m, ball, level_s } => {
                if let Some(rolling) = ball {
                    rolling.roll(beam, angle_rad, rate_rad_s, self.period_s);
                    self.score.count(time_s, self.period_s, rolling.at_m);
                    if rolling.has_fallen(beam) {
                        self.score.tally.falls += 1;
                        (*ball, *level_s) = (None, 0.0);
                    }
                } else {
                    *level_s = if angle_rad.abs() < LEVEL_RAD { *level_s + self.period_s } else { 0.0 };
                    if *level_s >= LEVEL_S {
                        *ball = Some(Ball::put_down(*start_m));
                        self.score.begin(time_s, BALL_SETTLES_S);
                    }
                }
                match ball {
                    Some(ball) => (Some(ball.at_m), ball.at_m, ball.torque_n_m(beam, angle_rad, rate_rad_s)),
                    None => (None, f64::NAN, 0.0),
                }
            }
            Body::Servo { asked_rad, until_s, most_rad, centre_s, rad_per_s, pilot } => {
                if time_s >= *until_s {
                    *until_s = time_s + ASKED_FOR_S;
                    *asked_rad = *most_rad * (2.0 * pilot.even() - 1.0);
                    self.score.begin(time_s, SERVO_SETTLES_S);
                }
                self.score.count(time_s, self.period_s, angle_rad - *asked_rad);
                (Some(*centre_s + *asked_rad / *rad_per_s), *asked_rad, 0.0)
            }
        };
        // a camera that sees no ball says nothing
        if let Some(said) = self.sensor.look(time_s, seen.unwrap_or(f64::NAN)).filter(|said| said.is_finite()) {
            self.watch.say(said);
        }
        wires.disturb(self.channel, &World { draught, pull_n: torque_n_m / self.lever_m, ..World::CALM });
        self.watch.set_pose(Pose { angle_rad, other }, draught);
        self.watch.set_tally(&self.score.tally);
    }
}
