//! From an unknown wire to a fitted rig file: the routines that make every parameter identifiable, and how well the fitted
//! model predicts a routine that was not fitted.
//!
//! - `loops`: slow pulls at three heating powers. Moduli, transformation strain, the plateaus and what a kelvin does to them.
//! - `warm`: the same in a warm chamber. A power alone says temperature and loss to the air only together: what the
//!   wire does at another temperature of the air distinguishes them.
//! - `inner`: pulls that turn back half way. What the wire does between the outer curves.
//! - `steps`: power on and off under a steady force. Heat capacity and latent heat, by how fast temperature follows.
//! - `sines`: power up and down under a smaller force, ever faster. Partial loops, and the shift with stress once more.
//!
//! All are recorded with imposed position and measured force, whatever was held, so one fit takes all five.
//!
//! On a running rig, whose own load pulls: `loop`, once slowly through the transformation and back; `inner`, back and forth within it; `steps`
//! and `sines` as above. The driver records them, so duty drives the model, and position and voltages are its answer.

mod page;

use std::collections::BTreeMap;

use serde::Serialize;
use sinew_diagnosis::{FittedParameter, Identified, Settings};
use sinew_physics::{Load, WireModel};
use sinew_recording::{Column, Recording};
use sinew_rig::{Machine as Spec, Prior, Rig};

use crate::plan::{Options, RoutineKind, holding_power_w, hot_c, thermal_time_s};
use crate::record::rig_in_machine;
use crate::wave::Shape;

pub use page::{Unseen, page};

/// One routine of the characterisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// What its recording is called.
    pub name: &'static str,
    /// The routine.
    pub kind: RoutineKind,
    /// With these numbers.
    pub options: Options,
    /// Whether the fit may see it; otherwise what was fitted is judged by it.
    pub is_fitted: bool,
}

/// Parameters that have no prior by default but may move here, because these recordings tell them: key, 1 σ.
const MORE_PRIORS: [(&str, Prior); 2] =
    [("outer_loop_weight", Prior::Absolute(0.1)), ("thermoelastic_mpa_per_k", Prior::Relative(0.2))];
/// Heating levels of the loops, as shares of the power that makes the wire austenite under load.
const LEVELS: [f64; 3] = [0.6, 0.8, 1.0];
/// The warm chamber is this far below the middle of the cooling transformation, K.
const BELOW_K: f64 = 7.0;
/// The inner loops go between these shares of the transformation strain.
const INNER: [f64; 2] = [0.3, 0.7];
/// Stresses of the steps and the sines, Pa.
const STRESSES_PA: [f64; 2] = [150e6, 50e6];
/// The loops end this far beyond the transformation strain, share of the length.
const BEYOND: f64 = 0.005;
/// A way of a loop, and periods of steps, sines and of what is foretold, in thermal time constants.
const WAY: f64 = 9.0;
const STEPS: [f64; 2] = [22.0, 9.0];
const SINES: [f64; 2] = [30.0, 9.0];
const CHECK: [f64; 2] = [13.0, 3.0];
/// On a rig: the period of the slow loop and of the inner ones, in thermal time constants, and between which shares of the heat those go.
const LOOP: f64 = 40.0;
const INNER_PERIOD: f64 = 20.0;
const WITHIN: [f64; 2] = [0.4, 0.8];
/// A wire that is hotter than believed is to be made austenite all the same: so much more heat. The driver bounds its temperature.
const RESERVE: f64 = 1.15;

