//! The analysis as functions: what `sinew simulate`, `identify` and `diagnose` do, on columns in memory or on files.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sinew_diagnosis::{MOST_SAMPLES, Settings};
use sinew_recording::{Options, Recording, SimulatedColumns, TIME, Utc};
use sinew_report::About;
use sinew_rig::Rig;

use crate::columns::{Column, Recorded, RigFile, bytes, channel, columns_of, options};
use crate::failure::{bad_input, failure, of_diagnosis, of_recording};
use crate::patience;

/// A simulation tells its progress once in so many rows.
const TELL_ROWS: usize = 4096;

/// What the model does under a recording's inputs: the columns of `sinew simulate`, each in its unit.
#[pyfunction]
#[pyo3(signature = (rig, inputs, channel_name=None, ignore_columns=false, catalogue=None, progress=None))]
pub fn simulate<'py>(
    py: Python<'py>,
    rig: RigFile,
    inputs: Recorded,
    channel_name: Option<&str>,
    ignore_columns: bool,
    catalogue: Option<RigFile>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Vec<Column<'py>>> {
    let rig = rig.read(catalogue.as_ref())?;
    let wire = &rig.channels[channel(&rig, channel_name)?];
    let recording = inputs.read(&options(&rig, wire, ignore_columns, sinew_recording::MAX_ROWS))?;
    let columns = SimulatedColumns::of(&recording, &wire.model);
    let names = columns.names();
    let filled = patience::wait(py, progress, |tell| -> Result<Vec<Vec<f64>>, sinew_recording::Error> {
        let mut filled = vec![Vec::with_capacity(recording.len()); names.len()];
        for (row, simulated) in recording.simulated(&wire.model)?.enumerate() {
            if row % TELL_ROWS == 0 {
                tell("simulating", row as f64 / recording.len() as f64);
            }
            let (inputs, outputs) = simulated?;
            for (column, value) in filled.iter_mut().zip(columns.values(&inputs, &outputs)) {
                column.push(value);
            }
        }
        Ok(filled)
    })?;
    let filled = filled.map_err(|error| of_recording(&error))?;
    let time = std::iter::once((TIME.to_string(), bytes(py, recording.time_s())));
    let simulated = names.iter().zip(&filled).map(|(name, values)| (name.to_string(), bytes(py, values)));
    Ok(time.chain(simulated).collect())
}

/// The parameters that fit best: what was fitted, as JSON, and the rig file with them.
#[pyfunction]
#[pyo3(signature = (rig, recordings, channel_name=None, ignore_columns=false, catalogue=None, seed=1, jobs=0, progress=None))]
#[allow(clippy::too_many_arguments)] // they are named where they are given
pub fn identify<'py>(
    py: Python<'py>,
    rig: RigFile,
    recordings: Vec<Recorded>,
    channel_name: Option<&str>,
    ignore_columns: bool,
    catalogue: Option<RigFile>,
    seed: u64,
    jobs: usize,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = rig.read(catalogue.as_ref())?;
    let wire = channel(&rig, channel_name)?;
    let (recordings, _) = read_all(&rig, wire, &recordings, &[], ignore_columns)?;
    let identified = patience::wait(py, progress, |tell| {
        let settings = Settings { seed, jobs, thorough: false, progress: tell };
        sinew_diagnosis::identify(&rig, wire, &recordings, None, &settings)
    })?
    .map_err(|error| of_diagnosis(&error))?;
    let json = serde_json::json!({
        "rig": rig.name,
        "channel": rig.channels[wire].name,
        "recordings": recordings.iter().map(Recording::name).collect::<Vec<_>>(),
        "seed": seed,
        "noise": identified.noise,
        "fit": identified.fit,
        "parameters": identified.parameters,
        "warnings": identified.warnings,
    });
    let answer = PyDict::new(py);
    answer.set_item("json", json.to_string())?;
    answer.set_item("rig_toml", identified.rig.to_toml())?;
    Ok(answer)
}

/// Where the model and the recordings differ, and what physics is missing: `diagnosis.json`, the report, the picture, the rig file
/// with what was found, and the programme that would tell more, if one would.
#[pyfunction]
#[pyo3(signature = (rig, recordings, holdout, channel_name=None, ignore_columns=false, catalogue=None, seed=1, jobs=0, thorough=false, command="", progress=None))]
#[allow(clippy::too_many_arguments)] // they are named where they are given
pub fn diagnose<'py>(
    py: Python<'py>,
    rig: RigFile,
    recordings: Vec<Recorded>,
    holdout: Vec<Recorded>,
    channel_name: Option<&str>,
    ignore_columns: bool,
    catalogue: Option<RigFile>,
    seed: u64,
    jobs: usize,
    thorough: bool,
    command: &str,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = rig.read(catalogue.as_ref())?;
    let wire = channel(&rig, channel_name)?;
    let (recordings, held_out) = read_all(&rig, wire, &recordings, &holdout, ignore_columns)?;
    let outcome = patience::wait(py, progress, |tell| {
        let settings = Settings { seed, jobs, thorough, progress: tell };
        sinew_diagnosis::diagnose(&rig, wire, &recordings, &held_out, &settings)
    })?
    .map_err(|error| of_diagnosis(&error))?;
    let about = About {
        rig: rig.name.clone(),
        channel: rig.channels[wire].name.clone(),
        command: command.to_string(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        date: Utc::now().to_string(),
        files: Vec::new(),
    };
    let json = serde_json::to_string(&outcome.diagnosis)
        .map_err(|error| failure("SinewError", &format!("the answer cannot be written as JSON: {error}"), ""))?;
    let answer = PyDict::new(py);
    answer.set_item("json", json)?;
    answer.set_item("report_html", sinew_report::html(&outcome.diagnosis, &outcome.figures, &about))?;
    answer.set_item("picture_svg", sinew_report::picture(&outcome.diagnosis, &outcome.figures))?;
    answer.set_item("rig_toml", outcome.improved.to_toml())?;
    answer.set_item("next_programme", outcome.next_programme.as_ref().map(|next| columns_of(py, next)))?;
    Ok(answer)
}

/// Reads what is fitted and what is only judged by; refuses one and the same recording twice: it would count double, or judge
/// itself.
fn read_all(
    rig: &Rig,
    wire: usize,
    fitted: &[Recorded],
    held_out: &[Recorded],
    ignore_columns: bool,
) -> PyResult<(Vec<Recording>, Vec<Recording>)> {
    let options: Options<'_> = options(rig, &rig.channels[wire], ignore_columns, MOST_SAMPLES);
    let mut all: Vec<Recording> = Vec::new();
    for recorded in fitted.iter().chain(held_out) {
        let recording = recorded.read(&options)?;
        if let Some(twin) = all.iter().find(|other| other.has_the_samples_of(&recording)) {
            let message = format!("{} is the same recording as {}", recording.name(), twin.name());
            return Err(bad_input(
                &message,
                "give every recording once; without holdout=, blocks of each are kept back",
            ));
        }
        all.push(recording);
    }
    let held_out = all.split_off(fitted.len());
    Ok((all, held_out))
}
