//! The machines of chapter 12 that simulated wires move ([`[demonstrator]`](sinew_rig::Demonstrator) of a rig file), and what
//! a robot program sees of them.
//!
//! [`Demonstrator`] stands around a simulated rig: after each period it lets its bodies move as far as the wire has turned
//! them, puts their weight on the wire for the next, and lets its draughts blow. [`DemonstratorBackend`] is both as the driver's
//! backend. A robot program sees none of it: it has the ordinary client, and the lines of its sensors ([`Watch::reading`]), a camera, a
//! receiver, a compass or potentiometers, late and noisy. Whoever draws or judges has the truth ([`Watch::pose`], [`Watch::tally`]), from any thread.
//!
//! ```
//! use sinew_demonstrators::{Demonstrator, Pose};
//! use sinew_backend::Backend;
//!
//! let rig = sinew_rig::Rig::parse(sinew_demonstrators::BALL_ON_BEAM, "ball-on-beam.toml")?;
//! let mut wires = sinew_sim_backend::SimulatedRig::new(&rig)?;
//! let mut beam = Demonstrator::of(&rig)?.ok_or("it has a demonstrator")?;
//! wires.start()?;
//! let mut samples = [sinew_backend::Sample::NONE];
//! for _ in 0..1000 {
//!     wires.exchange(&[0.0], &mut samples)?;
//!     beam.pass(&mut wires);
//! }
//! let Pose::Beam { angle_rad, .. } = beam.watch().pose() else { unreachable!("it is a beam") };
//! assert!(angle_rad < -0.02, "cold and long, the wire lets its end of the beam down");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod arm;
mod backend;
mod ball;
mod bound;
mod chance;
mod demonstrator;
mod hexapod;
mod picture;
mod pose;
mod sensor;
mod space;
mod torso;
mod watch;

pub use backend::DemonstratorBackend;
pub use bound::{Catchable, Walkable};
pub use demonstrator::{Demonstrator, Error};
pub use hexapod::Stance;
pub use picture::{Ink, Picture, Shape};
pub use pose::Pose;
pub use watch::{Reading, SAID, Tally, Watch};

/// The rig file of the arm.
pub const ARM: &str = include_str!("arm.toml");
/// The rig file of the ball on the beam.
pub const BALL_ON_BEAM: &str = include_str!("ball-on-beam.toml");
/// The rig file of the servo in a Bowden tube.
pub const BOWDEN_SERVO: &str = include_str!("bowden-servo.toml");
/// The rig file of the micro-servo.
pub const SERVO: &str = include_str!("servo.toml");
/// The rig file of the torso with two arms.
pub const TORSO: &str = include_str!("torso.toml");
/// The rig file of the hexapod that walks.
pub const WALKER: &str = include_str!("walker.toml");
