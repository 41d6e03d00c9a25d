//! The rig file's own wire, simulated when a law is made: what laws that are fitted to a wire are fitted to.

use crate::wire_map::WireMap;
use sinew_physics::{Drive, DriveKind, Effects, Inputs, Load, Wire, WireModel};
use sinew_state_space::{DMatrix, DVector};

/// Iterations after which a least-squares fit is given up.
const MOST_ITERATIONS: usize = 1000;

/// How slowly the loop is gone through, K/s, in steps of so many seconds.
const SLOWLY_K_PER_S: f64 = 1.0;
const STEP_S: f64 = 5e-3;

/// The reference model of a wire, heated by power as such: what heats it does not matter, nor what lies beyond the reference model; a load
/// that nobody knows is none.
pub(super) fn reference(model: &WireModel, map: &WireMap) -> WireModel {
    let load = if map.load_known {
        model.load
    } else {
        Load::SpringMassDamper { mass_kg: 0.01, damping_n_s_per_m: 1.0, spring_n_per_m: 0.0, preload_n: 0.0 }
    };
    let drive = Drive { kind: DriveKind::Power, ..model.drive };
    WireModel { load, drive, effects: Effects::default(), taps: None, ..model.clone() }
}

/// A reference model that moves, and how far.
pub(super) struct Moving {
    pub model: WireModel,
    /// Lengths cold and hot, and between them, m.
    pub cold_m: f64,
    pub hot_m: f64,
    pub stroke_m: f64,
}

impl Moving {
    /// `None` of a wire that does not move.
    pub fn of(model: WireModel) -> Option<Moving> {
        let (cold_m, hot_m) = (sinew_physics::cold_length_m(&model).ok()?, sinew_physics::hot_length_m(&model).ok()?);
        let stroke_m = cold_m - hot_m;
        (stroke_m > 1e-9).then_some(Moving { model, cold_m, hot_m, stroke_m })
    }

    /// Stroke of a wire at an elongation, m: 0 cold, 1 hot.
    pub fn stroke(&self, elongation_m: f64) -> f64 {
        (self.cold_m - self.model.geometry.length_m - elongation_m) / self.stroke_m
    }

    /// Temperatures so many widths beyond both curves' centres, wherever the load puts them: cold, and no colder than the air, and hot, °C.
    pub fn beyond_c(&self, map: &WireMap, widths: f64) -> [f64; 2] {
        let shifts = [self.cold_m, self.hot_m].map(|length_m| map.stress(length_m - map.length, 0.0) * map.shift);
        let cold_c = map.cooling_centre + shifts[0].min(shifts[1]) - widths * map.cooling_width;
        [cold_c.max(map.ambient), map.heating_centre + shifts[0].max(shifts[1]) + widths * map.heating_width]
    }
}

/// What solves rows · x = wanted best, by least squares; `None` where that is not found.
pub(super) fn least_squares(rows: DMatrix<f64>, wanted: &DVector<f64>) -> Option<DVector<f64>> {
    rows.try_svd(true, true, f64::EPSILON, MOST_ITERATIONS)?.solve(wanted, 1e-12).ok()
}

/// Points of a way through the loop: temperature, °C, and elongation, m.
pub(super) type Way = Vec<(f64, f64)>;

/// The wire of a model, heated or cooled slowly to where `until` says so.
pub(super) fn slowly(wire: &mut Wire, model: &WireModel, loss: f64, to_c: f64, until: impl Fn(&Wire) -> bool) -> Way {
    let mut way = Way::new();
    let from_c = wire.temperature_c();
    let steps = ((to_c - from_c).abs() / (SLOWLY_K_PER_S * STEP_S)).min(1e5) as usize;
    let capacity = model.heat_capacity_j_per_k();
    for k in 1..=steps {
        let wanted = from_c + (to_c - from_c) * k as f64 / steps as f64;
        let now = wire.temperature_c();
        // the loss, and the heat that brings it to where it is to be within ten steps
        let power = loss * (now - model.ambient_c) + capacity * (wanted - now) / (10.0 * STEP_S);
        wire.step(&Inputs { drive: power.max(0.0), ..model.rest_inputs() }, STEP_S);
        way.push((wire.temperature_c(), wire.position_m()));
        if until(wire) {
            break;
        }
    }
    way
}

/// The temperature at which a way first makes `of` (of the elongation) positive.
pub(super) fn crossing(way: &Way, of: impl Fn(f64) -> f64) -> Option<f64> {
    way.iter().find(|(_, x)| of(*x) >= 0.0).map(|(t, _)| *t)
}
