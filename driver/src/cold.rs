//! Detects a cold wire, whatever its history: the witness of length and resistance.

use sinew_control::StrokeRange;
use sinew_physics::WireModel;
use sinew_physics::formulas::{logit, resistance_ohm};
use sinew_sensing::Reading;

/// What length and resistance say together of a wire that lies at its cold end.
#[derive(Debug, Clone, Copy)]
pub struct ColdWitness {
    /// No shorter is a cold wire, m.
    least_length_m: f64,
    /// Resistance of a cold wire per length, Ω/m.
    ohm_per_m: f64,
    /// No wire that shows both is hotter, °C.
    bound_c: f64,
}

impl ColdWitness {
    /// Share of the stroke from the cold end within which a wire counts as long, and how far its resistance may be off.
    const LONG: f64 = 0.05;
    const TOLERANCE: f64 = 0.02;
    /// The resistance must tell austenite from martensite by so many times that.
    const DISTINCT: f64 = 3.0;

    /// The witness of a wire with taps; `None` where its resistance cannot tell a hot one from a cold one.
    pub fn of(model: &WireModel, stroke: &StrokeRange) -> Option<ColdWitness> {
        model.taps?;
        let (m, ambient_c) = (&model.material, model.ambient_c);
        let cold = m.martensite_resistivity(ambient_c);
        // The heating curve (eq. 20) at the phase of the longest that is not quite cold, without the load's shift.
        let by_length_c = m.austenite_temperature_c + logit(1.0 - Self::LONG) / m.heating_steepness_per_k;
        let hot = m.austenite_resistivity(m.austenite_temperature_c);
        if (hot / cold - 1.0).abs() < Self::DISTINCT * Self::TOLERANCE {
            return None;
        }
        let per_k = m.martensite_resistivity(ambient_c + 1.0) / cold - 1.0;
        let by_resistance_c = ambient_c + if per_k > 0.0 { Self::TOLERANCE / per_k } else { f64::INFINITY };
        Some(ColdWitness {
            least_length_m: stroke.length_m(Self::LONG),
            ohm_per_m: resistance_ohm(cold, 1.0, model.geometry.area_m2()),
            bound_c: by_length_c.min(by_resistance_c).max(ambient_c),
        })
    }

    /// The temperature the wire cannot be above, °C, where a reading shows it cold; `None` where it does not.
    #[inline]
    pub fn bound_c(&self, reading: &Reading) -> Option<f64> {
        let is_long = reading.length_m >= self.least_length_m;
        let off = reading.resistance_ohm / (self.ohm_per_m * reading.length_m) - 1.0;
        (reading.health.is_ok() && is_long && off.abs() <= Self::TOLERANCE).then_some(self.bound_c)
    }
}
