//! The arguments of what drives a rig, or talks to a driver.

mod bench;
#[cfg(thesis)]
mod bench_control;
#[cfg(network)]
mod bridge;
mod bringup;
mod design;
mod life;
mod record;
mod replay;
#[cfg(network)]
mod scope;
mod show;
mod test;
#[cfg(thesis)]
mod thesis;

use std::path::PathBuf;

use clap::{Args, Subcommand};
use sinew_ipc::MOST_PRIORITY;

use super::Laws;
use super::numbers::{positive, seconds};

pub use bench::{Bench, BenchLoop, BenchWhat};
#[cfg(thesis)]
pub use bench_control::BenchControl;
#[cfg(network)]
pub use bridge::{Bridge, BridgeWhat, Foxglove, Prometheus, Zenoh};
pub use bringup::{Bringup, BringupStep};
pub use design::{Design, Joint, Method};
pub use life::Life;
pub use record::Record;
pub use replay::Replay;
#[cfg(network)]
pub use scope::Scope;
pub use show::{Demo, Tour};
pub use test::*;
#[cfg(thesis)]
pub use thesis::Thesis;

/// The commands that need a driver, or are one.
#[derive(Debug, Subcommand)]
pub enum Driving {
    /// Drive a rig: the real-time loop, its supervisor and its publishing.
    Run(Run),
    /// One look at the running driver.
    Status(Status),
    /// Watch and command every channel on a live screen.
    Monitor(Monitor),
    /// The running driver as a live page for a browser of this machine.
    #[cfg(network)]
    Scope(Scope),
    /// The running driver for other programs and machines: Prometheus, Foxglove.
    #[cfg(network)]
    Bridge(Bridge),
    /// Command channels: one, or several in the same cycle.
    Set(Set),
    /// Play setpoints from a CSV file, all channels in the same cycle.
    Play(Play),
    /// Clear the latched faults of channels.
    Reset(Reset),
    /// Stop the running driver: outputs to zero, then it reports and ends.
    Stop(Stop),
    /// Record every cycle of the running driver.
    Record(Record),
    /// What each wire has done, what that used of its life, and what is left of it.
    Life(Life),
    /// See what this program does, in three minutes: a wire moves, a program dies, physics is missing. Leaves nothing behind.
    Tour(Tour),
    /// A machine of the thesis, simulated with the robot program that runs it: a ball on a beam, a servo.
    Demo(Demo),
    /// Let the driver's sensing and control run again on a recording's voltages, and list what differs.
    Replay(Replay),
    /// Size a wire from the force, the stroke and the speed it is to have.
    Design(Design),
    /// Run a routine of the test machine: pull, heat, regulate a wire, and report the numbers it is run for.
    Test(Box<Test>),
    /// What this machine lacks for real time and for the rig, and what to type.
    Doctor(Doctor),
    /// Bring a soldered board up, step by step: supply, emergency stop, stages, a resistor, the wires.
    Bringup(Bringup),
    /// Measure this machine beside a bare timer loop.
    Bench(Bench),
    /// The thesis page by page: what it states beside what this program computes.
    #[cfg(thesis)]
    Thesis(Thesis),
}

/// `sinew run`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew run                                        the built-in 18-wire hexapod, simulated, walking on the spot
  sinew run examples/hexapod.toml --for 60 --report run.json
  sinew run bench.toml --no-monitor 2> run.log     one line a second on stdout
  sinew run bench.toml --plain                     in words, for a screen reader; commands are typed
  sinew run bench.toml --speed 20                  simulated wires, twenty times as fast

On a terminal it shows the monitor, on one without a cursor (TERM=dumb) the same in words; otherwise one line a second. Ctrl-C and SIGTERM put all outputs to zero,
print the report and exit 0.")]
pub struct Run {
    /// The rig file; without one, the built-in simulated hexapod.
    #[arg(value_name = "RIG.toml")]
    pub rig: Option<PathBuf>,
    /// Stop after so many seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    /// Write the report here, as JSON ("sinew.run/1"); `-` is stdout.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// One line a second, also on a terminal.
    #[arg(long)]
    pub no_monitor: bool,
    /// In words, for screen readers and logs: what changes is said, a line each, and commands are typed (`help` tells them).
    #[arg(long, conflicts_with = "no_monitor")]
    pub plain: bool,
    /// So many simulated seconds in a second, 1 to 10000, or `max`: simulated wires only; leases count simulated time.
    #[arg(long, value_name = "F|max", value_parser = speed)]
    pub speed: Option<f64>,
    /// Physics of one's own, for simulated wires.
    #[command(flatten)]
    pub laws: Laws,
}

/// Which running driver is meant.
#[derive(Debug, Args)]
pub struct Target {
    /// Name of the rig; only needed where several drivers run.
    #[arg(long = "rig", value_name = "NAME")]
    pub name: Option<String>,
}

/// `sinew status`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew status
  sinew status --json | jq '.channel[] | {name, length_m, fault}'")]
pub struct Status {
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
    /// As JSON.
    #[arg(long)]
    pub json: bool,
}

