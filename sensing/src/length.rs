//! One sample in, one length out, with its standard deviation and a verdict.
//!
//! Every threshold stands [`GUARD`] standard deviations of the converter's noise clear of what it must not hit, so
//! that a healthy channel raises no alarm in years of running; what it must hit lies far beyond it (a lost probe is wrong
//! by whole strokes, an open wire by orders of magnitude), so that one sample is enough.

use crate::error::{check, check_ordered};
use crate::{Error, Health, ResistanceLine};

/// Distance of every threshold from healthy values, in standard deviations of the noise: one false alarm in 10¹⁵.
const GUARD: f64 = 8.0;

/// How far the first tap may stray from its fixed share of the second, as a part of V3: offsets of the converter
/// and the lead at the fixed end are below, a lost first probe is above it, or else too small to matter.
const TAP_TOLERANCE: f64 = 0.02;

/// The same where the first tap is well away from the fixed end. There the lead moves both taps nearly alike, and a tap
/// that sticks to the wire shows: its share moves with the wire.
const FAR_TAP_TOLERANCE: f64 = 0.01;
const FAR_TAP_SHARE: f64 = 0.1;

/// Chance per sample at which a repeated code counts as frozen.
const STUCK_CHANCE: f64 = 1e-15;

/// A code that would have to repeat more often than this to be suspect says nothing; it is not watched.
const STUCK_LIMIT: f64 = 2000.0;

/// What the converter saw in one period: all of it in the on-phase, save the supply of a shared input. NaN = not sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// First tap against ground, V1, in V.
    pub v1_v: f64,
    /// Second tap against ground, V2, in V.
    pub v2_v: f64,
    /// Moving end against ground, V3, in V; not sampled where the input is shared.
    pub v3_v: f64,
    /// Current through the wire, in A.
    pub current_a: f64,
    /// Supply, in V; NaN = not measured. Of a shared input: as it saw it in the off-phase of the same period.
    pub supply_v: f64,
}

impl Sample {
    /// A period in which nothing was sampled.
    pub const NONE: Sample =
        Sample { v1_v: f64::NAN, v2_v: f64::NAN, v3_v: f64::NAN, current_a: f64::NAN, supply_v: f64::NAN };
}

impl Default for Sample {
    fn default() -> Self {
        Sample::NONE
    }
}

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

    fn voltage_lsb_v(&self) -> f64 {
        2.0 * self.voltage_range_v / 2f64.powi(self.bits as i32)
    }

    fn current_lsb_a(&self) -> f64 {
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

/// What a [`LengthSensor`] has to know. [`LengthSensorConfig::for_wire`] fills it from the wire's two ends.
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
    /// Limits for a wire from its two ends, each (resistance in Ω, length in m): contracted hot and stretched cold.
    ///
    /// Lengths may pass the ends by half a stroke (though the contracted wire never by more than half of what it keeps
    /// from the second tap), resistances by a factor 0.7 and 1.4; the current must reach a fifth of what the supply
    /// drives through the largest resistance; the supply may sag by a fifth. `supply_v` is the nominal supply. The circuit
    /// is [`Circuit::Separate`]; see [`LengthSensorConfig::sharing`].
    pub fn for_wire(
        method: Method,
        area_m2: f64,
        supply_v: f64,
        hot: (f64, f64),
        cold: (f64, f64),
        converter: Converter,
    ) -> LengthSensorConfig {
        let stroke = (cold.1 - hot.1).abs();
        let (short, long) = (hot.1.min(cold.1), hot.1.max(cold.1));
        let lowest = match method {
            // V2 ≈ V3 reads as l0 + ls and must stay outside the range.
            Method::DualMeasurement { l0_m, ls_m } => 0.5 * (short + l0_m + ls_m),
            Method::Resistance { .. } => 0.0,
        };
        let max_resistance_ohm = 1.4 * hot.0.max(cold.0);
        LengthSensorConfig {
            method,
            circuit: Circuit::Separate,
            area_m2,
            converter,
            min_supply_v: 0.8 * supply_v,
            min_current_a: 0.2 * supply_v / max_resistance_ohm,
            min_length_m: (short - 0.5 * stroke).max(lowest),
            max_length_m: long + 0.5 * stroke,
            min_resistance_ohm: 0.7 * hot.0.min(cold.0),
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

/// Samples after which frozen inputs are found; `None` where noise is too small beside one code to tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StuckAfter {
    /// The whole converter.
    pub all: Option<u32>,
    /// One voltage alone.
    pub voltage: Option<u32>,
    /// The current alone.
    pub current: Option<u32>,
}

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
        }
    }

    /// The length, where one was measured.
    pub fn length(&self) -> Option<f64> {
        self.health.is_ok().then_some(self.length_m)
    }
}

/// Counts how long the inputs have repeated their codes, and weighs it.
///
/// Noise repeats a code now and then, but not for long and not on all inputs at once: the inputs' noises are independent,
/// so the chances multiply. A whole converter that has frozen is found in a few samples, a single input in as many as its
/// own noise needs.
#[derive(Debug, Clone, Copy)]
struct Repeats {
    last: [f64; Repeats::INPUTS],
    count: [u32; Repeats::INPUTS],
    /// −ln of the chance that noise repeats the code of an input; 0 where that says nothing.
    weight: [f64; Repeats::INPUTS],
}

