//! `sinew test`: the routines of the test machine, on a simulated one and on running rigs.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use sinew_control::{AlgorithmKind, EstimatorKind};
use sinew_ipc::MOST_PRIORITY;
use sinew_machine::hanging::Disturbance;
use sinew_machine::{Quantity, Shape};

use crate::args::numbers::{positive, seconds};

/// `sinew test`.
#[derive(Debug, Args)]
#[command(after_help = format!("{EXAMPLES}\n\n{}", sinew_machine::plan::rigs_table_text()))]
pub struct Test {
    /// Which routine.
    #[command(subcommand)]
    pub routine: TestRoutine,
}

const EXAMPLES: &str = "\
Examples:
  sinew test list
  sinew test direct-strain examples/test-machine.toml --heating power=0.6,0.9,1.2W --strain 0-4.5% --out loops
  sinew test position-regulation examples/test-machine.toml --controller pid --json
  sinew test characterise examples/test-machine.toml --out wire
  sinew test constant-force-sweep --rig bench --channel left --out sweep     on a wire of a running driver
  sinew test characterise --rig bench --channel left --out wire

The machine is described by [machine] of the rig file; docs/test-machine.md says what each routine yields. With --rig the wire is one of a
running driver, on its own load. The channel is claimed, and a lease switches the wire off if this program dies.
Ctrl-C ends a routine at zero output; its recording and a partial report are written all the same.";

/// The routines.
#[derive(Debug, Subcommand)]
pub enum TestRoutine {
    /// What there is, and what for.
    List(TestList),
    /// Pull between two strains at constant speed: moduli, transformation stresses, hysteresis.
    DirectStrain(DirectStrain),
    /// Pull between two loads at constant speed: the same, for wires that give way.
    DirectLoad(DirectLoad),
    /// Heat up and down ever faster under one load: stroke and open-loop bandwidth.
    ConstantForceSweep(ConstantForceSweep),
    /// Heat up and down ever faster at one length: force and open-loop bandwidth.
    ConstantStrainSweep(ConstantStrainSweep),
    /// A law brings a hanging mass to places: settling, overshoot, steady error.
    PositionRegulation(PositionRegulation),
    /// A law lets a hanging mass follow a wave: tracking error.
    PositionTracking(PositionTracking),
    /// A law lets a hanging mass follow ever faster sines: closed-loop bandwidth.
    TrackingSweep(TrackingSweep),
    /// Heat and cool under one load until strain and temperatures settle: how many cycles a new wire takes.
    BreakIn(BreakIn),
    /// Play a file: what heats the wire and where its end is, such as the next.csv that a diagnosis proposes.
    Programme(Programme),
    /// All that a new wire needs, the fit to it, and how well that foretells routines it was not fitted to.
    Characterise(Characterise),
}

/// `sinew test list`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test list
  sinew test list --json")]
pub struct TestList {
    /// As JSON.
    #[arg(long)]
    pub json: bool,
}

/// `sinew test programme`.
#[derive(Debug, Args)]
#[command(
    allow_missing_positional = true,
    after_help = "\
Examples:
  sinew diagnose loops/rig.toml loops/direct-strain.mcap --out answer
  sinew test programme rig.toml answer/next.csv --out next
  sinew test programme --rig bench --channel left duties.csv --out played
  sinew diagnose loops/rig.toml loops/direct-strain.mcap next/programme.mcap --out both

Columns: time_s; current_a in A or power_w in W, held from row to row; position_m, elongation in m, straight from row
to row, or force_n in N. On a running rig duty, power_w or current_a, and nothing that moves the wire's end."
)]
pub struct Programme {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// What to play: .csv or .csv.gz.
    #[arg(value_name = "PROGRAMME.csv")]
    pub programme: PathBuf,
}

