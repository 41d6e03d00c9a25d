//! The command line for clap: every command with its options and an example.

mod around;
mod astm;
mod bridge;
mod bringup;
mod conceal;
mod design;
mod exchange;
mod life;
mod look;
mod recording;
mod test;
mod thesis;

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand};
use sinew_ipc::MOST_PRIORITY;

pub use around::{Check, Completions, Man, NamedLanguage, New, Schema};
pub use astm::{Astm, Standard};
pub use bridge::{Bridge, BridgeWhat, Foxglove, Prometheus};
pub use bringup::{Bringup, BringupStep};
pub use conceal::{Conceal, Reveal};
pub use design::{Design, Joint, Method};
pub use exchange::{Export, Import, Replay};
pub use life::Life;
pub use look::{Plot, PlotKind, Scope};
pub use recording::{Record, Recording, RecordingInfo, RecordingRecover, RecordingWhat};
pub use test::*;
pub use thesis::Thesis;

use crate::log::Wordiness;

/// Drives shape-memory-alloy wires in real time: each wire is heated by pulses and measured by its own voltages.
#[derive(Debug, Parser)]
#[command(name = "sinew", version = VERSION, long_version = LONG_VERSION, arg_required_else_help = true, max_term_width = 100, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Say more on stderr; twice: all there is. `RUST_LOG` says it by module.
    #[arg(short, long, global = true, action = ArgAction::Count, conflicts_with = "quiet", help_heading = "Everywhere")]
    verbose: u8,
    /// Say nothing on stderr but errors.
    #[arg(short, long, global = true, help_heading = "Everywhere")]
    quiet: bool,
}

impl Cli {
    /// How much is to be said beside what is asked for.
    pub fn wordiness(&self) -> Wordiness {
        match self.verbose {
            _ if self.quiet => Wordiness::Quiet,
            0 => Wordiness::Usual,
            1 => Wordiness::Wordy,
            _ => Wordiness::Everything,
        }
    }
}

/// The number, and what this program was built from.
macro_rules! version {
    () => {
        concat!(env!("CARGO_PKG_VERSION"), " (", env!("SINEW_BUILT_FROM"), ")")
    };
}

/// As `-V` says it.
pub const VERSION: &str = version!();
/// What `--version` says besides: for which machine, and with which of the features that may be left out.
const LONG_VERSION: &str =
    concat!(version!(), "\nfor ", env!("SINEW_BUILT_FOR"), "\nfeatures: ", env!("SINEW_FEATURES"));

const EXIT_CODES: &str = "\
Start here:
  sinew tour                       what there is to see, in three minutes
  sinew run                        the built-in simulated hexapod, walking on the spot
  sinew new bench                  a rig file of your own, from what lies on your bench
  sinew monitor                    watch it from another terminal
  sinew set front_left_femur stroke=40%   take one wire over for a few seconds

