//! Parquet, where this program was compiled with it.

use std::path::Path;

use sinew_exchange::Table;

use crate::failure::Failure;

/// Writes these channels of a table, all where none is named; how many rows there are.
#[cfg(feature = "formats")]
pub fn parquet(table: &dyn Table, channels: &[usize], path: &Path) -> Result<u64, Failure> {
    sinew_exchange::parquet(table, channels, path).map_err(super::simulate::recording_failure)
}

/// Refuses to.
#[cfg(not(feature = "formats"))]
pub fn parquet(_: &dyn Table, _: &[usize], path: &Path) -> Result<u64, Failure> {
    Err(Failure::left_out(format_args!("{}: Parquet", path.display()), "formats"))
}
