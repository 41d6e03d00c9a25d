//! Random histories of a wire: kills, restarts, stalls, failed writes, frozen converters, commands and resets, one upon the other.
//!
//! A wire remembers what a process forgets. Each history runs the driver's engine and a simulated rig on a simulated clock, by a script
//! (`script.rs`) that is drawn first; what is judged is the true temperature of the wire, all the time (`run.rs`). Half of the scripts are
//! searched for: varied again and again, each time the hotter one kept. One that burns its wire is cut down to what it takes.
//!
//! Histories come from a seed. Every second one tells the driver a rig file that is up to 30 % off. All rigs have a watchdog relay before their
//! stages, which matters where a stage is stuck: a dead driver cannot cut it off.

mod rig;
mod run;
mod script;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::time::Instant;

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use crate::failure::Failure;
use rig::{Plan, Witnesses};
use run::{Outcome, run};
use script::Script;

/// Runs that cutting a script down may take.
const SHRINKING_RUNS: u32 = 400;

/// What to run.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// How many histories.
    #[arg(long, default_value_t = 300)]
    histories: u64,
    /// Number of the first of them.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Scripts tried for each history that is searched for, which is every second one.
    #[arg(long, default_value_t = 12, value_name = "SCRIPTS")]
    search: u32,
    /// Tells what each of them came to.
    #[arg(long)]
    verbose: bool,
    /// Writes every cycle of the last one to this file.
    #[arg(long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
}

/// A history as it was found: by chance, or by a search of so many scripts.
struct History {
    seed: u64,
    script: Script,
    outcome: Outcome,
    runs: u64,
}

impl History {
    /// Whether the script of a seed is searched for.
    fn is_searched(seed: u64) -> bool {
        (seed / 2).is_multiple_of(2)
    }

    /// Whether its power stage sticks at some moment.
    fn is_stuck(seed: u64) -> bool {
        matches!(seed % 10, 7 | 8)
    }

    fn of(seed: u64, search: u32) -> Result<History, Failure> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5eed_0f5c_2197_a1b7);
        let rate_hz = Plan::of(seed).rate_hz;
        let script = Script::by_chance(&mut rng, rate_hz, History::is_stuck(seed));
        let outcome = run(seed, &script, None)?;
        let mut history = History { seed, script, outcome, runs: 1 };
        for _ in 1..if History::is_searched(seed) { search } else { 1 } {
            let script = history.script.varied(&mut rng, rate_hz);
            let outcome = run(seed, &script, None)?;
            history.runs += 1;
            if outcome.over_k > history.outcome.over_k {
                (history.script, history.outcome) = (script, outcome);
            }
        }
        Ok(history)
    }

    /// The same, cut down to the moments it takes to burn the wire.
    fn shrunk(&self) -> Result<Script, Failure> {
        let mut script = self.script.clone();
        let mut runs = 0;
        let mut chunk = script.moments.len().div_ceil(2).max(1);
        loop {
            let mut at = 0;
            let mut is_shorter = false;
            while at < script.moments.len() && runs < SHRINKING_RUNS {
                let mut shorter = script.clone();
                shorter.moments.drain(at..(at + chunk).min(script.moments.len()));
                runs += 1;
                if run(self.seed, &shorter, None)?.is_kept() == Some(false) {
                    (script, is_shorter) = (shorter, true);
                } else {
                    at += chunk;
                }
            }
            if runs >= SHRINKING_RUNS || (chunk == 1 && !is_shorter) {
                return Ok(script);
            }
            chunk = (chunk / 2).max(1);
        }
    }

    fn tell(&self) {
        let Outcome { over_k, under_k, starts, resets, is_true, .. } = self.outcome;
        println!(
            "{} {}: {over_k:+.1} K from the limit, {under_k:.1} K under the truth, {starts} starts, {resets} resets, {}, {}: {}",
            if self.outcome.is_kept() == Some(false) { "BURNT" } else { "kept" },
            self.seed,
            if History::is_searched(self.seed) { "searched for" } else { "by chance" },
            if is_true { "a true rig file" } else { "beliefs off" },
            Plan::of(self.seed).words()
        );
    }
}

