//! What every gate looks at: the recording, the rig, and what the rig as given says would have been measured.

use std::collections::BTreeMap;

use sinew_physics::formulas::cooling_time_s;
use sinew_physics::{DriveKind, Wire, WireModel};
use sinew_recording::{Column, Recording, drive_column, imposed_column};
use sinew_rig::Channel;

use super::statistics::span;
use crate::error::{Broken, Error, Trouble};
use crate::noise::{Noise, estimate};

/// Fewest samples a diagnosis is tried on.
pub const LEAST_SAMPLES: usize = 100;

/// Most samples of one recording: 83 minutes at 200 Hz. It is simulated hundreds of times.
pub const MOST_SAMPLES: usize = 1_000_000;

/// Rows that are compared with a simulation; a longer recording is thinned to about as many.
const COMPARED_ROWS: usize = 20_000;

/// Something a reader of the diagnosis must know, and what is left out because of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// With the recording's name, the column, the time and the remedy.
    pub text: String,
    /// The column it concerns; none = all of them.
    pub column: Option<Column>,
    /// What is left out of fit and judgement.
    pub exclude: Exclude,
}

/// What a warning leaves out.
#[derive(Debug, Clone, PartialEq)]
pub enum Exclude {
    /// Nothing.
    Nothing,
    /// These intervals, s, ends included: of the column, or of every sensor where the warning names none.
    Windows(Vec<(f64, f64)>),
    /// All of the column.
    Column,
}

/// The columns of a recording that this wire's model has something to say about and that do not drive it.
pub fn sensors(recording: &Recording, model: &WireModel) -> Vec<Column> {
    let kind = model.drive.kind;
    let inputs = [Some(drive_column(kind)), imposed_column(&model.load)];
    // a furnace determines no currents and voltages, a given power nothing of the taps
    let electrical = matches!(kind, DriveKind::Pwm | DriveKind::Current);
    let known = |column: Column| match column {
        Column::CurrentA | Column::V3V => electrical || kind == DriveKind::Power,
        Column::V1V | Column::V2V => electrical && model.taps.is_some(),
        Column::PowerW => kind != DriveKind::Temperature,
        Column::TemperatureC | Column::ForceN | Column::PositionM => true,
        Column::Duty | Column::SupplyV | Column::AmbientC | Column::DisturbanceN => false,
    };
    recording.columns().map(|(column, _)| column).filter(|c| known(*c) && !inputs.contains(&Some(*c))).collect()
}

/// What the gates look at: the recording, the rig, and what the rig as given says would have been measured.
pub(super) struct Gate<'a> {
    pub(super) recording: &'a Recording,
    pub(super) channel: &'a Channel,
    pub(super) model: &'a WireModel,
    pub(super) sensors: Vec<Column>,
    pub(super) noise: BTreeMap<Column, Noise>,
    pub(super) simulated: Simulated,
}

/// The rig as given, driven by the recording, at every n-th row.
pub(super) struct Simulated {
    /// The rows.
    pub(super) rows: Vec<usize>,
    /// Everything a sensor could see, by column.
    pub(super) columns: BTreeMap<Column, Vec<f64>>,
    /// ξ.
    pub(super) martensite: Vec<f64>,
    /// R, Ω.
    pub(super) resistance_ohm: Vec<f64>,
    /// V_s as it drove the model.
    pub(super) supply_v: Vec<f64>,
}

