//! A kind of fault, a hundred tries of it, and its row of the table.

use std::fmt;
use std::time::Instant;

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use sinew_ipc::Fault;

use crate::failure::Failure;
use crate::site::Site;

/// Where a fault comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// Wires, taps, converter, power stage, supply.
    Electrical,
    /// Emergency stop and enable line.
    Stop,
    /// What a wire may take.
    Budgets,
    /// Commands that cannot be carried out.
    Commands,
    /// The loop itself: late, or let down by its backend.
    Loop,
    /// The driver's process and its machine.
    Process,
    /// Programs that look and command.
    Clients,
    /// The line to a front-end.
    Serial,
    /// Linux's own outputs and converters.
    Linux,
}

/// What a reaction is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// Periods of the loop, from the arrival of the first sample that shows the fault.
    Periods,
    /// Milliseconds on the clock, from the fault itself.
    Milliseconds,
    /// Kelvin of the true wire above its limit.
    Kelvin,
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Unit::Periods => "periods",
            Unit::Milliseconds => "ms",
            Unit::Kelvin => "K",
        })
    }
}

/// What carries out the tries of a kind.
pub type CarryOut = Box<dyn Fn(&Site, &mut Trials) -> Result<(), Failure> + Send + Sync>;

/// A kind of fault: what is done, and what has to come of it.
pub struct Kind {
    /// Its name, for `--only`.
    pub name: &'static str,
    /// Where it comes from.
    pub group: Group,
    /// How it is injected.
    pub injected: &'static str,
    /// What the driver promises to do.
    pub expected: &'static str,
    /// How soon (or by how little), at most, in `unit`.
    pub within: f64,
    /// What that is measured in.
    pub unit: Unit,
    /// Exactly what is lost; every try checks that nothing else is.
    pub lost: &'static str,
    /// The rows of the driver's fault table that this shows.
    pub faults: &'static [Fault],
    /// Carries out the tries.
    pub carry_out: CarryOut,
}

/// The tries of one kind as they go on.
#[derive(Debug)]
pub struct Trials {
    /// How many there are to be.
    pub tries: usize,
    /// What each has measured.
    pub reactions: Vec<f64>,
    /// What went wrong, and in which try.
    pub failures: Vec<(usize, String)>,
    seed: u64,
    /// What is promised, in the kind's unit.
    pub within: f64,
}

impl Trials {
    /// None so far.
    pub fn new(kind: &Kind, tries: usize, seed: u64) -> Trials {
        // A kind draws the same whatever others are asked for.
        let seed = kind.name.bytes().fold(seed ^ 0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        Trials { tries, reactions: Vec::new(), failures: Vec::new(), seed, within: kind.within }
    }

    /// Carries out each try with a generator of its own; it gives the measured reaction, or says what went wrong.
    ///
    /// # Errors
    /// [`Failure::Impossible`], which ends the tries.
    pub fn each(
        &mut self,
        mut one: impl FnMut(&mut Xoshiro256PlusPlus) -> Result<f64, Failure>,
    ) -> Result<(), Failure> {
        for number in 0..self.tries {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed.wrapping_add(number as u64));
            match one(&mut rng) {
                Ok(reaction) => {
                    // A NaN is no measurement.
                    if reaction.is_nan() || reaction > self.within {
                        self.failures.push((number, format!("{reaction:.2} where {} is promised", self.within)));
                    }
                    self.reactions.push(reaction);
                }
                Err(Failure::Unexpected(what)) => self.failures.push((number, what)),
                Err(impossible) => return Err(impossible),
            }
        }
        Ok(())
    }
}

/// What the tries of a kind came to.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Measured {
    /// Tries carried out.
    pub tries: usize,
    /// The worst reaction of all tries; `null` without one.
    pub worst: Option<f64>,
    /// The median of them.
    pub median: Option<f64>,
    /// Tries that came out otherwise.
    pub failed: usize,
    /// What was wrong with the first of them, or why the kind could not be tried.
    pub remark: Option<String>,
    /// Whether everything came out as promised, in every try.
    pub kept: bool,
    /// How long it took, s.
    pub seconds: f64,
}

