//! A wire of the model in a furnace: its temperature and the force on it imposed.

use sinew_physics::{DriveKind, Inputs, Load, Wire, WireModel};

use crate::error::Error;

/// How fast it is heated and cooled where nobody says, K/s: 10 K/min, what standards ask for.
pub(crate) const USUAL_RATE_K_PER_S: f64 = 10.0 / 60.0;

/// What it shows along an even sweep, in the order of the sweep.
#[derive(Debug, Clone)]
pub(crate) struct Sweep {
    pub temperature_c: Vec<f64>,
    /// ξ.
    pub martensite: Vec<f64>,
    /// Elongation over the wire's length.
    pub strain: Vec<f64>,
}

/// From one temperature to another in so many even steps, under a constant stress; it begins as martensite where it is heated, else as
/// austenite.
pub(crate) fn sweep(
    model: &WireModel,
    [from_c, to_c]: [f64; 2],
    steps: usize,
    stress_pa: f64,
    rate_k_per_s: f64,
) -> Result<Sweep, Error> {
    let mut model = model.clone();
    model.drive.kind = DriveKind::Temperature;
    model.load = Load::ImposedForce;
    model.initial.temperature_c = Some(from_c);
    model.initial.martensite = f64::from(u8::from(to_c > from_c));
    let imposed = stress_pa * model.geometry.area_m2();
    let at = |drive: f64| Inputs { drive, imposed, ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(&model, &at(from_c))?;
    let step_k = (to_c - from_c) / steps as f64;
    let dt_s = step_k.abs() / rate_k_per_s;
    let mut seen = Sweep { temperature_c: Vec::new(), martensite: Vec::new(), strain: Vec::new() };
    for i in 0..=steps {
        let t = from_c + step_k * i as f64;
        if i > 0 {
            wire.step(&at(t), dt_s);
        }
        seen.temperature_c.push(t);
        seen.martensite.push(wire.martensite());
        seen.strain.push(wire.position_m() / model.geometry.length_m);
    }
    Ok(seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_rig::Rig;

    #[test]
    fn the_phase_follows_the_outer_curves_in_closed_form() {
        let model = &Rig::hexapod().channels[0].model;
        let m = model.material;
        for (way, centre_c, k) in [
            ([0.0, 160.0], m.austenite_temperature_c, m.heating_steepness_per_k),
            ([160.0, 0.0], m.martensite_temperature_c, m.cooling_steepness_per_k),
        ] {
            let seen = sweep(model, way, 400, 0.0, USUAL_RATE_K_PER_S).expect("a wire");
            for (t, xi) in seen.temperature_c.iter().zip(&seen.martensite) {
                // eq. 20
                let expected = 1.0 / (1.0 + (k * (t - centre_c)).exp());
                assert!((xi - expected).abs() < 2e-3, "{t} °C: {xi}, expected {expected}");
            }
        }
    }
}
