//! The test machine: chapter 8 of the thesis as software.
//!
//! [`Machine`] is the interface of every testing machine; [`SimulatedMachine`] simulates one. A [`Routine`] is a
//! state machine over the measurements, made of [`Stage`]s; [`plan`] has the seven of the thesis, one that plays a [`Programme`], and one that breaks a wire in. [`run()`](run::run)
//! runs it on a machine, or on a wire of a running driver ([`RunningRig`]), while [`Watch`] checks the limits, and [`record`] makes a recording of it for `simulate`,
//! `identify` and `diagnose`.
//!
//! # Example
//! The first second of a routine on the simulated machine:
//! ```
//! use sinew_machine::{Ending, Options, RoutineKind, SimulatedMachine, Watch, plan, run};
//! use sinew_rig::Rig;
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/test-machine.toml");
//! let rig = Rig::load(path.as_ref())?;
//! let (wire, spec) = (&rig.channels[0], &rig.machine);
//! let options = Options::default_for(RoutineKind::DirectStrain, &wire.model, spec);
//! let mut routine = plan::routine(RoutineKind::DirectStrain, &wire.model, spec, &options);
//! let mut machine = SimulatedMachine::new(&wire.model, spec, 1)?;
//! let mut watch = Watch::new(&wire.model, &wire.limits, spec);
//! let ran = run::run(&mut machine, &mut routine, &mut watch, &mut |row, _, _| row.time_s < 1.0);
//! assert_eq!(ran.ending, Ending::Stopped);
//! assert!(ran.rows.iter().all(|row| row.reading.force_n.is_finite()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod analysis;
pub mod characterise;
pub mod hanging;
mod load;
mod machine;
mod page;
pub mod plan;
mod programme;
pub mod record;
mod report;
mod routine;
pub mod run;
pub mod running;
pub mod settling;
mod simulated;
mod stage;
mod watch;
mod wave;

pub use load::OwnLoad;
pub use machine::{Heater, Machine, MachineError, Order, Reading, Travel};
pub use page::{page, picture};
pub use plan::{Options, RoutineKind};
pub use programme::{End, NoProgramme, Programme};
pub use report::{About, OnRig, Report};
pub use routine::{Directive, Routine};
pub use run::{Ending, Ran, Row};
pub use running::RunningRig;
pub use simulated::{SimulatedMachine, mounted};
pub use stage::{Heat, Motion, Part, Stage, Until};
pub use watch::{Bounded, Breach, Watch};
pub use wave::{Quantity, Shape, Wave};
