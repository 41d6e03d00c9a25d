//! The physical formulas, each in one place, with its equation number in the thesis (see the [crate's front page](crate)).
//!
//! Whoever needs a resistance, a heat loss or a tension calls it here, with the operating point as an argument: what a
//! caller leaves out on purpose (a sagging supply, the change of h with temperature) it leaves out by what it passes.
//! The step of the simulation carries products of the parameters that do not change ([`Wire`](crate::Wire)); tests hold
//! it to these formulas. All quantities are SI, temperatures in °C.
//!
//! - `electrical`: the circuit, resistance and its inverse, heating power, the dual measurement (eq. 36–44)
//! - `thermal`: convection, heat capacity, the time constant 1/λ of cooling (eq. 27, 34, 48)
//! - `mechanical`: compliance, stiffness, the pull of the load (eq. 3, 4, 51)
//! - `kinetic`: the driving temperature and the logistic curve, both ways (eq. 12, 20)
//! - `control`: the sliding surfaces (chapter 11)
//! - `life`: cycles to failure, and how the first ones settle (chapter 4)

mod control;
mod electrical;
mod kinetic;
mod life;
mod mechanical;
mod thermal;
mod wire;

pub use control::{sliding_surface, sliding_surface_first_order};
pub use electrical::{
    current_a, dual_variance, heating_power_w, mixture, phase_resistivity, regulated_a, resistance_ohm,
    resistivity_ohm_m, share_between_taps,
};
pub use kinetic::{SURELY_HOT_K, logistic, logit, stress_shift_k};
pub use life::{
    BREAK_IN_CYCLES, CycleUse, LASTING_CYCLES, LASTING_STRAIN, LASTING_STRESS_PA, Life, cycles_to_failure, overheated,
    settled, stress_for_life_pa,
};
pub use mechanical::{STANDARD_GRAVITY_M_S2, compliance, load_pull_n};
pub(crate) use thermal::CONVECTION_EXPONENT;
pub use thermal::{WORKING_EXCESS_K, convection_growth, cooling_time_s, relaxed};
