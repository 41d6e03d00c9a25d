//! What is to be concealed, and the case that conceals it.

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

use crate::generator::bench::Kin;
use crate::generator::case::{self, Case};
use crate::generator::magnitudes::{CATALOGUE, OUTSIDE};
use crate::generator::plan::{Null, Spec, What};

/// The seeds of `sinew conceal` begin here: beyond those of development and those of scoring, so that none of the proof's wires can
/// be met by chance.
const FIRST_SEED: u64 = 1 << 40;
/// Levels a random choice has: plainly there, and obvious.
const RANDOM_LEVELS: [f64; 2] = [3.0, 10.0];
/// One in so many random choices hides nothing, and one something outside the catalogue.
const RANDOM_KINDS: u32 = 6;
/// An effect that a wire does not show is no riddle: another one is drawn, so many times at the most.
const DRAWS: u32 = 4;
/// What it has to leave at the least, of what it is meant to.
const SHOWN: f64 = 0.5;

/// What is to be concealed.
#[derive(Debug, Clone, PartialEq)]
pub enum Choice {
    /// Whatever the seed says: an effect of the catalogue mostly, something outside it at times, nothing at times.
    Random,
    /// Nothing: only parameters are off, within their tolerances.
    Nothing,
    /// Effects of the catalogue, by id.
    Effects(Vec<&'static str>),
    /// Something that no catalogue has, by its words.
    Outside(&'static str),
}

/// A case to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Name of the rig.
    pub name: String,
    /// What is in it.
    pub choice: Choice,
    /// What the effect is to leave once every parameter has been refitted, RMS over the noise; random where none is given.
    pub level: Option<f64>,
    /// Everything random comes from it: the wire, its load, its sensors, the programme, the noise.
    pub seed: u32,
    /// Another recording to be diagnosed beside the first.
    pub second_recording: bool,
}

/// Ids of the effects of the catalogue that can be concealed.
pub fn effects() -> impl Iterator<Item = &'static str> + Clone {
    CATALOGUE.iter().map(|kind| kind.id)
}

/// Names of what is outside the catalogue.
pub fn outside() -> impl Iterator<Item = &'static str> + Clone {
    OUTSIDE.iter().map(|(name, _, _)| *name)
}

impl Order {
    /// Makes the case: seconds of work, in which the size is sought that leaves the level.
    pub fn make(&self) -> Case {
        // another stream than the case's own, which begins at the seed itself
        let mut rng = SmallRng::seed_from_u64(!u64::from(self.seed));
        let level = self.level.unwrap_or_else(|| RANDOM_LEVELS[rng.random_range(0..RANDOM_LEVELS.len())]);
        let (an_effect, an_outsider) = (any(effects(), &mut rng), any(outside(), &mut rng));
        let what = match &self.choice {
            Choice::Random => match rng.random_range(0..RANDOM_KINDS) {
                0 => What::Null(Null::Off),
                1 => What::Outside(an_outsider.into()),
                _ => What::Effects(vec![an_effect.into()]),
            },
            Choice::Nothing => What::Null(Null::Off),
            Choice::Effects(ids) => What::Effects(ids.iter().map(ToString::to_string).collect()),
            Choice::Outside(name) => What::Outside(name.to_string()),
        };
        let is_drawn = matches!((&self.choice, &what), (Choice::Random, What::Effects(_)));
        let mut case = self.made(what, level);
        for _ in 1..DRAWS {
            if !is_drawn || case.answer.level >= SHOWN * level {
                break;
            }
            case = self.made(What::Effects(vec![any(effects(), &mut rng).into()]), level);
        }
        case
    }

    fn made(&self, what: What, level: f64) -> Case {
        case::make(&Spec {
            name: self.name.clone(),
            seed: FIRST_SEED + u64::from(self.seed),
            target: (!matches!(what, What::Null(_))).then_some(level),
            what,
            long: false,
            second: false,
            kin: Kin::Alike,
            both: self.second_recording,
        })
    }
}

/// One of them.
fn any(all: impl Iterator<Item = &'static str>, rng: &mut SmallRng) -> &'static str {
    let all: Vec<&str> = all.collect();
    all[rng.random_range(0..all.len())]
}
