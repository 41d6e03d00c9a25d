//! Random histories of a wire: kills, restarts, stalls, failed writes, lost lines, frozen converters, commands and resets, one upon the other.
//!
//! A wire remembers what a process forgets. Each history runs the driver's engine and a simulated rig on a simulated clock, by a script
//! (`script.rs`) that is drawn first; what is judged is the true temperature of the wire, all the time (`run.rs`). Most of what happens does so
//! when the wire is hot. Half of the scripts are searched for: several are drawn, and the hotter ones varied again and again before their
//! hottest moment. One that burns its wire is cut down to what it takes.
//!
//! Histories come from a seed. Every second one tells the driver a rig file that is up to 30 % off. All rigs whose stage sticks have
//! a watchdog relay before it: a dead driver cannot cut it off. Most of the others are struck by one thing at the worst moment (`script.rs`).

mod rig;
mod run;
mod script;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::num::NonZero;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use crate::failure::Failure;
use rig::{Plan, Rigs, Witnesses};
use run::{Outcome, Stage, run};
use script::{Aim, Script, Sticks};

/// Runs that cutting a script down may take.
const SHRINKING_RUNS: u32 = 400;
/// Scripts of a search that are drawn by chance, as a share of all, and how many of the hottest are gone on from.
const DRAWN: u32 = 4;
const KEPT: usize = 3;
/// A rig is drawn again at the most so often; and its wire is waited for no longer than this, s.
const MOST_DRAWS: u64 = 20;
const MOST_WARMING_S: f64 = 60.0;

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
    #[arg(long, default_value_t = 24, value_name = "SCRIPTS")]
    search: u32,
    /// Histories at the same time; all cores where it is not given.
    #[arg(long)]
    jobs: Option<NonZero<usize>>,
    /// Every wire in a sleeve that its rig file states (`thermal.sheath`), of twice its own heat capacity.
    #[arg(long)]
    sleeve: bool,
    /// Ends with the first history that burns its wire.
    #[arg(long)]
    until_burnt: bool,
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
    plan: Plan,
    rigs: Rigs,
    script: Script,
    outcome: Outcome,
    /// How often its rig was drawn again, because full power alone does not make that one's wire hot.
    again: u64,
    runs: u64,
}

/// What is kept of it.
#[derive(Debug, Clone, Copy)]
struct Found {
    seed: u64,
    outcome: Outcome,
    again: u64,
    takes_jam: bool,
    runs: u64,
}

impl History {
    /// Whether the script of a seed is searched for.
    fn is_searched(seed: u64) -> bool {
        (seed / 2 + seed / 20).is_multiple_of(2)
    }

    /// Whether its power stage sticks at some moment, and what of the rest is left then.
    fn sticks(seed: u64) -> Option<Sticks> {
        match (seed % 20, seed / 20 % 3) {
            (7 | 8, _) => Some(Sticks::Watched),
            (17 | 18, 0) => Some(Sticks::Anyhow),
            (17 | 18, 1) => Some(Sticks::Stopped),
            (17 | 18, _) => Some(Sticks::Abandoned),
            _ => None,
        }
    }

