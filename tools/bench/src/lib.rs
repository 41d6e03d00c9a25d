//! Sensing, estimators and controllers on the same simulated plants, compared with the physical bounds.
//!
//! It runs the product's own code: a rig file configures the driver ([`sinew_rig`]), [`sinew_driver::Engine`] runs its cycles,
//! and [`sinew_sim_backend::SimulatedRig`] is the real rig, which may differ. Every value of the rig file's keys
//! for controller, estimator and sensing is a row ([`Choice::all`]).
//! Everything is simulated time and seeded: the same call gives the same numbers, whatever the machine.
//!
//! # Example
//! ```
//! use sinew_bench::{Choice, Plant};
//!
//! // the rig as configured in the driver, and the true, misjudged rig
//! let plant = Plant::named("hotter").ok_or("no such plant")?;
//! let believed = plant.believed(&Choice::default(), 1)?;
//! let truth = plant.truth(&believed);
//! assert!(truth != believed);
//! assert!(Choice::all().contains(&Choice::default()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod answer;
pub mod bound;
mod choice;
mod exact;
pub mod findings;
pub mod follow;
mod page;
mod plant;
pub mod row;
mod run;
pub mod score;
pub mod sensing;
mod session;
mod text;
mod trial;

pub use answer::{About, Answer, Reachable, SCHEMA, reachable, sensing_report};
pub use bound::{Bound, time_optimal};
pub use choice::Choice;
pub use exact::{ExactStep, exact_steps};
pub use page::{page, pictures};
pub use plant::{Family, Plant};
pub use row::{Figures, Row, Trace, Traces};
pub use run::{Filter, Plan, QUICK, Ran, run};
pub use session::{Error, Moment, Session};
pub use text::text;
pub use trial::{BAND, Disturbed, Sine, Step, disturb, idle, sine, step};
