//! Errors of the crates as exceptions: `sinew._errors` has the classes, each with the message and the remedy apart.

use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What the command line's options are called here.
const IN_PYTHON: [(&str, &str); 3] =
    [("--ignore-columns", "ignore_columns=True"), ("--thorough", "thorough=True"), ("--holdout", "holdout=")];

/// An exception of the class of this name, made of message and remedy.
pub fn failure(class: &str, message: &str, remedy: &str) -> PyErr {
    Python::attach(|py| with(py, class, message, remedy, None).unwrap_or_else(|broken| broken))
}

/// The same with further attributes.
pub fn with(
    py: Python<'_>,
    class: &str,
    message: &str,
    remedy: &str,
    more: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyErr> {
    let remedy = IN_PYTHON.iter().fold(remedy.to_string(), |said, (option, argument)| said.replace(option, argument));
    let made = py.import("sinew._errors")?.getattr(class)?.call((message, remedy), more)?;
    Ok(PyErr::from_value(made))
}

/// What the caller gave and cannot be used.
pub fn bad_input(message: &str, remedy: &str) -> PyErr {
    failure("BadInput", message, remedy)
}

/// A recording's mistake, with its place.
pub fn of_recording(error: &sinew_recording::Error) -> PyErr {
    match error.is_bad_input() {
        true => bad_input(&error.message(), &error.hint()),
        false => failure("SinewError", &error.message(), &error.hint()),
    }
}

/// A rig file's mistakes, every one on its line.
pub fn of_rig(error: &sinew_rig::Error) -> PyErr {
    let remedy = match error {
        sinew_rig::Error::Unreadable { .. } => "check the path; the text of a rig file may be given in its place",
        sinew_rig::Error::Invalid { .. } => "docs/rig.md has every key with its range and default",
    };
    bad_input(&error.to_string(), remedy)
}

/// Why there is no answer.
pub fn of_diagnosis(error: &sinew_diagnosis::Error) -> PyErr {
    match error {
        sinew_diagnosis::Error::Rig(error) => of_rig(error),
        _ if error.is_bad_input() => bad_input(&error.message(), &error.hint()),
        _ => failure("SinewError", &error.message(), &error.hint()),
    }
}
