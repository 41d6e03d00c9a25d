//! The compiled half of the Python package `sinew`: what its pure half (`python/sinew`) puts into the hands of a user.
//!
//! | module | |
//! |---|---|
//! | [`clocks`] | clocks beside the driver's |
//! | [`driver`] | the client of a running driver (Linux) |
//! | [`analysis`] | simulate, identify, diagnose: with the interpreter's lock released, progress told and Ctrl-C obeyed |
//! | [`recordings`] | sessions and recordings as columns |
//! | [`columns`] | columns of numbers on their way between the two halves: bytes of little-endian `f64`, copied once |
//! | [`failure`] | errors as the exceptions of `sinew._errors` |
//!
//! Nothing here knows NumPy: the stable interface of Python (abi3) has no arrays, and bytes are what both sides understand.

mod analysis;
mod clocks;
mod columns;
#[cfg(target_os = "linux")]
mod driver;
mod failure;
mod patience;
mod recordings;

/// `sinew._sinew`.
#[pyo3::pymodule]
mod _sinew {
    #[pymodule_export]
    use super::analysis::{diagnose, identify, simulate};
    #[pymodule_export]
    use super::clocks::ClockMap;
    #[cfg(target_os = "linux")]
    #[pymodule_export]
    use super::clocks::Clocks;
    #[cfg(target_os = "linux")]
    #[pymodule_export]
    use super::driver::{Client, Stream, discover, fault_table, fields, modes};
    #[pymodule_export]
    use super::recordings::{read_recording, read_session};

    /// Version of the package.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
