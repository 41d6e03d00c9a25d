//! The result of one sample: length, resistance, health.

use crate::health::Health;

/// What one sample says of the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Wire length, in m; NaN unless `health` is [`Health::Ok`].
    pub length_m: f64,
    /// Resistance V3/I of the whole wire, in Ω; NaN where no current was measured.
    pub resistance_ohm: f64,
    /// Resistivity between the taps (eq. 44), or of the whole wire by its estimated length (eq. 39), in Ω m;
    /// NaN unless `health` is [`Health::Ok`].
    pub resistivity_ohm_m: f64,
    /// The verdict.
    pub health: Health,
    /// Standard deviation of `length_m` from the converter's noise, in m; infinite where there is no length.
    pub length_sigma_m: f64,
    /// Standard deviation of `resistance_ohm` from the converter's noise, in Ω; infinite where there is no length.
    pub resistance_sigma_ohm: f64,
}

impl Reading {
    /// No length, for this reason.
    pub const fn none(health: Health) -> Reading {
        Reading {
            length_m: f64::NAN,
            resistance_ohm: f64::NAN,
            resistivity_ohm_m: f64::NAN,
            health,
            length_sigma_m: f64::INFINITY,
            resistance_sigma_ohm: f64::INFINITY,
        }
    }

    /// The length, where one was measured.
    pub fn length(&self) -> Option<f64> {
        self.health.is_ok().then_some(self.length_m)
    }
}
