//! The arguments of `record`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sinew_recording::session::Compression;

use super::Target;
use crate::args::numbers::seconds;

/// `sinew record`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew record walk.mcap --for 60
  sinew record night.mcap --max-size 1GB --max-time 10min      night.mcap, night-0001.mcap, night-0002.mcap, …
  sinew record night.mcap --max-time 1h --keep-files 24        the last 24 hours
  sinew record night.mcap --keep-size 20GB --keep-free 2GB     the last 20 GB; ends before less than 2 GB are free
  sinew record walk.mcap --for 10 --json | jq '.cycles, .lost'

Every cycle of every channel of a running driver, with the rig file, the loop's own figures, faults and gaps: MCAP, which
Foxglove, PlotJuggler and Python open as well (docs/recording-sessions.md). Ctrl-C, SIGTERM and the end of the driver
complete the file. Exit 3 when cycles were lost: the summary and the file say how many and which. Exit 1 when it ended
because the disk is full or less was free than --keep-free; a warning comes at twice that, with the time it lasts.")]
pub struct Record {
    /// Where to write.
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    /// Stop after so many seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
    /// How to compress: lz4 is fast, zstd smaller.
    #[arg(long, value_name = "HOW", default_value = "lz4")]
    pub compression: Packing,
    /// Begin a new file before the present one is larger than this: 500MB, 1GB.
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub max_size: Option<u64>,
    /// Begin a new file when the present one is so long: 30s, 10min, 2h.
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub max_time: Option<f64>,
    /// Keep so many files, the one being written among them, and remove the oldest of this recording.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    pub keep_files: Option<u32>,
    /// Keep so many bytes in all files together, likewise: 20GB. Without --max-size a file is an eighth of it.
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub keep_size: Option<u64>,
    /// End before less than this is free on the disk; 0 = when it is full.
    #[arg(long, value_name = "SIZE", default_value = "256MB", value_parser = size_or_none)]
    pub keep_free: u64,
    /// Replace a file that is there.
    #[arg(long)]
    pub force: bool,
    /// The summary as JSON on stdout ("sinew.record/1").
    #[arg(long)]
    pub json: bool,
}

/// Names of compressions on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Packing {
    /// Fast.
    Lz4,
    /// Smaller.
    Zstd,
    /// Not at all.
    None,
}

impl From<Packing> for Compression {
    fn from(packing: Packing) -> Compression {
        match packing {
            Packing::Lz4 => Compression::Lz4,
            Packing::Zstd => Compression::Zstd,
            Packing::None => Compression::None,
        }
    }
}

/// A size with its unit, in bytes.
fn size(text: &str) -> Result<u64, String> {
    let units = [("GB", 1e9), ("MB", 1e6), ("kB", 1e3), ("GiB", 1073741824.0), ("MiB", 1048576.0)];
    let bytes = with_unit(text, &units).ok_or("expected a size such as 500MB or 1GB")?;
    if bytes < 1e6 { Err("expected at least 1MB".into()) } else { Ok(bytes as u64) }
}

/// A size, or none of it.
fn size_or_none(text: &str) -> Result<u64, String> {
    if text == "0" { Ok(0) } else { size(text).map_err(|error| format!("{error}, or 0")) }
}

/// A time with its unit, in seconds.
fn time(text: &str) -> Result<f64, String> {
    let units = [("min", 60.0), ("s", 1.0), ("h", 3600.0)];
    let seconds = with_unit(text, &units).ok_or("expected a time such as 30s, 10min or 2h")?;
    if seconds < 1.0 { Err("expected at least 1s".into()) } else { Ok(seconds) }
}

fn with_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let (number, factor) = units.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)))?;
    let value = number.trim().parse::<f64>().ok()? * factor;
    (value.is_finite() && value < 1e18).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_times_carry_their_units() {
        assert_eq!(size("1GB"), Ok(1_000_000_000));
        assert_eq!(size("1.5 MiB"), Ok(1_572_864));
        assert_eq!((size_or_none("0"), size_or_none("256MB")), (Ok(0), Ok(sinew_recorder::Options::KEEP_FREE_BYTES)));
        assert!(size_or_none("-1").is_err() && size_or_none("100").is_err());
        assert_eq!(time("10min"), Ok(600.0));
        assert_eq!(time("90s"), Ok(90.0));
        for bad in ["", "5", "1TBB", "nanMB", "-3GB", "infGB", "20kB"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        for bad in ["", "7", "0.5s", "-1min", "nans", "1e300h"] {
            assert!(time(bad).is_err(), "{bad}");
        }
    }
}
