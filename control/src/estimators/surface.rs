//! What a wire gives its heat to: the air, or a sleeve that its rig file states, which is as warm as the wire has made it.

use sinew_physics::WireModel;
use sinew_physics::effects::Sheath;

use crate::wire_map::WireMap;

/// The surroundings that a heat balance (eq. 48) counts from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Surface {
    /// Conductance to them, W/K.
    pub(crate) loss_w_per_k: f64,
    /// Their temperature, °C.
    pub(crate) temperature_c: f64,
    ambient_c: f64,
    /// A sleeve around the wire (`thermal.sheath`).
    sleeve: Option<Sheath>,
}

impl Surface {
    /// Of a wire that has been at its air's temperature for long.
    pub(crate) fn of(model: &WireModel, map: &WireMap) -> Surface {
        let sleeve = Some(model.effects.thermal.sheath).filter(Sheath::is_on);
        let loss_w_per_k = sleeve.map_or(map.loss, |sleeve| sleeve.inner_w_per_k);
        Surface { loss_w_per_k, temperature_c: map.ambient, ambient_c: map.ambient, sleeve }
    }

    /// From now on beside a wire that has been as hot as this, °C, for as long as anybody knows.
    pub(crate) fn settle(&mut self, wire_c: f64) {
        if let Some(sleeve) = &self.sleeve {
            self.temperature_c = sleeve.settled(wire_c, self.ambient_c);
        }
    }

    /// After `dt` seconds beside a wire of this temperature, °C, that loses so many times as much as it should: C Ṫ_s = k_i (T − T_s) −
    /// k_o (T_s − T∞), implicitly. What leaves the wire is in the sleeve: an error of the loss makes none of the whole.
    #[inline]
    pub(crate) fn follow(&mut self, wire_c: f64, loss_scale: f64, dt: f64) {
        if let Some(sleeve) = &self.sleeve {
            let Sheath { heat_capacity_j_per_k: stored, inner_w_per_k, outer_w_per_k: outer } = *sleeve;
            let inner = loss_scale * inner_w_per_k;
            let now = (stored * self.temperature_c + dt * (inner * wire_c + outer * self.ambient_c))
                / (stored + dt * (inner + outer));
            if now.is_finite() {
                self.temperature_c = now;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use sinew_physics::{Inputs, Wire};

    use super::*;
    use crate::testing::wire;

    fn model() -> WireModel {
        let mut model = wire();
        let sheath = &mut model.effects.thermal.sheath;
        (sheath.heat_capacity_j_per_k, sheath.inner_w_per_k, sheath.outer_w_per_k) = (0.03, 0.02, 0.01);
        model
    }

    /// Beside the simulated wire, which follows its sleeve by another method.
    #[test]
    fn a_sleeve_is_as_warm_as_its_wire_has_made_it() {
        let model = model();
        let mut wire = Wire::new(&model).unwrap();
        let map = WireMap::new(&model);
        let mut surface = Surface::of(&model, &map);
        assert_eq!(surface.temperature_c, model.ambient_c);
        let mut kept_j = 0.0;
        for cycle in 0..20_000 {
            let drive = if cycle < 8000 { 0.2 } else { 0.0 };
            wire.step(&Inputs { drive, ..model.rest_inputs() }, 1e-3);
            surface.follow(wire.temperature_c(), 1.0, 1e-3);
            let whole_j = wire.energy().sheath_j;
            let own_j = 0.03 * (surface.temperature_c - model.ambient_c);
            kept_j = f64::max(kept_j, whole_j);
            assert!((own_j - whole_j).abs() < 0.01 * kept_j.max(0.05), "cycle {cycle}: {own_j} {whole_j}");
        }
        assert!(kept_j > 0.3, "{kept_j}");
    }

    #[test]
    fn beside_a_wire_that_was_hot_for_long_it_is_as_warm_as_it_can_be() {
        let model = model();
        let mut surface = Surface::of(&model, &WireMap::new(&model));
        surface.settle(model.ambient_c + 90.0);
        assert!((surface.temperature_c - model.ambient_c - 60.0).abs() < 1e-9);
        let before = surface.temperature_c;
        surface.follow(model.ambient_c + 90.0, 1.0, 1.0);
        assert!((surface.temperature_c - before).abs() < 1e-9, "at rest");
    }

    #[test]
    fn in_air_there_is_nothing_to_follow() {
        let model = wire();
        let map = WireMap::new(&model);
        let mut surface = Surface::of(&model, &map);
        surface.settle(150.0);
        surface.follow(150.0, 1.0, 1.0);
        assert_eq!((surface.temperature_c, surface.loss_w_per_k), (map.ambient, map.loss));
    }
}
