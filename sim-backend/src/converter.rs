//! The analogue-to-digital converter of one channel: offset, noise, range, steps.

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;
use rand_distr::{Distribution, StandardNormal};
use sinew_backend::Sample;
use sinew_rig::Adc;

/// How long the switch has to be closed before a sample is taken, in s: settling and acquisition.
pub const MIN_ON_TIME_S: f64 = 1e-6;

/// The supply is measured over a divider whose full scale is this many times its nominal voltage.
const SUPPLY_HEADROOM: f64 = 1.5;

/// How far below 0 an input still reads, as a share of its range. Amplifiers before a converter are wired with such a
/// pedestal so that a voltage of 0 shows its noise; without it V_1 at the fixed end would read half a noise too high.
const BELOW_ZERO: f64 = 1.0 / 16.0;

/// One input: what it adds, and what numbers can come out of it.
#[derive(Debug, Clone, Copy)]
struct Input {
    offset: f64,
    noise: f64,
    /// One step, in the input's unit; 0 where the full scale is 0.
    step: f64,
    per_step: f64,
    /// Lowest and highest code.
    least: f64,
    most: f64,
}

impl Input {
    /// An input of `bits` over 0 to `range`, and a little below 0.
    fn new(bits: u32, range: f64, offset: f64, noise: f64) -> Input {
        let codes = 2f64.powi(bits.clamp(1, 48) as i32);
        let step = range / codes;
        let per_step = if step > 0.0 { 1.0 / step } else { 0.0 };
        Input { offset, noise, step, per_step, least: -(BELOW_ZERO * codes).floor(), most: codes - 1.0 }
    }

    /// The number read for `value` and one draw of unit noise.
    #[inline]
    fn read(&self, value: f64, draw: f64) -> f64 {
        let code = (value + self.offset + self.noise * draw) * self.per_step;
        // within ±2⁵¹ after the clamp, where this rounds to the nearest code and costs next to nothing
        const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 · 2⁵²
        let code = (code.max(self.least).min(self.most) + ROUND) - ROUND;
        code * self.step
    }

    fn full_scale(&self) -> f64 {
        self.most * self.step
    }
}

/// What the converter's pins see in the moment of sampling. `taps` is `None` where the rig has none. Of a shared input
/// `v3_v` is not looked at, `current_a` stands for the voltage it leaves on the input, and what was not sampled is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pins {
    pub taps: Option<[f64; 2]>,
    pub v3_v: f64,
    pub current_a: f64,
    pub supply_v: f64,
}

/// The converter of one channel with its source of noise.
#[derive(Debug, Clone)]
pub(crate) struct Converter {
    voltage: Input,
    current: Input,
    supply: Input,
    /// Switch and shunt below a shared input, Ω.
    low_ohm: Option<f64>,
    random: Xoshiro256PlusPlus,
}

impl Converter {
    /// `low_ohm`: switch and shunt below an input that supply and current share.
    pub fn new(adc: &Adc, nominal_supply_v: f64, low_ohm: Option<f64>, seed: u64) -> Converter {
        let supply_range = SUPPLY_HEADROOM * nominal_supply_v;
        Converter {
            low_ohm,
            voltage: Input::new(adc.bits, adc.voltage_range_v, adc.voltage_offset_v, adc.voltage_noise_v),
            current: Input::new(adc.bits, adc.current_range_a, adc.current_offset_a, adc.current_noise_a),
            supply: Input::new(adc.bits, supply_range, 0.0, adc.supply_noise_v),
            random: Xoshiro256PlusPlus::seed_from_u64(seed),
        }
    }

