//! From requirements to a wire: what is asked for, the thesis' rules of chapter 2 that size it, a rig file of it, what that will
//! do as predicted, and what the driver would hold back of it.
#![forbid(unsafe_code)]

mod demand;
mod design;
mod figure;
mod nearest;
mod path;
mod predict;
mod rig_file;
mod rules;
mod simulate;
mod sizing;

pub use demand::{Joint, Method, Motion, Requirement, Source};
pub use design::{Design, Shortfall, best, designs};
pub use figure::compromise;
pub use nearest::{Change, Nearest, nearest};
pub use path::Path;
pub use predict::{Cycle, HeldBack, Obstacle, Prediction, Task, predict};
pub use rig_file::{load_of, rig_file, swing_s};
pub use rules::WireRules;
pub use simulate::{Simulated, simulate};
pub use sizing::{Lack, MOST_LEVER_RAD, MOST_WIRES, STOCK_DIAMETERS_M, Sizing, sizings};
