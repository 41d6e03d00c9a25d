//! The analogue-to-digital converter: its ranges, its noise, and its wiring.

/// How the converter is wired to the heating circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Circuit {
    /// V3 and the current have inputs of their own; the wire's fixed end is ground.
    Separate,
    /// One input at the wire's low end, above switch and shunt: the supply in the off-phase, the current's voltage over
    /// both in the on-phase. V3 is what the supply has left after them and the leads; the taps stand on their voltage.
    Shared {
        /// Switch and shunt, between the wire's fixed end and ground, in Ω.
        low_ohm: f64,
        /// Known leads between the supply and the moving end, in Ω.
        lead_ohm: f64,
    },
}

/// The converter: its ranges and its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    /// Resolution, in bits over −range..range.
    pub bits: u32,
    /// Largest voltage, in V.
    pub voltage_range_v: f64,
    /// Largest current, in A.
    pub current_range_a: f64,
    /// Noise of a voltage, rms, in V, without quantisation.
    pub voltage_noise_v: f64,
    /// Noise of the current, rms, in A, without quantisation.
    pub current_noise_a: f64,
}

impl Default for Converter {
    /// 16 bits, ±10 V with 1.5 mV rms, ±1 A with 0.4 mA rms.
    fn default() -> Self {
        Converter {
            bits: 16,
            voltage_range_v: 10.0,
            current_range_a: 1.0,
            voltage_noise_v: 0.0015,
            current_noise_a: 0.0004,
        }
    }
}

impl Converter {
    /// This converter with the current read as the voltage over `low_ohm`, through the same kind of input as the voltages.
    pub fn sharing(self, low_ohm: f64) -> Converter {
        Converter {
            current_range_a: self.voltage_range_v / low_ohm,
            current_noise_a: self.voltage_noise_v / low_ohm,
            ..self
        }
    }

    /// One code of a voltage, in V.
    pub(crate) fn voltage_lsb_v(&self) -> f64 {
        2.0 * self.voltage_range_v / 2f64.powi(self.bits as i32)
    }

    /// One code of the current, in A.
    pub(crate) fn current_lsb_a(&self) -> f64 {
        2.0 * self.current_range_a / 2f64.powi(self.bits as i32)
    }

    /// Standard deviation of a voltage, quantisation included, in V.
    pub fn voltage_sigma_v(&self) -> f64 {
        (self.voltage_noise_v.powi(2) + self.voltage_lsb_v().powi(2) / 12.0).sqrt()
    }

    /// Standard deviation of the current, quantisation included, in A.
    pub fn current_sigma_a(&self) -> f64 {
        (self.current_noise_a.powi(2) + self.current_lsb_a().powi(2) / 12.0).sqrt()
    }
}
