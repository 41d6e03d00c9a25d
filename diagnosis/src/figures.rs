//! What the report draws: traces thinned for a page, maps, unknown inputs, and everything that was tried.

use sinew_physics::DriveKind;
use sinew_recording::drive_column;

use crate::answer::{Figures, SensorTrace, Traces, Tried, UnknownInput};
use crate::conditions;
use crate::data::Data;
use crate::explanation::Explanation;
use crate::grade;
use crate::locate::Located;
use crate::select::Selection;
use crate::simulate;
use crate::stages::{Compared, Stage};

/// Most points of a line.
const MOST_POINTS: usize = 3000;

/// Draws what `compared` left of the data, what `selection` tried, and the unknown inputs of `located`.
pub(crate) fn figures(
    data: &Data,
    drive: DriveKind,
    compared: &Compared,
    selection: &Selection,
    located: &[Located],
) -> Figures {
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
        tried: tried(data, selection),
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

fn tried(data: &Data, selection: &Selection) -> Vec<Tried> {
    let names = |x: &Explanation| x.fit.space.effects.iter().map(|e| e.id.to_string()).collect::<Vec<_>>();
    let row = |x: &Explanation| Tried {
        effects: names(x),
        holdout_chi: grade::chi_kept(data, &x.fit),
        delta_bic: -2.0 * (x.evidence - selection.reference.evidence),
        chosen: names(x) == names(&selection.chosen),
        screened: false,
    };
    let mut all = vec![row(&selection.chosen), row(&selection.reference)];
    for round in &selection.rounds {
        all.extend(round.refitted.iter().map(|(_, x)| row(x)));
        // what screening alone says of the others, beside what it was added to
        let base = row(&round.base);
        all.extend(round.screened.iter().map(|s| Tried {
            effects: base.effects.iter().cloned().chain([s.candidate.effect.id.to_string()]).collect(),
            delta_bic: base.delta_bic - 2.0 * s.gain,
            chosen: false,
            screened: true,
            ..base.clone()
        }));
    }
    let mut seen: Vec<Vec<String>> = Vec::new();
    all.retain(|t| {
        let new = !seen.contains(&t.effects);
        seen.push(t.effects.clone());
        new
    });
    all.sort_by(|a, b| a.holdout_chi.total_cmp(&b.holdout_chi));
    all
}