impl Repeats {
    /// V1, V2, V3, current.
    const INPUTS: usize = 4;

    /// Noise and step of each input, in its unit.
    fn new(inputs: [(f64, f64); Repeats::INPUTS]) -> Repeats {
        let weight = inputs.map(|(sigma, lsb)| {
            // The noise may turn out to be half of what the rig file says; then a code is at most this likely, wherever the
            // signal stands within it, and so is its repetition.
            let likeliest = libm::erf(lsb / (2.0 * std::f64::consts::SQRT_2 * 0.5 * sigma));
            let weight = -likeliest.ln();
            // NaN and infinity: no noise at all.
            if weight.is_finite() && weight * STUCK_LIMIT > -STUCK_CHANCE.ln() { weight } else { 0.0 }
        });
        Repeats { last: [f64::NAN; Repeats::INPUTS], count: [0; Repeats::INPUTS], weight }
    }

    /// Takes the next codes (NaN = not sampled); true once they have repeated too often.
    #[inline]
    fn frozen(&mut self, codes: [f64; Repeats::INPUTS]) -> bool {
        let mut against = 0.0;
        for (i, code) in codes.into_iter().enumerate() {
            self.count[i] = if code == self.last[i] { self.count[i].saturating_add(1) } else { 0 };
            self.last[i] = code;
            against += self.weight[i] * f64::from(self.count[i]);
        }
        against >= -STUCK_CHANCE.ln()
    }

    /// Repetitions after which these inputs, all frozen, are found.
    fn limit(&self, inputs: &[usize]) -> Option<u32> {
        let weight: f64 = inputs.iter().map(|&i| self.weight[i]).sum();
        (weight > 0.0).then(|| (-STUCK_CHANCE.ln() / weight).ceil() as u32)
    }
}

/// Turns samples of one channel into lengths.
#[derive(Debug, Clone, Copy)]
pub struct LengthSensor {
    config: LengthSensorConfig,
    sigma_v: f64,
    sigma_i: f64,
    // Noise of V3, in V, and how much of it is not V1's and V2's kind, in units of a voltage's variance.
    sigma_v3: f64,
    drop: f64,
    full_v: f64,
    full_i: f64,
    // Guards on R against its limits, as a voltage.
    guard_short_v: f64,
    guard_open_v: f64,
    // Share of V2 that V1 must be, and how far noise alone may move it.
    tap_share: f64,
    tap_tolerance: f64,
    guard_tap_v: f64,
    half_span_m: f64,
    repeats: Repeats,
}

impl LengthSensor {
    /// A sensor with its thresholds worked out.
    ///
    /// # Errors
    /// As [`LengthSensorConfig::validate`].
    pub fn new(config: LengthSensorConfig) -> Result<LengthSensor, Error> {
        config.validate()?;
        let c = config.converter;
        let (sigma_v, sigma_i) = (c.voltage_sigma_v(), c.current_sigma_a());
        let tap_share = match config.method {
            Method::DualMeasurement { l0_m, ls_m } => l0_m / (l0_m + ls_m),
            Method::Resistance { .. } => 0.0,
        };
        let drop = match config.circuit {
            Circuit::Separate => 0.0,
            Circuit::Shared { low_ohm, lead_ohm } => lead_ohm / low_ohm,
        };
        let sigma_v3 = match config.circuit {
            Circuit::Separate => sigma_v,
            Circuit::Shared { .. } => sigma_v * (1.0 + (1.0 + drop) * (1.0 + drop)).sqrt(),
        };
        let voltage = (c.voltage_noise_v, c.voltage_lsb_v());
        // A code at 0 V that is cut off there repeats without being frozen: V1 at the fixed end says nothing, unless it
        // stands on a shunt.
        let shared = matches!(config.circuit, Circuit::Shared { .. });
        let first = if tap_share > 0.0 || shared { voltage } else { (0.0, 0.0) };
        Ok(LengthSensor {
            config,
            sigma_v,
            sigma_i,
            sigma_v3,
            drop,
            full_v: c.voltage_range_v - 1.5 * c.voltage_lsb_v(),
            full_i: c.current_range_a - 1.5 * c.current_lsb_a(),
            guard_short_v: GUARD * (sigma_v3 + config.min_resistance_ohm * sigma_i),
            guard_open_v: GUARD * (sigma_v3 + config.max_resistance_ohm * sigma_i),
            tap_share,
            tap_tolerance: if tap_share > FAR_TAP_SHARE { FAR_TAP_TOLERANCE } else { TAP_TOLERANCE },
            guard_tap_v: GUARD * sigma_v * (1.0 + tap_share * tap_share).sqrt(),
            half_span_m: 0.5 * (config.max_length_m - config.min_length_m),
            repeats: Repeats::new([first, voltage, voltage, (c.current_noise_a, c.current_lsb_a())]),
        })
    }

    /// The configuration it was made from.
    pub fn config(&self) -> &LengthSensorConfig {
        &self.config
    }

