//! From requirements to a wire: what is asked for, the thesis' rules of chapter 2 that size it, a rig file of it, what that will
//! do as predicted, and what the driver would hold back of it.
//!
//! ```
//! use sinew_design::{Motion, Requirement, STOCK_DIAMETERS_M, best, designs};
//!
//! // 2 N over 6 mm
//! let requirement = Requirement::of(Motion::Linear { force_n: 2.0, stroke_m: 6e-3 });
//! let all = designs(&requirement, &STOCK_DIAMETERS_M);
//! let chosen = best(&all).expect("some wire does that");
//! assert_eq!((chosen.sizing.wires, chosen.sizing.wire.diameter_m), (1, 0.2e-3));
//! // the rules' times stand beside what is predicted of the rig file
//! let cycle = chosen.prediction.expect("what is chosen gets there and back").cycle;
//! assert!(cycle.cycle_s() > 2.0 && chosen.sizing.cycle_s() > 2.0);
//! assert!(chosen.rig_text.contains("diameter_mm = 0.2"));
//! ```
#![forbid(unsafe_code)]

mod demand;
mod design;
mod figure;
mod mechanism;
mod nearest;
mod path;
mod predict;
mod rig_file;
mod route;
mod rules;
mod simulate;
mod sizing;
mod task;

pub use demand::{Joint, Method, Motion, Requirement, Source};
pub use design::{Design, Shortfall, best, designs};
pub use figure::compromise;
pub use mechanism::{Mechanism, Worth};
pub use nearest::{Change, Nearest, nearest};
pub use path::Path;
pub use predict::{HeldBack, Prediction, predict};
pub use rig_file::{load_of, rig_file, swing_s};
pub use route::{Route, TUBE_BORE, TUBE_FRICTION, TUBE_OUTER};
pub use rules::{Allowed, WireRules};
pub use simulate::{Simulated, simulate};
pub use sizing::{Lack, MOST_LEVER_RAD, MOST_WIRES, STOCK_DIAMETERS_M, Sizing, sizings};
pub use task::{Cycle, Obstacle, Task};