/// Where the wire is, and what is believed of it.
#[derive(Debug, Args)]
pub struct TestedWire {
    /// The rig file: what is believed of the wire, and the machine; with --rig, other beliefs than those the driver runs by.
    #[arg(value_name = "RIG.toml", required_unless_present = "running")]
    pub rig: Option<PathBuf>,
    /// Run it on a wire of this running rig instead of the machine: on its own load, as `sinew test list` says.
    #[arg(long = "rig", value_name = "NAME")]
    pub running: Option<String>,
    /// Which channel of the rig, where it has several.
    #[arg(long, value_name = "NAME")]
    pub channel: Option<String>,
    /// The rig file of the wire that is really in the simulated machine; without it, the wire is as believed.
    #[arg(long, value_name = "TRUE.toml")]
    pub truth: Option<PathBuf>,
    /// With --rig: of the claim to the channel, which takes it over from a lower one.
    #[arg(long, value_name = "0..9", requires = "running", default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_PRIORITY)))]
    pub priority: u32,
}

/// What every routine takes.
#[derive(Debug, Args)]
pub struct Mounted {
    /// Where the wire is.
    #[command(flatten)]
    pub wire: TestedWire,
    /// Regulate the chamber to this temperature first, such as 60C; without it, the wire is in the room.
    #[arg(long, value_name = "CELSIUS", value_parser = celsius, allow_negative_numbers = true)]
    pub chamber: Option<f64>,
    /// Write recording, report and pictures into this folder.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Keep to the clock; without it, a simulated machine runs as fast as it can.
    #[arg(long)]
    pub real_time: bool,
    /// The report as JSON on stdout ("sinew.test/1").
    #[arg(long)]
    pub json: bool,
}

/// `sinew test direct-strain`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test direct-strain rig.toml                             one power, that makes the wire super-elastic
  sinew test direct-strain rig.toml --heating power=0.6,0.9,1.2W --strain 0-4.5% --rate 0.3mm/s --out loops
  sinew test direct-strain rig.toml --heating power=0W --chamber 90C --cycles 3")]
pub struct DirectStrain {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// Heating levels.
    #[command(flatten)]
    pub direct: Direct,
    /// Between these strains.
    #[arg(long, value_name = "LOW-HIGH%", value_parser = strain)]
    pub strain: Option<Values>,
}

/// `sinew test direct-load`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test direct-load rig.toml --load 0.1-3N
  sinew test direct-load rig.toml --load 0.1-3N --heating power=0.9,1.2W --rate 0.3mm/s --out loops")]
pub struct DirectLoad {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// Heating levels.
    #[command(flatten)]
    pub direct: Direct,
    /// Between these loads.
    #[arg(long, value_name = "LOW-HIGH N", value_parser = load)]
    pub load: Option<Values>,
}

/// What the direct routines share.
#[derive(Debug, Args)]
pub struct Direct {
    /// What the heater holds, one level after the other: power=0.5,1W, voltage=9V or current=150,200mA.
    #[arg(long, value_name = "WHAT=LEVELS", value_parser = heating)]
    pub heating: Option<Heating>,
    /// Speed of the cross-head.
    #[arg(long, value_name = "mm/s", value_parser = speed)]
    pub rate: Option<f64>,
    /// Cycles at each level.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub cycles: Option<u16>,
    /// Do not make the wire austenite before each level.
    #[arg(long)]
    pub no_reset: bool,
}

/// `sinew test constant-force-sweep`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test constant-force-sweep rig.toml --heating power=0-1.3W --load 1.2N --frequencies 0.02-1Hz
  sinew test constant-force-sweep rig.toml --wave step --frequencies 0.05Hz --cycles 3 --out steps
  sinew test constant-force-sweep --rig bench --channel left --out sweep      under the load that hangs there")]
pub struct ConstantForceSweep {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// Heating.
    #[command(flatten)]
    pub sweep: Sweep,
    /// The load that is held.
    #[arg(long, value_name = "N", value_parser = load)]
    pub load: Option<Values>,
}

