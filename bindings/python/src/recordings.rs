//! Recordings as columns: of one channel for the analysis, and whole sessions of a driver.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use sinew_recording::session::{Kind, Session};
use std::path::PathBuf;

use crate::columns::{Column, Recorded, RigFile, channel, columns_of, options};
use crate::failure::of_recording;

/// The columns of a recording of one channel, as `simulate`, `identify` and `diagnose` understand it.
#[pyfunction]
#[pyo3(signature = (recording, rig=None, channel_name=None, ignore_columns=false))]
pub fn read_recording<'py>(
    py: Python<'py>,
    recording: Recorded,
    rig: Option<RigFile>,
    channel_name: Option<&str>,
    ignore_columns: bool,
) -> PyResult<Vec<Column<'py>>> {
    let max_rows = sinew_recording::MAX_ROWS;
    let read = match rig {
        Some(rig) => {
            let rig = rig.read(None)?;
            let wire = &rig.channels[channel(&rig, channel_name)?];
            recording.read(&options(&rig, wire, ignore_columns, max_rows))?
        }
        None => recording.read(&sinew_recording::Options {
            ignore_columns,
            channel: channel_name,
            ..sinew_recording::Options::default()
        })?,
    };
    Ok(columns_of(py, &read))
}

/// A session of a driver: what it says of itself, the heads of its cycles (number, time and missed periods as 8 bytes each), and
/// its cycles as they lie in the file, from `from_s` to `to_s` after the first.
#[pyfunction]
#[pyo3(signature = (path, from_s=f64::NEG_INFINITY, to_s=f64::INFINITY))]
pub fn read_session<'py>(py: Python<'py>, path: PathBuf, from_s: f64, to_s: f64) -> PyResult<Bound<'py, PyDict>> {
    let (session, heads, cycles) = py
        .detach(|| -> Result<_, sinew_recording::Error> {
            let session = Session::open(&path)?;
            let (mut heads, mut bytes) = (Vec::new(), Vec::new());
            let mut cycles = session.cycles_between(from_s, to_s);
            while let Some(cycle) = cycles.next()? {
                for number in [cycle.head.cycle, cycle.head.monotonic_ns, cycle.head.missed] {
                    heads.extend_from_slice(&number.to_le_bytes());
                }
                bytes.extend_from_slice(cycle.bytes());
            }
            drop(cycles);
            Ok((session, heads, bytes))
        })
        .map_err(|error| of_recording(&error))?;
    let (about, layout, ending) = (session.about(), session.layout(), session.ending());
    let fields: Vec<(&str, &str, &str)> = layout
        .fields
        .iter()
        .map(|field| (field.name.as_str(), field.unit.as_str(), if field.kind == Kind::F64 { "<f8" } else { "<u4" }))
        .collect();
    let answer = PyDict::new(py);
    answer.set_item("rig", &about.rig)?;
    answer.set_item("simulated", about.simulated)?;
    answer.set_item("rate_hz", about.rate_hz)?;
    answer.set_item("started_unix_ns", about.started_unix_ns)?;
    answer.set_item("started_monotonic_ns", about.started_monotonic_ns)?;
    answer.set_item("software", &about.software)?;
    answer.set_item("rig_toml", about.rig_toml.as_deref())?;
    answer.set_item("channels", &layout.channels)?;
    answer.set_item("fields", fields)?;
    answer.set_item("lost", ending.map(|ending| ending.lost))?;
    answer.set_item("heads", PyBytes::new(py, &heads))?;
    answer.set_item("cycles", PyBytes::new(py, &cycles))?;
    Ok(answer)
}