/// A row of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Name of the kind.
    pub name: &'static str,
    /// Where it comes from.
    pub group: Group,
    /// How it was injected.
    pub injected: &'static str,
    /// What was promised.
    pub expected: &'static str,
    /// How soon, at most.
    pub within: f64,
    /// In what.
    pub unit: Unit,
    /// Flags of the driver's fault table that it shows.
    pub flags: Vec<&'static str>,
    /// What is lost, as checked in every try.
    pub lost: &'static str,
    /// What came of it.
    #[serde(flatten)]
    pub measured: Measured,
}

impl Kind {
    /// Carries out so many tries.
    pub fn measure(&self, site: &Site, tries: usize, seed: u64) -> Row {
        let started = Instant::now();
        let mut trials = Trials::new(self, tries, seed);
        let ended = (self.carry_out)(site, &mut trials);
        let Trials { mut reactions, failures, .. } = trials;
        reactions.sort_by(f64::total_cmp);
        let first = failures.first().map(|(number, what)| format!("try {number}: {what}"));
        let remark = match &ended {
            Err(failure) => Some(failure.to_string()),
            Ok(()) => first,
        };
        self.row(Measured {
            tries: reactions.len().max(failures.len()),
            worst: reactions.last().copied(),
            median: reactions.get(reactions.len() / 2).copied(),
            failed: failures.len(),
            kept: ended.is_ok() && failures.is_empty() && reactions.len() == tries,
            remark,
            seconds: started.elapsed().as_secs_f64(),
        })
    }

    /// The row that this makes; what was measured earlier is held to the promise of today.
    pub fn row(&self, mut measured: Measured) -> Row {
        measured.kept &= measured.worst.is_none_or(|worst| worst <= self.within);
        Row {
            name: self.name,
            group: self.group,
            injected: self.injected,
            expected: self.expected,
            within: self.within,
            unit: self.unit,
            flags: self.faults.iter().map(|fault| fault.flag()).collect(),
            lost: self.lost,
            measured,
        }
    }
}

/// A number between, evenly.
pub fn between(rng: &mut Xoshiro256PlusPlus, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// A whole number from `low` to `high`, both included.
pub fn whole(rng: &mut Xoshiro256PlusPlus, low: u64, high: u64) -> u64 {
    rng.random_range(low..=high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(carry_out: impl Fn(&Site, &mut Trials) -> Result<(), Failure> + Send + Sync + 'static) -> Kind {
        Kind {
            name: "made_up",
            group: Group::Loop,
            injected: "",
            expected: "",
            within: 2.0,
            unit: Unit::Periods,
            lost: "",
            faults: &[],
            carry_out: Box::new(carry_out),
        }
    }

    #[test]
    fn one_try_that_takes_too_long_breaks_the_promise() {
        let site = Site::new().unwrap();
        let good = kind(|_, trials| trials.each(|rng| Ok(between(rng, 0.0, 2.0)))).measure(&site, 50, 7);
        assert!(
            good.measured.kept
                && good.measured.failed == 0
                && good.measured.tries == 50
                && good.measured.worst <= Some(2.0),
            "{good:?}"
        );
        let bad = kind(|_, trials| {
            let mut count = 0;
            trials.each(|_| {
                count += 1;
                Ok(if count == 31 { 2.01 } else { 1.0 })
            })
        })
        .measure(&site, 50, 7);
        assert!(
            !bad.measured.kept
                && bad.measured.failed == 1
                && bad.measured.worst == Some(2.01)
                && bad.measured.median == Some(1.0),
            "{bad:?}"
        );
        assert!(bad.measured.remark.unwrap().starts_with("try 30"));
        let nothing = kind(|_, trials| trials.each(|_| Ok(f64::NAN))).measure(&site, 3, 7);
        assert!(!nothing.measured.kept && nothing.measured.failed == 3);
    }

    #[test]
    fn what_cannot_be_tried_is_no_promise_kept() {
        let site = Site::new().unwrap();
        let row = kind(|_, _| Err(Failure::Impossible("no root".into()))).measure(&site, 3, 7);
        assert!(!row.measured.kept && row.measured.tries == 0, "{row:?}");
        assert!(row.measured.remark.unwrap().contains("no root"));
    }
}
