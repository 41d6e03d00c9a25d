//! Sliding mode control of a wire (chapter 11) on the second-order surface.
//!
//! The thesis' law takes ẍ from the length, differentiated twice; at the accuracy of one reading in a hundred of the
//! stroke that is all noise. [`SurfaceLaw::Equivalent`] takes it from the wire instead: where the load is damped, the speed of a
//! transforming wire is its excess temperature over the curve it is on, v = −(T − T_b(x))/κ with κ = B/(αA_c) (the stress shift
//! of the drag, eq. 12 and 51), and so the surface σ = ẍ + 2λẋ + λ²(x − x_ref) is one in temperature:
//! σ = (2λ/κ)(T_b(x) + κ(λ/2)(x − x_ref) − T) up to the slow drift of T_b. The power that keeps σ = 0 follows from the heat
//! balance as in eq. 70, and is what a switch between maximum and minimum power is modulated to.
//!
//! Three effects that the surface does not model are handled separately:
//! - Crossing the hysteresis moves the wire the wrong way by its thermal strain. So a wire within a band around the
//!   reference is held at its temperature until its mean error leaves the band.
//! - A wire that lengthens is slow to move and quick to stop: it approaches [`COOLING_HASTE`] times as steeply.
//! - The last correction out of a hold is approached slowly.

use super::hold::Hold;
use crate::cycle::Curves;
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;
use sinew_physics::formulas::sliding_surface;

/// How much steeper a cooling wire approaches: heating brakes it with several times the power that cools it.
const COOLING_HASTE: f64 = 3.5;
/// Within this of its curve, in widths, and within the reach of a hold ([`Hold::reach`]), a wire is crept at.
const CREEP_WITHIN: f64 = 0.6;
/// Rate of creeping, in widths times λ.
const CREEP: f64 = 0.06;
/// Least rate, as a share of that, of a wire that does not move as it should: the integral action of this law.
const CREEP_AT_LEAST: f64 = 0.5;
/// Share of the estimated loss that is compensated on the way: the rest lets a wire arrive slowly instead of overshooting.
const MADE_UP: f64 = 0.975;

/// How σ becomes power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SurfaceLaw {
    /// The thesis' law as it stands: maximum power where the measured σ > 0, minimum elsewhere.
    Plain,
    /// With the equivalent control that keeps σ = 0 (eq. 70), in the wire's estimated state.
    Equivalent,
}

/// Critically damped second-order surface σ = ẍ + 2λẋ + λ²(x − x_ref).
#[derive(Debug, Clone)]
pub struct SlidingMode {
    map: WireMap,
    lambda: f64,
    law: SurfaceLaw,
    range: Range,
    /// 1/κ at mid-stroke, m/(K s): from a rate of temperature to σ.
    per_kelvin: f64,
    hold: Hold,
    surface: f64,
}

impl SlidingMode {
    pub(crate) fn new(map: WireMap, lambda: f64, law: SurfaceLaw, band: f64, range: Range) -> SlidingMode {
        let lead = 0.5 * map.kelvin_per_metre(0.5, map.heating_width, map.stress(0.0, 0.0));
        let per_kelvin = 1.0 / (map.drag + lead / lambda).max(1e-12);
        SlidingMode { map, lambda, law, range, per_kelvin, hold: Hold::new(band), surface: 0.0 }
    }

    /// Equivalent control: the mean duty that keeps σ = 0.
    #[inline]
    fn equivalent(&mut self, demand: &Demand) -> f64 {
        let seen = &demand.estimate;
        let error = seen.length_m - demand.reference_m;
        let (m, lambda) = (&self.map, self.lambda);
        // the curves where the wire stands still: without the drag's share of the stress
        let drag_k = m.stress(seen.length_m - m.length, 0.0) * m.shift - seen.stress_pa * m.shift;
        let curves = Curves { heating_c: seen.heating_curve_c + drag_k, cooling_c: seen.cooling_curve_c + drag_k };
        let Curves { heating_c: heating, cooling_c: cooling } = curves;
        let drag = m.drag;
        let held = self.hold.decide(m, demand, error, 0.0, curves, lambda);
        let error = if self.hold.shortens() {
            error - self.hold.lead(m, seen.martensite)
        } else {
            error + self.hold.lead(m, seen.martensite)
        };
        let (target, width) = if let Some(temperature) = held {
            (temperature, m.heating_width)
        } else {
            let (curve, width, haste) = if error > 0.0 {
                (heating, m.heating_width, lambda)
            } else {
                (cooling, m.cooling_width, COOLING_HASTE * lambda)
            };
            // besides the drag, the lead that keeps a load without any from following too closely
            let s = seen.stress_pa + m.thermoelastic * (seen.temperature_c - m.reference);
            let lead = 0.5 * m.kelvin_per_metre(seen.martensite, width, s);
            (curve + 0.5 * (haste * drag + lead) * error, width)
        };
        let mut rate = 2.0 * lambda * (target - seen.temperature_c);
        let mut transforming = 0.0;
        if held.is_none() {
            let xi = seen.martensite.clamp(0.03, 0.97);
            transforming = xi * (1.0 - xi) / width * seen.release_j;
            if error.abs() < self.hold.reach() {
                let (creep, within) = (CREEP * lambda * width, CREEP_WITHIN * width);
                let towards = if error > 0.0 { -seen.velocity_m_s } else { seen.velocity_m_s };
                // slower than half of the surface's speed: the curve is not where the model has it
                let least =
                    if towards < 0.25 * lambda * error.abs() { CREEP_AT_LEAST * creep } else { f64::NEG_INFINITY };
                if error > 0.0 {
                    let most = creep + 2.0 * lambda * (heating - within - seen.temperature_c).max(0.0);
                    rate = rate.max(least).min(most);
                } else {
                    let most = creep + 2.0 * lambda * (seen.temperature_c - cooling - within).max(0.0);
                    rate = rate.min(-least).max(-most);
                }
            }
        }
        self.surface = rate * self.per_kelvin;
        let share = if held.is_some() { 1.0 } else { MADE_UP };
        (share * seen.loss_w + (m.heat_capacity + transforming) * rate) / seen.full_power_w
    }
}

impl Law for SlidingMode {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            self.surface = 0.0;
            return None;
        }
        if self.law == SurfaceLaw::Equivalent && demand.estimate.temperature_c.is_finite() {
            let wanted = self.equivalent(demand);
            return Some(self.range.give(wanted));
        }
        let error = demand.length_m - demand.reference_m;
        self.surface = sliding_surface(error, demand.velocity_m_s, demand.acceleration_m_s2, self.lambda);
        Some(self.range.switch(self.surface))
    }

    fn reset(&mut self) {
        self.range.reset();
        self.hold.reset();
        self.surface = 0.0;
    }

    fn surface(&self) -> f64 {
        self.surface
    }
}
