//! Sliding mode control on a first-order surface σ = ẋ + λ(x − x_ref), for comparison with the second-order one.
//!
//! A wire responds to power one state later than the surface measures, so switched on σ alone it keeps cycling (figure 113). With the
//! equivalent control that keeps σ = 0 (eq. 70, one order lower) the switch only has to compensate the model's errors,
//! and its mean inside the PWM period is proportional to σ within a thin layer around the surface.

use super::sliding::SurfaceLaw;
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;
use sinew_physics::formulas::sliding_surface_first_order;

/// Half thickness of the layer in which the switch's mean is proportional to σ, in strokes times λ.
const LAYER: f64 = 0.1;
/// Power of the switch as a share of full power: model errors of that size are still made up for.
const SWITCHED: f64 = 0.5;

/// First-order surface σ = ẋ + λ(x − x_ref).
#[derive(Debug, Clone)]
pub struct SlidingModeFirstOrder {
    map: WireMap,
    lambda: f64,
    law: SurfaceLaw,
    range: Range,
    /// 1/(half thickness of the layer), s/m.
    per_layer: f64,
    surface: f64,
}

impl SlidingModeFirstOrder {
    pub(crate) fn new(map: WireMap, lambda: f64, law: SurfaceLaw, stroke: f64, range: Range) -> SlidingModeFirstOrder {
        let per_layer = 1.0 / (LAYER * lambda * stroke);
        SlidingModeFirstOrder { map, lambda, law, range, per_layer, surface: 0.0 }
    }

    /// Equivalent control and what the switch adds to it on average, as a duty.
    #[inline]
    fn equivalent(&mut self, demand: &Demand) -> f64 {
        let (m, seen) = (&self.map, &demand.estimate);
        let shorten = self.lambda * (seen.length_m - demand.reference_m);
        self.surface = seen.velocity_m_s + shorten;
        // On the surface ẋ is −λ(x − x_ref) and σ̇ = 0 is ẍ = −λẋ, so that Ṫ has to bring (K + K_SMA + λ(λM − B)) ẋ (eq. 68).
        // Taken there, not at the measured ẋ: feeding that back would hold on to whatever speed a wrong ∂ξ/∂T has caused.
        let stiffness = m.spring + m.stiffness(seen.martensite);
        let share = 1.0 + self.lambda * (self.lambda * m.mass - m.damping) / stiffness;
        let heat = m.heat_per_metre(m.slope_here(shorten > 0.0, seen), seen);
        let equivalent = seen.loss_w + heat * share * shorten;
        let switched = SWITCHED * self.range.maximum * (self.surface * self.per_layer).clamp(-1.0, 1.0);
        equivalent / seen.full_power_w + switched
    }
}

impl Law for SlidingModeFirstOrder {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            self.surface = 0.0;
            return None;
        }
        if self.law == SurfaceLaw::Equivalent && demand.estimate.is_usable() {
            let wanted = self.equivalent(demand);
            return Some(self.range.give(wanted));
        }
        let error = demand.length_m - demand.reference_m;
        self.surface = sliding_surface_first_order(error, demand.velocity_m_s, self.lambda);
        Some(self.range.switch(self.surface))
    }

    fn reset(&mut self) {
        self.range.reset();
        self.surface = 0.0;
    }

    fn surface(&self) -> f64 {
        self.surface
    }
}