/// `sinew test constant-strain-sweep`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test constant-strain-sweep rig.toml --strain 1.5% --frequencies 0.02-1Hz
  sinew test constant-strain-sweep rig.toml --heating current=0-200mA --wave sawtooth --out held")]
pub struct ConstantStrainSweep {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// Heating.
    #[command(flatten)]
    pub sweep: Sweep,
    /// The strain that is held.
    #[arg(long, value_name = "%", value_parser = strain)]
    pub strain: Option<Values>,
}

/// `sinew test break-in`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test break-in rig.toml                                   until it has settled, 150 cycles at most
  sinew test break-in rig.toml --load 1.5N --cycles 60 --strain-within 0.01% --kelvin-within 0.5 --out broken-in
  sinew test break-in rig.toml --truth new-wire.toml             a simulated wire that settles (docs/life.md)

Ends when three cycles in a row are like the one before each, in the strain of the cold and of the hot wire and in the heat at which half
of the way is done, both ways.")]
pub struct BreakIn {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// The load that is held.
    #[arg(long, value_name = "N", value_parser = load)]
    pub load: Option<Values>,
    /// Between which powers the heater goes: power=0-1.3W.
    #[arg(long, value_name = "power=LOW-HIGH", value_parser = heating)]
    pub heating: Option<Heating>,
    /// Cycles a second; without it, so few that all of the wire follows.
    #[arg(long, value_name = "Hz", value_parser = frequencies)]
    pub frequency: Option<Values>,
    /// Cycles at the most.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(4..=1000))]
    pub cycles: Option<u16>,
    /// Strains that differ by no more are the same; without it, 0.005 %, on a running rig 0.04 %.
    #[arg(long, value_name = "%", value_parser = strain)]
    pub strain_within: Option<Values>,
    /// Temperatures that differ by no more are the same, K; without it, 0.1, on a running rig 0.5.
    #[arg(long, value_name = "K", value_parser = positive)]
    pub kelvin_within: Option<f64>,
}

/// What the open-loop sweeps share.
#[derive(Debug, Args)]
pub struct Sweep {
    /// Between which ends the heater goes: power=0-1.3W, voltage=2-9V or current=50-200mA.
    #[arg(long, value_name = "WHAT=LOW-HIGH", value_parser = heating)]
    pub heating: Option<Heating>,
    /// Form of the wave: step, sawtooth or sine.
    #[arg(long, value_name = "FORM", value_parser = shape)]
    pub wave: Option<Shape>,
    /// Frequencies: LOW-HIGH for seven evenly spaced by their logarithms, or a list.
    #[arg(long, value_name = "LOW-HIGHHz", value_parser = frequencies)]
    pub frequencies: Option<Values>,
    /// Periods that count at each frequency.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub cycles: Option<u16>,
}

/// `sinew test position-regulation`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test position-regulation rig.toml --controller pid
  sinew test position-regulation rig.toml --controller sliding_mode_first_order --lambda 4 --places 1,3% --hold 8
  sinew test position-regulation rig.toml --disturb 0.2N@20-25s --out pulled
  sinew test position-regulation --rig bench --channel left --hold 8      by the law of the running driver")]
pub struct PositionRegulation {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// Mass and law.
    #[command(flatten)]
    pub hanging: Hanging,
    /// How long each place is held, s.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub hold: Option<f64>,
    /// Rounds through the places.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub cycles: Option<u16>,
}

/// `sinew test position-tracking`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test position-tracking rig.toml --wave sawtooth --frequency 0.05Hz
  sinew test position-tracking rig.toml --controller pi --places 1,3%")]
pub struct PositionTracking {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// Mass and law.
    #[command(flatten)]
    pub hanging: Hanging,
    /// Form of the wave: step, sawtooth or sine.
    #[arg(long, value_name = "FORM", value_parser = shape)]
    pub wave: Option<Shape>,
    /// Its frequency.
    #[arg(long, value_name = "Hz", value_parser = frequencies)]
    pub frequency: Option<Values>,
    /// Periods that count.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub cycles: Option<u16>,
}

