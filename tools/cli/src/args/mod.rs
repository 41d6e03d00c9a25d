//! The command line for clap: every command with its options and an example.

mod around;
mod astm;
mod conceal;
#[cfg(driver)]
mod driving;
mod exchange;
mod look;
mod numbers;
mod recording;

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand};

pub use around::{Check, Completions, Man, NamedLanguage, New, Schema};
pub use astm::{Astm, Named, Standard};
pub use conceal::{Conceal, Reveal};
#[cfg(driver)]
pub use driving::*;
pub use exchange::{Export, Import};
pub use look::{Plot, PlotKind};
pub use recording::{Recording, RecordingInfo, RecordingRecover, RecordingWhat};

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

/// The commands that drive a rig or talk to what does, each with the feature it needs, for a program without that to say so.
pub const DRIVING: [(&str, &str); 20] = [
    ("run", "driver"),
    ("status", "driver"),
    ("monitor", "driver"),
    ("scope", "network"),
    ("bridge", "network"),
    ("set", "driver"),
    ("play", "driver"),
    ("reset", "driver"),
    ("stop", "driver"),
    ("record", "driver"),
    ("life", "driver"),
    ("tour", "driver"),
    ("demo", "driver"),
    ("replay", "driver"),
    ("design", "driver"),
    ("test", "driver"),
    ("doctor", "driver"),
    ("bringup", "driver"),
    ("bench", "driver"),
    ("thesis", "thesis"),
];

/// The feature without which this program was compiled, if this command needs one, or this subcommand or option of a command.
pub fn left_out(command: &str, word: &str) -> Option<&'static str> {
    let feature = match (command, word) {
        ("bench", "control") => "thesis",
        ("demo", "--scope") => "network",
        _ => DRIVING.into_iter().find(|(name, _)| *name == word)?.1,
    };
    let compiled = [("driver", cfg!(driver)), ("network", cfg!(network)), ("thesis", cfg!(thesis))];
    compiled.contains(&(feature, false)).then_some(feature)
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Those that drive a rig, or talk to what does.
    #[cfg(driver)]
    #[command(flatten)]
    Driving(Driving),
    /// Look into a recording, check it, mend it.
    Recording(Recording),
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
    /// Bring a recording into CSV or Parquet.
    Export(Export),
    /// Bring a foreign recording in, or say what is in one.
    Import(Import),
    /// Transformation temperatures, strains and plateaus off a material laboratory's curve, as the ASTM standards have them.
    Astm(Box<Astm>),
    /// Draw recordings: over time, as loops, in the phase plane; as SVG, PNG or a page to zoom into.
    Plot(Plot),
    /// Choose the bandwidth λ of each channel's sliding surface from power, cooling, range and uncertainty.
    Tune(Tune),
    /// The first files of a bench: a rig file that runs, a robot program, an editor's settings.
    New(New),
    /// Read a rig file, and tell all its mistakes or what it comes to.
    Check(Check),
    /// The JSON Schema of a rig file, by which editors complete and check.
    Schema(Schema),
    /// The script by which a shell completes commands and options.
    Completions(Completions),
    /// The manual pages.
    Man(Man),
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
    #[arg(value_name = "RECORDING")]
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
#[command(
    after_help = "\
Examples:
  sinew identify bench.toml monday.csv -o fitted.toml
  sinew identify bench.toml monday.csv tuesday.csv.gz -o fitted.toml --channel wire --json
  sinew identify bench.toml monday.csv --dsc dsc.csv -o fitted.toml    a calorimeter's curve beside it
  sinew identify bench.toml --dsc dsc.txt --mass-mg 12.4 --rate 10 -o fitted.toml

The physics stays that of the rig file; its parameters move within their priors
([channel.priors]). The table gives each with its 90 % interval. FITTED.toml is the rig file with
the fitted values in their places.

A calorimeter's curve (--dsc, in any file that `sinew import` reads) is fitted by the same physics without stress, and
joins the fit of the recordings; where both contradict each other it is said. Without recordings FITTED.toml gets what
the curve says, and its uncertainties as priors.",
    mut_arg("recordings", |recordings| recordings.required_unless_present("dsc"))
)]
pub struct Identify {
    /// What to fit.
    #[command(flatten)]
    pub fitting: Fitting,
    /// A calorimeter's curve of the wire's material, heating and cooling; may be given several times.
    #[arg(long, value_name = "FILE")]
    pub dsc: Vec<PathBuf>,
    /// Mass of the calorimeter's sample, mg, where the file has the whole sample's heat flow; one for all curves, or one for each.
    #[arg(long, value_name = "MG", value_parser = numbers::positive, requires = "dsc")]
    pub mass_mg: Vec<f64>,
    /// Rate of the calorimeter's sweep, K/min, where the file has no times.
    #[arg(long, value_name = "K_PER_MIN", value_parser = numbers::positive, requires = "dsc")]
    pub rate: Option<f64>,
    /// Which column of the calorimeter's file holds a quantity, where its name does not say so: temperature, heat-flow, time.
    #[arg(long = "column", value_name = "QUANTITY=NAME", value_parser = astm::named, requires = "dsc")]
    pub columns: Vec<Named>,
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
    #[arg(long, value_name = "SHARE", default_value = "30%", value_parser = numbers::uncertainty, allow_negative_numbers = true)]
    pub uncertainty: f64,
    /// The strokes it moves between, 0 % = cold and long, 100 % = hot and short.
    #[arg(long, value_name = "LOW-HIGH%", default_value = "10-90%", value_parser = numbers::strokes)]
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
#[command(
    after_help = "\
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
one clock.",
    mut_arg("recordings", |recordings| recordings.required(true))
)]
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    #[cfg(driver)]
    fn what_may_be_left_out_is_known_where_it_is() {
        let half = Driving::augment_subcommands(clap::Command::new("sinew"));
        let there = DRIVING.map(|(name, _)| name).into_iter().filter(|name| left_out("", name).is_none());
        assert!(half.get_subcommands().map(clap::Command::get_name).eq(there));
    }

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
}
