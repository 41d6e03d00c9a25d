//! Steps with the state known: a law that is told length, temperature and phase as they are, without an estimator between them.
//!
//! What is left over the time-optimal bound is then the law's own. As in the driver a duty takes effect one period after the
//! state it was made from; whoever is told the state needs no sensing pulse, so that the least duty is none.

use sinew_control::{Algorithm, Controller, Demand, Estimate, Settings, StrokeRange};
use sinew_driver::setup;
use sinew_physics::formulas::{WORKING_EXCESS_K, heating_power_w, load_pull_n, logit};
use sinew_physics::{Inputs, Load, Wire, WireModel};

use crate::bound::{Aim, swing_s, time_optimal};
use crate::{BAND, Choice, Error, Family, Plant};

/// A phase is no closer to an end than this where a logarithm is taken of it.
const EDGE: f64 = 0.01;

/// What became of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactStep {
    /// Where it went, share of the stroke.
    pub to: f64,
    /// Last moment outside ±0.5 % of the stroke, s; the length of the watch where it never came to rest.
    pub settle_s: f64,
    /// As fast as physics allows, s; `None` where that does not get there.
    pub bound_s: Option<f64>,
    /// Farthest beyond the reference, share of the stroke.
    pub overshoot: f64,
    /// RMS error of the last third, share of the stroke.
    pub rms: f64,
}

impl ExactStep {
    /// Settling time over the bound.
    pub fn ratio(&self) -> Option<f64> {
        self.bound_s.filter(|bound| *bound > 0.0).map(|bound| self.settle_s / bound)
    }
}

/// Steps of a plant, whose driver knows it, to each of `strokes` (0..1) in turn under the law of `choice`, from cold.
///
/// # Errors
/// [`Error::Rig`] where the rig file does not allow the choice on this plant, or the plant is a pair of wires.
pub fn exact_steps(plant: &Plant, choice: &Choice, strokes: &[f64]) -> Result<Vec<ExactStep>, Error> {
    let refused = |error: &dyn std::fmt::Display| Error::Rig(error.to_string());
    let no_single_wire =
        || Error::Rig(format!("{}: its wires are no single wire, so no law of a channel drives them", plant.name));
    if plant.family == Family::Pair {
        return Err(no_single_wire());
    }
    let believed = plant.believed(choice, 0)?;
    let [channel] = believed.channels.as_slice() else { return Err(no_single_wire()) };
    let model = &channel.model;
    let range = StrokeRange::of(model).map_err(|error| refused(&error))?;
    let (dt_s, max_duty) = (1.0 / believed.rate_hz, channel.limits.max_duty);
    let settings = Settings { minimum_duty: 0.0, ..setup::settings(channel) };
    let mut told = Told { law: Algorithm::new(model, &settings), model, dt_s };
    let mut wire = Wire::new(model).map_err(|error| refused(&error))?;
    let inputs = model.rest_inputs();
    let mut duty = settings.minimum_duty;
    let band_m = BAND * range.stroke_m();
    let cycles = (plant.watch_s / dt_s) as usize;
    Ok(strokes
        .iter()
        .map(|&to| {
            let reference_m = range.length_m(to);
            let target_m = reference_m - model.geometry.length_m;
            let aim = Aim { target_m, band_m, max_duty, inputs, swing_s: swing_s(model) };
            let bound_s = time_optimal(&wire, &aim).map(|bound| bound.settle_s);
            let shortens = wire.position_m() > target_m;
            let (mut outside, mut overshoot, mut square, mut late) = (0, 0.0f64, 0.0, 0);
            for k in 0..cycles {
                let next = told.duty(&wire, reference_m);
                wire.step(&Inputs { drive: duty, ..inputs }, dt_s);
                duty = next;
                let error = (wire.position_m() - target_m) / range.stroke_m();
                if error.abs() > BAND {
                    outside = k + 1;
                }
                overshoot = overshoot.max(if shortens { -error } else { error });
                if 3 * k >= 2 * cycles {
                    square += error * error;
                    late += 1;
                }
            }
            let rms = (square / f64::from(late.max(1))).sqrt();
            ExactStep { to, settle_s: outside as f64 * dt_s, bound_s, overshoot, rms }
        })
        .collect())
}

/// A law that is told the truth.
struct Told<'a> {
    law: Algorithm,
    model: &'a WireModel,
    dt_s: f64,
}

impl Told<'_> {
    fn duty(&mut self, wire: &Wire, reference_m: f64) -> f64 {
        let (m, material) = (self.model, &self.model.material);
        let length_m = m.geometry.length_m + wire.position_m();
        let martensite = wire.martensite();
        // as the estimators have it: the load's pull without its inertia (eq. 51)
        let stress_pa = match m.load {
            Load::SpringMassDamper { damping_n_s_per_m, spring_n_per_m, preload_n, .. } => {
                let (x, v) = (wire.position_m(), wire.velocity_m_s());
                load_pull_n(preload_n, spring_n_per_m, damping_n_s_per_m, x, v) / m.geometry.area_m2()
            }
            Load::ImposedPosition | Load::ImposedForce => wire.stress_pa(),
        };
        let centre = |centre_c: f64, steepness_per_k: f64| {
            centre_c
                + logit(martensite.clamp(EDGE, 1.0 - EDGE)) / steepness_per_k
                + stress_pa * material.stress_shift_k_per_pa
        };
        let resistance_ohm = wire.resistance_ohm();
        let d = &m.drive;
        let amps = d.supply_v / (resistance_ohm + d.series_ohm());
        let estimate = Estimate {
            temperature_c: wire.temperature_c(),
            martensite,
            hottest_c: wire.temperature_c(),
            stress_pa,
            heating_curve_c: centre(material.austenite_temperature_c, material.heating_steepness_per_k),
            cooling_curve_c: centre(material.martensite_temperature_c, material.cooling_steepness_per_k),
            length_m,
            loss_w: m.loss_w_per_k(WORKING_EXCESS_K) * (wire.temperature_c() - m.ambient_c),
            loss_sigma_w: 0.0,
            release_j: m.latent_heat_j() + m.geometry.volume_m3() * stress_pa * material.transformation_strain,
            full_power_w: heating_power_w(1.0, amps, resistance_ohm),
            velocity_m_s: wire.velocity_m_s(),
        };
        self.law.duty(&Demand {
            reference_m,
            length_m,
            velocity_m_s: wire.velocity_m_s(),
            acceleration_m_s2: 0.0,
            resistance_ohm,
            dt_s: self.dt_s,
            estimate,
        })
    }
}