/// The routines, those that are fitted first, for a wire that is believed to be like `model`.
pub fn tasks(model: &WireModel, spec: &Spec) -> Vec<Task> {
    let (area, time_s) = (model.geometry.area_m2(), thermal_time_s(model));
    let most_n = 0.8 * spec.max_force_n;
    let strain = (model.material.transformation_strain + BEYOND).min(0.9 * spec.max_strain);
    let hot_at = |air_c: f64| holding_power_w(model, hot_c(model, STRESSES_PA[0]), air_c);
    let hot_w = hot_at(model.ambient_c);
    let loops = |name: &'static str, heating: Vec<f64>, chamber_c: Option<f64>, reset_w: f64| Task {
        name,
        kind: RoutineKind::DirectStrain,
        options: Options {
            heating,
            strains: vec![0.0, strain],
            speed_m_s: strain * model.geometry.length_m / (WAY * time_s),
            cycles: 1,
            chamber_c,
            reset_w: Some(reset_w),
            ..Options::default_for(RoutineKind::DirectStrain, model, spec)
        },
        is_fitted: true,
    };
    let sweep = |name: &'static str, shape: Shape, stress_pa: f64, periods: [f64; 2]| Task {
        name,
        kind: RoutineKind::ConstantForceSweep,
        options: Options {
            heating: vec![0.0, hot_w],
            shape,
            loads_n: vec![(stress_pa * area).min(most_n)],
            frequencies_hz: periods.map(|times| 1.0 / (times * time_s)).to_vec(),
            cycles: 1,
            ..Options::default_for(RoutineKind::ConstantForceSweep, model, spec)
        },
        is_fitted: true,
    };
    let warm_c = (model.material.martensite_temperature_c - BELOW_K).clamp(spec.chamber_min_c, spec.chamber_max_c);
    let warm_w = hot_at(warm_c);
    vec![
        loops("loops", LEVELS.map(|share| share * hot_w).to_vec(), None, hot_w),
        loops("warm", vec![0.3 * warm_w, 0.8 * warm_w], Some(warm_c), warm_w),
        Task {
            options: Options {
                heating: vec![0.8 * hot_w, hot_w],
                strains: INNER.map(|share| share * model.material.transformation_strain).to_vec(),
                cycles: 3,
                ..loops("inner", Vec::new(), None, hot_w).options
            },
            ..loops("inner", Vec::new(), None, hot_w)
        },
        sweep("steps", Shape::Step, STRESSES_PA[0], STEPS),
        sweep("sines", Shape::Sine, STRESSES_PA[1], SINES),
        Task {
            name: "held",
            kind: RoutineKind::ConstantStrainSweep,
            options: Options {
                heating: vec![0.0, 0.9 * hot_w],
                strains: vec![0.4 * model.material.transformation_strain],
                frequencies_hz: CHECK.map(|times| 1.0 / (times * time_s)).to_vec(),
                cycles: 1,
                ..Options::default_for(RoutineKind::ConstantStrainSweep, model, spec)
            },
            is_fitted: false,
        },
        Task {
            name: "pulled",
            kind: RoutineKind::DirectLoad,
            options: Options {
                heating: vec![0.7 * hot_w, 0.9 * hot_w],
                loads_n: vec![0.02 * most_n, (300e6 * area).min(most_n)],
                speed_m_s: strain * model.geometry.length_m / (1.5 * WAY * time_s),
                cycles: 2,
                ..Options::default_for(RoutineKind::DirectLoad, model, spec)
            },
            is_fitted: false,
        },
    ]
}

/// The same for a rig, whose wire pulls against its own load: `on_rig` are the numbers of a sweep there, and no more than `most_w` heats.
pub fn tasks_on_rig(model: &WireModel, on_rig: &Options, most_w: f64) -> Vec<Task> {
    let time_s = thermal_time_s(model);
    let hot_w = (RESERVE * on_rig.heating.iter().copied().fold(0.0, f64::max)).min(most_w);
    let task =
        |name: &'static str, shape: Shape, shares: [f64; 2], periods: &[f64], cycles: usize, is_fitted: bool| Task {
            name,
            kind: RoutineKind::ConstantForceSweep,
            options: Options {
                heating: shares.map(|share| share * hot_w).to_vec(),
                shape,
                frequencies_hz: periods.iter().map(|times| 1.0 / (times * time_s)).collect(),
                cycles,
                ..on_rig.clone()
            },
            is_fitted,
        };
    vec![
        task("loop", Shape::Sine, [0.0, 1.0], &[LOOP], 1, true),
        task("inner", Shape::Sine, WITHIN, &[INNER_PERIOD], 3, true),
        task("steps", Shape::Step, [0.0, 1.0], &STEPS, 1, true),
        task("sines", Shape::Sine, [0.0, 1.0], &SINES, 1, true),
        task("sawtooth", Shape::SawTooth, [0.0, 1.0], &CHECK, 1, false),
        task("pieces", Shape::Step, [0.5, 0.95], &CHECK, 2, false),
    ]
}

