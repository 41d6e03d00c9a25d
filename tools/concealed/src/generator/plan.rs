//! Which cases there are: a fixed list, of which a development run and a scoring run draw different wires.

use rand::rngs::SmallRng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};

use super::bench::Kin;
use super::laws;
use super::magnitudes::{CATALOGUE, OUTSIDE};
use crate::second::mechanisms;

/// Which seeds are drawn. The two ranges have none in common, and nothing is ever tuned on the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Seeds {
    /// For looking at while the diagnosis is built.
    Dev,
    /// For docs/proof.md.
    Score,
}

impl Seeds {
    /// The first of a range of a million.
    pub const fn first(self) -> u64 {
        match self {
            Seeds::Dev => 1_000_000,
            Seeds::Score => 2_000_000,
        }
    }

    const fn letter(self) -> char {
        match self {
            Seeds::Dev => 'd',
            Seeds::Score => 's',
        }
    }
}

/// Nothing is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Null {
    /// Parameters off, white noise.
    Off,
    /// The rig file is right to the last digit.
    Exact,
    /// Coloured noise.
    Coloured,
    /// Steps of a converter larger than the noise.
    Quantised,
    /// Missing samples.
    Missing,
    /// A wire of many nodes whose ends lose nothing: another way to compute the same wire.
    Nodes,
    /// The second generator: grains instead of curves, its own noise, nothing else.
    Grains,
    /// The second generator with its own air, cold ends or guided spring: effects that are then allowed.
    Built,
}

impl Null {
    /// Those of the first generator.
    const FIRST: [Null; 6] = [Null::Off, Null::Exact, Null::Coloured, Null::Quantised, Null::Missing, Null::Nodes];

    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Null::Off => "parameters off",
            Null::Exact => "rig file exactly right",
            Null::Coloured => "parameters off, coloured noise",
            Null::Quantised => "parameters off, coarse converter",
            Null::Missing => "parameters off, missing samples",
            Null::Nodes => "parameters off, computed with axial nodes",
            Null::Grains => "second truth: grains instead of curves",
            Null::Built => "second truth: grains, its own air, ends or guide",
        }
    }
}

/// A recording that nothing must be concluded from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trap {
    /// Time stamps run at half speed.
    ClockScaled,
    /// Blocks of samples lost, and the rest stamped as if they had followed.
    Restamped,
    /// A sensor clips.
    Saturated,
    /// The position stays where it was.
    Stuck,
    /// Position in millimetres.
    Millimetres,
    /// Current in milliamperes.
    Milliamperes,
    /// Two samples.
    TwoSamples,
    /// The drive never moves.
    NoExcitation,
    /// The rig file of a wire of twice the diameter.
    OtherWire,
    /// V_2 and V_3 exchanged.
    Exchanged,
}

impl Trap {
    const ALL: [Trap; 10] = [
        Trap::ClockScaled,
        Trap::Restamped,
        Trap::Saturated,
        Trap::Stuck,
        Trap::Millimetres,
        Trap::Milliamperes,
        Trap::TwoSamples,
        Trap::NoExcitation,
        Trap::OtherWire,
        Trap::Exchanged,
    ];

    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Trap::ClockScaled => "time stamps at half speed",
            Trap::Restamped => "lost blocks, stamped over",
            Trap::Saturated => "a sensor clips",
            Trap::Stuck => "position stuck",
            Trap::Millimetres => "position in mm",
            Trap::Milliamperes => "current in mA",
            Trap::TwoSamples => "two samples",
            Trap::NoExcitation => "the drive never moves",
            Trap::OtherWire => "rig file of another wire",
            Trap::Exchanged => "V2 and V3 exchanged",
        }
    }
}

/// What is concealed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum What {
    /// Nothing.
    Null(Null),
    /// Effects of the catalogue, by id.
    Effects(Vec<String>),
    /// Something no catalogue has, by its words.
    Outside(String),
    /// Something only the laboratory's own file of candidates has, by its words.
    Own(String),
    /// A broken recording.
    Trap(Trap),
}

/// An entry of the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Spec {
    /// Name of the case.
    pub name: String,
    /// Everything random comes from it.
    pub seed: u64,
    /// What is concealed.
    pub what: What,
    /// The level to be left after refitting.
    pub target: Option<f64>,
    /// 90 s at 200 Hz.
    pub long: bool,
    /// Of the second generator.
    pub second: bool,
    /// Wires and loads like those of development, or not.
    pub kin: Kin,
    /// Two recordings to diagnose together.
    pub both: bool,
}

#[cfg(test)]
impl Default for Spec {
    fn default() -> Self {
        Spec {
            name: String::new(),
            seed: 0,
            what: What::Null(Null::Off),
            target: None,
            long: false,
            second: false,
            kin: Kin::Alike,
            both: false,
        }
    }
}

