//! `sinew bringup`: a soldered board's first hour.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::args::numbers::positive;

/// `sinew bringup`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew bringup bench.toml --parts                       which resistors, before anything is soldered
  sinew bringup bench.toml                               all steps: supply, estop, stages, dummy, wire
  sinew bringup bench.toml --only supply                 one of them
  sinew bringup bench.toml --from dummy --channel left --supply-meter 6.48 --dummy 11.97
  sinew bringup bench.toml --report bringup.json < answers.txt

Each step says what to connect, what it expects by the rig file, what it sees, and what is wrong if that differs. Nothing gets more than the
sensing pulse of 2 %, and the driver's supervisor stays in charge. Gains and offsets go into the rig file; a copy of it as it was is kept beside it.
Answers are lines: Enter (done), s (go on without it), q (end), or a number. Exit code 0: all as it should be; 1: something is wrong still.

Without a board, in another terminal (`--wrong help` lists what can be wrong):
  sinew-front-end bench.toml --link /tmp/front-end --mount nothing --wrong \"shunt left 0.2\"
docs/bringup.md has the whole of it.")]
pub struct Bringup {
    /// The rig file: its backend is the board.
    #[arg(value_name = "RIG.toml")]
    pub rig: PathBuf,
    /// Begin with this step.
    #[arg(long, value_name = "STEP", value_enum, conflicts_with = "only")]
    pub from: Option<BringupStep>,
    /// This step and no other.
    #[arg(long, value_name = "STEP", value_enum)]
    pub only: Option<BringupStep>,
    /// Only this channel's resistor and wire; repeat it for several.
    #[arg(long = "channel", value_name = "NAME")]
    pub channels: Vec<String>,
    /// What a meter shows at the board's supply terminals, V, instead of being asked.
    #[arg(long = "supply-meter", value_name = "VOLTS", value_parser = positive)]
    pub supply_meter_v: Option<f64>,
    /// What a meter shows of the resistor that stands for the wires, Ω, instead of being asked.
    #[arg(long = "dummy", value_name = "OHM", value_parser = positive)]
    pub dummy_ohm: Option<f64>,
    /// Correct also gains that are further off than 5 % and offsets above 1 %: that is how the board is meant.
    #[arg(long)]
    pub accept_gains: bool,
    /// Drive nothing: print the values of shunt, resistor and fuse for each wire.
    #[arg(long)]
    pub parts: bool,
    /// Leave the rig file as it is.
    #[arg(long)]
    pub keep: bool,
    /// Write the report here, as JSON ("sinew.bringup/1"); `-` is stdout.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
}

/// A step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BringupStep {
    /// The supply, and every input in the dark, with nothing connected.
    Supply,
    /// The emergency stop, where one is fitted.
    Estop,
    /// Every stage with nothing connected: its pulse stands at the terminal.
    Stages,
    /// A resistor in place of each wire: shunt, gains, offsets, which channel is which.
    Dummy,
    /// Each wire under the sensing pulse: resistance, taps, length.
    Wire,
}

impl BringupStep {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            BringupStep::Supply => "supply",
            BringupStep::Estop => "estop",
            BringupStep::Stages => "stages",
            BringupStep::Dummy => "dummy",
            BringupStep::Wire => "wire",
        }
    }
}
