//! Whether an answer depends on what it must not depend on: the order of the recordings, which blocks are kept back, the
//! number of threads.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::PathBuf;

use sinew_diagnosis::{Diagnosis, Settings, Verdict, diagnose};
use sinew_recording::Recording;
use sinew_rig::Rig;

use crate::diagnose_case::read;
use crate::failure::Failure;
use crate::holdout;

/// Two answers are the same if their shares differ by no more than this, either way.
const SHARE_BAND: f64 = 0.1;
/// And their errors by no more than this part, either way.
const ERROR_BAND: f64 = 0.05;

/// What to arrange.
#[derive(Debug, clap::Args)]
pub struct Order {
    /// The rig file
    #[arg(value_name = "RIG.toml")]
    rig: PathBuf,
    /// Recordings to fit together, in every order (of more than three: every rotation)
    #[arg(value_name = "RECORDING", required = true)]
    recordings: Vec<PathBuf>,
    /// A recording that is only judged by; then no blocks are kept back, and their phase is not varied
    #[arg(long, value_name = "RECORDING")]
    holdout: Vec<PathBuf>,
    /// Numbers of threads; the first is used for every arrangement, the others for the first arrangement
    #[arg(long, value_name = "N,…", value_delimiter = ',', default_values_t = [2, 1])]
    threads: Vec<usize>,
}

/// One way to put the same question.
#[derive(Debug, Clone, PartialEq)]
struct Arrangement {
    /// Positions of the recordings as they were named.
    order: Vec<usize>,
    seed: u64,
    threads: usize,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
struct Came {
    arrangement: Arrangement,
    /// The first effect, else the equation, else the verdict.
    first: String,
    /// By effect.
    shares: BTreeMap<String, f64>,
    /// chi of the improved rig file on all recordings.
    chi: f64,
}

impl Order {
    /// Diagnoses every arrangement and prints a line for each and what they have in common.
    ///
    /// # Errors
    /// What could not be read or diagnosed.
    pub fn run(&self) -> Result<(), Failure> {
        let rig = Rig::load(&self.rig).map_err(|e| e.to_string())?;
        let read = |paths: &[PathBuf]| {
            let all = paths.iter().map(|path| read(&rig, path).map_err(|e| e.to_string()));
            all.collect::<Result<Vec<Recording>, String>>()
        };
        let (recordings, held) = (read(&self.recordings)?, read(&self.holdout)?);
        let seeds = if held.is_empty() { 1..=3 } else { 1..=1 };
        let mut came: Vec<Came> = Vec::new();
        println!("order | blocks | threads | first | chi | shares");
        for arrangement in arrangements(recordings.len(), seeds, &self.threads) {
            let ordered: Vec<Recording> = arrangement.order.iter().map(|i| recordings[*i].clone()).collect();
            let settings =
                Settings { seed: arrangement.seed, jobs: arrangement.threads, thorough: false, progress: &|_, _| {} };
            let outcome = diagnose(&rig, 0, &ordered, &held, &settings).map_err(|e| e.to_string())?;
            let Diagnosis { noise, .. } = &outcome.diagnosis;
            let squares = recordings.iter().chain(&held).filter_map(|r| holdout::chi(&outcome.improved, r, noise));
            let squares: Vec<f64> = squares.map(|(_, chi)| chi * chi).collect();
            let chi = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
            let one = Came {
                arrangement,
                first: first(&outcome.diagnosis),
                shares: outcome.diagnosis.effects.iter().map(|e| (e.id.clone(), e.share)).collect(),
                chi,
            };
            println!("{one}");
            came.push(one);
        }
        println!("{}", Stability::of(&came));
        Ok(())
    }
}

/// Every order with every phase of the blocks on the first number of threads; the first of them on the others, too.
fn arrangements(recordings: usize, seeds: std::ops::RangeInclusive<u64>, threads: &[usize]) -> Vec<Arrangement> {
    let Some((&usual, others)) = threads.split_first() else { return Vec::new() };
    let orders = orders(recordings);
    let with_seeds = |order: &Vec<usize>| {
        let of = |seed| Arrangement { order: order.clone(), seed, threads: usual };
        seeds.clone().map(of).collect::<Vec<_>>()
    };
    let mut all: Vec<Arrangement> = orders.iter().flat_map(with_seeds).collect();
    let first = all[0].clone();
    all.extend(others.iter().map(|&threads| Arrangement { threads, ..first.clone() }));
    all
}

/// Every permutation of up to three, every rotation of more.
fn orders(n: usize) -> Vec<Vec<usize>> {
    let rotations = (0..n).map(|by| (0..n).map(|i| (i + by) % n).collect::<Vec<usize>>());
    match n {
        3 => rotations.flat_map(|r| [r.clone(), vec![r[1], r[0], r[2]]]).collect(),
        _ => rotations.collect(),
    }
}

fn first(diagnosis: &Diagnosis) -> String {
    match (&diagnosis.verdict, diagnosis.effects.first(), &diagnosis.location.equation) {
        (Verdict::Agrees | Verdict::ParametersOff, None, _) => diagnosis.verdict.name().into(),
        (_, Some(effect), _) => effect.id.clone(),
        (_, None, Some(equation)) => format!("unknown, {equation}"),
        (_, None, None) => "unknown".into(),
    }
}

impl fmt::Display for Came {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let order: Vec<String> = self.arrangement.order.iter().map(|i| (i + 1).to_string()).collect();
        let shares: Vec<String> = self.shares.iter().map(|(id, share)| format!("{id} {share:.2}")).collect();
        let Arrangement { seed, threads, .. } = self.arrangement;
        write!(f, "{} | {seed} | {threads} | {} | {:.3} | {}", order.join(" "), self.first, self.chi, shares.join(", "))
    }
}

