//! The rig file's own wire, simulated when a law is made: what laws that are fitted to a wire are fitted to.

use crate::wire_map::WireMap;
use sinew_physics::{Drive, DriveKind, Effects, Inputs, Load, Wire, WireModel};

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