/// Where a wire was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In a test machine, by its sensors.
    Machine,
    /// On a rig, by its driver.
    Rig,
}

impl Place {
    /// The rig as recordings of it are.
    pub fn recorded(self, rig: &Rig, channel: usize) -> Rig {
        match self {
            Place::Machine => rig_in_machine(rig, channel),
            Place::Rig => rig.clone(),
        }
    }
}

/// The rig as the recordings see it, with what else may be fitted to them.
pub fn beliefs(rig: &Rig, channel: usize, place: Place) -> Rig {
    let mut mounted = place.recorded(rig, channel);
    if let Some(wire) = mounted.channels.get_mut(channel) {
        for (key, prior) in MORE_PRIORS {
            wire.priors.entry(key.to_string()).or_insert(prior);
        }
    }
    mounted
}

/// How far a simulation is from a recording, by column: RMS over the sensor's noise, and how many samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Misfit {
    /// RMS error over noise: 1 = nothing left.
    pub chi: f64,
    /// Samples.
    pub samples: usize,
}

/// What a rig foretells of a recording, beside what was measured.
#[derive(Debug, Clone)]
pub struct Foretold {
    /// By column.
    pub misfits: BTreeMap<String, Misfit>,
    /// Over all of them.
    pub chi: f64,
    /// Force as simulated, N, by row.
    pub force_n: Vec<f64>,
    /// Elongation as simulated, m, by row.
    pub position_m: Vec<f64>,
}

impl Foretold {
    /// What is foretold of this column, by row: force, else elongation.
    fn of(&self, column: Column) -> &[f64] {
        if column == Column::ForceN { &self.force_n } else { &self.position_m }
    }
}

/// Simulates a recording with channel `channel` of a rig and compares force, position where it is an answer, and voltages, in the noise
/// `rig` gives.
///
/// # Errors
/// A recording without the inputs the rig needs.
pub fn foretell(rig: &Rig, channel: usize, recording: &Recording) -> Result<Foretold, sinew_recording::Error> {
    let wire = &rig.channels[channel];
    let model = &wire.model;
    let columns: Vec<(Column, f64)> = [Column::ForceN, Column::PositionM, Column::V1V, Column::V2V, Column::V3V]
        .into_iter()
        .filter_map(|column| Some((column, *wire.noise.get(column.name())?)))
        .filter(|(column, _)| recording.get(*column).is_some())
        // what is put in is no answer
        .filter(|(column, _)| *column != Column::PositionM || model.load != Load::ImposedPosition)
        .collect();
    let mut sums = vec![(0.0, 0usize); columns.len()];
    let (mut force_n, mut position_m) = (Vec::with_capacity(recording.len()), Vec::with_capacity(recording.len()));
    for (row, simulated) in recording.simulated(model)?.enumerate() {
        let (inputs, outputs) = simulated?;
        force_n.push(outputs.force_n);
        position_m.push(Column::PositionM.of_outputs(&outputs).unwrap_or(f64::NAN));
        for ((column, noise), sum) in columns.iter().zip(&mut sums) {
            let measured = recording.get(*column).map_or(f64::NAN, |values| values[row]);
            // without a current there is no voltage to tell anything by
            let seen = matches!(column, Column::ForceN | Column::PositionM) || inputs.drive > 0.0;
            let Some(simulated) = column.of_outputs(&outputs).filter(|_| seen && !measured.is_nan()) else { continue };
            sum.0 += ((measured - simulated) / noise).powi(2);
            sum.1 += 1;
        }
    }
    let total = sums.iter().fold((0.0, 0), |(a, n), (b, m)| (a + b, n + m));
    let chi = |sum: f64, count: usize| (sum / count.max(1) as f64).sqrt();
    let misfits = columns
        .iter()
        .zip(&sums)
        .map(|((column, _), (sum, samples))| {
            (column.name().to_string(), Misfit { chi: chi(*sum, *samples), samples: *samples })
        })
        .collect();
    Ok(Foretold { misfits, chi: chi(total.0, total.1), force_n, position_m })
}