/// `sinew test tracking-sweep`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test tracking-sweep rig.toml --frequencies 0.02-0.5Hz
  sinew test tracking-sweep rig.toml --controller velocity_servo --json")]
pub struct TrackingSweep {
    /// Rig and output.
    #[command(flatten)]
    pub mounted: Mounted,
    /// Mass and law.
    #[command(flatten)]
    pub hanging: Hanging,
    /// Frequencies: LOW-HIGH for seven evenly spaced by their logarithms, or a list.
    #[arg(long, value_name = "LOW-HIGHHz", value_parser = frequencies)]
    pub frequencies: Option<Values>,
    /// Periods that count at each frequency.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub cycles: Option<u16>,
}

/// What the closed loops share: the mass the cross-head plays, and the law that moves it.
#[derive(Debug, Args)]
pub struct Hanging {
    /// Weight that hangs on the wire.
    #[arg(long, value_name = "N", value_parser = load)]
    pub load: Option<Values>,
    /// Mass of it, kg; without it, its weight over g, or more where the machine is too slow for that.
    #[arg(long, value_name = "KG", value_parser = positive)]
    pub mass: Option<f64>,
    /// Damping ratio of the mass on the wire.
    #[arg(long, value_name = "RATIO", value_parser = not_negative)]
    pub damping: Option<f64>,
    /// Places as strains: those it is brought to in turn, or between which the wave goes.
    #[arg(long, value_name = "%,%", value_parser = strain)]
    pub places: Option<Values>,
    /// Power at duty 1: power=4W.
    #[arg(long, value_name = "power=W", value_parser = heating)]
    pub heating: Option<Heating>,
    /// The law, by its word in the rig file; without it, time_optimal.
    #[arg(long, value_name = "LAW", value_parser = law)]
    pub controller: Option<AlgorithmKind>,
    /// The estimator, by its word in the rig file; without it, fused.
    #[arg(long, value_name = "ESTIMATOR", value_parser = estimator)]
    pub estimator: Option<EstimatorKind>,
    /// Bandwidth of the sliding surface, 1/s.
    #[arg(long, value_name = "1/s", value_parser = positive)]
    pub lambda: Option<f64>,
    /// Gains of PI and PID in duty per mm, per mm and s, and s per mm: P,I,D.
    #[arg(long, value_name = "P,I,D", value_parser = gains)]
    pub gains: Option<sinew_control::PidGains>,
    /// Switch power once a period, all or nothing, instead of setting its level.
    #[arg(long)]
    pub switched: bool,
    /// A pull on the mass for a while, counted from when it is let go: 0.2N@20-25s. May be given several times.
    #[arg(long, value_name = "N@FROM-TOs", value_parser = disturbance, allow_negative_numbers = true)]
    pub disturb: Vec<Disturbance>,
}

/// `sinew test characterise`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew test characterise rig.toml --out wire                    wire/fitted.toml, wire/report.html, all recordings
  sinew test characterise belief.toml --truth true.toml --out wire   a simulated wire that the fit has to find out
  sinew test characterise --rig bench --channel left --out wire  a wire of a running driver, on its own load")]
pub struct Characterise {
    /// Where the wire is.
    #[command(flatten)]
    pub wire: TestedWire,
    /// Write the fitted rig file, the recordings and the reports into this folder.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Seed of the fit: same recordings and seed, same answer.
    #[arg(long, value_name = "N", default_value_t = crate::args::SEED)]
    pub seed: u64,
    /// Threads of the fit; without it, as many as there are processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,
    /// The answer as JSON on stdout ("sinew.characterise/1").
    #[arg(long)]
    pub json: bool,
}

