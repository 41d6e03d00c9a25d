//! The noise budget of `docs/board.md`: what each part of a sample's noise comes to as a length, by the equations that sense
//! (`sinew-sensing`), for the reference wire of `docs/sensing.md`.

use sinew_sensing::{Converter, LengthSensor, LengthSensorConfig, Method, WireEnd};

/// The reference wire: 0.125 mm × 160 mm, taps at 0 and 150 mm, cold.
pub const LENGTH_M: f64 = 0.163;
pub const LS_M: f64 = 0.150;
pub const RESISTANCE_OHM: f64 = 11.3;
pub const SUPPLY_V: f64 = 6.5;
/// Least duty that is measured in, and the rate.
pub const SENSING_DUTY: f64 = 0.02;
pub const RATE_HZ: f64 = 500.0;
/// What a sample may have.
pub const WANTED_M: f64 = 0.1e-3;

/// A converter that could be on the board.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    pub name: &'static str,
    /// Where the figures are from.
    pub source: &'static str,
    /// Full scale of the voltages, V, and signal to noise of a full sine, dB.
    pub full_v: f64,
    pub snr_db: f64,
    /// Its inputs' filter: corner, Hz, and order; `None` = it has none.
    pub filter: Option<(f64, u32)>,
    /// Inputs, and conversions at once.
    pub inputs: u32,
    pub at_once: u32,
}

/// 8.7 effective bits of a range of one sign are 54.1 dB of a sine through all of it.
pub const CANDIDATES: [Candidate; 3] = [
    Candidate {
        name: "RP2040's own",
        source: "RP2040 data sheet: 8.7 effective bits; 3.3 V behind a divider by 3",
        full_v: 5.0,
        snr_db: 54.1,
        filter: None,
        inputs: 3,
        at_once: 1,
    },
    Candidate {
        name: "ADS8688",
        source: "SBAS582, from memory, not at hand: 92 dB, 15 kHz, second order",
        full_v: 10.24,
        snr_db: 92.0,
        filter: Some((15_000.0, 2)),
        inputs: 8,
        at_once: 1,
    },
    Candidate {
        name: "AD7616",
        source: "data sheet Rev. 0, its first page: 90.5 dB at 1 MSPS, first order; from memory: 39 kHz",
        full_v: 10.0,
        snr_db: 90.5,
        filter: Some((39_000.0, 1)),
        inputs: 16,
        at_once: 2,
    },
];

impl Candidate {
    /// Noise of a voltage, rms, V.
    pub fn sigma_v(&self) -> f64 {
        self.full_v / 2f64.sqrt() * 10f64.powf(-self.snr_db / 20.0)
    }

    /// How much of an on-phase's voltage is missing at a time after it began, in parts.
    pub fn missing(&self, time_s: f64) -> f64 {
        let Some((corner_hz, order)) = self.filter else { return 0.0 };
        let at = 2.0 * std::f64::consts::PI * corner_hz * time_s;
        match order {
            1 => (-at).exp(),
            // Butterworth, its envelope.
            _ => 2f64.sqrt() * (-at / 2f64.sqrt()).exp(),
        }
    }

    /// Until less than this is missing, s.
    pub fn settled_s(&self, missing: f64) -> f64 {
        (0..).map(|us| f64::from(us) * 1e-6).find(|time_s| self.missing(*time_s) <= missing).unwrap_or(f64::NAN)
    }
}

/// The current through the reference wire over the shunt and the switch, A.
pub fn current_a(shunt_ohm: f64, switch_ohm: f64) -> f64 {
    SUPPLY_V / (RESISTANCE_OHM + shunt_ohm + switch_ohm)
}

/// σ of a length for a noise of its three voltages, m: `LengthSensor` itself says it.
pub fn sigma_m(noise_v: f64, current_a: f64) -> f64 {
    let converter = Converter { bits: 24, voltage_range_v: 10.0, voltage_noise_v: noise_v, ..Converter::default() };
    let config = LengthSensorConfig::for_wire(
        Method::DualMeasurement { l0_m: 0.0, ls_m: LS_M },
        std::f64::consts::FRAC_PI_4 * 0.125e-3f64.powi(2),
        SUPPLY_V,
        WireEnd { resistance_ohm: 11.9, length_m: 0.1603 },
        WireEnd { resistance_ohm: 10.4, length_m: 0.1667 },
        converter,
    );
    let sensor = LengthSensor::new(config).expect("a valid configuration");
    sensor.expected_sigma_m(LENGTH_M, current_a * RESISTANCE_OHM, current_a)
}

/// One row of the budget: a cause, and the noise of a voltage it makes, rms, V.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    pub cause: &'static str,
    pub by: &'static str,
    pub noise_v: f64,
}

/// Boltzmann's constant, J/K.
const BOLTZMANN: f64 = 1.380_649e-23;
/// Noise of the shunt's range as a share of full scale is assumed not better than this, dB: the data sheet's figure for ±2.5 V was not at hand.
pub const SHUNT_SNR_DB: f64 = 84.0;
/// What a sliding tap adds, V: the thesis' laboratory measured 1.5 mV in all (`docs/sensing.md`), and nothing is known of this board's.
const CONTACT_V: f64 = 1.5e-3;

/// The shunt's noise, V.
pub fn shunt_noise_v() -> f64 {
    2.5 / 2f64.sqrt() * 10f64.powf(-SHUNT_SNR_DB / 20.0)
}

/// The rows, for the AD7616.
pub fn rows() -> [Row; 5] {
    let converter = CANDIDATES[2];
    let band_hz = std::f64::consts::FRAC_PI_2 * converter.filter.map_or(0.0, |(corner_hz, _)| corner_hz);
    let code_v = 10.0 / 65_534.0;
    [
        Row {
            cause: "converter",
            by: "90.5 dB below a full sine of ±10 V, quantisation included",
            noise_v: converter.sigma_v(),
        },
        Row {
            cause: "shunt's range",
            by: "84 dB (assumed) of ±2.5 V, subtracted from every tap",
            noise_v: shunt_noise_v(),
        },
        Row { cause: "code of the line", by: "10 V / 65534, uniform", noise_v: code_v / 12f64.sqrt() },
        Row {
            cause: "1 kΩ in each input",
            by: "√(4 k T R B), B = π/2 × 39 kHz",
            noise_v: (4.0 * BOLTZMANN * 300.0 * 1000.0 * band_hz).sqrt(),
        },
        Row { cause: "sliding taps", by: "1.5 mV, all that the thesis' set-up had", noise_v: CONTACT_V },
    ]
}

/// The noise of a voltage with everything, V.
pub fn total_v(rows: &[Row]) -> f64 {
    rows.iter().map(|row| row.noise_v.powi(2)).sum::<f64>().sqrt()
}