Results go to stdout, everything else to stderr.
Exit codes: 0 done, 1 own failure, 2 bad input or use (the hint says what to mend), 3 recorded, but cycles were lost.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Drive a rig: the real-time loop, its supervisor and its publishing.
    Run(Run),
    /// One look at the running driver.
    Status(Status),
    /// Watch and command every channel on a live screen.
    Monitor(Monitor),
    /// The running driver as a live page for a browser of this machine.
    Scope(Scope),
    /// The running driver for other programs and machines: Prometheus, Foxglove.
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
    /// Look into a recording, check it, mend it.
    Recording(Recording),
    /// What each wire has done, what that used of its life, and what is left of it.
    Life(Life),
    /// Let a recording's inputs drive the model, and write what the sensors would have measured.
    Simulate(Simulate),
    /// Fit the model's parameters to recordings, with their intervals.
    Identify(Identify),
    /// Find where a recording and its simulation differ, what physics was left out, and put it into the model.
    Diagnose(Diagnose),
    /// Make a diagnosis again from its archive, and say whether the answer is the same.
    Repeat(Repeat),
    /// Hide an effect in a recording, for a diagnosis to find.
    Conceal(Conceal),
    /// What was hidden in a recording, beside what a diagnosis found.
    Reveal(Reveal),
    /// See what this program does, in three minutes: a wire moves, a program dies, physics is missing. Leaves nothing behind.
    Tour(Tour),
    /// A machine of the thesis, simulated with the robot program that runs it: a ball on a beam, a servo.
    Demo(Demo),
    /// Bring a recording into CSV or Parquet.
    Export(Export),
    /// Bring a foreign recording in, or say what is in one.
    Import(Import),
    /// Transformation temperatures, strains and plateaus off a material laboratory's curve, as the ASTM standards have them.
    Astm(Box<Astm>),
    /// Let the driver's sensing and control run again on a recording's voltages, and list what differs.
    Replay(Replay),
    /// Draw recordings: over time, as loops, in the phase plane; as SVG, PNG or a page to zoom into.
    Plot(Plot),
    /// Choose the bandwidth λ of each channel's sliding surface from power, cooling, range and uncertainty.
    Tune(Tune),
    /// Size a wire from the force, the stroke and the speed it is to have.
    Design(Design),
    /// Run a routine of the test machine: pull, heat, regulate a wire, and report the numbers it is run for.
    Test(Box<Test>),
    /// The first files of a bench: a rig file that runs, a robot program, an editor's settings.
    New(New),
    /// Read a rig file, and tell all its mistakes or what it comes to.
    Check(Check),
    /// The JSON Schema of a rig file, by which editors complete and check.
    Schema(Schema),
    /// What this machine lacks for real time and for the rig, and what to type.
    Doctor(Doctor),
    /// Bring a soldered board up, step by step: supply, emergency stop, stages, a resistor, the wires.
    Bringup(Bringup),
    /// Measure this machine beside a bare timer loop.
    Bench(Bench),
    /// The thesis page by page: what it states beside what this program computes.
    Thesis(Thesis),
    /// The script by which a shell completes commands and options.
    Completions(Completions),
    /// The manual pages.
    Man(Man),
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
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = test::positive, allow_negative_numbers = true)]
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

/// `sinew simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew simulate bench.toml recording.csv -o simulated.csv
  sinew simulate bench.toml recording.csv.gz -o - | head
  sinew simulate hexapod.toml walk.mcap --channel front_left_femur -o simulated.csv
  sinew simulate bench.toml recording.csv --catalogue laws.toml -o simulated.csv

The inputs are the column of the drive's kind (duty, power_w, current_a or temperature_c), position_m or force_n where
the load imposes it, and supply_v, ambient_c and disturbance_n where present. A row's inputs hold from its time to the
next row's; its outputs are those at the end of that span. Rows and time stamps are those of the recording.")]
pub struct Simulate {
    /// The rig file.
    #[arg(value_name = "RIG.toml")]
    pub rig: PathBuf,
    /// The recording whose inputs drive the model: .csv, .csv.gz, or a driver's .mcap.
    #[arg(value_name = "RECORDING")]
    pub inputs: PathBuf,
    /// Where to write, .csv or .csv.gz; `-` is stdout.
    #[arg(short, long, value_name = "SIMULATED.csv")]
    pub output: PathBuf,
    /// Which channel of the rig file, where it has several; and of the recording.
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// Pass over columns that are no recording's instead of refusing them.
    #[arg(long)]
    pub ignore_columns: bool,
    /// Physics of one's own.
    #[command(flatten)]
    pub laws: Laws,
}

/// Physics of one's own, beside that of the rig file.
#[derive(Debug, Default, Args)]
pub struct Laws {
    /// A file of physics of your own, [effects."own.NAME"]: candidates for a diagnosis, and laws the rig file may set
    /// (docs/own-physics.md).
    #[arg(long, value_name = "LAWS.toml")]
    pub catalogue: Option<PathBuf>,
}

/// Where the counting of the blocks kept back starts, unless another seed is given.
pub const SEED: u64 = 1;

/// What is fitted to and how, the same for `identify` and `diagnose`.
#[derive(Debug, Args)]
pub struct Fitting {
    /// The rig file: what is believed of the rig.
    #[arg(value_name = "RIG.toml")]
    pub rig: PathBuf,
    /// What happened: .csv, .csv.gz or .mcap. Several are fitted together.
    #[arg(value_name = "RECORDING", required = true)]
    pub recordings: Vec<PathBuf>,
    /// Which channel of the rig file, where it has several; and of the recording.
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// Pass over columns that are no recording's instead of refusing them.
    #[arg(long)]
    pub ignore_columns: bool,
    /// Which third of each recording a diagnosis keeps back and judges by: 1, 2, 3, and from the beginning again. Same
    /// input and seed, same answer.
    #[arg(long, value_name = "N", default_value_t = SEED)]
    pub seed: u64,
    /// Threads; without it, as many as there are processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,
    /// The answer as JSON on stdout.
    #[arg(long)]
    pub json: bool,
    /// Physics of one's own.
    #[command(flatten)]
    pub laws: Laws,
}