/// What an entry of the plan is made of.
struct Content {
    what: What,
    target: Option<f64>,
    second: bool,
}

/// Cases of the full plan that are long.
const LONG: usize = 6;

/// Every so many-th case is of a wire and load unlike those of development, and one has two recordings.
const UNLIKE_EVERY: usize = 5;
const BOTH_EVERY: usize = 2;

/// What is in the plan, in an order in which any prefix has some of everything.
fn contents() -> Vec<Content> {
    let mut all = Vec::new();
    let mut add = |what: What, target: Option<f64>, second: bool| all.push(Content { what, target, second });
    let first = [(Null::Off, 40), (Null::Exact, 14), (Null::Coloured, 18), (Null::Quantised, 16), (Null::Missing, 12)];
    for (null, count) in first.into_iter().chain([(Null::Nodes, 12)]) {
        (0..count).for_each(|_| add(What::Null(null), None, false));
    }
    for null in [Null::Grains, Null::Built] {
        (0..50).for_each(|_| add(What::Null(null), None, true));
    }
    for kind in &CATALOGUE {
        for target in [1.0, 3.0, 3.0, 10.0] {
            add(What::Effects(vec![kind.id.to_string()]), Some(target), false);
        }
    }
    for kind in &mechanisms::CATALOGUE {
        for target in [1.0, 3.0, 3.0, 10.0, 10.0] {
            add(What::Effects(vec![kind.id.to_string()]), Some(target), true);
        }
    }
    // which effects meet is part of the plan: the same in development and scoring
    let mut rng = SmallRng::seed_from_u64(77);
    let firsts: Vec<&str> = CATALOGUE.iter().filter(|k| k.shows).map(|k| k.id).collect();
    let seconds: Vec<&str> = mechanisms::CATALOGUE.iter().filter(|k| k.shows).map(|k| k.id).collect();
    for (ids, second, pairs, triples) in [(&firsts, false, 24, 18), (&seconds, true, 16, 16)] {
        for i in 0..pairs + triples {
            let count = if i < pairs { 2 } else { 3 };
            add(What::Effects(together(&mut rng, ids, count)), Some(3.0), second);
        }
    }
    for (name, _, _) in &OUTSIDE {
        // the cosine is there or not: it leaves what it leaves
        let targets = if *name == "cosine kinetics" { [None; 2] } else { [Some(3.0), Some(10.0)] };
        targets.into_iter().for_each(|target| add(What::Outside(name.to_string()), target, false));
    }
    for novel in &mechanisms::NOVEL {
        for target in [3.0, 3.0, 10.0, 10.0] {
            add(What::Outside(novel.name.to_string()), Some(target), true);
        }
    }
    for name in laws::described() {
        for target in [3.0, 3.0, 10.0] {
            add(What::Own(name.to_string()), Some(target), false);
        }
    }
    Trap::ALL.into_iter().for_each(|trap| add(What::Trap(trap), None, false));
    all.shuffle(&mut rng);
    all
}

/// Effects that may be concealed together: they can show, and no two of them are near relatives.
fn together(rng: &mut SmallRng, ids: &[&str], count: usize) -> Vec<String> {
    let related = |a: &str, b: &str| {
        let family = |id: &str| match id {
            "mechanical.friction" | "mechanical.capstan" | "sensing.delay" => 1,
            "kinetic.lag" | "kinetic.minor_loop" => 2,
            "thermal.end_conduction" | "kinetic.distributed" | "kinetic.asymmetry" => 3,
            _ if id.starts_with("electrical.") || id.starts_with("sensing.") => 4,
            _ => 0,
        };
        a == b || (family(a) != 0 && family(a) == family(b))
    };
    let mut chosen: Vec<&str> = Vec::new();
    while chosen.len() < count {
        let next = ids[rng.random_range(0..ids.len())];
        if !chosen.iter().any(|id| related(id, next)) {
            chosen.push(next);
        }
    }
    chosen.into_iter().map(String::from).collect()
}

/// The plan, or its first `cases` entries.
pub fn plan(seeds: Seeds, cases: Option<usize>) -> Vec<Spec> {
    let all = contents();
    let step = all.len() / LONG + 1;
    let mut specs: Vec<Spec> = all
        .into_iter()
        .enumerate()
        .map(|(index, Content { what, target, second })| {
            let trap = matches!(what, What::Trap(_));
            Spec {
                name: format!("{}{index:03}", seeds.letter()),
                seed: seeds.first() + index as u64,
                long: index % step == step - 1 && !trap,
                kin: if index % UNLIKE_EVERY == 0 { Kin::Unlike } else { Kin::Alike },
                both: index % BOTH_EVERY == 0 && !trap,
                second,
                what,
                target,
            }
        })
        .collect();
    // what is never used in development is not in a development plan
    specs.retain(|s| seeds == Seeds::Score || !(s.second && matches!(s.what, What::Outside(_))));
    specs.truncate(cases.unwrap_or(usize::MAX));
    specs
}

