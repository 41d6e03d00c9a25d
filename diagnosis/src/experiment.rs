//! What to record next: drive programmes, loads and supplies are tried by simulation, and the one on which two
//! explanations differ most — after everything that may move has been refitted — is proposed.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sinew_physics::{DriveKind, Inputs, Load, WireModel};
use sinew_recording::{Column, Recording, drive_column, imposed_column};

use crate::data::{Data, Part, Run};
use crate::derivatives;
use crate::fit::Fit;
use crate::products;
use crate::residuals::{self, Residuals};
use crate::simulate;

/// Length and rate of a proposed recording, s and Hz.
const LENGTH_S: f64 = 60.0;
const RATE_HZ: f64 = 50.0;
/// Designs on which one of the two is refitted.
const REFITTED: usize = 4;

/// A proposed recording and how far apart the two explanations are on it.
#[derive(Debug, Clone)]
pub(crate) struct Proposal {
    /// What to do, in words.
    pub(crate) words: String,
    /// RMS difference over the sensors' noise, after refitting.
    pub(crate) apart: f64,
    /// The same on the recordings there are.
    pub(crate) apart_now: f64,
    /// Its inputs, as a recording that `simulate` takes.
    pub(crate) programme: Option<Recording>,
}

/// What an answer proposes to do next.
#[derive(Debug, Clone)]
pub(crate) struct NextExperiment {
    /// In words.
    pub(crate) says: String,
    /// What to drive the wire by, where a programme is proposed.
    pub(crate) programme: Option<Recording>,
}

impl NextExperiment {
    /// One without a programme of the drive.
    pub(crate) fn in_words(says: String) -> NextExperiment {
        NextExperiment { says, programme: None }
    }
}

/// What the file of a proposed programme is called.
pub const NEXT_PROGRAMME: &str = "next.csv";

/// What a run is driven by.
fn inputs(run: &Run, model: &WireModel) -> Result<Recording, sinew_recording::Error> {
    let mut programme = Recording::new(NEXT_PROGRAMME, run.time_s.clone())?;
    let of = |value: &dyn Fn(&Inputs) -> f64| run.inputs.iter().map(|(inputs, _)| value(inputs)).collect();
    programme.set(drive_column(model.drive.kind), of(&|i| i.drive))?;
    if let Some(imposed) = imposed_column(&model.load) {
        programme.set(imposed, of(&|i| i.imposed))?;
    }
    if model.drive.kind == DriveKind::Pwm {
        programme.set(Column::SupplyV, of(&|i| i.supply_v))?;
    }
    Ok(programme)
}

/// What is driven how.
struct Design {
    words: String,
    run: Run,
    change: Box<dyn Fn(&mut WireModel) + Sync>,
}

/// The recording that separates `a` from `b` best.
pub(crate) fn propose(data: &Data, a: &Fit, b: &Fit) -> Option<Proposal> {
    let model = a.space.model(&a.z)?;
    let apart_now = apart(data, a, b, &|_| (), true)?;
    let designs = designs(data, &model);
    let on = |design: &Design, refit: bool| {
        let mut other = data.clone();
        other.runs = vec![design.run.clone()];
        apart(&other, a, b, &*design.change, refit)
    };
    // where they differ most as they are; of those, where refitting cannot make up for it
    let mut promising: Vec<(f64, &Design)> =
        designs.par_iter().filter_map(|design| Some((on(design, false)?, design))).collect();
    promising.sort_by(|x, y| y.0.total_cmp(&x.0));
    promising.truncate(REFITTED);
    let best = promising
        .par_iter()
        .filter_map(|(_, design)| Some((on(design, true)?, design)))
        .max_by(|x, y| x.0.total_cmp(&y.0))?;
    let (apart, design) = best;
    Some(Proposal { words: design.words.clone(), apart, apart_now, programme: inputs(&design.run, &model).ok() })
}