impl<'a> Gate<'a> {
    pub(super) fn new(recording: &'a Recording, channel: &'a Channel) -> Result<Gate<'a>, Error> {
        let model = &channel.model;
        let sensors = sensors(recording, model);
        let broken = |what| Broken { recording: recording.name().into(), column: None, span_s: None, what };
        // before anything is computed from it
        let found = recording.len();
        if found > MOST_SAMPLES {
            return Err(broken(Trouble::TooLong { found, most: MOST_SAMPLES }).into());
        }
        if found < LEAST_SAMPLES {
            return Err(broken(Trouble::TooFewSamples { found, least: LEAST_SAMPLES }).into());
        }
        if sensors.is_empty() {
            let would_do = Column::ALL.into_iter().filter(|c| {
                let mut with = recording.clone();
                recording.get(*c).is_none()
                    && with.set(*c, vec![0.0; found]).is_ok()
                    && !self::sensors(&with, model).is_empty()
            });
            return Err(broken(Trouble::NothingMeasured { would_do: would_do.collect() }).into());
        }
        let noise = sensors.iter().map(|c| (*c, estimate(recording, *c, None))).collect();
        let simulated = simulate(recording, model, 1.0, COMPARED_ROWS)?;
        Ok(Gate { recording, channel, model, sensors, noise, simulated })
    }

    /// An error about a column of this recording, or about all of it.
    pub(super) fn broken(&self, column: Option<Column>, what: Trouble) -> Error {
        Broken { recording: self.recording.name().into(), column, span_s: None, what }.into()
    }

    /// A warning about a column of this recording.
    pub(super) fn warning(&self, column: Option<Column>, exclude: Exclude, text: String) -> Warning {
        let place = column.map(|c| format!("column \"{}\": ", c.name())).unwrap_or_default();
        Warning { text: format!("{}: {place}{text}", self.recording.name()), column, exclude }
    }

    /// A measured column at the compared rows; NaN where it is missing.
    pub(super) fn measured(&self, column: Column) -> Option<Vec<f64>> {
        let values = self.recording.get(column)?;
        Some(self.simulated.rows.iter().map(|row| values[*row]).collect())
    }

    /// The same of a sensor that is not left out.
    pub(super) fn sensor(&self, column: Column) -> Option<Vec<f64>> {
        self.measured(column).filter(|_| self.sensors.contains(&column))
    }

    /// The same with what the model says beside it.
    pub(super) fn pair(&self, column: Column) -> Option<(Vec<f64>, &[f64])> {
        Some((self.sensor(column)?, self.simulated.columns.get(&column)?))
    }

    /// How far the model's wire is from its coldest to its hottest, K.
    pub(super) fn warmed_k(&self) -> f64 {
        span(&self.simulated.columns[&Column::TemperatureC])
    }

    /// Time constant of the wire's cooling m c_p/(h A_s), s.
    pub(super) fn time_constant_s(&self) -> f64 {
        let loss = self.model.material.convection_w_per_m2_k.max(LEAST_CONVECTION);
        cooling_time_s(self.model.heat_capacity_j_per_k(), self.model.geometry.loss_w_per_k(loss))
    }
}

/// No wire in air loses less than this, W/(m² K): stands in where the rig's own law gives no number.
pub(super) const LEAST_CONVECTION: f64 = 10.0;

/// Drives the model with the recording, its clock running `pace` times as fast, and keeps about `rows` rows of it.
pub(super) fn simulate(recording: &Recording, model: &WireModel, pace: f64, rows: usize) -> Result<Simulated, Error> {
    let every = recording.len().div_ceil(rows).max(1);
    let kept: Vec<usize> = (0..recording.len()).step_by(every).collect();
    let mut columns: BTreeMap<Column, Vec<f64>> = BTreeMap::new();
    let (mut martensite, mut resistance_ohm, mut supply_v) = (Vec::new(), Vec::new(), Vec::new());
    let mut wire: Option<Wire> = None;
    for (row, (inputs, interval_s)) in recording.inputs_for(model)?.enumerate() {
        let wire = match &mut wire {
            Some(wire) => wire,
            none => none.insert(Wire::with_inputs(model, &inputs)?),
        };
        wire.step(&inputs, interval_s * pace);
        if row % every == 0 {
            let outputs = wire.outputs();
            for column in Column::ALL {
                if let Some(value) = column.of_outputs(&outputs) {
                    columns.entry(column).or_default().push(value);
                }
            }
            martensite.push(outputs.martensite);
            resistance_ohm.push(outputs.resistance_ohm);
            supply_v.push(inputs.supply_v);
        }
    }
    Ok(Simulated { rows: kept, columns, martensite, resistance_ohm, supply_v })
}