/// The plan as it is committed: one line a case.
pub fn table(specs: &[Spec]) -> String {
    let mut text = String::from("case,seed,generator,concealed,target,kin,recordings,long\n");
    for s in specs {
        let concealed = match &s.what {
            What::Null(null) => format!("nothing ({})", null.words()),
            What::Effects(ids) => ids.join(" + "),
            What::Outside(name) => format!("outside: {name}"),
            What::Own(name) => format!("own law: {name}"),
            What::Trap(trap) => format!("trap: {}", trap.words()),
        };
        let (target, recordings) = (s.target.map_or(String::new(), |t| t.to_string()), if s.both { 2 } else { 1 });
        let (generator, long) = (if s.second { 2 } else { 1 }, if s.long { "yes" } else { "" });
        let kin = if s.kin == Kin::Unlike { "unlike" } else { "" };
        // a comma inside a cell would be a cell of its own
        let concealed = concealed.replace(',', ";");
        text += &format!("{},{},{generator},{concealed},{target},{kin},{recordings},{long}\n", s.name, s.seed);
    }
    text
}

/// About thirty cases that have every group in them.
pub fn quick(seeds: Seeds) -> Vec<Spec> {
    let mut chosen = Vec::new();
    let mut counts = [0usize; 6];
    let mut nulls = Vec::new();
    for spec in plan(seeds, None) {
        let (group, most) = match &spec.what {
            // one of each, and two more of the plainest
            What::Null(null) if !nulls.contains(null) || (*null == Null::Off && counts[0] - nulls.len() < 2) => {
                if !nulls.contains(null) {
                    nulls.push(*null);
                }
                (0, Null::FIRST.len() + 4)
            }
            What::Null(_) => continue,
            What::Effects(ids) if ids.len() == 1 => (1, if spec.target == Some(1.0) { 0 } else { 11 }),
            What::Effects(_) => (2, 3),
            What::Outside(_) => (3, 4),
            What::Trap(_) => (4, 3),
            What::Own(_) => (5, 1),
        };
        if counts[group] < most {
            counts[group] += 1;
            chosen.push(Spec { long: false, ..spec });
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plan_has_as_much_of_everything_as_is_required() {
        let plan = plan(Seeds::Score, None);
        let count = |is: fn(&Spec) -> bool| plan.iter().filter(|s| is(s)).count();
        assert!(plan.len() >= 600, "{}", plan.len());
        assert!(count(|s| matches!(s.what, What::Null(_))) >= 200);
        assert!(10 * count(|s| s.second) >= 4 * plan.len(), "{}", count(|s| s.second));
        assert!(5 * count(|s| s.kin == Kin::Unlike) >= plan.len());
        assert!(count(|s| matches!(&s.what, What::Effects(ids) if ids.len() == 3)) >= 30);
        for novel in &mechanisms::NOVEL {
            assert_eq!(plan.iter().filter(|s| s.what == What::Outside(novel.name.into())).count(), 4);
        }
        for null in Null::FIRST.into_iter().chain([Null::Grains, Null::Built]) {
            assert!(plan.iter().any(|s| s.what == What::Null(null)), "{null:?}");
        }
    }

    #[test]
    fn development_shares_no_seed_with_scoring_and_sees_none_of_the_eight() {
        let seeds = |s: Seeds| plan(s, None).into_iter().map(|s| s.seed).collect::<Vec<_>>();
        let scored = seeds(Seeds::Score);
        assert!(seeds(Seeds::Dev).iter().all(|seed| !scored.contains(seed)));
        for novel in &mechanisms::NOVEL {
            assert!(!plan(Seeds::Dev, None).iter().any(|s| s.what == What::Outside(novel.name.into())));
        }
    }

    #[test]
    fn the_quick_subset_has_every_group_and_every_null() {
        let quick = quick(Seeds::Dev);
        assert!((26..=36).contains(&quick.len()), "{}", quick.len());
        for null in Null::FIRST.into_iter().chain([Null::Grains, Null::Built]) {
            assert!(quick.iter().any(|s| s.what == What::Null(null)), "{null:?}");
        }
        assert!(quick.iter().any(|s| matches!(s.what, What::Outside(_))));
        assert!(quick.iter().any(|s| matches!(s.what, What::Trap(_))));
    }
}
