//! Temperature and martensite of a wire, cycle by cycle, from its electrical power and its length.
//!
//! The length says the phase (eq. 6 and 23 with the stress of the load), the power the enthalpy (eq. 48): what is kept
//! is m c_p T − H ξ, so that latent heat is paid by difference and noise of the length never adds up. Two facts
//! bound the drift of that open-loop heat balance: the driving temperature lies between the outer curves of the phase
//! that is measured (g_M ≤ ξ ≤ g_A), and a wire that shortens on its own sits on the heating curve, one that lengthens on the
//! cooling curve. Both pull with bounded gains, so a wrong parameter biases the estimate and can never make it run away.

use crate::wire_map::WireMap;
use sinew_physics::WireModel;

/// Rate at which a temperature outside the outer curves is pulled back to them, 1/s.
const BOUND_RATE: f64 = 20.0;
/// Rate at which a moving wire's temperature is pulled to the curve it moves on, 1/s.
const BRANCH_RATE: f64 = 4.0;
/// Of ξ per second: slower than this is standing (noise, thermal strain), four times as fast is surely moving.
const STANDING_PER_S: f64 = 0.15;
/// Rate at which a measured length is followed, 1/s: the length noise of a cycle is of the size of the hold band.
const LENGTH_RATE: f64 = 40.0;
/// Hottest and coldest temperature an estimate can take, °C.
const RANGE_C: (f64, f64) = (-250.0, 1000.0);

/// What one cycle measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Mean electrical power in the wire since the last call (duty · I²R, the sensing pulse included), in W.
    /// NaN = not measured: then the duty and the model's circuit say it.
    pub power_w: f64,
    /// Duty since the last call, 0..1; only read where `power_w` is NaN.
    pub duty: f64,
    /// Wire length, in m; NaN = not measured: the model alone.
    pub length_m: f64,
    /// Its derivative, in m/s; NaN counts as 0.
    pub velocity_m_s: f64,
    /// Wire tension, in N; NaN = follows from the load.
    pub tension_n: f64,
    /// Time since the last call, in s.
    pub dt_s: f64,
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
    };
}

/// Temperature and martensite of one wire, online.
#[derive(Debug, Clone)]
pub struct StateEstimator {
    map: WireMap,
    temperature: f64,
    fraction: f64,
    hottest: f64,
    elongation: f64,
    /// Whether a length has come yet.
    seen: bool,
    initial: (f64, f64),
}

impl StateEstimator {
    /// An estimator for a wire that starts as the model says: at its initial temperature (ambient) and phase.
    pub fn new(model: &WireModel) -> StateEstimator {
        let map = WireMap::new(model);
        let initial = (model.initial.temperature_c.unwrap_or(model.ambient_c), model.initial.martensite);
        let mut estimator = StateEstimator {
            map,
            temperature: 0.0,
            fraction: 0.0,
            hottest: 0.0,
            elongation: 0.0,
            seen: false,
            initial,
        };
        estimator.reset();
        estimator
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        (self.temperature, self.fraction) = self.initial;
        self.hottest = self.temperature;
        self.seen = false;
        let stress = self.map.stress(0.02 * self.map.length, 0.0);
        let theta = self.temperature - stress * self.map.shift;
        self.fraction = self.clipped(self.fraction, theta);
        self.elongation = self.map.elongation(self.fraction, stress, self.temperature);
    }

    /// ξ inside the outer curves (eq. 20).
    fn clipped(&self, fraction: f64, theta: f64) -> f64 {
        let m = &self.map;
        let low = 1.0 / (1.0 + ((theta - m.cooling_centre) / m.cooling_width).min(700.0).exp());
        let high = 1.0 / (1.0 + ((theta - m.heating_centre) / m.heating_width).min(700.0).exp());
        fraction.clamp(low.min(high), high)
    }

    /// Takes one cycle in.
    #[inline]
    pub fn update(&mut self, seen: &Observation) -> Estimate {
        let m = &self.map;
        let dt = if seen.dt_s > 0.0 { seen.dt_s.min(0.1) } else { 0.0 };
        let velocity = if seen.velocity_m_s.is_finite() { seen.velocity_m_s } else { 0.0 };
        let power = if seen.power_w.is_finite() {
            seen.power_w.max(0.0)
        } else if seen.duty.is_finite() {
            seen.duty.clamp(0.0, 1.0) * m.power_at_full_duty(self.fraction, self.temperature, self.elongation)
        } else {
            m.full_power
        };
        let measured = seen.length_m.is_finite();
        if measured {
            let elongation = seen.length_m - m.length;
            if self.seen {
                let share = (LENGTH_RATE * dt).min(1.0);
                // velocity lead: no lag behind a steady motion
                self.elongation += share * (elongation + velocity / LENGTH_RATE - self.elongation);
            } else {
                self.elongation = elongation;
                self.seen = true;
            }
        }
        let stress = if seen.tension_n.is_finite() {
            (seen.tension_n / m.area).max(0.0)
        } else {
            m.stress(self.elongation, if measured { velocity } else { 0.0 })
        };
        let shift = stress * m.shift;
        let old = self.fraction;
        // heat first, at the phase as it was (eq. 48)
        let heat = power - m.loss * (self.temperature - m.ambient);
        let fraction = if measured {
            m.fraction(self.elongation, stress, self.temperature).clamp(0.0, 1.0)
        } else {
            let predicted = self.temperature + heat * dt / m.heat_capacity;
            // ahead on an outer curve only as far as this cycle's heat pays for
            let next = self.clipped(old, predicted - shift);
            let latent = (m.latent + m.area * m.length * stress * m.strain).max(1e-12);
            let most = (heat * dt).abs() / latent;
            old + (next - old).clamp(-most, most)
        };
        let released = (m.latent + m.area * m.length * stress * m.strain) * (fraction - old);
        self.temperature += (heat * dt + released) / m.heat_capacity;
        self.fraction = fraction;
        if !measured {
            self.elongation = m.elongation(fraction, stress, self.temperature);
        }

        let logit = WireMap::logit(fraction);
        let heating_curve = m.heating_centre + m.heating_width * logit + shift;
        let cooling_curve = m.cooling_centre + m.cooling_width * logit + shift;
        if measured {
            let mut pull = 0.0;
            if fraction > 0.02 && self.temperature > heating_curve {
                pull = BOUND_RATE * (heating_curve - self.temperature);
            } else if fraction < 0.98 && self.temperature < cooling_curve {
                pull = BOUND_RATE * (cooling_curve - self.temperature);
            } else if fraction > 0.02 && fraction < 0.98 {
                let speed = velocity / (m.length * m.strain.max(1e-3) * STANDING_PER_S);
                let sure = (BRANCH_RATE / 3.0) * (speed.abs() - 1.0).clamp(0.0, 3.0);
                let curve = if speed < 0.0 { heating_curve } else { cooling_curve };
                pull = sure * (curve - self.temperature);
            }
            self.temperature += pull * dt.min(1.0 / BOUND_RATE);
        }
        self.temperature = self.temperature.clamp(RANGE_C.0, RANGE_C.1);
        let rise = power - 0.5 * m.loss * (self.hottest - m.ambient);
        self.hottest = (self.hottest + rise * dt / m.heat_capacity).clamp(self.temperature, RANGE_C.1);
        Estimate {
            temperature_c: self.temperature,
            martensite: fraction,
            hottest_c: self.hottest,
            stress_pa: stress,
            heating_curve_c: heating_curve,
            cooling_curve_c: cooling_curve,
            length_m: m.length + self.elongation,
        }
    }
}