/// One recording of the characterisation and how it is met.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Met {
    /// What it is called.
    pub recording: String,
    /// Which routine it is.
    pub routine: &'static str,
    /// Whether it was fitted.
    pub fitted: bool,
    /// Length, s.
    pub seconds: f64,
    /// chi over all sensors with the rig file as it was.
    pub chi_as_believed: f64,
    /// chi over all sensors with the fitted rig.
    pub chi: f64,
    /// By column with the fitted rig.
    pub sensors: BTreeMap<String, Misfit>,
}

/// What a characterisation comes to.
#[derive(Debug, Clone, Serialize)]
pub struct Characterised {
    /// `sinew.characterise/1`.
    pub schema: &'static str,
    /// Name of the rig.
    pub rig: String,
    /// Name of the channel.
    pub channel: String,
    /// By key: given, fitted, interval.
    pub parameters: BTreeMap<String, FittedParameter>,
    /// Every recording, those that were not fitted last.
    pub recordings: Vec<Met>,
    /// chi over all recordings that were not fitted.
    pub chi_unseen: f64,
    /// What a reader must know.
    pub warnings: Vec<String>,
}

/// A recording of a [`Task`].
#[derive(Debug, Clone)]
pub struct Recorded {
    /// The task.
    pub task: Task,
    /// What it measured.
    pub recording: Recording,
}

/// Fits the wire of `channel` to the recordings of the tasks that are to be fitted.
///
/// # Errors
/// As [`sinew_diagnosis::identify`].
pub fn fit(
    rig: &Rig,
    channel: usize,
    place: Place,
    recorded: &[Recorded],
    settings: &Settings<'_>,
) -> Result<Identified, sinew_diagnosis::Error> {
    let recordings: Vec<Recording> =
        recorded.iter().filter(|r| r.task.is_fitted).map(|r| r.recording.clone()).collect();
    sinew_diagnosis::identify(&beliefs(rig, channel, place), channel, &recordings, None, settings)
}

/// The rig file with the fitted material, its own drive and load kept.
pub fn fitted_rig(rig: &Rig, channel: usize, identified: &Identified) -> Rig {
    let mut fitted = rig.clone();
    fitted.channels[channel].model.material = identified.rig.channels[channel].model.material;
    fitted
}

/// What was believed, with the noise of its sensors; where the rig file says nothing of it, with what the recordings themselves show.
pub fn believed(rig: &Rig, channel: usize, place: Place, identified: &Identified) -> Rig {
    let mut believed = place.recorded(rig, channel);
    for (column, sigma) in &identified.noise {
        believed.channels[channel].noise.entry(column.clone()).or_insert(*sigma);
    }
    believed
}

/// Judges a fit by every recording.
///
/// # Errors
/// A recording without the inputs the rig needs.
pub fn judge(
    rig: &Rig,
    channel: usize,
    place: Place,
    identified: &Identified,
    recorded: &[Recorded],
) -> Result<Characterised, sinew_recording::Error> {
    let believed = believed(rig, channel, place, identified);
    // the assumed noise of the sensors, whatever was fitted
    let mut fitted = identified.rig.clone();
    fitted.channels[channel].noise.clone_from(&believed.channels[channel].noise);
    let (mut unseen, mut count) = (0.0, 0.0);
    let mut recordings = Vec::new();
    for Recorded { task, recording } in recorded {
        let met = foretell(&fitted, channel, recording)?;
        if !task.is_fitted {
            let samples: usize = met.misfits.values().map(|misfit| misfit.samples).sum();
            unseen += met.chi * met.chi * samples as f64;
            count += samples as f64;
        }
        recordings.push(Met {
            recording: task.name.to_string(),
            routine: task.kind.word(),
            fitted: task.is_fitted,
            seconds: recording.duration_s(),
            chi_as_believed: foretell(&believed, channel, recording)?.chi,
            chi: met.chi,
            sensors: met.misfits,
        });
    }
    Ok(Characterised {
        schema: "sinew.characterise/1",
        rig: rig.name.clone(),
        channel: rig.channels[channel].name.clone(),
        parameters: identified.parameters.clone(),
        recordings,
        chi_unseen: f64::sqrt(unseen / f64::max(count, 1.0)),
        warnings: identified.warnings.clone(),
    })
}