    /// Samples after which a frozen converter, or a single frozen voltage or current, is found: `None` where the noise is too
    /// small beside one code to tell.
    pub fn stuck_after(&self) -> StuckAfter {
        let dual = matches!(self.config.method, Method::DualMeasurement { .. });
        let all: &[usize] = if dual { &[0, 1, 2, 3] } else { &[2, 3] };
        StuckAfter {
            all: self.repeats.limit(all),
            voltage: self.repeats.limit(&[2]),
            current: self.repeats.limit(&[3]),
        }
    }

    /// Standard deviation of a length measured at this length and this V3, in m: to design with.
    pub fn expected_sigma_m(&self, length_m: f64, v3_v: f64, current_a: f64) -> f64 {
        match self.config.method {
            Method::DualMeasurement { l0_m, ls_m } => {
                let between = v3_v * ls_m / length_m;
                self.dual_sigma(ls_m, between, (length_m - l0_m) / ls_m)
            }
            Method::Resistance { line } => self.line_sigma(&line, v3_v, current_a, v3_v / current_a),
        }
    }

    /// Reads one sample. Any bit pattern is allowed in it.
    #[inline]
    pub fn read(&mut self, sample: &Sample) -> Reading {
        let Sample { v1_v: mut v1, v2_v: mut v2, v3_v: mut v3, current_a: i, supply_v: supply } = *sample;
        let c = &self.config;
        let dual = matches!(c.method, Method::DualMeasurement { .. });
        let shared = matches!(c.circuit, Circuit::Shared { .. });
        // In a shared circuit the supply stands where V3 stands in the other, until the drops are taken off.
        let third = if shared { supply } else { v3 };
        let whole = third.is_finite() && i.is_finite() && !supply.is_infinite();
        // eq. 43: the first tap may be the fixed end itself, and need not be sampled
        let taps = !dual || (v2.is_finite() && (v1.is_finite() || (v1.is_nan() && self.tap_share == 0.0)));
        if !(whole && taps) {
            let none = third.is_nan() && i.is_nan() && (!dual || (v1.is_nan() && v2.is_nan()));
            return Reading::none(if none { Health::NoSample } else { Health::NotFinite });
        }
        // All count on every sample, so that a frozen one is found whatever the others do.
        let frozen = self.repeats.frozen(if dual { [v1, v2, third, i] } else { [f64::NAN, f64::NAN, third, i] });
        let tap = if dual { v2.abs().max(v1.abs()) } else { 0.0 }; // `max` leaves a NaN out
        let highest = third.abs().max(tap);

        if let Circuit::Shared { low_ohm, lead_ohm } = c.circuit {
            // With the wire broken the off-phase shows no supply either.
            if supply < GUARD * self.sigma_v && i < c.min_current_a {
                return Reading::none(Health::OpenWire);
            }
            let low = i * low_ohm;
            v3 = supply - low - i * lead_ohm;
            (v1, v2) = (v1 - low, v2 - low);
        }
        if v1.is_nan() || !dual {
            v1 = 0.0;
        }
        if !dual {
            v2 = 0.0;
        }
        if supply < c.min_supply_v {
            return Reading::none(Health::SupplyDip);
        }
        if i < c.min_current_a {
            // Voltage without current is a break beyond the taps; neither is no on-phase, or a break before them.
            let voltage = v3 > c.min_current_a * c.max_resistance_ohm + self.guard_open_v;
            return Reading::none(if voltage && !shared { Health::OpenWire } else { Health::NoCurrent });
        }
        let per_amp = 1.0 / i;
        let resistance_ohm = v3 * per_amp;
        let failed = |health| Reading { resistance_ohm, ..Reading::none(health) };
        // Before saturation: a short drives the current out of range, and then the true resistance is smaller still.
        if v3 < c.min_resistance_ohm * i - self.guard_short_v {
            return failed(Health::ShortedWire);
        }
        if highest >= self.full_v || i >= self.full_i {
            return failed(Health::Saturated);
        }
        if v3 > c.max_resistance_ohm * i + self.guard_open_v {
            return failed(Health::OpenWire);
        }
        let (length_m, length_sigma_m, resistivity_ohm_m) = match c.method {
            Method::DualMeasurement { l0_m, ls_m } => {
                // Whatever the wire is made of, V1 is a fixed share of V2: the only redundancy among three voltages.
                let between = v2 - v1;
                let stray = (v1 - self.tap_share * v2).abs();
                if between < GUARD * std::f64::consts::SQRT_2 * self.sigma_v
                    || stray > self.tap_tolerance * v3 + self.guard_tap_v
                {
                    return failed(Health::ProbeLost);
                }
                let ratio = (v3 - v1) / between;
                let length = l0_m + ls_m * ratio; // eq. 42
                (length, self.dual_sigma(ls_m, between, ratio), c.area_m2 / ls_m * between * per_amp) // eq. 44
            }
            Method::Resistance { line } => {
                let length = line.length_m(resistance_ohm);
                (length, self.line_sigma(&line, v3, i, resistance_ohm), resistance_ohm * c.area_m2 / length) // eq. 39
            }
        };
        let outside = (c.min_length_m - length_m).max(length_m - c.max_length_m) - GUARD * length_sigma_m;
        // Written so that NaN fails, though none can get here.
        if outside.is_nan() || outside > 0.0 {
            let lost = match c.method {
                // Far out, or V2 the same as V3: the moving end cannot come down to the second tap.
                Method::DualMeasurement { l0_m, ls_m } => {
                    outside > self.half_span_m || length_m < l0_m + ls_m + GUARD * length_sigma_m
                }
                Method::Resistance { .. } => false,
            };
            return failed(if lost { Health::ProbeLost } else { Health::OutOfRange });
        }
        if frozen {
            return failed(Health::Stuck);
        }
        Reading { length_m, resistance_ohm, resistivity_ohm_m, health: Health::Ok, length_sigma_m }
    }

