//! The arguments of `export` and `import`.

use std::path::PathBuf;

use clap::Args;

/// `sinew export`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew export walk.mcap -o walk.parquet                        every field of every channel, one file
  sinew export walk.mcap -o femur.csv --channel front_left_femur
  sinew export walk.mcap -o walk.csv.gz                         walk-front_left_coxa.csv.gz and so on, one a channel
  sinew export walk.mcap -o step.parquet --from 6 --to 12

CSV has the columns every lab can use (docs/recordings.md): what drove the wire and what was measured on it. Parquet has
all that was recorded, a column CHANNEL.FIELD each, for pandas, polars and DuckDB. Times count from the start of the
recording.")]
pub struct Export {
    /// The recording: .mcap, .csv or .csv.gz.
    #[arg(value_name = "RECORDING")]
    pub recording: PathBuf,
    /// Where to write: .csv, .csv.gz or .parquet.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Only this channel; again for more.
    #[arg(long = "channel", value_name = "NAME")]
    pub channels: Vec<String>,
    /// From this time, s.
    #[arg(long = "from", value_name = "SECONDS", value_parser = moment, allow_negative_numbers = true)]
    pub from_s: Option<f64>,
    /// Up to this time, s.
    #[arg(long = "to", value_name = "SECONDS", value_parser = moment, allow_negative_numbers = true)]
    pub to_s: Option<f64>,
}

/// `sinew import`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew import --guess messung.csv --rig bench.toml                what is in it? a table to confirm
  sinew import --guess messung.csv --rig bench.toml -o map.toml    and the mapping that comes of it
  sinew import messung.csv --map map.toml --rig bench.toml -o messung.mcap
  sinew import --guess walk.mat --rate 100                         rows without times, 100 a second
  sinew import tensile.csv --rig bench.toml -o tensile.csv         by the mapping in the rig file
  sinew import daq.csv --rig bench.toml --clock pairs.csv -o daq.mcap
                                                                   on the driver's time, by moments on both clocks

Reads text of any encoding with any separator and decimal sign, .xlsx, .xls, .ods, MATLAB's .mat, HDF5, LabVIEW's .lvm and \
.tdms. Signs, zeros and units are held against heat, Ohm's law and the rig file; what they speak against is said and proposed in \
the mapping: look at every line that begins with ? before you use it (docs/import.md).

A mapping is part of a rig file, or a file of its own:
  [recording.columns]
  time_s = { column = \"t_ms\", scale = 0.001 }
  position_m = { column = \"Pos\", scale = 0.001 }       # mm; longer is positive, 0 is the length L_0
A position that counts shortening has scale = -0.001, and then its zero is hardly L_0: set [channel.sensors] position_zero = \
\"free\" in the rig file too, or the fit makes up for it with the wire's properties.")]
pub struct Import {
    /// The foreign recording.
    #[arg(value_name = "FOREIGN")]
    pub foreign: PathBuf,
    /// Say what is in the file and how it was understood; with -o, write the mapping.
    #[arg(long)]
    pub guess: bool,
    /// The rig file: the wire it was recorded on, and the columns where no mapping is given. Guesses are held against it.
    #[arg(long, value_name = "RIG.toml", required_unless_present = "guess")]
    pub rig: Option<PathBuf>,
    /// The mapping that --guess wrote, instead of the rig file's.
    #[arg(long, value_name = "MAP.toml", conflicts_with = "guess")]
    pub map: Option<PathBuf>,
    /// Where to write: .mcap, .csv, .csv.gz or .parquet; with --guess the mapping, .toml.
    #[arg(short, long, value_name = "OUT", required_unless_present = "guess")]
    pub output: Option<PathBuf>,
    /// Which channel of the rig file, where it has several.
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// Put it on the driver's time: a file with the columns driver_s, other_s and, at will, error_s, both clocks' times of the
    /// same moments, s.
    #[arg(long, value_name = "PAIRS.csv", conflicts_with = "guess")]
    pub clock: Option<PathBuf>,
    /// With --guess: rows a second, where the file has no times.
    #[arg(long, value_name = "HZ", requires = "guess", value_parser = rate)]
    pub rate: Option<f64>,
    /// With --guess: this sheet of a spreadsheet, or group of a TDMS file.
    #[arg(long, value_name = "NAME", requires = "guess")]
    pub sheet: Option<String>,
    /// Pass over columns that are no recording's instead of refusing them. With --map they always are.
    #[arg(long, conflicts_with = "guess")]
    pub ignore_columns: bool,
}

/// A moment of a recording, in s.
fn moment(text: &str) -> Result<f64, String> {
    match text.trim_end_matches('s').parse::<f64>() {
        Ok(moment_s) if moment_s.is_finite() => Ok(moment_s),
        _ => Err("give the time in seconds as a number, as in 2.5".into()),
    }
}

/// A rate, in Hz.
fn rate(text: &str) -> Result<f64, String> {
    match text.trim_end_matches("Hz").trim().parse::<f64>() {
        Ok(rate_hz) if (1e-6..=1e9).contains(&rate_hz) => Ok(rate_hz),
        _ => Err("give the rows a second as a number from 0.000001 to 1000000000, as in 100".into()),
    }
}
