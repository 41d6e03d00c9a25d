//! From the rows of a run to its routine's results, each with its method or why it cannot be determined.

mod finding;
mod line;
pub mod loops;
pub mod played;
mod run;
pub mod settled;
pub mod steps;
pub mod sweep;

use crate::plan::RoutineKind;

pub use finding::{Estimate, Finding};
pub use run::{AtRest, Run};

/// Every number of a run.
pub fn findings(run: &Run<'_>) -> Vec<Finding> {
    match run.kind {
        RoutineKind::DirectStrain | RoutineKind::DirectLoad => loops::findings(run),
        RoutineKind::ConstantForceSweep | RoutineKind::ConstantStrainSweep => sweep::open_loop(run),
        RoutineKind::PositionRegulation => steps::findings(run),
        RoutineKind::PositionTracking | RoutineKind::TrackingSweep => sweep::closed_loop(run),
        RoutineKind::Programme => played::findings(run),
        RoutineKind::BreakIn => settled::findings(run),
    }
}
