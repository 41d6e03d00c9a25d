//! The arguments of `bench`.

use clap::{Args, Subcommand};

#[cfg(thesis)]
use super::bench_control::BenchControl;
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
    #[cfg(thesis)]
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