    /// Forgets how long codes have repeated.
    pub fn reset(&mut self) {
        (self.repeats.last, self.repeats.count) = ([f64::NAN; Repeats::INPUTS], [0; Repeats::INPUTS]);
    }

    /// First-order propagation through eq. 42: ∂L/∂V3 = ls/D, ∂L/∂V2 = −q ls/D, ∂L/∂V1 = (q−1) ls/D with
    /// D = V2 − V1 and q = (V3 − V1)/D. In a shared circuit V3 stands on the supply and, through the leads, on the current's
    /// voltage; what switch and shunt take is taken off V1, V2 and V3 alike and falls out.
    #[inline]
    fn dual_sigma(&self, ls_m: f64, between_v: f64, ratio: f64) -> f64 {
        let rest = ratio - 1.0;
        ls_m * self.sigma_v / between_v * (1.0 + ratio * ratio + rest * rest + self.drop * self.drop).sqrt()
    }

    /// First-order propagation through L = a + b V3/I.
    #[inline]
    fn line_sigma(&self, line: &ResistanceLine, v3: f64, i: f64, resistance: f64) -> f64 {
        let relative = ((self.sigma_v3 / v3).powi(2) + (self.sigma_i / i).powi(2)).sqrt();
        (line.slope_m_per_ohm * resistance).abs() * relative
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng, rngs::SmallRng};
    use rand_distr::StandardNormal;

    const AREA: f64 = 1.2272e-8;
    const HOT: (f64, f64) = (11.9, 0.1603);
    const COLD: (f64, f64) = (10.4, 0.1667);

    fn config(l0_m: f64, ls_m: f64) -> LengthSensorConfig {
        let method = Method::DualMeasurement { l0_m, ls_m };
        LengthSensorConfig::for_wire(method, AREA, 6.0, HOT, COLD, Converter::default())
    }

    fn sensor() -> LengthSensor {
        LengthSensor::new(config(0.0, 0.150)).unwrap()
    }

    fn line() -> ResistanceLine {
        ResistanceLine::through(HOT, COLD).unwrap()
    }

    fn resistance_sensor() -> LengthSensor {
        let method = Method::Resistance { line: line() };
        let config = LengthSensorConfig::for_wire(method, AREA, 6.0, HOT, COLD, Converter::default());
        LengthSensor::new(config).unwrap()
    }

    /// What a wire of this length and resistance shows on the given taps.
    fn sample_of(l0: f64, ls: f64, length: f64, resistance: f64, v3: f64) -> Sample {
        Sample {
            v1_v: v3 * l0 / length,
            v2_v: v3 * (l0 + ls) / length,
            v3_v: v3,
            current_a: v3 / resistance,
            supply_v: 6.0,
        }
    }

    fn healthy() -> Sample {
        sample_of(0.0, 0.150, 0.163, 11.3, 5.9)
    }

    struct Adc {
        rng: SmallRng,
        converter: Converter,
    }

    impl Adc {
        fn new(seed: u64, converter: Converter) -> Adc {
            Adc { rng: SmallRng::seed_from_u64(seed), converter }
        }

        fn measure(&mut self, s: Sample) -> Sample {
            let c = self.converter;
            let mut code = |value: f64, noise: f64, range: f64, lsb: f64| {
                let noisy = value + noise * self.rng.sample::<f64, _>(StandardNormal);
                ((noisy / lsb).round() * lsb).clamp(-range, range - lsb)
            };
            let mut voltage = |value| code(value, c.voltage_noise_v, c.voltage_range_v, c.voltage_lsb_v());
            let (v1_v, v2_v, v3_v) = (voltage(s.v1_v), voltage(s.v2_v), voltage(s.v3_v));
            let supply_v = voltage(s.supply_v);
            let current_a = code(s.current_a, c.current_noise_a, c.current_range_a, c.current_lsb_a());
            Sample { v1_v, v2_v, v3_v, current_a, supply_v }
        }
    }

    const LOW_OHM: f64 = 0.12;
    const LEAD_OHM: f64 = 0.05;

    fn shared(l0: f64, ls: f64, converter: Converter) -> LengthSensor {
        let config = LengthSensorConfig { converter, ..config(l0, ls) };
        LengthSensor::new(config.sharing(LOW_OHM, LEAD_OHM)).unwrap()
    }

    /// What a wire shows on a shared input: the circuit solved from the supply down.
    fn shared_sample(l0: f64, ls: f64, length: f64, resistance: f64, supply_v: f64) -> Sample {
        let current_a = supply_v / (LEAD_OHM + resistance + LOW_OHM);
        let (low, per_metre) = (current_a * LOW_OHM, current_a * resistance / length);
        Sample { v1_v: low + per_metre * l0, v2_v: low + per_metre * (l0 + ls), v3_v: f64::NAN, current_a, supply_v }
    }