    fn of(seed: u64, search: u32, in_sleeve: bool) -> Result<History, Failure> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5eed_0f5c_2197_a1b7);
        let mut aims = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0xa1b3_77de_0c41_5e29);
        let (aim, sticks) = (Aim::by_chance(&mut aims, seed.is_multiple_of(2)), History::sticks(seed));
        let (mut again, mut runs) = (0, 0);
        let (plan, rigs, warm_s) = loop {
            let plan = Plan::of(seed, again).in_sleeve(in_sleeve);
            let plan = match sticks {
                Some(how) => plan.with_switch(how == Sticks::Stopped),
                None if aim.needs_silence() => plan.bare(),
                None => plan.quick(aim == Aim::Turns),
            };
            let rigs = plan.clone().rigs()?;
            let calm = run(&rigs, &Script::calm(plan.rate_hz), None)?;
            runs += 1;
            if calm.was_heated() || again == MOST_DRAWS {
                let warm_s = calm.heated_s.clamp(2.0 / plan.rate_hz, MOST_WARMING_S);
                break (plan, rigs, warm_s);
            }
            again += 1;
        };
        let rate_hz = plan.rate_hz;
        let (drawn, all) = if History::is_searched(seed) { ((search / DRAWN).max(1), search.max(1)) } else { (1, 1) };
        let mut hottest: Vec<(Script, Outcome)> = Vec::new();
        let (mut number, mut is_early) = (0, true);
        while number < all {
            let script = if number < drawn {
                let early = is_early && rng.random_range(0..4) == 0;
                Script::by_chance(&mut rng, rate_hz, warm_s, early, sticks).aimed(&mut aims, aim, rate_hz, warm_s)
            } else {
                let place = rng.random_range(0..2 * hottest.len());
                let (script, outcome) = &hottest[if place < hottest.len() { place } else { 0 }];
                let (other, others) = &hottest[rng.random_range(0..hottest.len())];
                script.varied(&mut rng, rate_hz, warm_s, outcome.hottest_s, (other, others.hottest_s))
            };
            let outcome = run(&rigs, &script, None)?;
            runs += 1;
            // What came too early to let the wire get hot shows nothing.
            if !outcome.was_heated() && is_early {
                is_early = false;
                continue;
            }
            number += 1;
            let place = hottest.partition_point(|(_, other)| other.over_k >= outcome.over_k);
            hottest.insert(place, (script, outcome));
            hottest.truncate(KEPT);
        }
        let (script, outcome) = hottest.swap_remove(0);
        Ok(History { seed, plan, rigs, script, outcome, again, runs })
    }

    fn is_burnt(&self) -> bool {
        self.outcome.is_kept() == Some(false)
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
                if run(&self.rigs, &shorter, None)?.is_kept() == Some(false) {
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

    /// Whether it takes a jammed load to burn the wire.
    fn takes_jam(&self) -> Result<bool, Failure> {
        Ok(self.is_burnt() && run(&self.rigs, &self.script.without_jams(), None)?.is_kept() != Some(false))
    }

    fn tell(&self) {
        let Outcome { over_k, under_k, under_s, under_at_k, hottest_s, starts, resets, is_true, .. } = self.outcome;
        println!(
            "{} {}: {over_k:+.1} K from the limit at {hottest_s:.4} s, {under_k:.1} K under the truth ({under_at_k:+.1} K at {under_s:.4} s), \
             {starts} starts, {resets} resets, {}, {}, {}: {}",
            if self.is_burnt() { "BURNT" } else { "kept" },
            self.seed,
            if History::is_searched(self.seed) { "searched for" } else { "by chance" },
            if is_true { "a true rig file" } else { "beliefs off" },
            self.outcome.stage.words(),
            self.plan.words()
        );
    }

    /// What it takes, in words.
    fn tell_script(&self, script: &Script) {
        let looks = match script.looks_every_s {
            0.0 => "as fast as allowed".to_string(),
            every_s => format!("every {every_s:.3} s"),
        };
        println!("  of {} moments it takes these, and an operator who looks {looks}:", self.script.moments.len());
        script.moments.iter().for_each(|moment| println!("  {moment}"));
        if let Some(sticking) = script.sticks {
            println!("  {:9.4} s  the stage sticks", sticking.at_s);
        }
    }
}

/// Runs the histories of these seeds, so many at the same time; `each` sees every one and says whether to go on.
fn all(
    seeds: Range<u64>,
    search: u32,
    in_sleeve: bool,
    jobs: usize,
    each: impl Fn(&History) -> Result<bool, Failure> + Sync,
) -> Result<Vec<Found>, Failure> {
    let (next, is_over) = (AtomicU64::new(seeds.start), AtomicBool::new(false));
    let found = Mutex::new(Ok(Vec::new()));
    let work = || {
        while !is_over.load(Ordering::Relaxed) {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                break;
            }
            let result = History::of(seed, search, in_sleeve).and_then(|history| {
                if !each(&history)? {
                    is_over.store(true, Ordering::Relaxed);
                }
                let takes_jam = history.takes_jam()?;
                let History { seed, outcome, again, runs, .. } = history;
                Ok(Found { seed, outcome, again, takes_jam, runs })
            });
            let mut found = found.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            match (result, &mut *found) {
                (Ok(one), Ok(all)) => all.push(one),
                (Err(failure), _) => {
                    is_over.store(true, Ordering::Relaxed);
                    *found = Err(failure);
                }
                (Ok(_), Err(_)) => {}
            }
        }
    };
    thread::scope(|scope| (0..jobs).for_each(|_| drop(scope.spawn(work))));
    found.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// As many as there are cores.
fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}

