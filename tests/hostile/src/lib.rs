//! What comes from outside and is not what it should be: files, frames off a line, requests, visitors; and what every reader of this project
//! has to do with it.
//!
//! One function a format takes any bytes at all, lets the reader have them and holds it to its promises: no panic, an
//! error that names the file and has a remedy, and what was accepted is consistent and survives being written and read
//! again. What acts on what it reads, a front-end's firmware and the loop under the requests of its clients, is held to what keeps
//! a wire whole: no output beyond its limits, none without a driver. The fuzzer (`fuzz/`) looks for bytes that break one; [`damaged`] makes damaged files from
//! good ones, a few thousand on every run of the tests.
//!
//! ```
//! use sinew_hostile::{Format, damaged};
//!
//! damaged(Format::Rig, 1, 20); // twenty damaged rig files: panics where the reader breaks a promise
//! ```
#![forbid(unsafe_code)]

mod command;
mod damaged;
mod frames;
mod gate;
mod mcap;
mod mutate;
mod scan;
mod script;
pub mod seed;

use std::sync::LazyLock;

use sinew_recording::{Options, Recording, read_from, write_to};
use sinew_rig::Rig;

pub use command::command;
pub use damaged::{Format, damaged};
pub use frames::{firmware, line};
pub use gate::{gate, visit};
pub use mcap::mcap;
pub use mutate::Mutator;
pub use scan::scan;

/// What messages call the bytes.
const NAME: &str = "hostile";
/// A fuzzer's file is small; with a limit of its own the limit is met.
const MOST_ROWS: usize = 1000;
/// The wire that recordings are read for.
static HEXAPOD: LazyLock<Rig> = LazyLock::new(Rig::hexapod);

/// Bytes for the reader of CSV: the first is a set of options, the rest the file.
///
/// # Panics
/// Where the reader breaks a promise.
pub fn csv(bytes: &[u8]) {
    let Some((&choice, text)) = bytes.split_first() else { return };
    let model = (choice & 1 != 0).then_some(&HEXAPOD.channels[0].model);
    let options = Options { ignore_columns: choice & 2 != 0, model, max_rows: MOST_ROWS, ..Options::default() };
    match read_from(text, NAME, &options) {
        Ok(recording) => {
            consistent(&recording);
            if let Some(model) = model {
                let inputs = recording.inputs_for(model).unwrap_or_else(|e| panic!("accepted with its model: {e}"));
                assert!(inputs.take(MOST_ROWS).all(|(_, dt_s)| dt_s > 0.0));
            }
            let mut written = Vec::new();
            write_to(&mut written, &recording).unwrap_or_else(|e| panic!("{e}"));
            let again = read_from(&written[..], NAME, &Options::default()).unwrap_or_else(|e| panic!("rewritten: {e}"));
            assert_eq!(bits(&again), bits(&recording), "what was written is not what was read");
        }
        Err(error) => {
            assert!(error.to_string().starts_with(NAME) && !error.hint().is_empty(), "{error:?}");
            assert!(error.is_bad_input(), "{error:?}");
        }
    }
}

/// Text for the reader of rig files.
///
/// # Panics
/// Where the reader breaks a promise.
pub fn rig(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Rig::parse(text, NAME) {
        Ok(rig) => {
            assert!(rig.rate_hz.is_finite() && rig.rate_hz > 0.0 && !rig.channels.is_empty());
            let _ = rig.check_drivable();
            let again = Rig::parse(&rig.to_toml(), NAME).unwrap_or_else(|e| panic!("rewritten: {e}"));
            assert_eq!(again.channels.len(), rig.channels.len());
            assert_eq!(again.name, rig.name);
        }
        Err(error) => {
            assert!(!error.problems().is_empty(), "{error:?}");
            for problem in error.problems() {
                assert!(problem.file == NAME && problem.line >= 1, "{problem:?}");
                // an editor shows a line behind the last newline, too
                assert!(problem.line <= 1 + text.matches('\n').count(), "{problem:?} is below the end of the file");
            }
            assert!(!error.to_string().is_empty());
        }
    }
}

/// What holds of every recording, wherever it came from.
fn consistent(recording: &Recording) {
    let times = recording.time_s();
    assert!(recording.len() >= sinew_recording::MIN_SAMPLES);
    assert!(times.iter().all(|t| t.is_finite()) && times.windows(2).all(|pair| pair[0] < pair[1]));
    for (column, values) in recording.columns() {
        assert_eq!(values.len(), times.len(), "{}", column.name());
        assert!(values.iter().all(|v| !v.is_infinite()), "{}", column.name());
    }
}

/// Every number of a recording by its bits, one missing sample like the other.
fn bits(recording: &Recording) -> Vec<u64> {
    let bits = |v: &f64| if v.is_nan() { f64::NAN.to_bits() } else { v.to_bits() };
    let columns = recording.columns().flat_map(|(_, values)| values);
    recording.time_s().iter().chain(columns).map(bits).collect()
}
