//! The arguments of `life`.

use std::path::PathBuf;

use clap::Args;

/// `sinew life`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew life                                   every wire that was ever driven here
  sinew life bench.toml                        those of one rig
  sinew life bench.toml wire --json
  sinew life bench.toml wire --new-wire        the wire was replaced: begin anew, the old account is kept
  sinew life --of walk.mcap                    what a recording has used of its wires
  sinew life --of monday.csv --rig bench.toml --channel wire

`sinew run` keeps an account of each wire: its cycles (rainflow), and what they used of its life by stress, strain, share of the \
transformation and heat. \"used\" and \"left\" are orders of magnitude: behind them stands what most wires have, a factor of ten and more \
apart. What is counted, by which law and from which sources: docs/life.md.")]
pub struct Life {
    /// The rig file; without one, all rigs.
    #[arg(value_name = "RIG.toml", conflicts_with = "of")]
    pub rig: Option<PathBuf>,
    /// One of its channels.
    #[arg(value_name = "CHANNEL")]
    pub channel: Option<String>,
    /// The channel has a new wire: its account is begun anew, the old one is put into the folder `old` beside it.
    #[arg(long, requires = "channel", conflicts_with_all = ["of", "json"])]
    pub new_wire: bool,
    /// Reckon with a recording instead, as if its wires had been new: .mcap, .csv or .csv.gz.
    #[arg(long, value_name = "RECORDING")]
    pub of: Option<PathBuf>,
    /// What wires the recording is of; a driver's .mcap says so itself.
    #[arg(long = "rig", value_name = "RIG.toml", requires = "of")]
    pub of_rig: Option<PathBuf>,
    /// Which channel of the recording, or of the rig file where that has several.
    #[arg(long = "channel", value_name = "NAME", requires = "of")]
    pub of_channel: Option<String>,
    /// As JSON ("sinew.life/1").
    #[arg(long)]
    pub json: bool,
}
