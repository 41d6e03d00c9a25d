//! The estimators of a wire's temperature, phase and loss to the air, one a file, and the table they are registered in.
//!
//! **To add an estimator**: write its file here, with a type that has `update(&mut self, &Observation) -> Estimate` and
//! `reset(&mut self)`; add its `mod` line and its row below; run `SINEW_BLESS=1 cargo test -p sinew-control --test integration tables::`. Rig
//! file, driver, bench, command line and docs follow from the row.

mod enthalpy;
mod fused;
mod luenberger;
mod surface;
#[macro_use]
mod table;

pub use table::EstimatorRow;

// For each type of estimator its words in the rig file. `protective`: whether its temperature can be trusted with the wire's
// life; where not, the driver runs an enthalpy observer beside it. Chapter 9's estimators are tens of kelvins off whenever the
// wire moves, and in a draught.
estimators! {
    fused::FusedEstimator {
        /// Length, resistance, power and model weighed together.
        Fused { word: "fused", protective: true, new: FusedEstimator::new }
    }
    enthalpy::EnthalpyObserver {
        /// Enthalpy from the power, phase from the length.
        Enthalpy { word: "enthalpy", protective: true, new: EnthalpyObserver::new }
    }
    luenberger::LuenbergerObserver {
        /// The thesis' linear state estimator with constant gains, for comparison.
        Luenberger { word: "luenberger", protective: false, new: LuenbergerObserver::constant }
        /// The same with gains scheduled by the slope of the phase.
        LuenbergerScheduled { word: "luenberger_scheduled", protective: false, new: LuenbergerObserver::scheduled }
    }
}
