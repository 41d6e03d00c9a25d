//! What is believed of a wire, cycle by cycle: its temperature, its phase, its loss to the air.

mod enthalpy;
mod fused;
mod luenberger;

pub use enthalpy::EnthalpyObserver;
pub use fused::FusedEstimator;
pub use luenberger::LuenbergerObserver;

use sinew_physics::WireModel;

/// What one cycle measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Mean electrical power in the wire since the last call (duty · I²R, the sensing pulse included), in W.
    /// NaN = not measured: then the duty and the model's circuit say it.
    pub power_w: f64,
    /// Duty since the last call, 0..1: what the power was given for.
    pub duty: f64,
    /// Wire length as the sensor read it, unfiltered, in m; NaN = not measured: the model alone.
    pub length_m: f64,
    /// Standard deviation of that length from the converter's noise, in m; infinite or NaN = not known.
    pub length_sigma_m: f64,
    /// Resistance of the whole wire, in Ω; NaN = not measured.
    pub resistance_ohm: f64,
    /// Wire tension, in N; NaN = follows from the load.
    pub tension_n: f64,
    /// Time since the last call, in s.
    pub dt_s: f64,
}

impl Observation {
    /// A cycle of `dt_s` in which nothing was measured but the duty.
    pub const fn nothing(duty: f64, dt_s: f64) -> Observation {
        Observation {
            power_w: f64::NAN,
            duty,
            length_m: f64::NAN,
            length_sigma_m: f64::NAN,
            resistance_ohm: f64::NAN,
            tension_n: f64::NAN,
            dt_s,
        }
    }
}

/// What is believed of a wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean wire temperature, in °C.
    pub temperature_c: f64,
    /// Martensite fraction, 0..1.
    pub martensite: f64,
    /// Temperature the wire cannot be above: half the loss to the air, no latent heat, never below the estimate; °C.
    pub hottest_c: f64,
    /// Stress of the load, in Pa.
    pub stress_pa: f64,
    /// Temperature of the heating curve at this phase and stress, in °C: above it the wire would be shorter.
    pub heating_curve_c: f64,
    /// Temperature of the cooling curve, in °C: below it the wire would be longer.
    pub cooling_curve_c: f64,
    /// Smoothed length, in m.
    pub length_m: f64,
    /// Loss to the air at this temperature, as learned, in W: the power that holds it.
    pub loss_w: f64,
    /// Standard deviation of that loss, in W.
    pub loss_sigma_w: f64,
    /// Heat and work a wire gives off when all of it turns martensite (eq. 48), in J.
    pub release_j: f64,
    /// Power the wire takes at duty 1, in W: as last measured, else by the model.
    pub full_power_w: f64,
    /// Smoothed velocity, in m/s.
    pub velocity_m_s: f64,
}

impl Estimate {
    /// An estimate that knows nothing: everything NaN.
    pub const UNKNOWN: Estimate = Estimate {
        temperature_c: f64::NAN,
        martensite: f64::NAN,
        hottest_c: f64::NAN,
        stress_pa: f64::NAN,
        heating_curve_c: f64::NAN,
        cooling_curve_c: f64::NAN,
        length_m: f64::NAN,
        loss_w: f64::NAN,
        loss_sigma_w: f64::NAN,
        release_j: f64::NAN,
        full_power_w: f64::NAN,
        velocity_m_s: f64::NAN,
    };
}

/// The estimators to choose from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EstimatorKind {
    /// [`FusedEstimator`].
    Fused,
    /// [`EnthalpyObserver`].
    Enthalpy,
    /// [`LuenbergerObserver`] with constant gains.
    Luenberger,
    /// [`LuenbergerObserver`] with gains scheduled by the slope of the phase.
    LuenbergerScheduled,
}

impl EstimatorKind {
    /// Every estimator.
    pub const ALL: [EstimatorKind; 4] =
        [EstimatorKind::Fused, EstimatorKind::Enthalpy, EstimatorKind::Luenberger, EstimatorKind::LuenbergerScheduled];

    /// Its word in the rig file.
    pub fn word(self) -> &'static str {
        match self {
            EstimatorKind::Fused => "fused",
            EstimatorKind::Enthalpy => "enthalpy",
            EstimatorKind::Luenberger => "luenberger",
            EstimatorKind::LuenbergerScheduled => "luenberger_scheduled",
        }
    }

    /// Whether its temperature can be trusted with the wire's life. Chapter 9's estimators are tens of kelvins off whenever
    /// the wire moves, and in a draught.
    pub fn is_protective(self) -> bool {
        match self {
            EstimatorKind::Fused | EstimatorKind::Enthalpy => true,
            EstimatorKind::Luenberger | EstimatorKind::LuenbergerScheduled => false,
        }
    }
}

/// A channel's estimator: one of the kinds, chosen once, dispatched without indirection.
// Lies by value in the channel's struct, as the law does.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
pub enum StateEstimator {
    /// Length, resistance, power and model weighed together.
    Fused(FusedEstimator),
    /// Enthalpy from the power, phase from the length.
    Enthalpy(EnthalpyObserver),
    /// The linear model pulled to the length, with either kind of gains.
    Luenberger(LuenbergerObserver),
}

impl StateEstimator {
    /// An estimator for a wire that starts as the model says.
    pub fn new(model: &WireModel, kind: EstimatorKind) -> StateEstimator {
        match kind {
            EstimatorKind::Fused => StateEstimator::Fused(FusedEstimator::new(model)),
            EstimatorKind::Enthalpy => StateEstimator::Enthalpy(EnthalpyObserver::new(model)),
            EstimatorKind::Luenberger => StateEstimator::Luenberger(LuenbergerObserver::constant(model)),
            EstimatorKind::LuenbergerScheduled => StateEstimator::Luenberger(LuenbergerObserver::scheduled(model)),
        }
    }

    /// Takes one cycle in.
    #[inline]
    pub fn update(&mut self, seen: &Observation) -> Estimate {
        match self {
            StateEstimator::Fused(estimator) => estimator.update(seen),
            StateEstimator::Enthalpy(estimator) => estimator.update(seen),
            StateEstimator::Luenberger(estimator) => estimator.update(seen),
        }
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        match self {
            StateEstimator::Fused(estimator) => estimator.reset(),
            StateEstimator::Enthalpy(estimator) => estimator.reset(),
            StateEstimator::Luenberger(estimator) => estimator.reset(),
        }
    }
}