/// RMS over noise by which `b` misses what `a` predicts, its nuisance parameters refitted or left alone.
fn apart(data: &Data, a: &Fit, b: &Fit, change: &(dyn Fn(&mut WireModel) + Sync), refit: bool) -> Option<f64> {
    let outputs = |fit: &Fit, z: &[f64]| -> Option<Vec<Vec<Vec<f64>>>> {
        let mut model = fit.space.model(z)?;
        change(&mut model);
        (0..data.runs.len()).map(|r| simulate::outputs(&model, &fit.space.run(data, r, z), &data.sensors)).collect()
    };
    let truth = outputs(a, &a.z)?;
    let difference = |there: &[Vec<Vec<f64>>]| -> Residuals {
        truth
            .iter()
            .zip(there)
            .map(|(t, o)| {
                t.iter()
                    .zip(o)
                    .zip(&data.sensors)
                    .map(|((t, o), s)| t.iter().zip(o).map(|(t, o)| ((t - o) / s.noise) as f32).collect())
                    .collect()
            })
            .collect()
    };
    let here = difference(&outputs(b, &b.z)?);
    let of_wire = |i: &usize| b.space.coordinates[*i].is_of_run().is_none();
    let own: Vec<usize> = (0..b.space.len()).filter(|i| refit && of_wire(i)).collect();
    let mut columns: Vec<Residuals> = own
        .par_iter()
        .filter_map(|i| {
            let mut z = b.z.clone();
            let c = &b.space.coordinates[*i];
            let step = if z[*i] + c.step <= c.high { c.step } else { -c.step };
            z[*i] += step;
            let there = difference(&outputs(b, &z)?);
            Some(residuals::zip(&there, &here, |there, here| (there - here) / step as f32))
        })
        .collect();
    if columns.len() != own.len() {
        return None;
    }
    // an arbitrary zero makes up for any constant difference, in every recording anew
    if refit && data.free_zero && data.position().is_some() {
        let scale = data.sensors.iter().map(|s| s.noise).fold(f64::INFINITY, f64::min);
        columns.extend((0..data.runs.len()).map(|run| derivatives::of_zero(data, scale, run, &here)));
    }
    let all = Data { runs: data.runs.iter().map(Run::everything_fitted).collect(), ..data.clone() };
    let mut information = products::gram(&all, Part::Fitted, &columns);
    // what is known of the parameters already stays known, as far as it is not of a recording's own zero
    let known = known(b, &own);
    information.view_mut((0, 0), known.shape()).zip_apply(&known, |sum, known| *sum += known);
    for i in 0..columns.len() {
        information[(i, i)] += 1e-9;
    }
    let gradient =
        DVector::from_iterator(columns.len(), columns.iter().map(|c| products::inner(&all, Part::Fitted, c, &here)));
    let step = information.clone().cholesky()?.solve(&gradient);
    let (mut sum, mut count) = (0.0, 0.0);
    for (r, by_sensor) in here.iter().enumerate() {
        for (s, values) in by_sensor.iter().enumerate() {
            for (row, value) in values.iter().enumerate() {
                if data.runs[r].measured[s][row].is_nan() {
                    continue;
                }
                let explained: f64 = columns.iter().zip(step.iter()).map(|(c, d)| f64::from(c[r][s][row]) * d).sum();
                sum += (f64::from(*value) - explained).powi(2);
                count += 1.0;
            }
        }
    }
    Some((sum / f64::max(count, 1.0)).sqrt())
}

/// The information on some coordinates of a fit, whatever the others are.
fn known(fit: &Fit, own: &[usize]) -> DMatrix<f64> {
    let others: Vec<usize> = (0..fit.space.len()).filter(|i| !own.contains(i)).collect();
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |r, c| fit.information[(rows[r], columns[c])])
    };
    let (inner, cross) = (part(own, own), part(own, &others));
    match part(&others, &others).cholesky() {
        Some(factor) if !others.is_empty() => inner - &cross * factor.solve(&cross.transpose()),
        _ => inner,
    }
}

/// Programmes that rigs can run, under every change to the rig.
fn designs(data: &Data, model: &WireModel) -> Vec<Design> {
    let Some(first) = data.runs.first() else { return Vec::new() };
    let drives = || data.runs.iter().flat_map(|run| run.inputs.iter().map(|(i, _)| i.drive));
    let most = drives().fold(f64::NEG_INFINITY, f64::max);
    let least = drives().fold(f64::INFINITY, f64::min);
    let mut designs = Vec::new();
    for Programme { words, drive } in programmes(model.drive.kind, least, most) {
        let run = recorded(data, first, &words, &*drive);
        for Change { words: extra, of_model, supply } in changes(model) {
            let mut run = run.clone();
            for (inputs, _) in &mut run.inputs {
                inputs.supply_v *= supply;
            }
            designs.push(Design { words: format!("{words}{extra}"), run, change: of_model });
        }
    }
    designs
}

/// How the drive goes over time.
struct Programme {
    words: String,
    /// From the time, s, to the drive, in its unit.
    drive: Box<dyn Fn(f64) -> f64>,
}

impl Programme {
    fn new(words: String, drive: impl Fn(f64) -> f64 + 'static) -> Programme {
        Programme { words, drive: Box::new(drive) }
    }
}