/// `sinew identify`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew identify bench.toml monday.csv -o fitted.toml
  sinew identify bench.toml monday.csv tuesday.csv.gz -o fitted.toml --channel wire --json

The physics stays that of the rig file; its parameters move within their priors
([channel.priors]). The table gives each with its 90 % interval. FITTED.toml is the rig file with
the fitted values in their places.")]
pub struct Identify {
    /// What to fit.
    #[command(flatten)]
    pub fitting: Fitting,
    /// Where to write the rig file with the fitted parameters; `-` is stdout, and the table goes to stderr.
    #[arg(short, long, value_name = "FITTED.toml")]
    pub output: PathBuf,
}

/// `sinew tune`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew tune bench.toml
  sinew tune bench.toml --channel wire --uncertainty 10% --range 20-80%
  sinew tune bench.toml --cool-freely --write
  sinew tune bench.toml --json | jq '.channels[] | {name, lambda_per_s, margin}'

The surface is reachable while the power that keeps the wire on it lies between the least and the most the
channel has (thesis, chapter 11, eq. 67-70), over the range of strokes and with every parameter of the model
wrong by the uncertainty, in whatever combination is worst. Where no lambda does, it says what to change.
--write puts it into the rig file, which otherwise stays as it is.")]
pub struct Tune {
    /// The rig file.
    #[arg(value_name = "RIG.toml")]
    pub rig: PathBuf,
    /// Only this channel; without it, every one.
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// How wrong each parameter may be: 30% or 0.3.
    #[arg(long, value_name = "SHARE", default_value = "30%", value_parser = share, allow_negative_numbers = true)]
    pub uncertainty: f64,
    /// The strokes it moves between, 0 % = cold and long, 100 % = hot and short.
    #[arg(long, value_name = "LOW-HIGH%", default_value = "10-90%", value_parser = strokes)]
    pub range: (f64, f64),
    /// Ask for reachability only while the wire shortens; lengthening, it cools freely until it is near its target.
    #[arg(long)]
    pub cool_freely: bool,
    /// Put the values into the rig file, which keeps everything else as it is written.
    #[arg(long)]
    pub write: bool,
    /// The answer as JSON on stdout.
    #[arg(long)]
    pub json: bool,
}

/// `sinew diagnose`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew diagnose bench.toml monday.csv --out monday
  sinew diagnose bench.toml slow.csv fast.csv --holdout tuesday.csv --out week
  sinew diagnose bench.toml monday.csv --catalogue laws.toml --out monday
  sinew diagnose bench.toml monday.csv --out monday --json | jq '.verdict, .effects[].id'
  sinew diagnose bench.toml monday.csv --out monday --bundle monday.zip
  sinew diagnose leg.toml walk.mcap --whole-rig --out leg
  sinew diagnose leg.toml left=a-left.csv right=a-right.csv --whole-rig --out leg

Writes DIR/diagnosis.json, DIR/improved.toml (the rig file with what was found in it, as
`sinew simulate` takes it), DIR/report.html and, where another recording would settle something,
DIR/next.csv: what to drive the wire by. Without --holdout about a third of each recording
is kept back, in blocks, and judged by. The verdict is agrees, parameters_off, physics_missing or
unknown_physics; a broken recording gets none, but exit code 2.

