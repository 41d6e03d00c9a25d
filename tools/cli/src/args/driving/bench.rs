//! The arguments of `bench`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::args::numbers::seconds;

/// `sinew bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// What to measure.
    #[command(subcommand)]
    pub what: BenchWhat,
}

/// What can be measured.
#[derive(Debug, Subcommand)]
pub enum BenchWhat {
    /// The driver with simulated wires, beside a bare timer loop in the same run.
    Loop(BenchLoop),
    /// Every controller and estimator on the same simulated plants, beside what physics allows.
    Control(BenchControl),
}

/// `sinew bench loop`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew bench loop
  sinew bench loop --channels 64 --rate 5000 --for 60 --json")]
pub struct BenchLoop {
    /// How many wires.
    #[arg(long, default_value_t = 18, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub channels: u32,
    /// Cycles a second.
    #[arg(long = "rate", value_name = "HZ", default_value = "1000", value_parser = rate, allow_negative_numbers = true)]
    pub rate_hz: f64,
    /// Length of the measurement.
    #[arg(long = "for", value_name = "SECONDS", default_value = "10", value_parser = seconds, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// As JSON.
    #[arg(long)]
    pub json: bool,
}

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

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (10.0..=10_000.0).contains(&value) => Ok(value),
        Ok(_) => Err("the rate is 10 to 10000 Hz".into()),
        Err(_) => Err("give the rate in Hz as a number, as in 1000".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_those_a_loop_can_have() {
        assert_eq!(rate("1000"), Ok(1000.0));
        assert!(rate("5").is_err() && rate("nan").is_err() && rate("1e6").is_err());
    }
}
