//! The arguments of `bench control`.

use std::path::PathBuf;

use clap::Args;

/// `sinew bench control`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew bench control --out bench              everything: bench/report.html and bench/bench.json
  sinew bench control --quick                  five plants, one seed: a first look within a minute
  sinew bench control --plant figure --controller sliding_mode --controller pi
  sinew bench control --quick --json | jq '.rows[] | {controller, estimator, plant, ratio_up, overshoot_percent}'

Simulated time, as fast as the machine can, the same numbers for the same seeds on any number of threads.
A full run takes seeds that nobody develops with; --quick takes others.")]
pub struct BenchControl {
    /// Where report.html and bench.json are written; made if it is not there.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Where the pictures of the documentation are written, as SVG.
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// A few plants on one seed to develop with.
    #[arg(long)]
    pub quick: bool,
    /// Only this controller, of a wire or of a joint, by its word in the rig file; may be given several times.
    #[arg(long, value_name = "WORD")]
    pub controller: Vec<String>,
    /// Only this estimator, by its word in the rig file; may be given several times.
    #[arg(long, value_name = "WORD")]
    pub estimator: Vec<String>,
    /// Only this plant; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub plant: Vec<String>,
    /// How many seeds of the noise each row is run with; 3, with --quick 1.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub seeds: Option<u16>,
    /// Threads; without it, as many as there are processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,
    /// The answer as JSON on stdout.
    #[arg(long)]
    pub json: bool,
}
