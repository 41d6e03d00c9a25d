//! The arguments of `export`, `import` and `replay`.

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
  sinew import tensile.csv --rig bench.toml -o tensile.mcap
  sinew import tensile.csv --rig bench.toml -o tensile.csv      the same in the contract's names and units
  sinew import tensile.csv --rig bench.toml -o tensile.parquet

Foreign names and units are mapped by the rig file:
  [recording.columns]
  time_s = { column = \"t_ms\", scale = 0.001 }
  position_m = { column = \"Pos\", scale = -0.001, offset = 0.0 }")]
pub struct Import {
    /// The foreign recording: .csv or .csv.gz.
    #[arg(value_name = "FOREIGN.csv")]
    pub foreign: PathBuf,
    /// The rig file: the wire it was recorded on, and its columns.
    #[arg(long, value_name = "RIG.toml")]
    pub rig: PathBuf,
    /// Where to write: .mcap, .csv, .csv.gz or .parquet.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Which channel of the rig file, where it has several.
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// Pass over columns that are no recording's instead of refusing them.
    #[arg(long)]
    pub ignore_columns: bool,
}

/// `sinew replay`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew replay walk.mcap                                    does this version decide as the one did that recorded?
  sinew replay walk.mcap --set control.algorithm=pid        what would another law have decided?
  sinew replay walk.mcap --set front_left_femur:limits.maximum_duty=0.3 --json
  sinew replay walk.mcap fitted.toml -o again.mcap          with another rig file, written down to be plotted
  sinew replay walk.mcap --expect-identical                 exit 1 where a single bit differs

The driver's own cycle runs again over the voltages of then, with the same beats and requests; what comes out otherwise is
listed. The recorded wire does not answer: how it would have moved under another duty only a simulation can say. Bit for
bit the same is to be expected of a recording that begins with the driver (docs/replay.md).")]
pub struct Replay {
    /// The recording of a driver.
    #[arg(value_name = "RECORDING.mcap")]
    pub recording: PathBuf,
    /// Another rig file; without one, that of the recording.
    #[arg(value_name = "RIG.toml")]
    pub rig: Option<PathBuf>,
    /// Change the rig file for this replay: TABLE.KEY=VALUE for every channel, CHANNEL:TABLE.KEY=VALUE for one.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
    /// Write what comes out now as a session.
    #[arg(short, long, value_name = "NEW.mcap")]
    pub output: Option<PathBuf>,
    /// What differs, as JSON on stdout ("sinew.replay/1").
    #[arg(long)]
    pub json: bool,
    /// Exit 1 unless everything is bit for bit the same.
    #[arg(long)]
    pub expect_identical: bool,
}

/// A moment of a recording, in s.
fn moment(text: &str) -> Result<f64, String> {
    match text.trim_end_matches('s').parse::<f64>() {
        Ok(moment_s) if moment_s.is_finite() => Ok(moment_s),
        _ => Err("give the time in seconds as a number, as in 2.5".into()),
    }
}