    /// The shared input's current goes through a voltage input.
    fn shared_adc(seed: u64) -> Adc {
        Adc::new(seed, Converter::default().sharing(LOW_OHM))
    }

    #[test]
    fn a_shared_input_gives_the_same_length_and_knows_its_noise() {
        for (l0, ls) in [(0.0, 0.150), (0.091, 0.055)] {
            let mut sensor = shared(l0, ls, Converter::default());
            let exact = shared_sample(l0, ls, 0.163, 11.3, 6.0);
            let reading = sensor.read(&exact);
            assert_eq!(reading.health, Health::Ok);
            assert!((reading.length_m - 0.163).abs() < 1e-12, "{reading:?}");
            assert!((reading.resistance_ohm - 11.3).abs() < 1e-9 && reading.resistivity_ohm_m > 0.0);
            assert!((reading.resistivity_ohm_m - 11.3 * AREA / 0.163).abs() < 1e-15);
            let (mut adc, mut squares, n) = (shared_adc(1), 0.0, 200_000);
            for _ in 0..n {
                squares += (sensor.read(&adc.measure(exact)).length().unwrap() - 0.163).powi(2);
            }
            let seen = (squares / f64::from(n)).sqrt();
            assert!((seen / reading.length_sigma_m - 1.0).abs() < 0.02, "{seen} seen, {} told", reading.length_sigma_m);
        }
        // A first tap that is not sampled is the shared input itself.
        let mut sensor = shared(0.0, 0.150, Converter::default());
        let untapped = Sample { v1_v: f64::NAN, ..shared_sample(0.0, 0.150, 0.163, 11.3, 6.0) };
        assert!(sensor.read(&untapped).length_m.is_finite());
    }

    #[test]
    fn a_shared_input_raises_no_false_alarm() {
        let mut dual = shared(0.0, 0.150, Converter::default());
        let mut thesis = shared(0.091, 0.055, Converter::default());
        let mut adc = shared_adc(4);
        for k in 0..1_000_000u32 {
            let at = (0.5 + 0.7 * (f64::from(k) * 1e-5).sin()).clamp(0.0, 1.0);
            let (length, resistance) = (HOT.1 + at * (COLD.1 - HOT.1), HOT.0 + at * (COLD.0 - HOT.0));
            let supply = 5.5 + 0.5 * (f64::from(k) * 3e-6).cos();
            for (sensor, l0, ls) in [(&mut dual, 0.0, 0.150), (&mut thesis, 0.091, 0.055)] {
                let reading = sensor.read(&adc.measure(shared_sample(l0, ls, length, resistance, supply)));
                assert_eq!(reading.health, Health::Ok, "sample {k}: {reading:?}");
            }
        }
    }

    #[test]
    fn a_shared_input_finds_faults_at_once() {
        let good = shared_sample(0.0, 0.150, 0.163, 11.3, 6.0);
        let full = Sample { v1_v: 10.0, v2_v: 10.0, v3_v: f64::NAN, current_a: 10.0 / LOW_OHM, supply_v: 10.0 };
        let bridged = shared_sample(0.0, 0.150, 0.163, 1.0, 6.0);
        let cases: [(Sample, &[Health]); 8] = [
            (Sample { v1_v: 0.0, v2_v: 0.0, current_a: 0.0, supply_v: 0.0, ..good }, &[Health::OpenWire]),
            (Sample { v1_v: 0.0, v2_v: 0.0, current_a: 0.0, ..good }, &[Health::NoCurrent]),
            (bridged, &[Health::ShortedWire]),
            (shared_sample(0.0, 0.150, 0.163, 11.3, 4.5), &[Health::SupplyDip]),
            (Sample { v2_v: 1.5, ..good }, &[Health::ProbeLost]),
            (Sample { v2_v: 6.0, ..good }, &[Health::ProbeLost]),
            (full, &[Health::Saturated, Health::ShortedWire]),
            (Sample::NONE, &[Health::NoSample]),
        ];
        for (seed, (bad, expected)) in cases.into_iter().enumerate() {
            let (mut sensor, mut adc) = (shared(0.0, 0.150, Converter::default()), shared_adc(seed as u64));
            for _ in 0..500 {
                assert_eq!(sensor.read(&adc.measure(good)).health, Health::Ok);
                let reading = sensor.read(&adc.measure(bad));
                assert!(expected.contains(&reading.health), "{reading:?}, expected one of {expected:?}");
            }
        }
        let mut sensor = shared(0.0, 0.150, Converter::default());
        assert_eq!(sensor.read(&Sample { supply_v: f64::NAN, ..good }).health, Health::NotFinite);
        let refused = LengthSensor::new(config(0.0, 0.150).sharing(0.0, 0.0)).unwrap_err();
        assert!(refused.to_string().contains("switch and shunt"), "{refused}");
    }

