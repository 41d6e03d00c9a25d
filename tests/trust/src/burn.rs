//! Random histories of a wire: kills, restarts, stalls, failed writes, frozen converters, commands and resets, one upon the other.
//!
//! A wire remembers what a process forgets. Each history runs the driver's engine and a simulated rig on a simulated clock; the rig goes
//! on while the driver is dead, its stage keeps its last duty until its own watchdog acts, and what is judged is the true temperature
//! of the wire, all the time.
//!
//! Histories come from a seed. Every second one tells the driver a rig file that is up to 30 % off.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::Instant;

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use sinew_backend::{Backend, Sample};
use sinew_driver::heat::Recalled;
use sinew_driver::{Ask, Beat, Engine, Order};
use sinew_ipc::{DriverState, Snapshot};
use sinew_rig::{FaultKind, Rig};
use sinew_sim_backend::{SimulatedRig, World};

use crate::failure::Failure;
use crate::kind::{between, whole};

/// Cycles of a history at the most, whatever its rate and length: what is longer is cut.
const MOST_CYCLES: u64 = 60_000;
/// A history heats its wire if that comes above this share of the rise to its limit.
const HEATED: f64 = 0.8;
/// How far beyond its limit a wire may come, K: where the rig file is true, and where it is up to this share off.
pub const PROMISED_K: f64 = 10.0;
/// See there.
pub const PROMISED_OFF_K: f64 = 40.0;
const OFF: f64 = 0.3;

/// What to run.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// How many histories.
    #[arg(long, default_value_t = 300)]
    histories: u64,
    /// Number of the first of them.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Tells what each of them came to.
    #[arg(long)]
    verbose: bool,
    /// Writes every cycle of the last one to this file.
    #[arg(long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
}

/// The kinds of wire: diameter in mm, supply as a multiple of what drives the current its rule allows for ever.
const WIRES: [(f64, f64); 15] = [
    (0.025, 1.3),
    (0.025, 3.0),
    (0.05, 1.3),
    (0.05, 2.0),
    (0.05, 4.0),
    (0.1, 1.3),
    (0.1, 2.0),
    (0.125, 1.5),
    (0.125, 3.0),
    (0.15, 2.0),
    (0.2, 2.0),
    (0.2, 4.0),
    (0.3, 2.0),
    (0.375, 2.0),
    (0.5, 2.0),
];
const RATES_HZ: [f64; 6] = [50.0, 100.0, 250.0, 500.0, 1000.0, 5000.0];
// (the default three times out of six)
const ESTIMATORS: [&str; 6] = ["fused", "fused", "fused", "enthalpy", "luenberger", "luenberger_scheduled"];

/// How a wire is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Taps {
    Separate,
    Shared,
    None,
}

/// What the temperature of a wire is known by, besides the power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Witnesses {
    /// Length by taps and resistance, both weighed by the estimator.
    LengthAndResistance,
    /// Length alone: an estimator that is blind to resistance.
    Length,
    /// Resistance alone, which is taken for the length: no taps.
    Resistance,
}

/// What a history came to.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Its number.
    pub seed: u64,
    /// Whether the rig file was true.
    pub is_true: bool,
    /// What the driver could know its temperature by.
    pub witnesses: Witnesses,
    /// Most the wire was above its limit, K; negative below.
    pub over_k: f64,
    /// Most the published temperature was below the true one, K.
    pub under_k: f64,
    /// Whether the wire was heated above 80 % of its rise.
    pub was_heated: bool,
    /// Starts of the driver.
    pub starts: u32,
    /// Resets that were taken.
    pub resets: u32,
}

impl Outcome {
    /// Whether what is promised of such a history was kept; `None` where nothing is.
    pub fn is_kept(&self) -> Option<bool> {
        let promised_k = if self.is_true { PROMISED_K } else { PROMISED_OFF_K };
        (self.witnesses == Witnesses::LengthAndResistance).then_some(self.over_k <= promised_k)
    }
}