    /// A draw of the standard normal distribution.
    #[inline]
    pub fn draw(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// Samples all pins.
    #[inline]
    pub fn sample(&mut self, pins: &Pins) -> Sample {
        let (v1_v, v2_v) = match pins.taps {
            Some([v1, v2]) => {
                let (d1, d2) = (self.draw(), self.draw());
                (self.voltage.read(v1, d1), self.voltage.read(v2, d2))
            }
            None => (f64::NAN, f64::NAN),
        };
        if let Some(low_ohm) = self.low_ohm {
            let (on, off) = (self.draw(), self.draw());
            let shared = |volts: f64, draw| if volts.is_nan() { f64::NAN } else { self.voltage.read(volts, draw) };
            return Sample {
                v1_v,
                v2_v,
                v3_v: f64::NAN,
                current_a: shared(pins.current_a * low_ohm, on) / low_ohm,
                supply_v: shared(pins.supply_v, off),
            };
        }
        let (d3, di, ds) = (self.draw(), self.draw(), self.draw());
        Sample {
            v1_v,
            v2_v,
            v3_v: self.voltage.read(pins.v3_v, d3),
            current_a: self.current.read(pins.current_a, di),
            supply_v: self.supply.read(pins.supply_v, ds),
        }
    }

    /// Every input at full scale.
    pub fn saturated(&self, taps: bool) -> Sample {
        let volts = self.voltage.full_scale();
        let tap = if taps { volts } else { f64::NAN };
        if let Some(low_ohm) = self.low_ohm {
            return Sample { v1_v: tap, v2_v: tap, v3_v: f64::NAN, current_a: volts / low_ohm, supply_v: volts };
        }
        Sample {
            v1_v: tap,
            v2_v: tap,
            v3_v: volts,
            current_a: self.current.full_scale(),
            supply_v: self.supply.full_scale(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_rig::SamplingCircuit;

    fn adc() -> Adc {
        Adc {
            circuit: SamplingCircuit::SeparateTaps,
            bits: 16,
            voltage_range_v: 10.0,
            current_range_a: 1.0,
            voltage_noise_v: 0.0015,
            current_noise_a: 0.0004,
            voltage_offset_v: 0.01,
            current_offset_a: -0.002,
            supply_noise_v: 0.003,
        }
    }

    const PINS: Pins = Pins { taps: Some([0.0, 5.3]), v3_v: 5.9, current_a: 0.57, supply_v: 6.0 };

    #[test]
    fn noise_and_offset_are_what_the_rig_says() {
        let mut converter = Converter::new(&adc(), 6.0, None, 1);
        const N: usize = 200_000;
        let mut sums = [(0.0, 0.0); 5];
        let truth = [0.0 + 0.01, 5.3 + 0.01, 5.9 + 0.01, 0.57 - 0.002, 6.0];
        let sigma = [0.0015, 0.0015, 0.0015, 0.0004, 0.003];
        let mut cross = 0.0;
        for _ in 0..N {
            let s = converter.sample(&PINS);
            let off: [f64; 5] =
                std::array::from_fn(|i| [s.v1_v, s.v2_v, s.v3_v, s.current_a, s.supply_v][i] - truth[i]);
            for (sum, off) in sums.iter_mut().zip(off) {
                sum.0 += off;
                sum.1 += off * off;
            }
            cross += off[1] * off[2];
        }
        let n = N as f64;
        for ((sum, squares), sigma) in sums.into_iter().zip(sigma) {
            let (mean, spread) = (sum / n, (squares / n).sqrt());
            assert!(mean.abs() < 5.0 * sigma / n.sqrt(), "mean {mean} of {sigma}");
            // quantisation adds step²/12: under 0.4 % of the variance here
            assert!((spread / sigma - 1.0).abs() < 0.012, "spread {spread}, expected {sigma}");
        }
        let correlation = cross / n / (0.0015 * 0.0015);
        assert!(correlation.abs() < 5.0 / n.sqrt(), "V2 and V3 are correlated by {correlation}");
    }

    #[test]
    fn numbers_come_in_steps_and_end_at_the_range() {
        let quiet = Adc {
            bits: 8,
            voltage_noise_v: 0.0,
            current_noise_a: 0.0,
            supply_noise_v: 0.0,
            voltage_offset_v: 0.0,
            current_offset_a: 0.0,
            ..adc()
        };
        let mut converter = Converter::new(&quiet, 6.0, None, 1);
        let step = 10.0 / 256.0;
        for i in -2000..2000 {
            let v3_v = f64::from(i) * 0.01;
            let read = converter.sample(&Pins { v3_v, ..PINS }).v3_v;
            assert!((read / step).fract() == 0.0, "{read} is between two codes");
            if (-0.6..9.9).contains(&v3_v) {
                assert!((read - v3_v).abs() <= 0.5 * step * (1.0 + 1e-9), "{v3_v} became {read}");
            }
            assert!((-0.625..=10.0 - step).contains(&read));
        }
        for huge in [1e300, f64::INFINITY] {
            assert_eq!(converter.sample(&Pins { v3_v: huge, ..PINS }).v3_v, 10.0 - step);
            assert_eq!(converter.sample(&Pins { v3_v: -huge, ..PINS }).v3_v, -0.625);
        }
        assert_eq!(converter.saturated(true).v2_v, 10.0 - step);
    }

    #[test]
    fn taps_that_are_not_there_are_not_sampled() {
        let mut converter = Converter::new(&adc(), 6.0, None, 1);
        let s = converter.sample(&Pins { taps: None, ..PINS });
        assert!(s.v1_v.is_nan() && s.v2_v.is_nan() && s.v3_v.is_finite());
        assert!(converter.saturated(false).v1_v.is_nan());
    }

    #[test]
    fn a_shared_input_reads_supply_and_current_with_a_voltage_inputs_noise() {
        let mut converter = Converter::new(&adc(), 6.0, Some(0.12), 1);
        const N: usize = 100_000;
        let (mut amps, mut volts) = (0.0, 0.0);
        for _ in 0..N {
            let s = converter.sample(&PINS);
            assert!(s.v3_v.is_nan() && s.v2_v.is_finite());
            amps += (s.current_a - 0.57 - 0.01 / 0.12).powi(2);
            volts += (s.supply_v - 6.0 - 0.01).powi(2);
        }
        let (amps, volts) = ((amps / N as f64).sqrt(), (volts / N as f64).sqrt());
        assert!((amps / (0.0015 / 0.12) - 1.0).abs() < 0.012, "{amps}");
        assert!((volts / 0.0015 - 1.0).abs() < 0.012, "{volts}");
        let dark = converter.sample(&Pins { current_a: f64::NAN, ..PINS });
        assert!(dark.current_a.is_nan() && dark.supply_v.is_finite());
    }
}
