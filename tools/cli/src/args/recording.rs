//! The arguments of `recording`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// `sinew recording`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew recording info walk.mcap
  sinew recording doctor walk.mcap
  sinew recording recover killed.mcap -o mended.mcap")]
pub struct Recording {
    /// What to do.
    #[command(subcommand)]
    pub what: RecordingWhat,
}

/// What to do with a recording.
#[derive(Debug, Subcommand)]
pub enum RecordingWhat {
    /// What is in a recording: rig, channels, time, cycles, what was lost, sizes.
    Info(RecordingInfo),
    /// Check all of a recording, and say what to do. Exit 0: it is whole; 1: it is damaged.
    Doctor(RecordingInfo),
    /// Make a whole recording of what is left of one that was killed, cut off or damaged.
    Recover(RecordingRecover),
}

/// `sinew recording info` and `doctor`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew recording info walk.mcap
  sinew recording info walk.mcap --json | jq '.cycles, .lost, .gaps'
  sinew recording doctor walk.mcap && echo whole")]
pub struct RecordingInfo {
    /// The recording.
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    /// As JSON.
    #[arg(long)]
    pub json: bool,
}

/// `sinew recording recover`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew recording recover killed.mcap                    writes killed-recovered.mcap
  sinew recording recover killed.mcap -o mended.mcap --json

All that can be read is kept, of an incomplete last chunk too; what is missing is listed as lost. The damaged file stays
as it is.")]
pub struct RecordingRecover {
    /// The recording.
    #[arg(value_name = "FILE.mcap")]
    pub file: PathBuf,
    /// Where to write; without it, FILE-recovered.mcap.
    #[arg(short, long, value_name = "FILE.mcap")]
    pub output: Option<PathBuf>,
    /// Replace a file that is there.
    #[arg(long)]
    pub force: bool,
    /// What was kept and lost as JSON on stdout ("sinew.recover/1").
    #[arg(long)]
    pub json: bool,
}