/// `sinew monitor`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew monitor
  sinew monitor --rig hexapod
  sinew monitor > watch.log        no terminal: one line a second
  sinew monitor --plain            in words, for a screen reader; type help, or Enter for how things are
  sinew monitor --plain --every 60 > events.log     what happens, and how things are each minute

In words: nothing is drawn, what changes is said, and commands are typed, as `set left 40%`, `off left`, `status left`, `stop`, `quit`; so it is
on a terminal without a cursor (TERM=dumb) too. By a pipe commands come the same way, and its end is not the monitor's.

Keys: arrows or j/k select, + and - move the stroke by 5 %, digits type a stroke (Enter sends), o off, r reset,
Space let go of the channel, d details, n the next channel with a fault or held back, ? help, q quit. NO_COLOR leaves the colours out.")]
pub struct Monitor {
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
    /// Stop after so many seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    /// In words, for screen readers and logs: what changes is said, a line each, and commands are typed.
    #[arg(long)]
    pub plain: bool,
    /// In words, also how things are, so often.
    #[arg(long = "every", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true, requires = "plain")]
    pub every_s: Option<f64>,
}

/// `sinew set`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew set front_left_femur stroke=40%
  sinew set front_left_femur length=164mm --hold 30
  sinew set front_left_femur duty=0.1 --hold 2
  sinew set front_left_femur force=2N
  sinew set front_left_femur off
  sinew set front_left_femur stroke=40% front_left_tibia stroke=6mm

Units: length in mm, cm or m; stroke in % (0 % cold and long, 100 % hot and short) or, from the cold end, in mm, cm or m; duty 0..1 or %; force in N or mN.
Several channels are commanded in the same cycle, all or none. Names and setpoints take turns, so that a channel may be called anything.
Without --hold a setpoint holds for 10 s; then the channel goes back to what the driver does by itself.
`off` stays until the next command unless --hold is given.")]
pub struct Set {
    /// Name of a channel and its setpoint: length=164mm, stroke=40%, duty=0.1, force=2N or off; then those of the next.
    #[arg(value_names = ["CHANNEL", "SETPOINT"], num_args = 2.., required = true)]
    pub wanted: Vec<String>,
    /// How long it holds without being renewed.
    #[arg(long = "hold", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub hold_s: Option<f64>,
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
}

/// `sinew play`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew play wave.csv
  sinew play wave.csv --speed 0.5 --times 10
  sinew play wave.csv --rig hexapod --keep
  sinew play wave.csv --priority 5        nobody else's setpoints meanwhile

The file: a first line `time_s,left,right` with the channels' names, then rows such as `0,10%,off`, `0.5,164mm,` or `2,,duty=0.1`. A cell is a setpoint
as in the monitor, a bare number the stroke in %, an empty one leaves its channel as it is. All of a row is in force from the same cycle on.
Setpoints are leases of --hold seconds, renewed while the file is played; at its end, and after Ctrl-C, its channels are off.")]
pub struct Play {
    /// The CSV file.
    #[arg(value_name = "FILE.csv")]
    pub file: PathBuf,
    /// How much faster than written.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive, allow_negative_numbers = true)]
    pub speed: f64,
    /// How often.
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub times: u32,
    /// How long each setpoint holds without being renewed.
    #[arg(long = "hold", value_name = "SECONDS", default_value_t = 0.5, value_parser = seconds, allow_negative_numbers = true)]
    pub hold_s: f64,
    /// Leave the last setpoints until their lease runs out, instead of switching off.
    #[arg(long)]
    pub keep: bool,
    /// Have the channels to oneself while the file is played: claim them with this priority, which takes them over from a lower one.
    #[arg(long, value_name = "0..9", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_PRIORITY)))]
    pub priority: Option<u32>,
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
}

/// `sinew reset`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew reset front_left_femur
  sinew reset front_left_femur front_left_tibia
  sinew reset --all

A fault stays latched until it is reset, and is only cleared once its cause is gone.")]
pub struct Reset {
    /// Names of the channels.
    #[arg(value_name = "CHANNEL", required_unless_present = "all")]
    pub channels: Vec<String>,
    /// Every channel that has a fault.
    #[arg(long, conflicts_with = "channels")]
    pub all: bool,
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
}

/// `sinew stop`.
#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  sinew stop
  sinew stop --rig hexapod

Every output goes to zero, the supply off where a line switches it, and the driver ends. It overtakes whatever waits. `sinew set CHANNEL off`
instead leaves the sensing pulse, by which the wire goes on being measured. Software's stop is no emergency stop: see docs/wiring.md.")]
pub struct Stop {
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
}

/// `sinew doctor`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew doctor
  sinew doctor bench.toml --json")]
pub struct Doctor {
    /// A rig file, to be checked for what this machine can give it; without one, the built-in hexapod.
    #[arg(value_name = "RIG.toml")]
    pub rig: Option<PathBuf>,
    /// As JSON.
    #[arg(long)]
    pub json: bool,
}

/// A speed of simulated time; infinite as fast as possible.
fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        _ if text == "max" => Ok(f64::INFINITY),
        Ok(speed) if (1.0..=10_000.0).contains(&speed) => Ok(speed),
        _ => Err("expected 1 to 10000, or max".into()),
    }
}