    #[test]
    fn length_and_resistivity_are_those_of_the_thesis() {
        // Table 7: taps at 91 mm and 146 mm of a wire of 160 mm.
        let mut sensor = LengthSensor::new(config(0.091, 0.055)).unwrap();
        let reading = sensor.read(&sample_of(0.091, 0.055, 0.1603, 11.3, 5.9));
        assert_eq!(reading.health, Health::Ok);
        assert!((reading.length_m - 0.1603).abs() < 1e-12);
        assert!((reading.resistance_ohm - 11.3).abs() < 1e-12);
        assert!((reading.resistivity_ohm_m - 11.3 * AREA / 0.1603).abs() < 1e-18);
        // Eq. 43: a first tap at the fixed end need not be sampled.
        let grounded = Sample { v1_v: f64::NAN, ..healthy() };
        assert!((super::tests::sensor().read(&grounded).length_m - 0.163).abs() < 1e-12);
    }

    #[test]
    fn deviation_is_that_of_the_lengths() {
        for mut sensor in [sensor(), LengthSensor::new(config(0.091, 0.055)).unwrap(), resistance_sensor()] {
            let (l0, ls) = match sensor.config().method {
                Method::DualMeasurement { l0_m, ls_m } => (l0_m, ls_m),
                Method::Resistance { .. } => (0.0, 0.150),
            };
            let mut adc = Adc::new(1, Converter::default());
            let (mut sum, mut squares, n) = (0.0, 0.0, 200_000);
            let exact = sample_of(l0, ls, 0.163, 11.3, 5.9);
            let sigma = sensor.read(&exact).length_sigma_m;
            let expected = sensor.expected_sigma_m(0.163, 5.9, 5.9 / 11.3);
            assert!((sigma / expected - 1.0).abs() < 1e-9);
            for _ in 0..n {
                let length = sensor.read(&adc.measure(exact)).length().unwrap();
                sum += length - 0.163;
                squares += (length - 0.163).powi(2);
            }
            let mean: f64 = sum / f64::from(n);
            let seen = (squares / f64::from(n) - mean * mean).sqrt();
            assert!((seen / sigma - 1.0).abs() < 0.02, "{seen} seen, {sigma} told");
        }
    }

    #[test]
    fn no_false_alarm_in_millions_of_samples() {
        for (seed, converter) in [
            (1, Converter::default()),
            // So coarse that codes repeat, and noise far below what was promised.
            (2, Converter { bits: 12, ..Converter::default() }),
            (3, Converter { bits: 24, ..Converter::default() }),
        ] {
            let mut dual = LengthSensor::new(LengthSensorConfig { converter, ..config(0.0, 0.150) }).unwrap();
            let mut thesis = LengthSensor::new(LengthSensorConfig { converter, ..config(0.091, 0.055) }).unwrap();
            let mut plain =
                LengthSensor::new(LengthSensorConfig { converter, ..*resistance_sensor().config() }).unwrap();
            let mut adc = Adc::new(seed, converter);
            for k in 0..1_000_000u32 {
                // Through the whole stroke and a sagging supply, and long rests at its ends.
                let at = (0.5 + 0.7 * (f64::from(k) * 1e-5).sin()).clamp(0.0, 1.0);
                let (length, resistance) = (HOT.1 + at * (COLD.1 - HOT.1), HOT.0 + at * (COLD.0 - HOT.0));
                let supply = 5.5 + 0.5 * (f64::from(k) * 3e-6).cos();
                let v3 = supply * resistance / (resistance + 0.12);
                for (sensor, l0, ls) in [(&mut dual, 0.0, 0.150), (&mut thesis, 0.091, 0.055), (&mut plain, 0.0, 0.15)]
                {
                    let sample = Sample { supply_v: supply, ..sample_of(l0, ls, length, resistance, v3) };
                    let reading = sensor.read(&adc.measure(sample));
                    assert_eq!(reading.health, Health::Ok, "sample {k}, converter {seed}: {reading:?}");
                }
            }
        }
    }

    #[test]
    fn quieter_noise_than_promised_is_not_frozen() {
        let quiet = Converter { voltage_noise_v: 0.00075, current_noise_a: 0.0002, ..Converter::default() };
        let mut adc = Adc::new(9, quiet);
        let mut sensor = sensor();
        for k in 0..2_000_000u32 {
            assert_eq!(sensor.read(&adc.measure(healthy())).health, Health::Ok, "sample {k}");
        }
    }

    /// The verdicts on the first two samples of a fault, from a sensor that has run well, over many noises.
    fn found(fault: impl Fn(&mut SmallRng, Sample) -> Sample, expected: &[Health]) {
        let mut rng = SmallRng::seed_from_u64(17);
        for seed in 0..500 {
            let (mut sensor, mut adc) = (sensor(), Adc::new(seed, Converter::default()));
            let at = rng.random_range(0.0..1.0);
            let (length, resistance) = (HOT.1 + at * (COLD.1 - HOT.1), HOT.0 + at * (COLD.0 - HOT.0));
            let good = sample_of(0.0, 0.150, length, resistance, rng.random_range(4.9..5.9));
            for _ in 0..5 {
                assert_eq!(sensor.read(&adc.measure(good)).health, Health::Ok);
            }
            for _ in 0..2 {
                let reading = sensor.read(&adc.measure(fault(&mut rng, good)));
                assert!(expected.contains(&reading.health), "{reading:?}, expected one of {expected:?}");
                assert!(reading.length_m.is_nan() && reading.length().is_none());
                assert!(reading.length_sigma_m == f64::INFINITY);
            }
        }
    }

