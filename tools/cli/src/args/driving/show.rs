//! The arguments of `tour` and `demo`.

use std::path::PathBuf;

use clap::Args;

use crate::args::numbers::seconds;

/// `sinew tour`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew tour
  sinew tour --no-wait --seed 7         without waiting for Enter, and the same effect every time
  sinew tour --keep seen                keeps the files, and the report of the diagnosis

Types the commands that you would type, in a folder for temporary files and with a driver of its own: drivers that run already are not touched. At the
end, and after Ctrl-C, the driver is off and the folder is gone.")]
pub struct Tour {
    /// Do not wait for Enter between its parts.
    #[arg(long)]
    pub no_wait: bool,
    /// What the hidden effect comes from, 0 to 4294967295. Without it, another one each time.
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Keep what was made in this folder.
    #[arg(long, value_name = "FOLDER")]
    pub keep: Option<PathBuf>,
}

/// `sinew demo`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew demo                                 which there are
  sinew demo ball-on-beam                    live in this terminal, until q or Ctrl-C
  sinew demo ball-on-beam --scope            live in a browser
  sinew demo ball-on-beam --trials 20        twenty of ten minutes, without a clock: how often it succeeds
  sinew demo servo --keep bench              the rig file and the robot program, to go on from

The wires are simulated, and what they move with them (`[demonstrator]` of the rig file). The robot program runs in a process of its own, as an
ordinary client of the driver, and sees nothing but the lines of its sensor, late and noisy.")]
pub struct Demo {
    /// Which machine; without one, a list.
    #[arg(value_name = "NAME")]
    pub name: Option<String>,
    /// End by itself after this time; of a trial, how long it lasts (600 s if not said, 75 s of the walker).
    #[arg(long = "for", value_name = "S", value_parser = seconds)]
    pub duration_s: Option<f64>,
    /// What noise and draughts come from.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub seed: Option<u32>,
    /// Show it in a browser of this machine instead of in the terminal.
    #[cfg(network)]
    #[arg(long, conflicts_with_all = ["trials", "keep"])]
    pub scope: bool,
    /// So many trials without a clock, one for each seed from 1 (or --seed) on.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub trials: Option<u32>,
    /// The trials as JSON.
    #[arg(long, requires = "trials")]
    pub json: bool,
    /// Plain lines instead of the screen.
    #[arg(long)]
    pub no_monitor: bool,
    /// Write its rig file and its robot program into this new folder, and do nothing else.
    #[arg(long, value_name = "FOLDER", conflicts_with = "trials")]
    pub keep: Option<PathBuf>,
    /// Be its robot program.
    #[arg(long, hide = true)]
    pub robot: bool,
}
