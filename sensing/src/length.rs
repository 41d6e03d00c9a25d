//! One sample in, one length out, with its standard deviation and a verdict.
//!
//! Every threshold is [`GUARD`] standard deviations of the converter's noise away from healthy values, so
//! that a healthy channel raises no alarm in years of operation; faulty values lie far beyond it (a lost probe is wrong
//! by whole strokes, an open wire by orders of magnitude), so that one sample is enough.

use sinew_physics::Taps;
use sinew_physics::formulas::{dual_variance, resistivity_ohm_m, share_between_taps};

use crate::config::{GUARD, LengthSensorConfig, Method};
use crate::converter::Circuit;
use crate::error::Error;
use crate::health::Health;
use crate::reading::Reading;
use crate::repeats::{Grain, Input, Repeats, StuckAfter};
use crate::sample::Sample;

/// How far the first tap may stray from its fixed share of the second, as a part of V3: offsets of the converter
/// and the lead at the fixed end are below, a lost first probe is above it, or else too small to matter.
const TAP_TOLERANCE: f64 = 0.02;

/// The same where the first tap is well away from the fixed end. There the lead moves both taps nearly alike, and a tap
/// that sticks to the wire shows: its share moves with the wire.
const FAR_TAP_TOLERANCE: f64 = 0.01;
const FAR_TAP_SHARE: f64 = 0.1;

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
        let voltage = Grain { sigma: c.voltage_noise_v, step: c.voltage_lsb_v() };
        let current = Grain { sigma: c.current_noise_a, step: c.current_lsb_a() };
        // A code at 0 V that is cut off there repeats without being frozen: V1 at the fixed end says nothing, unless it
        // stands on a shunt.
        let shared = matches!(config.circuit, Circuit::Shared { .. });
        let first = if tap_share > 0.0 || shared { voltage } else { Grain::UNWATCHED };
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
            repeats: Repeats::new([first, voltage, voltage, current]),
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
        let all: &[Input] =
            if dual { &[Input::V1, Input::V2, Input::V3, Input::Current] } else { &[Input::V3, Input::Current] };
        StuckAfter {
            all: self.repeats.limit(all),
            voltage: self.repeats.limit(&[Input::V3]),
            current: self.repeats.limit(&[Input::Current]),
        }
    }

    /// Standard deviation of a length measured at this length and this V3, in m: to design with.
    pub fn expected_sigma_m(&self, length_m: f64, v3_v: f64, current_a: f64) -> f64 {
        match self.config.method {
            Method::DualMeasurement { l0_m, ls_m } => {
                let between = v3_v * ls_m / length_m;
                self.dual_sigma(ls_m, between, (length_m - l0_m) / ls_m)
            }
            Method::Resistance { line } => {
                line.slope_m_per_ohm.abs() * self.resistance_sigma(v3_v, current_a, v3_v / current_a)
            }
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
        let resistance_sigma_ohm = self.resistance_sigma(v3, i, resistance_ohm);
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
                let share = share_between_taps(v1, v2, v3);
                let length = Taps { l0_m, ls_m }.length_m(share);
                // eq. 44: of the wire between the taps
                let resistivity = resistivity_ohm_m(between * per_amp, ls_m, c.area_m2);
                (length, self.dual_sigma(ls_m, between, share), resistivity)
            }
            Method::Resistance { line } => {
                let length = line.length_m(resistance_ohm);
                let resistivity = resistivity_ohm_m(resistance_ohm, length, c.area_m2);
                (length, line.slope_m_per_ohm.abs() * resistance_sigma_ohm, resistivity)
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
        Reading {
            length_m,
            resistance_ohm,
            resistivity_ohm_m,
            health: Health::Ok,
            length_sigma_m,
            resistance_sigma_ohm,
        }
    }

    /// Forgets how long codes have repeated.
    pub fn reset(&mut self) {
        self.repeats.reset();
    }

    /// First-order propagation through eq. 42: ∂L/∂V3 = ls/D, ∂L/∂V2 = −q ls/D, ∂L/∂V1 = (q−1) ls/D with
    /// D = V2 − V1 and q = (V3 − V1)/D. In a shared circuit V3 stands on the supply and, through the leads, on the current's
    /// voltage; what switch and shunt take is taken off V1, V2 and V3 alike and falls out.
    #[inline]
    fn dual_sigma(&self, ls_m: f64, between_v: f64, share: f64) -> f64 {
        ls_m * self.sigma_v / between_v * (dual_variance(share) + self.drop * self.drop).sqrt()
    }

    /// First-order propagation through V3/I.
    #[inline]
    fn resistance_sigma(&self, v3: f64, i: f64, resistance: f64) -> f64 {
        resistance.abs() * ((self.sigma_v3 / v3).powi(2) + (self.sigma_i / i).powi(2)).sqrt()
    }
}

#[cfg(test)]
mod tests;