/// Runs the histories; whether what is promised was kept in all of them.
///
/// # Errors
/// A rig file that is refused.
pub fn burn(args: &Args) -> Result<bool, Failure> {
    let started = Instant::now();
    let mut outcomes = Vec::new();
    let end = args.seed.saturating_add(args.histories);
    for seed in args.seed..end {
        let trace = args.trace.as_ref().filter(|_| seed + 1 == end);
        let mut trace = trace.map(File::create).transpose()?.map(BufWriter::new);
        if let Some(trace) = &mut trace {
            writeln!(trace, "time_s,true_c,published_c,excess_k,true_duty,duty,mode,fault,flags,breaks")?;
        }
        let outcome = history(seed, trace.as_mut())?;
        if args.verbose || outcome.is_kept() == Some(false) {
            println!(
                "{} {seed}: {:+.1} K from the limit, {:.1} K under the truth, {} starts, {} resets, {}: {}",
                if outcome.is_kept() == Some(false) { "BURNT" } else { "kept" },
                outcome.over_k,
                outcome.under_k,
                outcome.starts,
                outcome.resets,
                if outcome.is_true { "a true rig file" } else { "beliefs off" },
                Plan::of(seed).words()
            );
        }
        outcomes.push(outcome);
    }
    for (what, witnesses) in [
        ("length and resistance", Witnesses::LengthAndResistance),
        ("blind to resistance", Witnesses::Length),
        ("no taps", Witnesses::Resistance),
    ] {
        for (beliefs, is_true) in [("true", true), ("30 % off", false)] {
            let group = || outcomes.iter().filter(|one| one.is_true == is_true && one.witnesses == witnesses);
            let worst = |of: fn(&Outcome) -> f64| group().map(of).fold(f64::NEG_INFINITY, f64::max);
            println!(
                "{what:<22} beliefs {beliefs:<9} {:>5} histories, {:>3.0} % heated; at worst {:+6.1} K from the limit, \
                 published {:5.1} K under the truth",
                group().count(),
                100.0 * group().filter(|one| one.was_heated).count() as f64 / group().count().max(1) as f64,
                worst(|one| one.over_k),
                worst(|one| one.under_k),
            );
        }
    }
    println!("{:.0} s", started.elapsed().as_secs_f64());
    Ok(outcomes.iter().all(|one| one.is_kept() != Some(false)))
}

/// The rig of a history, drawn from its seed.
struct Plan {
    diameter_mm: f64,
    supply_share: f64,
    rate_hz: f64,
    taps: Taps,
    estimator: &'static str,
    is_true: bool,
    rng: Xoshiro256PlusPlus,
}

impl Plan {
    fn of(seed: u64) -> Plan {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (diameter_mm, supply_share) = WIRES[rng.random_range(0..WIRES.len())];
        Plan {
            diameter_mm,
            supply_share,
            rate_hz: RATES_HZ[rng.random_range(0..RATES_HZ.len())],
            taps: [Taps::Separate, Taps::Shared, Taps::Separate, Taps::None][rng.random_range(0..4)],
            estimator: ESTIMATORS[rng.random_range(0..ESTIMATORS.len())],
            is_true: seed.is_multiple_of(2),
            rng,
        }
    }

    fn words(&self) -> String {
        let Plan { diameter_mm, supply_share, rate_hz, taps, estimator, .. } = self;
        format!("{diameter_mm} mm, {supply_share} times the rule's current, {rate_hz} Hz, {taps:?} taps, {estimator}")
    }

    fn text(&self, supply_v: f64) -> String {
        let (area, taps) = (self.diameter_mm * self.diameter_mm, self.taps);
        format!(
            "[rig]\nname = \"burn\"\nrate_hz = {:?}\n\n[[channel]]\nname = \"wire\"\n\
             wire = {{ diameter_mm = {:?}, length_mm = 160.0 }}\n{}\
             drive = {{ supply_v = {supply_v:?}, shunt_ohm = {:?}, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = {:?}, damping_n_s_per_m = {:?}, spring_n_per_m = {:?}, preload_n = {:?} }}\n\
             control = {{ estimator = \"{}\"{} }}\n{}",
            self.rate_hz,
            self.diameter_mm,
            if taps == Taps::None { "" } else { "taps = { l0_mm = 0.0, ls_mm = 150.0 }\n" },
            0.004 / area,
            5.0 * area,
            2000.0 * area,
            10_000.0 * area,
            150.0 * area,
            self.estimator,
            if taps == Taps::None { ", sensing = \"resistance\"" } else { "" },
            if taps == Taps::Shared { "adc = { circuit = \"shared\" }\n" } else { "" },
        )
    }

    /// The rig file the driver gets, and the rig it drives.
    fn rigs(&mut self) -> Result<(Rig, Rig), Failure> {
        let parse = |text: &str| {
            Rig::parse(text, "burn.toml").map_err(|e| Failure::Unexpected(format!("the rig is refused: {e}\n{text}")))
        };
        // What supply drives the current that the rule allows, through the wire when it is hot.
        let first = parse(&self.text(10.0))?;
        let (model, limits) = (&first.channels[0].model, &first.channels[0].limits);
        let m = &model.material;
        let hot_ohm =
            m.austenite_resistivity(m.austenite_temperature_c) * model.geometry.length_m / model.geometry.area_m2();
        let supply_v = self.supply_share * limits.continuous_current_a * (hot_ohm + model.drive.series_ohm());
        let believed = parse(&self.text((supply_v * 100.0).round() / 100.0))?;
        let mut truth = believed.clone();
        truth.simulation.seed = self.rng.random::<u32>().into();
        if !self.is_true {
            let material = &mut truth.channels[0].model.material;
            let rng = &mut self.rng;
            for value in [
                &mut material.specific_heat_j_per_kg_k,
                &mut material.latent_heat_j_per_kg,
                &mut material.convection_w_per_m2_k,
            ] {
                *value *= between(rng, 1.0 - OFF, 1.0 + OFF);
            }
        }
        Ok((believed, truth))
    }
}