/// Runs the histories; whether what is promised was kept in all of them.
///
/// # Errors
/// A rig file that is refused.
pub fn burn(args: &Args) -> Result<bool, Failure> {
    let started = Instant::now();
    let mut histories = Vec::new();
    let mut runs = 0;
    let end = args.seed.saturating_add(args.histories);
    for seed in args.seed..end {
        let history = History::of(seed, args.search)?;
        runs += history.runs;
        let is_burnt = history.outcome.is_kept() == Some(false);
        if args.verbose || is_burnt {
            history.tell();
        }
        let mut script = history.script.clone();
        if is_burnt {
            script = history.shrunk()?;
            println!(
                "  of {} moments it takes{}:",
                history.script.moments.len(),
                if script.is_eager { ", and resets as fast as allowed" } else { "" }
            );
            script.moments.iter().for_each(|moment| println!("  {moment}"));
        }
        if let Some(path) = args.trace.as_ref().filter(|_| seed + 1 == end) {
            let mut trace = BufWriter::new(File::create(path)?);
            writeln!(trace, "time_s,true_c,published_c,excess_k,true_duty,duty,mode,fault,flags,breaks")?;
            run(seed, &script, Some(&mut trace))?;
        }
        histories.push(history);
    }
    for (what, belongs) in groups() {
        for (beliefs, is_true) in [("true", true), ("30 % off", false)] {
            let group = || histories.iter().map(|one| one.outcome).filter(|one| one.is_true == is_true && belongs(one));
            let worst = |of: fn(&Outcome) -> f64| group().map(|one| of(&one)).fold(f64::NEG_INFINITY, f64::max);
            println!(
                "{what:<22} beliefs {beliefs:<9} {:>5} histories, {:>3.0} % heated; at worst {:+6.1} K from the limit ({:.1} periods \
                 of full power), published {:5.1} K under the truth; {} broken",
                group().count(),
                100.0 * group().filter(|one| one.was_heated).count() as f64 / group().count().max(1) as f64,
                worst(|one| one.over_k),
                worst(|one| one.over_periods),
                worst(|one| one.under_k),
                group().filter(|one| one.is_kept() == Some(false)).count(),
            );
        }
    }
    println!("{runs} scripts in {:.0} s", started.elapsed().as_secs_f64());
    Ok(histories.iter().all(|one| one.outcome.is_kept() != Some(false)))
}

/// A row of the table: its name, and which histories belong to it.
type Group = (&'static str, fn(&Outcome) -> bool);

/// The rows of the table.
fn groups() -> [Group; 4] {
    [
        ("length and resistance", |one| one.witnesses == Witnesses::LengthAndResistance && !one.was_stuck),
        ("blind to resistance", |one| one.witnesses == Witnesses::Length && !one.was_stuck),
        ("no taps", |one| one.witnesses == Witnesses::Resistance && !one.was_stuck),
        ("stage stuck on", |one| one.was_stuck),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_wire_burns_in_three_hundred_histories() {
        let histories: Vec<History> = (1..=300).map(|seed| History::of(seed, 4).unwrap()).collect();
        let burnt: Vec<&History> = histories.iter().filter(|one| one.outcome.is_kept() == Some(false)).collect();
        burnt.iter().for_each(|one| one.tell());
        assert!(burnt.is_empty(), "{} of 300: `sinew-trust burn --search 4` tells what it takes", burnt.len());
        // And they are histories that could have burnt one.
        let count = |which: fn(&Outcome) -> bool| histories.iter().filter(|one| which(&one.outcome)).count();
        assert!(count(|one| one.was_heated) > 100, "{}", count(|one| one.was_heated));
        let (starts, resets) = (count(|one| one.starts > 3), count(|one| one.resets > 3));
        assert!(starts > 100 && resets > 100, "{starts} {resets}");
    }
}