/// What the answers to one question have in common.
#[derive(Debug, Clone, PartialEq)]
struct Stability {
    /// How often each first effect, equation or verdict came.
    firsts: BTreeMap<String, usize>,
    /// Half the range of every effect's share; one that is missing has 0.
    share_spread: f64,
    /// Half the range of the errors over their middle.
    error_spread: f64,
}

impl Stability {
    fn of(came: &[Came]) -> Stability {
        let mut firsts = BTreeMap::new();
        came.iter().for_each(|one| *firsts.entry(one.first.clone()).or_insert(0) += 1);
        let ids: BTreeSet<&String> = came.iter().flat_map(|one| one.shares.keys()).collect();
        let half_range = |of: &dyn Fn(&Came) -> f64| {
            let (low, high) =
                came.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            ((high - low).max(0.0) / 2.0, (high + low) / 2.0)
        };
        let spread = |id: &&String| half_range(&|one| one.shares.get(*id).copied().unwrap_or(0.0)).0;
        let share_spread = ids.iter().map(spread).fold(0.0, f64::max);
        let (half, middle) = half_range(&|one| one.chi);
        Stability { firsts, share_spread, error_spread: half / middle }
    }

    fn holds(&self) -> bool {
        self.firsts.len() == 1 && self.share_spread <= SHARE_BAND && self.error_spread <= ERROR_BAND
    }
}

impl fmt::Display for Stability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let firsts: Vec<String> = self.firsts.iter().map(|(first, count)| format!("{first} {count} times")).collect();
        write!(
            f,
            "{}: first {}; shares ± {:.2} (± {SHARE_BAND} allowed), error ± {:.1} % (± {:.0} %)",
            if self.holds() { "stable" } else { "NOT stable" },
            firsts.join(", "),
            self.share_spread,
            100.0 * self.error_spread,
            100.0 * ERROR_BAND
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn came(first: &str, share: f64, chi: f64) -> Came {
        let arrangement = Arrangement { order: vec![0], seed: 1, threads: 1 };
        Came { arrangement, first: first.into(), shares: [(first.to_string(), share)].into(), chi }
    }

    #[test]
    fn every_order_every_phase_and_every_number_of_threads_is_tried_once() {
        let all = arrangements(3, 1..=3, &[2, 1]);
        assert_eq!(all.len(), 6 * 3 + 1);
        assert!(all.iter().enumerate().all(|(i, one)| !all[..i].contains(one)));
        let mut sorted: Vec<Vec<usize>> = orders(3);
        sorted.sort();
        sorted.dedup();
        assert_eq!(sorted.len(), 6);
        assert_eq!(arrangements(1, 1..=1, &[1]).len(), 1);
        assert_eq!(orders(4).len(), 4);
    }

    #[test]
    fn an_answer_that_moves_is_not_stable() {
        let stable = Stability::of(&[came("a", 0.5, 1.0), came("a", 0.6, 1.05)]);
        assert!(stable.holds(), "{stable}");
        assert!((stable.share_spread - 0.05).abs() < 1e-12);
        assert!(!Stability::of(&[came("a", 0.5, 1.0), came("b", 0.5, 1.0)]).holds(), "another effect");
        assert!(!Stability::of(&[came("a", 0.3, 1.0), came("a", 0.6, 1.0)]).holds(), "another share");
        assert!(!Stability::of(&[came("a", 0.5, 1.0), came("a", 0.5, 1.2)]).holds(), "another error");
        // an effect that is there only once has gone from nothing to its share
        assert!((Stability::of(&[came("a", 0.5, 1.0), came("b", 0.1, 1.0)]).share_spread - 0.25).abs() < 1e-12);
    }
}
