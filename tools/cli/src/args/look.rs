//! The arguments of `plot`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `sinew plot`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew plot walk.mcap -o walk.svg                       the usual quantities of the first channels over time
  sinew plot walk.mcap -o walk.html --channel front_left_femur --kind all
  sinew plot before.mcap after.mcap -o both.png --channel front_left_femur --quantity length --from 2 --to 6
  sinew plot furnace.csv.gz -o loop.png --kind hysteresis
  sinew plot walk.mcap -o phase.svg --kind phase --channel front_left_femur

Recordings are sessions (MCAP) and CSV files with the contract's columns; several are drawn over one another. The file's
ending says what it becomes: .svg, .png, or .html, a page to zoom into that needs no network.
Times are seconds from the start of each recording.")]
pub struct Plot {
    /// Recordings.
    #[arg(required = true, value_name = "RECORDING")]
    pub recordings: Vec<PathBuf>,
    /// Where the figure goes.
    #[arg(short, long, value_name = "FIGURE")]
    pub output: PathBuf,
    /// What kinds of figure; `all` takes whatever the recordings have.
    #[arg(long, value_name = "KIND", value_enum, default_value = "time")]
    pub kind: Vec<PlotKind>,
    /// Only these channels; otherwise the first six.
    #[arg(long, value_name = "NAME")]
    pub channel: Vec<String>,
    /// Only these quantities over time, with or without their unit.
    #[arg(long, value_name = "NAME")]
    pub quantity: Vec<String>,
    /// From this time, s.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// To this time, s.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Title; otherwise the recordings' names.
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Pass over columns of CSV that the contract does not know.
    #[arg(long)]
    pub ignore_columns: bool,
}

/// Kinds of figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlotKind {
    /// Quantities over time.
    Time,
    /// Length against temperature.
    Hysteresis,
    /// Resistance against length.
    Resistance,
    /// Tension against length.
    Tension,
    /// Speed over control error, and the sliding surface.
    Phase,
    /// Histograms of how late the loop was woken and how long its cycles took.
    Lateness,
    /// All of these that the recordings have.
    All,
}