With --whole-rig there is an answer for every wire, in DIR/CHANNEL, and one for what they share:
a supply that sags under the sum of their currents, heat that passes between two of them. A session
is of all its wires; a .csv says of which by CHANNEL=FILE. The n-th of each wire are of one run, with
one clock.")]
pub struct Diagnose {
    /// What to fit.
    #[command(flatten)]
    pub fitting: Fitting,
    /// Where the answer is written; made if it is not there.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A recording that is never fitted, only judged by; may be given several times.
    #[arg(long, value_name = "RECORDING")]
    pub holdout: Vec<PathBuf>,
    /// However long it takes: without it a search that has gone on for as long as people wait ends with what it has, and says so.
    #[arg(long)]
    pub thorough: bool,
    /// Also draw the recordings as measured and simulated: DIR/picture.svg.
    #[arg(long)]
    pub picture: bool,
    /// Several wires at once: an answer for each, and one for what they share.
    #[arg(long, conflicts_with = "channel")]
    pub whole_rig: bool,
    /// Also put all of it into one archive, for another laboratory to repeat: what went in, the command, the version, the answer.
    #[arg(long, value_name = "FILE.zip")]
    pub bundle: Option<PathBuf>,
}

/// `sinew repeat`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew diagnose bench.toml monday.csv --out monday --bundle monday.zip
  sinew repeat monday.zip
  sinew repeat monday.zip --out mine

Makes the diagnosis again from the files in the archive, writes the answer to DIR and says how it differs from the one in the
archive: not at all, in some values, or (exit code 1) in its verdict or effects.")]
pub struct Repeat {
    /// What `sinew diagnose --bundle` wrote.
    #[arg(value_name = "FILE.zip")]
    pub bundle: PathBuf,
    /// Where the new answer is written; without it, the archive's name and "-again", in this folder.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads; without it, as many as there are processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,
}

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
    /// End by itself after this time; of a trial, how long it lasts (600 s if not said).
    #[arg(long = "for", value_name = "S", value_parser = seconds)]
    pub duration_s: Option<f64>,
    /// What noise and draughts come from.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub seed: Option<u32>,
    /// Show it in a browser of this machine instead of in the terminal.
    #[arg(long, conflicts_with = "trials")]
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
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["trials", "scope"])]
    pub keep: Option<PathBuf>,
    /// Be its robot program.
    #[arg(long, hide = true)]
    pub robot: bool,
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
    /// Only this controller, by its word in the rig file; may be given several times.
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

/// A speed of simulated time; infinite as fast as possible.
fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        _ if text == "max" => Ok(f64::INFINITY),
        Ok(speed) if (1.0..=10_000.0).contains(&speed) => Ok(speed),
        _ => Err("expected 1 to 10000, or max".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.trim_end_matches('s').parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e7 => Ok(value),
        Ok(_) => Err("seconds are more than 0 and at most 10000000".into()),
        Err(_) => Err("give seconds as a number, as in 2.5".into()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number.trim_end(), 100.0));
    match number.parse::<f64>() {
        Ok(value) if (0.0..=0.9).contains(&(value / unit)) => Ok(value / unit),
        Ok(_) => Err("the uncertainty is 0 to 90 %".into()),
        Err(_) => Err("give the uncertainty as in 30% or 0.3".into()),
    }
}

fn strokes(text: &str) -> Result<(f64, f64), String> {
    let wanted = "give the strokes as in 10-90%";
    let number = |text: &str| text.trim().trim_end_matches('%').parse::<f64>().map_err(|_| wanted.to_string());
    let (low, high) = text.split_once('-').ok_or(wanted)?;
    let (low, high) = (number(low)? / 100.0, number(high)? / 100.0);
    match 0.0 <= low && low < high && high <= 1.0 {
        true => Ok((low, high)),
        false => Err("the strokes rise, from 0 to 100 %".into()),
    }
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
    use clap::CommandFactory;

    #[test]
    fn clap_finds_nothing_wrong_with_it() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_shows_an_example() {
        fn check(command: &clap::Command, above: &str) {
            let name = format!("{above} {}", command.get_name());
            if command.has_subcommands() {
                command.get_subcommands().filter(|c| c.get_name() != "help").for_each(|c| check(c, &name));
            } else {
                let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
                assert!(text.contains(&name), "{name}: {text}");
            }
        }
        check(&Cli::command(), " ");
    }

    #[test]
    fn durations_are_positive_numbers() {
        assert_eq!(seconds("2.5"), Ok(2.5));
        assert_eq!(seconds("3s"), Ok(3.0));
        for bad in ["0", "-1", "nan", "inf", "abc", ""] {
            assert!(seconds(bad).is_err(), "{bad}");
        }
        assert!(rate("5").is_err() && rate("nan").is_err() && rate("1e6").is_err());
    }
}