    #[test]
    fn open_wires_are_found_at_once() {
        let open = [Health::OpenWire];
        // Between the taps, above them, below them, and a crimp that still leads a little.
        found(|_, s| Sample { current_a: 0.0, v1_v: 0.0, v2_v: 0.0, v3_v: 6.0, ..s }, &open);
        found(|_, s| Sample { current_a: 0.0, v1_v: 0.0, v2_v: 6.0, v3_v: 6.0, ..s }, &open);
        found(|_, s| Sample { current_a: 0.0, v1_v: 6.0, v2_v: 6.0, v3_v: 6.0, ..s }, &open);
        found(|_, s| Sample { current_a: s.current_a / 3.0, ..s }, &open);
        // Before the moving end nothing is left to see.
        found(|_, s| Sample { current_a: 0.0, v1_v: 0.0, v2_v: 0.0, v3_v: 0.0, ..s }, &[Health::NoCurrent]);
    }

    #[test]
    fn shorted_wires_are_found_at_once() {
        let short = [Health::ShortedWire];
        // The current runs out of range, or the supply gives way, or half the wire is bridged.
        found(|_, s| Sample { current_a: 50.0, v1_v: 0.0, v2_v: 0.2, v3_v: 0.25, ..s }, &short);
        let volts = |s: Sample, k: f64| Sample { v1_v: k * s.v1_v, v2_v: k * s.v2_v, v3_v: k * s.v3_v, ..s };
        found(|_, s| volts(s, 0.5), &short);
        found(|_, s| Sample { current_a: 2.0 * s.current_a, ..volts(s, 0.9) }, &short);
    }

    #[test]
    fn lost_probes_are_found_at_once() {
        let lost = [Health::ProbeLost];
        found(|_, s| Sample { v2_v: 0.0, ..s }, &lost);
        found(|_, s| Sample { v2_v: s.v3_v, ..s }, &lost);
        found(|_, s| Sample { v2_v: s.v1_v, ..s }, &lost);
        found(|_, s| Sample { v2_v: 9.0, ..s }, &lost);
        found(|_, s| Sample { v2_v: -3.0, ..s }, &lost);
        // A weak contact shows once it takes more than the wire could have grown.
        let out = [Health::ProbeLost, Health::OutOfRange];
        found(|rng, s| Sample { v2_v: s.v2_v * rng.random_range(0.0..0.93), ..s }, &out);
        found(|_, s| Sample { v1_v: s.v2_v, ..s }, &lost);
        found(|_, s| Sample { v1_v: 0.2, ..s }, &lost);
    }

    #[test]
    fn other_faults_are_found_at_once() {
        found(|_, s| Sample { supply_v: 4.5, ..s }, &[Health::SupplyDip]);
        found(|_, s| Sample { v3_v: 11.0, v2_v: 10.2, current_a: 0.95, ..s }, &[Health::Saturated]);
        found(|_, s| Sample { current_a: 1.2, v1_v: 0.0, v2_v: 8.6, v3_v: 9.3, ..s }, &[Health::Saturated]);
    }

    #[test]
    fn missing_inputs_are_told_from_broken_ones() {
        let mut sensor = sensor();
        assert_eq!(sensor.read(&Sample::NONE).health, Health::NoSample);
        assert_eq!(sensor.read(&Sample { supply_v: 6.0, ..Sample::NONE }).health, Health::NoSample);
        let infinite = Sample { v3_v: f64::INFINITY, ..healthy() };
        for broken in [Sample { v2_v: f64::NAN, ..healthy() }, Sample { current_a: f64::NAN, ..healthy() }, infinite] {
            assert_eq!(sensor.read(&broken).health, Health::NotFinite);
        }
        assert_eq!(sensor.read(&Sample { supply_v: f64::NAN, ..healthy() }).health, Health::Ok);
        // Resistance alone needs no taps, and is not disturbed by lost ones.
        let mut plain = resistance_sensor();
        let untapped = Sample { v1_v: f64::NAN, v2_v: f64::NAN, ..healthy() };
        let reading = plain.read(&untapped);
        assert_eq!(reading.health, Health::Ok);
        assert!((reading.length_m - line().length_m(11.3)).abs() < 1e-12);
        assert_eq!(plain.read(&Sample::NONE).health, Health::NoSample);
    }

    #[test]
    fn a_frozen_input_is_found() {
        type Freeze = fn(&Sample, &mut Sample);
        let freezes: [Freeze; 4] = [
            |held, s| *s = *held,
            |held, s| s.v2_v = held.v2_v,
            |held, s| s.v3_v = held.v3_v,
            |held, s| s.current_a = held.current_a,
        ];
        let limits = StuckAfter { all: Some(6), voltage: Some(19), current: Some(13) };
        assert_eq!(sensor().stuck_after(), limits);
        for (freeze, limit) in freezes.into_iter().zip([limits.all, limits.voltage, limits.voltage, limits.current]) {
            let (mut sensor, mut adc) = (sensor(), Adc::new(2, Converter::default()));
            let held = adc.measure(healthy());
            sensor.read(&held);
            let after = (1..100u32).find(|_| {
                let mut sample = adc.measure(healthy());
                freeze(&held, &mut sample);
                sensor.read(&sample).health == Health::Stuck
            });
            // A little sooner where noise happens to repeat another input's code as well.
            assert!(after.is_some_and(|n| n <= limit.unwrap() && n + 2 >= limit.unwrap()), "{after:?} of {limit:?}");
            // And it is well again with the first fresh code.
            assert_eq!(sensor.read(&adc.measure(healthy())).health, Health::Ok);
        }
    }

