//! The configuration of a [`LengthSensor`](crate::LengthSensor), and the limits that follow from the wire's hot and cold
//! state.

use crate::converter::{Circuit, Converter};
use crate::error::{Error, check, check_ordered};
use crate::line::{ResistanceLine, WireEnd};

/// Distance of every threshold from healthy values, in standard deviations of the noise: one false alarm in 10¹⁵.
pub(crate) const GUARD: f64 = 8.0;

/// How a length is made of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Two fixed taps (eq. 42; with l0 = 0 and V1 not sampled eq. 43): needs no model of the material.
    DualMeasurement {
        /// First tap, counted from the fixed end, in m.
        l0_m: f64,
        /// From the first tap to the second, in m.
        ls_m: f64,
    },
    /// Total resistance and a calibrated line (fig. 76): the baseline. Needs no taps.
    Resistance {
        /// The calibration.
        line: ResistanceLine,
    },
}

/// What a [`LengthSensor`](crate::LengthSensor) has to know. [`LengthSensorConfig::for_wire`] fills it from the wire's two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthSensorConfig {
    /// Dual measurement or resistance.
    pub method: Method,
    /// How the converter is wired.
    pub circuit: Circuit,
    /// The wire's cross-section, in m²: enters the resistivity only.
    pub area_m2: f64,
    /// The converter.
    pub converter: Converter,
    /// Below this the supply counts as dipped, in V; only seen where the supply is measured.
    pub min_supply_v: f64,
    /// Below this there is too little current to measure with, in A.
    pub min_current_a: f64,
    /// Shortest length the wire can have, in m.
    pub min_length_m: f64,
    /// Longest length the wire can have, in m.
    pub max_length_m: f64,
    /// Resistance below which the wire must be bridged, in Ω.
    pub min_resistance_ohm: f64,
    /// Resistance above which the wire must be broken, in Ω.
    pub max_resistance_ohm: f64,
}

impl LengthSensorConfig {
    /// Limits for a wire from its two ends: contracted hot and stretched cold.
    ///
    /// Lengths may pass the ends by half a stroke (though the contracted wire never by more than half of what it keeps
    /// from the second tap), resistances by a factor 0.7 and 1.4; the current must reach a fifth of what the supply
    /// drives through the largest resistance; the supply may sag by a fifth. `supply_v` is the nominal supply. The circuit
    /// is [`Circuit::Separate`]; see [`LengthSensorConfig::sharing`].
    pub fn for_wire(
        method: Method,
        area_m2: f64,
        supply_v: f64,
        hot: WireEnd,
        cold: WireEnd,
        converter: Converter,
    ) -> LengthSensorConfig {
        let stroke = (cold.length_m - hot.length_m).abs();
        let (short, long) = (hot.length_m.min(cold.length_m), hot.length_m.max(cold.length_m));
        let lowest = match method {
            // V2 ≈ V3 reads as l0 + ls and must stay outside the range.
            Method::DualMeasurement { l0_m, ls_m } => 0.5 * (short + l0_m + ls_m),
            Method::Resistance { .. } => 0.0,
        };
        let max_resistance_ohm = 1.4 * hot.resistance_ohm.max(cold.resistance_ohm);
        LengthSensorConfig {
            method,
            circuit: Circuit::Separate,
            area_m2,
            converter,
            min_supply_v: 0.8 * supply_v,
            min_current_a: 0.2 * supply_v / max_resistance_ohm,
            min_length_m: (short - 0.5 * stroke).max(lowest),
            max_length_m: long + 0.5 * stroke,
            min_resistance_ohm: 0.7 * hot.resistance_ohm.min(cold.resistance_ohm),
            max_resistance_ohm,
        }
    }

    /// The same wire behind one input for supply and current, over `low_ohm` of switch and shunt and with `lead_ohm` of
    /// known leads.
    pub fn sharing(self, low_ohm: f64, lead_ohm: f64) -> LengthSensorConfig {
        let converter = self.converter.sharing(low_ohm);
        LengthSensorConfig {
            circuit: Circuit::Shared { low_ohm, lead_ohm },
            converter,
            min_current_a: self.min_current_a.max(GUARD * converter.current_sigma_a()),
            ..self
        }
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// The first number that cannot be used, by name.
    pub fn validate(&self) -> Result<(), Error> {
        if let Method::DualMeasurement { l0_m, ls_m } = self.method {
            check("l0 in m", l0_m, 0.0, 100.0)?;
            check("ls in m", ls_m, 1e-6, 100.0)?;
        }
        if let Method::Resistance { line } = self.method {
            check("offset of the resistance line in m", line.offset_m, -1e6, 1e6)?;
            check("slope of the resistance line in m/Ω", line.slope_m_per_ohm, -1e6, 1e6)?;
        }
        if let Circuit::Shared { low_ohm, lead_ohm } = self.circuit {
            check("switch and shunt in Ω", low_ohm, 1e-6, 1e6)?;
            check("leads in Ω", lead_ohm, 0.0, 1e6)?;
        }
        let c = &self.converter;
        check("cross-section in m²", self.area_m2, 1e-15, 1.0)?;
        check("converter bits", f64::from(c.bits), 4.0, 32.0)?;
        check("voltage range in V", c.voltage_range_v, 1e-3, 1e5)?;
        check("current range in A", c.current_range_a, 1e-6, 1e5)?;
        check("voltage noise in V", c.voltage_noise_v, 0.0, 0.1 * c.voltage_range_v)?;
        check("current noise in A", c.current_noise_a, 0.0, 0.1 * c.current_range_a)?;
        check("smallest supply in V", self.min_supply_v, 0.0, 1e5)?;
        // Anything nearer to zero would take noise for a current.
        let floor = GUARD * c.current_sigma_a();
        check("smallest current in A", self.min_current_a, floor, c.current_range_a)?;
        check_ordered("length range in m", self.min_length_m, self.max_length_m)?;
        check("shortest length in m", self.min_length_m, 0.0, 100.0)?;
        check_ordered("resistance range in Ω", self.min_resistance_ohm, self.max_resistance_ohm)?;
        check("smallest resistance in Ω", self.min_resistance_ohm, 0.0, 1e9)
    }
}
