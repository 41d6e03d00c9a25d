//! The arguments of `replay`.

use std::path::PathBuf;

use clap::Args;

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
