//! What the report draws: traces thinned for a page, maps, unknown inputs, and everything that was tried.

use sinew_physics::DriveKind;
use sinew_recording::drive_column;

use crate::answer::{Figures, SensorTrace, Traces, UnknownInput};
use crate::conditions;
use crate::data::Data;
use crate::locate::Located;
use crate::simulate;
use crate::stages::{Compared, Stage};

/// Most points of a line.
const MOST_POINTS: usize = 3000;

/// Draws what `compared` left of the data, and the unknown inputs of `located`.
pub(crate) fn figures(data: &Data, drive: DriveKind, compared: &Compared, located: &[Located]) -> Figures {
    let Compared { as_given, recalibrated, improved, chosen, .. } = compared;
    let states = chosen.fit.states(data);
    let recordings = data
        .runs
        .iter()
        .enumerate()
        .map(|(r, run)| {
            let stride = run.time_s.len().div_ceil(MOST_POINTS).max(1);
            let thin = |f: &dyn Fn(usize) -> f64| (0..run.time_s.len()).step_by(stride).map(f).collect::<Vec<f64>>();
            let states = states.as_ref().map(|states| &states[r]);
            let state =
                |f: &dyn Fn(&simulate::State) -> f64| thin(&|row| states.and_then(|s| s.get(row)).map_or(f64::NAN, f));
            Traces {
                name: run.name.clone(),
                time_s: thin(&|row| run.time_s[row]),
                drive: thin(&|row| run.inputs[row].0.drive),
                drive_column: drive_column(drive),
                kept_back: run.kept_back(),
                temperature_c: state(&|s| s.temperature_c),
                martensite: state(&|s| s.martensite),
                sensors: data
                    .sensors
                    .iter()
                    .enumerate()
                    .map(|(s, sensor)| {
                        let measured = &run.measured[s];
                        // what the residual leaves of the measurement is the simulation as the sensor would have shown it
                        let simulated = |stage: &Stage| {
                            thin(&|row| measured[row] - f64::from(stage.residuals[r][s][row]) * sensor.noise)
                        };
                        SensorTrace {
                            column: sensor.column,
                            noise: sensor.noise,
                            measured: thin(&|row| measured[row]),
                            as_given: simulated(as_given),
                            recalibrated: simulated(recalibrated),
                            improved: simulated(improved),
                        }
                    })
                    .collect(),
            }
        })
        .collect();
    Figures {
        recordings,
        maps: conditions::maps(data, &chosen.fit, &recalibrated.residuals, &improved.residuals),
        unknown_inputs: located.iter().map(unknown_input).collect(),
    }
}

fn unknown_input(located: &Located) -> UnknownInput {
    let (time_s, value) = located.input.first().cloned().unwrap_or_default();
    UnknownInput {
        equation: located.equation.name().to_string(),
        what: located.what.clone(),
        unit: located.unit.to_string(),
        score: located.score,
        time_s,
        value,
    }
}