/// Numbers as typed: a list, or two ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    /// In SI.
    pub values: Vec<f64>,
    /// Whether they were written as LOW-HIGH.
    pub is_range: bool,
}

/// What the heater is to hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Heating {
    /// Of what.
    pub quantity: Quantity,
    /// How much.
    pub values: Values,
}

/// Numbers with one unit behind them, which each unit turns into SI by its factor; the first unit is the one in examples.
fn values(text: &str, units: &[(&str, f64)], example: &str) -> Result<Values, String> {
    let wrong = || format!("write {example}");
    let text = text.trim();
    // the longest unit first: "mN" is no "N"
    let mut by_length: Vec<&(&str, f64)> = units.iter().collect();
    by_length.sort_by_key(|(unit, _)| std::cmp::Reverse(unit.len()));
    let (numbers, factor) =
        by_length.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, *factor))).ok_or_else(|| {
            let names: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
            format!("lacks its unit ({}): {}", names.join(" or "), wrong())
        })?;
    let is_range = !numbers.contains(',') && numbers.trim_start_matches('-').contains('-');
    let parts: Vec<&str> = if is_range { numbers.splitn(2, '-').collect() } else { numbers.split(',').collect() };
    let values = parts
        .into_iter()
        .map(|part| match part.trim().parse::<f64>() {
            Ok(value) if value.is_finite() && value >= 0.0 => Ok(value * factor),
            _ => Err(format!("`{}` is not a number from 0 up: {}", part.trim(), wrong())),
        })
        .collect::<Result<Vec<f64>, String>>()?;
    if is_range && values[0] > values[1] {
        return Err(format!("goes from high to low: {}", wrong()));
    }
    Ok(Values { values, is_range })
}

fn strain(text: &str) -> Result<Values, String> {
    values(text, &[("%", 0.01)], "a strain such as 0-4% or 1,3%")
}

fn load(text: &str) -> Result<Values, String> {
    values(text, &[("N", 1.0), ("mN", 1e-3)], "a load such as 1.2N or 0-3N")
}

fn frequencies(text: &str) -> Result<Values, String> {
    let found = values(text, &[("Hz", 1.0), ("mHz", 1e-3)], "frequencies such as 0.05-5Hz or 0.1,0.2Hz")?;
    match found.values.iter().all(|hz| (1e-4..=1e3).contains(hz)) {
        true => Ok(found),
        false => Err("frequencies are 0.0001 to 1000 Hz".into()),
    }
}

fn heating(text: &str) -> Result<Heating, String> {
    let wrong = "write power=0.5W, voltage=9V or current=150mA, of a running rig also duty=20%; several levels as 0.5,1W, two ends as 0-1W";
    let (word, rest) = text.split_once('=').ok_or(wrong)?;
    let quantity = Quantity::ALL.into_iter().find(|q| q.word() == word.trim()).ok_or(wrong)?;
    let milli = format!("m{}", quantity.unit());
    let units = [(quantity.unit(), 1.0), (milli.as_str(), 1e-3)];
    let units = if quantity == Quantity::Duty { &[("%", 0.01)][..] } else { &units };
    Ok(Heating { quantity, values: values(rest, units, wrong.trim_start_matches("write "))? })
}

fn shape(text: &str) -> Result<Shape, String> {
    let plain = text.replace(['-', '_'], "");
    Shape::ALL.into_iter().find(|s| s.word() == plain).ok_or_else(|| "write step, sawtooth or sine".into())
}

fn speed(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix("mm/s").ok_or("lacks its unit: write 0.3mm/s")?;
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 5000.0 => Ok(value * 1e-3),
        _ => Err("a speed is more than 0 and at most 5000 mm/s, as in 0.3mm/s".into()),
    }
}

fn celsius(text: &str) -> Result<f64, String> {
    match text.trim_end_matches(['C', '°']).parse::<f64>() {
        Ok(value) if (-200.0..=800.0).contains(&value) => Ok(value),
        _ => Err("a temperature in °C, as in 60C".into()),
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=100.0).contains(&value) => Ok(value),
        _ => Err("a number from 0 to 100".into()),
    }
}

