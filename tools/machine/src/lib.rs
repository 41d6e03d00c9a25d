//! The test machine: chapter 8 of the thesis as software.
//!
//! [`Machine`] is what every testing machine can do in one period; [`SimulatedMachine`] computes one. A [`Routine`] is a
//! state machine over what the machine saw, made of [`Stage`]s; [`plan`] has the seven of the thesis. [`run()`](run::run)
//! brings both together under the [`Watch`] of the limits, and [`record`] makes a recording of it that `simulate`,
//! `identify` and `diagnose` take.
#![forbid(unsafe_code)]

pub mod analysis;
pub mod characterise;
pub mod hanging;
mod machine;
mod page;
pub mod plan;
pub mod record;
mod report;
mod routine;
pub mod run;
mod simulated;
mod stage;
mod watch;
mod wave;

pub use machine::{Heater, Machine, MachineError, Order, Reading, Travel};
pub use page::{page, picture};
pub use plan::{Options, RoutineKind};
pub use report::{About, Report};
pub use routine::{Directive, Routine};
pub use run::{Ending, Ran, Row};
pub use simulated::{SimulatedMachine, mounted};
pub use stage::{Heat, Motion, Part, Stage, Until};
pub use watch::{Bounded, Breach, Watch};
pub use wave::{Quantity, Shape, Wave};
