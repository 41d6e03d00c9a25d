//! Observation and estimate of a wire in a cycle: the types between sensing, estimators and laws.

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
    /// Standard deviation of that resistance from the converter's noise, in Ω; infinite or NaN = not known.
    pub resistance_sigma_ohm: f64,
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
            resistance_sigma_ohm: f64::NAN,
            tension_n: f64::NAN,
            dt_s,
        }
    }
}

/// The estimated state of a wire.
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

    /// Whether what a law computes power from is there.
    pub(crate) fn is_usable(&self) -> bool {
        self.temperature_c.is_finite()
            && self.martensite.is_finite()
            && self.length_m.is_finite()
            && self.velocity_m_s.is_finite()
            && self.loss_w.is_finite()
            && self.full_power_w > 0.0
    }
}