/// Runs the histories; whether what is promised was kept in all of them.
///
/// # Errors
/// A rig file that is refused.
pub fn burn(args: &Args) -> Result<bool, Failure> {
    let started = Instant::now();
    let end = args.seed.saturating_add(args.histories);
    let each = |history: &History| {
        let is_burnt = history.is_burnt();
        let script = if is_burnt { history.shrunk()? } else { history.script.clone() };
        if args.verbose || is_burnt {
            history.tell();
        }
        if is_burnt {
            history.tell_script(&script);
        }
        if let Some(path) = args.trace.as_ref().filter(|_| history.seed + 1 == end) {
            let mut trace = BufWriter::new(File::create(path)?);
            writeln!(trace, "time_s,true_c,published_c,excess_k,true_duty,duty,mode,fault,flags,breaks")?;
            run(&history.rigs, &script, Some(&mut trace))?;
        }
        Ok(!(args.until_burnt && is_burnt))
    };
    let found = all(args.seed..end, args.search, args.sleeve, args.jobs.map_or_else(cores, NonZero::get), each)?;
    println!(
        "| the driver knows its wire by | beliefs | histories | heated | worst above the limit (periods of full power) | promised | broken (by a jam) | published under the truth |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|");
    for (what, belongs) in groups() {
        for (beliefs, is_true) in [("true", true), ("up to 30 % off", false)] {
            let group: Vec<&Found> =
                found.iter().filter(|one| one.outcome.is_true == is_true && belongs(&one.outcome)).collect();
            if group.is_empty() {
                continue;
            }
            let count = |of: fn(&Found) -> bool| group.iter().filter(|one| of(one)).count();
            let worst =
                |of: fn(&Outcome) -> f64| group.iter().map(|one| of(&one.outcome)).fold(f64::NEG_INFINITY, f64::max);
            println!(
                "| {what} | {beliefs} | {} | {:.0} % | {:+.1} K ({:+.1}) | {} | {} ({}) | {:.1} K |",
                group.len(),
                100.0 * count(|one| one.outcome.was_heated()) as f64 / group.len() as f64,
                worst(|one| one.over_k),
                worst(|one| one.over_k / one.full_power_k),
                group[0].outcome.promised().unwrap_or("–"),
                count(|one| one.outcome.is_kept() == Some(false)),
                count(|one| one.takes_jam),
                worst(|one| one.under_k),
            );
        }
    }
    let runs: u64 = found.iter().map(|one| one.runs).sum();
    let again: u64 = found.iter().map(|one| one.again).sum();
    println!(
        "{} histories ({again} rigs drawn again, whose wire full power does not make hot), {runs} scripts in {:.0} s",
        found.len(),
        started.elapsed().as_secs_f64()
    );
    let burnt = found.iter().filter(|one| one.outcome.is_kept() == Some(false));
    if let Some(first) = burnt.map(|one| one.seed).min() {
        println!("the first that burns its wire: number {first}");
        return Ok(false);
    }
    Ok(true)
}

/// A row of the table: its name, and which histories belong to it.
type Group = (&'static str, fn(&Outcome) -> bool);

/// The rows of the table.
fn groups() -> [Group; 8] {
    [
        ("length and resistance", |one| one.witnesses == Witnesses::LengthAndResistance && one.stage == Stage::Healthy),
        ("length (an estimator blind to resistance)", |one| {
            one.witnesses == Witnesses::Length && one.stage == Stage::Healthy
        }),
        ("resistance (no taps)", |one| one.witnesses == Witnesses::Resistance && one.stage == Stage::Healthy),
        ("length and resistance; stage stuck on, watched", |one| {
            one.witnesses == Witnesses::LengthAndResistance && one.stage == Stage::StuckWatched
        }),
        ("length and resistance; stage stuck on, converter silent, emergency stop pressed", |one| {
            one.witnesses == Witnesses::LengthAndResistance && one.stage == Stage::StuckStopped
        }),
        ("length and resistance; stage stuck on, driver killed at that", |one| {
            one.witnesses == Witnesses::LengthAndResistance && one.stage == Stage::StuckAbandoned
        }),
        ("one of them; stage stuck on, any of these three", |one| {
            one.witnesses != Witnesses::LengthAndResistance && !matches!(one.stage, Stage::Healthy | Stage::Stuck)
        }),
        ("any; stage stuck on, and anything else", |one| one.stage == Stage::Stuck),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_wire_burns_in_three_hundred_histories() {
        let burnt = Mutex::new(Vec::new());
        let each = |history: &History| {
            if history.is_burnt() {
                history.tell();
                burnt.lock().unwrap().push(history.seed);
            }
            Ok(true)
        };
        let found = all(1..301, 8, false, cores(), each).unwrap();
        let burnt = burnt.into_inner().unwrap();
        assert!(burnt.is_empty(), "{burnt:?}: `sinew-trust burn --search 8` tells what it takes");
        // And they are histories that could have burnt one.
        let count = |which: fn(&Outcome) -> bool| found.iter().filter(|one| which(&one.outcome)).count();
        let heated = count(Outcome::was_heated);
        assert!(100 * heated >= 97 * found.len(), "{heated}");
        let (starts, resets) = (count(|one| one.starts > 3), count(|one| one.resets > 3));
        assert!(starts > 30 && resets > 100, "{starts} {resets}");
    }
}