    #[test]
    fn without_noise_nothing_is_frozen() {
        let silent = Converter { voltage_noise_v: 0.0, current_noise_a: 0.0, ..Converter::default() };
        let mut sensor = LengthSensor::new(LengthSensorConfig { converter: silent, ..config(0.0, 0.150) }).unwrap();
        assert_eq!(sensor.stuck_after(), StuckAfter { all: None, voltage: None, current: None });
        for _ in 0..10_000 {
            assert_eq!(sensor.read(&healthy()).health, Health::Ok);
        }
    }

    #[test]
    fn a_second_tap_close_to_the_moving_end_still_tells_a_lost_probe() {
        let config = config(0.0, 0.158);
        let mut sensor = LengthSensor::new(config).unwrap();
        assert_eq!(sensor.read(&sample_of(0.0, 0.158, 0.1603, 11.9, 5.9)).health, Health::Ok);
        assert_eq!(sensor.read(&Sample { v2_v: 5.9, ..healthy() }).health, Health::ProbeLost);
    }

    #[test]
    fn configurations_that_cannot_work_are_refused_by_name() {
        let bad = |change: fn(&mut LengthSensorConfig)| {
            let mut config = config(0.0, 0.150);
            change(&mut config);
            LengthSensor::new(config).unwrap_err().to_string()
        };
        assert!(bad(|c| c.area_m2 = f64::NAN).contains("cross-section"));
        assert!(bad(|c| c.min_length_m = 0.2).contains("length range"));
        assert!(bad(|c| c.max_resistance_ohm = f64::INFINITY).contains("resistance range"));
        assert!(bad(|c| c.min_current_a = 0.001).contains("smallest current"));
        assert!(bad(|c| c.converter.bits = 0).contains("bits"));
        assert!(bad(|c| c.method = Method::DualMeasurement { l0_m: -0.1, ls_m: 0.1 }).contains("l0"));
    }

    fn any_input() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => -12.0f64..12.0,
            1 => any::<f64>(),
            1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, 10.0, 5e-324]),
        ]
    }

    proptest! {
        #[test]
        fn nothing_but_a_plausible_length_is_ok(
            inputs in prop::collection::vec((any_input(), any_input(), any_input(), any_input(), any_input()), 1..20),
            plain: bool,
        ) {
            let mut sensor = if plain { resistance_sensor() } else { sensor() };
            let (min, max) = (sensor.config().min_length_m, sensor.config().max_length_m);
            for (v1_v, v2_v, v3_v, current_a, supply_v) in inputs {
                let r = sensor.read(&Sample { v1_v, v2_v, v3_v, current_a, supply_v });
                if r.health.is_ok() {
                    prop_assert!(r.length_m > 0.9 * min && r.length_m < 1.1 * max, "{r:?}");
                    prop_assert!(r.resistance_ohm > 0.0 && r.resistivity_ohm_m > 0.0, "{r:?}");
                    prop_assert!(r.length_sigma_m > 0.0 && r.length_sigma_m < 0.01, "{r:?}");
                } else {
                    prop_assert!(r.length_m.is_nan() && r.resistivity_ohm_m.is_nan(), "{r:?}");
                }
            }
        }

        #[test]
        fn the_dual_measurement_needs_neither_scale_nor_zero_of_the_voltages(
            l0 in 0.0f64..0.09, length in 0.1603f64..0.1667, resistance in 10.4f64..11.9, v3 in 3.5f64..6.0,
            scale in 0.9f64..1.5, shift in -0.02f64..0.02,
        ) {
            let ls = 0.150 - l0;
            let mut sensor = LengthSensor::new(config(l0, ls)).unwrap();
            let s = sample_of(l0, ls, length, resistance, v3);
            let plain = sensor.read(&s);
            prop_assert_eq!(plain.health, Health::Ok);
            prop_assert!((plain.length_m - length).abs() < 1e-12);
            // More current through the same wire; the same wire on a converter with an offset.
            let scaled = Sample {
                v1_v: scale * s.v1_v, v2_v: scale * s.v2_v, v3_v: scale * s.v3_v, current_a: scale * s.current_a, ..s
            };
            let scaled = sensor.read(&scaled);
            prop_assert!((scaled.length_m - length).abs() < 1e-12);
            prop_assert!((scaled.resistance_ohm - resistance).abs() < 1e-9);
            prop_assert!((scaled.length_sigma_m * scale / plain.length_sigma_m - 1.0).abs() < 1e-9);
            let shifted = Sample { v1_v: s.v1_v + shift, v2_v: s.v2_v + shift, v3_v: s.v3_v + shift, ..s };
            prop_assert!((sensor.read(&shifted).length_m - length).abs() < 1e-12);
        }
    }
}