/// What ties are broken by: programmes between the least and the most that was driven.
fn programmes(kind: DriveKind, least: f64, most: f64) -> Vec<Programme> {
    let unit = match kind {
        DriveKind::Pwm | DriveKind::Amplifier(_) => "duty",
        DriveKind::Power => "W",
        DriveKind::Current => "A",
        DriveKind::Temperature => "°C",
    };
    let wave = |period_s: f64, share: f64, low: f64| {
        move |t: f64| low + share * (1.0 - (2.0 * (t / period_s).fract() - 1.0).abs())
    };
    let span = most - least;
    let says = |low: f64, high: f64| format!("between {low:.3} and {high:.3} {unit}");
    let mut programmes = vec![
        Programme::new(
            format!("slow triangular ramps of the drive, 20 s each way, {}", says(least, most)),
            wave(40.0, span, least),
        ),
        Programme::new(
            format!("triangular ramps of the drive, 5 s each way, {}", says(least, most)),
            wave(10.0, span, least),
        ),
        Programme::new(
            format!(
                "partial loops: ramps of 4 s each way, {}, after one full heating",
                says(least + 0.35 * span, least + 0.8 * span)
            ),
            {
                let inner = wave(8.0, 0.45 * span, least + 0.35 * span);
                move |t| if t < 4.0 { most } else { inner(t) }
            },
        ),
        Programme::new(format!("stairs, 6 s a step, {}", says(least, most)), move |t| {
            least + span * [0.2, 0.5, 0.8, 1.0, 0.6, 0.3, 0.0, 0.4, 0.9, 0.1][(t / 6.0) as usize % 10]
        }),
        Programme::new(
            format!("the same stairs at two speeds, 6 s and 1.5 s a step, {}", says(least, most)),
            move |t| {
                let place = if t < 30.0 { t / 6.0 } else { 5.0 + (t - 30.0) / 1.5 };
                least + span * [0.3, 0.7, 1.0, 0.5, 0.0][place as usize % 5]
            },
        ),
        Programme::new(
            format!("short full heating and long cooling, 2 s at {most:.3} and 13 s at {least:.3} {unit}"),
            move |t| if t % 15.0 < 2.0 { most } else { least },
        ),
    ];
    if kind == DriveKind::Temperature {
        // a furnace is slow: ramps only
        programmes.truncate(3);
    }
    programmes
}

/// The recording that a programme would give: the sensors there are, under the conditions of `first`.
fn recorded(data: &Data, first: &Run, name: &str, drive: &dyn Fn(f64) -> f64) -> Run {
    let usual = first.inputs[0].0;
    let imposed: Vec<f64> = first.inputs.iter().map(|(i, _)| i.imposed).collect();
    let interval_s = 1.0 / RATE_HZ;
    let count = (LENGTH_S * RATE_HZ) as usize;
    let time_s: Vec<f64> = (0..count).map(|i| i as f64 * interval_s).collect();
    let inputs = time_s
        .iter()
        .enumerate()
        .map(|(row, t)| (Inputs { drive: drive(*t), imposed: imposed[row % imposed.len()], ..usual }, interval_s))
        .collect();
    let measured = (0..data.sensors.len())
        .map(|s| {
            let there = data.runs.iter().any(|run| run.measured[s].iter().any(|v| !v.is_nan()));
            vec![if there { 0.0 } else { f64::NAN }; count]
        })
        .collect();
    Run {
        name: name.to_string(),
        measured,
        part: vec![Part::Fitted; count],
        block: vec![0; count],
        held_out: false,
        longest_pieces_s: vec![first.longest_pieces_s.iter().copied().fold(0.0, f64::max); count],
        early: Vec::new(),
        samples: Vec::new(),
        lacking: Vec::new(),
        around: Vec::new(),
        ambient_of_model: true,
        supply_of_model: false,
        inputs,
        time_s,
    }
}

/// What is changed on the rig.
struct Change {
    words: String,
    of_model: Box<dyn Fn(&mut WireModel) + Sync>,
    /// Factor on the supply voltage.
    supply: f64,
}

/// The rig as it is, with another load, with another supply.
fn changes(model: &WireModel) -> Vec<Change> {
    let mut changes: Vec<Change> = vec![Change { words: String::new(), of_model: Box::new(|_| ()), supply: 1.0 }];
    if let Load::SpringMassDamper { spring_n_per_m, .. } = model.load {
        for (factor, word) in [(1.5, "half more load"), (0.6, "0.6 of the load")] {
            let text = if spring_n_per_m > 0.0 { "preload" } else { "weight" };
            changes.push(Change {
                words: format!(", with {word} ({text} × {factor})"),
                of_model: Box::new(move |m| {
                    if let Load::SpringMassDamper { mass_kg, preload_n, spring_n_per_m, .. } = &mut m.load {
                        *preload_n *= factor;
                        if *spring_n_per_m == 0.0 {
                            *mass_kg *= factor;
                        }
                    }
                }),
                supply: 1.0,
            });
        }
    }
    if model.drive.kind == DriveKind::Pwm {
        let words = ", at 0.8 of the supply voltage".into();
        changes.push(Change { words, of_model: Box::new(|_| ()), supply: 0.8 });
    }
    changes
}
