//! Sliding mode control of a wire (chapter 11): second and first order surfaces.

use crate::demand::Range;
use crate::wire_map::WireMap;
use crate::{Controller, Demand, Modulation};

/// How σ of the second-order surface becomes power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// The thesis' law as it stands: maximum power where the measured σ > 0, minimum elsewhere.
    Plain,
    /// The surface written in the wire's temperature, with eq. 70's equivalent control modulated onto the switch.
    Equivalent,
}

/// Critically damped second-order surface σ = ẍ + 2λẋ + λ²(x − x_ref).
#[derive(Debug, Clone)]
pub struct SlidingMode2 {
    map: WireMap,
    lambda: f64,
    law: Law,
    range: Range,
    /// Half width of the band in which the wire is held where it stands, m.
    hold: f64,
    surface: f64,
    blind: bool,
}

impl SlidingMode2 {
    pub(crate) fn new(map: WireMap, lambda: f64, law: Law, hold: f64, range: Range) -> SlidingMode2 {
        SlidingMode2 { map, lambda, law, range, hold, surface: 0.0, blind: false }
    }

    /// Equivalent control: the mean power that keeps σ = 0.
    #[inline]
    fn equivalent(&mut self, demand: &Demand) -> f64 {
        let (m, lambda, seen) = (&self.map, self.lambda, &demand.estimate);
        let error = seen.length_m - demand.reference_m;
        let beyond = error - error.clamp(-self.hold, self.hold);
        let elongation = seen.length_m - m.length;
        // branches at rest: the stress the load will have once it stands
        let still = m.stress(elongation, 0.0) * m.shift;
        let offset = still - seen.stress_pa * m.shift;
        let s = seen.stress_pa + m.thermoelastic * (seen.temperature_c - m.reference);
        let (curve, width, release) = if beyond > 0.0 {
            (seen.heating_curve_c + offset, m.heating_width, 1.0)
        } else if beyond < 0.0 {
            (seen.cooling_curve_c + offset, m.cooling_width, 1.0)
        } else {
            let curve = seen.temperature_c.clamp(seen.cooling_curve_c + offset, seen.heating_curve_c + offset);
            (curve, m.heating_width, 0.0)
        };
        let per_metre = m.kelvin_per_metre(seen.martensite, width, s);
        let drag = m.damping * m.shift / m.area;
        let target = curve + release * 0.5 * (lambda * drag + 0.5 * per_metre) * beyond;
        let rate = 2.0 * lambda * (target - seen.temperature_c);
        // σ in m/s², by way of the drag that turns kelvin into speed
        self.surface = lambda * rate / (lambda * drag + 0.5 * per_metre).max(1e-9);
        let xi = seen.martensite.clamp(0.03, 0.97);
        let moving = release * xi * (1.0 - xi) / width * (m.latent + m.area * m.length * seen.stress_pa * m.strain);
        let power = m.loss * (seen.temperature_c - m.ambient) + (m.heat_capacity + moving) * rate;
        power / m.full_power
    }
}

impl Controller for SlidingMode2 {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        self.blind = !demand.is_finite();
        if self.blind {
            self.surface = 0.0;
            return self.range.minimum;
        }
        let plain = self.law == Law::Plain || !demand.estimate.temperature_c.is_finite();
        if plain {
            let l = self.lambda;
            self.surface =
                demand.acceleration_m_s2 + l * (2.0 * demand.velocity_m_s + l * (demand.length_m - demand.reference_m));
            return if self.surface > 0.0 { self.range.maximum } else { self.range.minimum };
        }
        let wanted = self.equivalent(demand);
        self.range.give(wanted)
    }

    fn reset(&mut self) {
        self.range.reset();
        self.surface = 0.0;
        self.blind = false;
    }

    fn surface(&self) -> f64 {
        self.surface
    }

    fn is_blind(&self) -> bool {
        self.blind
    }
}

/// First-order surface σ = ẋ + λ(x − x_ref), for comparison: it limit-cycles (figure 113).
#[derive(Debug, Clone)]
pub struct SlidingMode1 {
    lambda: f64,
    range: Range,
    surface: f64,
    blind: bool,
}

impl SlidingMode1 {
    pub(crate) fn new(lambda: f64, range: Range) -> SlidingMode1 {
        SlidingMode1 { lambda, range, surface: 0.0, blind: false }
    }
}

impl Controller for SlidingMode1 {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        self.blind = !demand.is_finite();
        if self.blind {
            self.surface = 0.0;
            return self.range.minimum;
        }
        self.surface = demand.velocity_m_s + self.lambda * (demand.length_m - demand.reference_m);
        if self.surface > 0.0 { self.range.maximum } else { self.range.minimum }
    }

    fn reset(&mut self) {
        self.surface = 0.0;
        self.blind = false;
    }

    fn surface(&self) -> f64 {
        self.surface
    }

    fn is_blind(&self) -> bool {
        self.blind
    }
}

#[allow(unused)]
const _: Modulation = Modulation::Duty;