fn gains(text: &str) -> Result<sinew_control::PidGains, String> {
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    match parts.as_deref() {
        Ok(&[p, i, d]) if [p, i, d].iter().all(|gain| (0.0..=1e6).contains(gain)) => Ok(sinew_control::PidGains {
            proportional_per_m: p * 1e3,
            integral_per_m_s: i * 1e3,
            derivative_s_per_m: d * 1e3,
            filter_s: sinew_control::PidGains::FILTER_S,
            tracking_s: sinew_control::PidGains::TRACKING_S,
        }),
        _ => Err("three gains from 0 up, as in 0.5,0.8,0.05".into()),
    }
}

fn law(text: &str) -> Result<AlgorithmKind, String> {
    AlgorithmKind::named(text).ok_or_else(|| {
        let words: Vec<&str> = AlgorithmKind::ALL.iter().map(|kind| kind.word()).collect();
        format!("there are {}", words.join(", "))
    })
}

fn estimator(text: &str) -> Result<EstimatorKind, String> {
    EstimatorKind::named(text).ok_or_else(|| {
        let words: Vec<&str> = EstimatorKind::ALL.iter().map(|kind| kind.word()).collect();
        format!("there are {}", words.join(", "))
    })
}

fn disturbance(text: &str) -> Result<Disturbance, String> {
    let wrong = || "write a pull and when: 0.2N@20-25s".to_string();
    let (pull, when) = text.split_once('@').ok_or_else(wrong)?;
    let (pull, factor) =
        pull.strip_suffix("mN").map(|p| (p, 1e-3)).or(pull.strip_suffix('N').map(|p| (p, 1.0))).ok_or_else(wrong)?;
    let (from, to) = when.trim_end_matches('s').split_once('-').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong);
    let disturbance = Disturbance { start_s: number(from)?, end_s: number(to)?, pull_n: factor * number(pull)? };
    if disturbance.start_s >= 0.0 && disturbance.end_s > disturbance.start_s { Ok(disturbance) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_carry_their_unit_and_are_lists_or_ranges() {
        assert_eq!(strain("0-4%").unwrap(), Values { values: vec![0.0, 0.04], is_range: true });
        assert_eq!(strain("1,3 %").unwrap(), Values { values: vec![0.01, 0.03], is_range: false });
        assert_eq!(load("1500mN").unwrap().values, [1.5]);
        assert!(load("1.5").unwrap_err().contains("lacks its unit"));
        assert!(load("3-1N").unwrap_err().contains("high to low"));
        assert!(load("-1N").is_err() && load("nanN").is_err() && load("N").is_err() && load("1e999N").is_err());
        assert_eq!(frequencies("0.05-5Hz").unwrap().values, [0.05, 5.0]);
        assert!(frequencies("0Hz").is_err());
    }

    #[test]
    fn heating_and_disturbances_are_read_as_written() {
        let found = heating("current=50-200mA").unwrap();
        assert_eq!((found.quantity, found.values.is_range), (Quantity::Current, true));
        assert!((found.values.values[1] - 0.2).abs() < 1e-12);
        assert!(heating("power=1V").unwrap_err().contains("lacks its unit"));
        assert!(heating("heat=1W").is_err());
        let found = heating("duty=0-40%").unwrap();
        assert_eq!((found.quantity, found.values.values), (Quantity::Duty, vec![0.0, 0.4]));
        let found = disturbance("-0.2N@20-25s").unwrap();
        assert_eq!((found.pull_n, found.start_s, found.end_s), (-0.2, 20.0, 25.0));
        assert!(disturbance("0.2N@25-20s").is_err() && disturbance("0.2N").is_err());
        assert_eq!(shape("saw-tooth").unwrap(), Shape::SawTooth);
    }
}
