//! The transformation temperatures of a model, named and read as the standards have them.

use std::collections::BTreeMap;

use serde::Serialize;
use sinew_diagnosis::FittedParameter;
use sinew_physics::WireModel;
use sinew_rig::Rig;
use sinew_standards::{calorimetry, thermal_cycle};

use crate::error::Error;
use crate::furnace::{USUAL_RATE_K_PER_S, sweep};

/// A temperature with its 90 % interval, °C.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Temperature {
    /// The temperature.
    pub value_c: f64,
    /// Lower end.
    pub low_c: f64,
    /// Upper end.
    pub high_c: f64,
}

/// A_s, A_f, M_s and M_f of a model under a stress.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Temperatures {
    /// By which standard: "ASTM F2004" off the heat flow without stress, "ASTM E3097" off the strain under one.
    pub standard: &'static str,
    /// The stress, Pa.
    pub stress_pa: f64,
    /// A_s.
    pub austenite_start: Temperature,
    /// A_f.
    pub austenite_finish: Temperature,
    /// M_s.
    pub martensite_start: Temperature,
    /// M_f.
    pub martensite_finish: Temperature,
}

/// How far the sweep goes beyond both centres, in 1/k, and its steps.
const BEYOND: f64 = 20.0;
const STEPS: usize = 800;
/// No wire is simulated beyond, °C.
const COLDEST_C: f64 = -270.0;
const HOTTEST_C: f64 = 790.0;

/// The temperatures of the model of one channel under a stress: without any those of a calorimeter (F2004), else those of a loop under it
/// (E3097). Their intervals come of those of the parameters, each moved to its ends alone: as if nothing were known of how they hang together.
///
/// # Errors
/// A model that cannot be simulated so far, or shows no transformation.
pub fn temperatures(
    rig: &Rig,
    channel: usize,
    parameters: &BTreeMap<String, FittedParameter>,
    stress_pa: f64,
) -> Result<Temperatures, Error> {
    let at = |rig: &Rig| read(&rig.channels[channel].model, stress_pa);
    let here = at(rig)?;
    let (mut below, mut above) = ([0.0; 4], [0.0; 4]);
    for (key, parameter) in parameters {
        for end in [parameter.low, parameter.high] {
            let mut moved = rig.clone();
            if moved.set_parameter(channel, key, end).is_err() {
                continue;
            }
            // a model that shows nothing there says nothing of that end
            let Ok(there) = at(&moved) else { continue };
            for i in 0..4 {
                let by = there[i] - here[i];
                let side = if by < 0.0 { &mut below[i] } else { &mut above[i] };
                *side += by * by;
            }
        }
    }
    let of = |i: usize| {
        let (low_c, high_c) = (here[i] - below[i].sqrt(), here[i] + above[i].sqrt());
        Temperature { value_c: here[i], low_c, high_c }
    };
    Ok(Temperatures {
        standard: if stress_pa == 0.0 { "ASTM F2004" } else { "ASTM E3097" },
        stress_pa,
        austenite_start: of(0),
        austenite_finish: of(1),
        martensite_start: of(2),
        martensite_finish: of(3),
    })
}

/// A_s, A_f, M_s, M_f.
fn read(model: &WireModel, stress_pa: f64) -> Result<[f64; 4], Error> {
    let material = &model.material;
    let shift = material.stress_shift_k_per_pa * stress_pa;
    let cold_c = material.martensite_temperature_c + shift - BEYOND / material.cooling_steepness_per_k;
    let hot_c = material.austenite_temperature_c + shift + BEYOND / material.heating_steepness_per_k;
    let cold_c = cold_c.min(hot_c - 2.0 * BEYOND / material.heating_steepness_per_k).max(COLDEST_C);
    let hot_c = hot_c.max(cold_c + 2.0 * BEYOND / material.cooling_steepness_per_k).min(HOTTEST_C);
    let mut swept = Vec::new();
    for way in [[cold_c, hot_c], [hot_c, cold_c]] {
        swept.push(sweep(model, way, STEPS, stress_pa, USUAL_RATE_K_PER_S)?);
    }
    if stress_pa != 0.0 {
        let temperature_c: Vec<f64> = swept.iter().flat_map(|sweep| sweep.temperature_c.iter().copied()).collect();
        let strain: Vec<f64> = swept.iter().flat_map(|sweep| sweep.strain.iter().copied()).collect();
        let cycle = thermal_cycle(&temperature_c, &strain)?;
        let [up, down] = [cycle.heating, cycle.cooling];
        return Ok([up.start_c.value, up.finish_c.value, down.start_c.value, down.finish_c.value]);
    }
    let middles = |sweep: &crate::furnace::Sweep| -> Vec<f64> {
        sweep.temperature_c.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
    };
    let flows = |sweep: &crate::furnace::Sweep| -> Vec<f64> {
        sweep.martensite.windows(2).map(|pair| pair[0] - pair[1]).collect()
    };
    let temperature_c: Vec<f64> = swept.iter().flat_map(middles).collect();
    let heat_flow: Vec<f64> = swept.iter().flat_map(flows).collect();
    let peaks = calorimetry(&temperature_c, &heat_flow)?;
    let [up, down] = [peaks.heating, peaks.cooling];
    Ok([up.start_c.value, up.finish_c.value, down.start_c.value, down.finish_c.value])
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_standards::{LOGISTIC_SPAN, STRAIN_SPAN};

    #[test]
    fn logistic_curves_have_their_tangents_in_closed_form() {
        let rig = Rig::hexapod();
        let material = rig.channels[0].model.material;
        let centre = FittedParameter {
            given: 0.0,
            value: material.austenite_temperature_c,
            low: material.austenite_temperature_c - 1.0,
            high: material.austenite_temperature_c + 2.0,
            unit: "°C".into(),
            prior_sigma: 5.0,
        };
        let parameters = BTreeMap::from([("austenite_temperature_c".to_string(), centre)]);
        for (stress_pa, span) in [(0.0, LOGISTIC_SPAN), (150e6, STRAIN_SPAN)] {
            let shift = material.stress_shift_k_per_pa * stress_pa;
            let found = temperatures(&rig, 0, &parameters, stress_pa).expect("a wire that moves");
            for (at, centre_c, sign, k) in [
                (found.austenite_start, material.austenite_temperature_c, -0.5, material.heating_steepness_per_k),
                (found.austenite_finish, material.austenite_temperature_c, 0.5, material.heating_steepness_per_k),
                (found.martensite_start, material.martensite_temperature_c, 0.5, material.cooling_steepness_per_k),
                (found.martensite_finish, material.martensite_temperature_c, -0.5, material.cooling_steepness_per_k),
            ] {
                let expected = centre_c + shift + sign * span / k;
                assert!((at.value_c - expected).abs() < 0.3, "{stress_pa}: {at:?}, expected {expected}");
            }
            let up = found.austenite_finish;
            assert!(
                (up.value_c - up.low_c - 1.0).abs() < 0.05 && (up.high_c - up.value_c - 2.0).abs() < 0.05,
                "{up:?}"
            );
            assert!((found.martensite_start.high_c - found.martensite_start.value_c).abs() < 0.05);
        }
    }
}