/// The driver while it lives, and what it leaves when it does not.
struct Driver {
    engine: Engine,
    duty: [f64; 1],
    snapshot: Box<Snapshot>,
}

/// A record as the driver keeps it.
#[derive(Clone, Copy)]
struct Record {
    recalled: Recalled,
    at_s: f64,
}

/// One history, every cycle of it into `trace`.
///
/// # Errors
/// A rig file that is refused.
pub fn history(seed: u64, mut trace: Option<&mut BufWriter<File>>) -> Result<Outcome, Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::Unexpected(format!("history {seed}: {error}"));
    let mut plan = Plan::of(seed);
    let (believed, truth) = plan.rigs()?;
    let mut wires = SimulatedRig::new(&truth).map_err(|e| wrong(&e))?;
    wires.start().map_err(|e| wrong(&e))?;
    let (limit_c, ambient_c) = (believed.channels[0].limits.max_temperature_c, believed.channels[0].model.ambient_c);
    let rate_hz = believed.rate_hz;
    let rng = &mut plan.rng;
    let cycles = ((between(rng, 10.0, 120.0) * rate_hz) as u64).min(MOST_CYCLES);
    // How often things happen, a second: from a quiet hour to a day on which nothing works.
    let (mischief, kills, stalls) = (between(rng, 0.0, 0.5), between(rng, 0.0, 0.5), between(rng, 0.0, 3.0));
    let eager = rng.random::<bool>();
    let forgetful = between(rng, 0.0, 1.0);
    let happens = |rng: &mut Xoshiro256PlusPlus, a_second: f64| rng.random::<f64>() * rate_hz < a_second;

    let mut driver: Option<Driver> = None;
    let mut record: Option<Record> = None;
    let mut mends_at_s: Vec<(FaultKind, f64)> = Vec::new();
    let mut outcome = Outcome {
        seed,
        is_true: plan.is_true,
        witnesses: match (plan.taps, plan.estimator) {
            (Taps::None, _) => Witnesses::Resistance,
            (_, "fused") => Witnesses::LengthAndResistance,
            _ => Witnesses::Length,
        },
        over_k: f64::NEG_INFINITY,
        under_k: f64::NEG_INFINITY,
        was_heated: false,
        starts: 0,
        resets: 0,
    };
    let mut samples = [Sample::NONE];
    let mut tickets = 0;
    let true_c = |wires: &SimulatedRig| wires.truth(0).map_or(f64::NAN, |truth| truth.temperature_c);
    let mut watch = |wires: &SimulatedRig| {
        let over_k = true_c(wires) - limit_c;
        outcome.over_k = outcome.over_k.max(over_k);
        outcome.was_heated |= over_k > (HEATED - 1.0) * (limit_c - ambient_c);
    };
    let (mut starts, mut resets, mut under_k) = (0, 0, f64::NEG_INFINITY);

    let mut done = 0;
    while done < cycles {
        let now_s = wires.time_s();
        mends_at_s.retain(|(kind, at_s)| {
            let lasts = *at_s > now_s;
            if !lasts {
                wires.faults().clear(0, *kind);
            }
            lasts
        });
        let Some(alive) = &mut driver else {
            // Nobody is there for some time; then the next one comes, if its stage can be put to zero.
            let pause_s = if rng.random::<bool>() { between(rng, 0.0, 0.3) } else { between(rng, 0.0, 10.0) };
            let pause = (pause_s * rate_hz) as u64;
            for _ in 0..pause {
                wires.missed(1);
                watch(&wires);
            }
            done += pause + 1;
            wires.missed(1);
            if wires.start().is_ok() {
                let mut engine = Engine::new(&believed, None).map_err(|e| wrong(&e))?;
                engine.bear_silence(wires.silence_s().unwrap_or(f64::NAN));
                if let Some(record) = record.filter(|_| rng.random::<f64>() > forgetful) {
                    let since_s = wires.time_s() - record.at_s;
                    engine.recall(0, &Recalled { since_s, ..record.recalled });
                }
                driver = Some(Driver { engine, duty: [0.0], snapshot: Box::new(Snapshot::new(1)) });
                starts += 1;
            }
            continue;
        };

        // The world, the stage, the converter.
        if happens(rng, mischief) {
            let kind = [
                FaultKind::WriteFails,
                FaultKind::AdcStuck,
                FaultKind::AdcNan,
                FaultKind::Jammed,
                FaultKind::SupplyDip,
                FaultKind::BackendError,
            ][rng.random_range(0..6)];
            wires.faults().set(0, kind);
            mends_at_s.push((kind, now_s + between(rng, 0.01, 3.0)));
        }
        if happens(rng, 0.5 * mischief) {
            let draught = if rng.random::<bool>() { between(rng, 0.0, 1.0) } else { 0.0 };
            wires.disturb(0, &World { draught, ..World::CALM });
        }
        // Commands and resets, by several clients at once.
        let mut ask = |engine: &mut Engine, ask: Ask| {
            tickets += 1;
            let now_ns = (now_s * 1e9) as u64 + 1_000_000_000;
            engine.take(&Order { ticket: tickets, channel: 0, ask, hold_ns: 60_000_000_000 }, now_ns)
        };
        let range = alive.engine.channels()[0].stroke_range();
        if done == 0 || happens(rng, 2.0) || (eager && happens(rng, 20.0)) {
            let asked = match whole(rng, 0, 5) {
                0 => Ask::Off,
                1 => Ask::Length(range.length_m(between(rng, 0.0, 1.0))),
                2 => Ask::Length(range.hot_m),
                3 => Ask::Duty(between(rng, 0.0, 1.0)),
                _ => Ask::Duty(believed.channels[0].limits.max_duty),
            };
            ask(&mut alive.engine, asked);
        }
        if alive.snapshot.channel[0].fault().is_some() && (eager || happens(rng, 2.0)) {
            resets += u32::from(ask(&mut alive.engine, Ask::Reset).is_none());
        }

        // A cycle, late or not; or the last one.
        let late = if happens(rng, stalls) {
            let longest_s = if rng.random_range(0..10) == 0 { 5.0 } else { 0.249 };
            (between(rng, 0.001, longest_s) * rate_hz) as u64
        } else {
            0
        };
        for _ in 0..late {
            wires.missed(1);
            watch(&wires);
        }
        let exchanged = wires.exchange(&alive.duty, &mut samples);
        watch(&wires);
        alive.engine.note_outputs(&wires);
        let now_s = wires.time_s();
        let beat = Beat { now_ns: (now_s * 1e9) as u64 + 1_000_000_000, missed: late };
        if happens(rng, kills) {
            // Killed between its exchange and the rest of its cycle.
            driver = None;
        } else {
            alive.engine.cycle(beat, exchanged, &samples, &mut alive.duty, |_| {});
            if alive.engine.must_cut() {
                wires.cut();
            }
            alive.engine.describe(beat.now_ns, DriverState::Running, &mut alive.snapshot);
            let channel = &alive.engine.channels()[0];
            let (temperature_c, account_j) = (channel.heat().temperature_c(), channel.heat().account_j());
            let recalled = Recalled { temperature_c, account_j, given_w: channel.most_given_w(), since_s: 0.0 };
            record = Some(Record { recalled, at_s: now_s });
            under_k = under_k.max(true_c(&wires) - alive.snapshot.channel[0].temperature_c);
            if let Some(trace) = &mut trace {
                let state = &alive.snapshot.channel[0];
                let breaks: Vec<&str> = mends_at_s.iter().map(|(kind, _)| kind.word()).collect();
                writeln!(
                    trace,
                    "{now_s:.4},{:.2},{:.2},{:.2},{:.4},{:.4},{:?},{},{},{}",
                    true_c(&wires),
                    state.temperature_c,
                    channel.heat().excess_k(),
                    wires.truth(0).map_or(f64::NAN, |truth| truth.duty),
                    state.duty,
                    state.mode(),
                    state.fault().map_or("", |fault| fault.flag()),
                    state.flags,
                    breaks.join(" ")
                )?;
            }
        }
        done += 1 + late;
    }
    (outcome.starts, outcome.resets, outcome.under_k) = (starts, resets, under_k);
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_wire_burns_in_three_hundred_histories() {
        let outcomes: Vec<Outcome> = (1..=300).map(|seed| history(seed, None).unwrap()).collect();
        let burnt: Vec<&Outcome> = outcomes.iter().filter(|one| one.is_kept() == Some(false)).collect();
        assert!(burnt.is_empty(), "{burnt:#?}");
        // And they are histories that could have burnt one.
        let count = |which: fn(&Outcome) -> bool| outcomes.iter().filter(|one| which(one)).count();
        assert!(count(|one| one.was_heated) > 150, "{}", count(|one| one.was_heated));
        assert!(count(|one| one.starts > 3) > 150 && count(|one| one.resets > 3) > 150);
    }
}
