//! Which cases there are: a fixed list, of which a development run and a scoring run draw different wires.

use rand::rngs::SmallRng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};

use super::magnitudes::{CATALOGUE, Kind, OUTSIDE};

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
}

impl Null {
    const ALL: [Null; 6] = [Null::Off, Null::Exact, Null::Coloured, Null::Quantised, Null::Missing, Null::Nodes];

    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Null::Off => "parameters off",
            Null::Exact => "rig file exactly right",
            Null::Coloured => "parameters off, coloured noise",
            Null::Quantised => "parameters off, coarse converter",
            Null::Missing => "parameters off, missing samples",
            Null::Nodes => "parameters off, computed with axial nodes",
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
}

/// Cases of the full plan that are long.
const LONG: usize = 6;

/// What is in the plan, in an order in which any prefix has some of everything.
fn contents() -> Vec<(What, Option<f64>)> {
    let mut all = Vec::new();
    let nulls = [(Null::Off, 26), (Null::Exact, 14), (Null::Coloured, 14), (Null::Quantised, 12), (Null::Missing, 8)];
    for (null, count) in nulls.into_iter().chain([(Null::Nodes, 8)]) {
        all.extend(std::iter::repeat_n((What::Null(null), None), count));
    }
    for kind in &CATALOGUE {
        for target in [1.0, 3.0, 3.0, 10.0, 10.0] {
            all.push((What::Effects(vec![kind.id.to_string()]), Some(target)));
        }
    }
    // which effects meet is part of the plan: the same in development and scoring
    let mut rng = SmallRng::seed_from_u64(77);
    for i in 0..30 {
        let count = if i % 5 == 4 { 3 } else { 2 };
        all.push((What::Effects(together(&mut rng, count)), Some(3.0)));
    }
    for (name, _, _) in &OUTSIDE {
        // the cosine is there or not: it leaves what it leaves
        let targets = if *name == "cosine kinetics" { [None; 3] } else { [Some(3.0), Some(10.0), Some(10.0)] };
        all.extend(targets.map(|target| (What::Outside(name.to_string()), target)));
    }
    all.extend(Trap::ALL.map(|trap| (What::Trap(trap), None)));
    all.shuffle(&mut rng);
    all
}

/// Effects that may be concealed together: they can show, and no two of them are near relatives.
fn together(rng: &mut SmallRng, count: usize) -> Vec<String> {
    let related = |a: &Kind, b: &Kind| {
        let family = |k: &Kind| match k.id {
            "mechanical.friction" | "mechanical.capstan" | "sensing.delay" => 1,
            "kinetic.lag" | "kinetic.minor_loop" => 2,
            "thermal.end_conduction" | "kinetic.distributed" | "kinetic.asymmetry" => 3,
            _ if k.id.starts_with("electrical.") || k.id.starts_with("sensing.") => 4,
            _ => 0,
        };
        a.id == b.id || (family(a) != 0 && family(a) == family(b))
    };
    let mut chosen: Vec<&Kind> = Vec::new();
    while chosen.len() < count {
        let next = &CATALOGUE[rng.random_range(0..CATALOGUE.len())];
        if next.shows && !chosen.iter().any(|k| related(k, next)) {
            chosen.push(next);
        }
    }
    chosen.into_iter().map(|k| k.id.to_string()).collect()
}

fn specs(seeds: Seeds, contents: Vec<(usize, What, Option<f64>)>) -> Vec<Spec> {
    let step = contents.len() / LONG + 1;
    contents
        .into_iter()
        .enumerate()
        .map(|(place, (index, what, target))| Spec {
            name: format!("{}{index:03}", seeds.letter()),
            seed: seeds.first() + index as u64,
            long: place % step == step - 1 && !matches!(what, What::Trap(_)),
            what,
            target,
        })
        .collect()
}

/// The plan, or its first `cases` entries.
pub fn plan(seeds: Seeds, cases: Option<usize>) -> Vec<Spec> {
    let all: Vec<_> = contents().into_iter().enumerate().map(|(i, (what, target))| (i, what, target)).collect();
    let mut specs = specs(seeds, all);
    specs.truncate(cases.unwrap_or(usize::MAX));
    specs
}

/// About thirty cases that have every group in them.
pub fn quick(seeds: Seeds) -> Vec<Spec> {
    let mut chosen = Vec::new();
    let mut counts = [0usize; 5];
    let mut nulls = Vec::new();
    for spec in plan(seeds, None) {
        let (group, most) = match &spec.what {
            // one of each, and two more of the plainest
            What::Null(null) if !nulls.contains(null) || (*null == Null::Off && counts[0] - nulls.len() < 2) => {
                if !nulls.contains(null) {
                    nulls.push(*null);
                }
                (0, Null::ALL.len() + 2)
            }
            What::Null(_) => continue,
            What::Effects(ids) if ids.len() == 1 => (1, if spec.target == Some(1.0) { 0 } else { 12 }),
            What::Effects(_) => (2, 3),
            What::Outside(_) => (3, 4),
            What::Trap(_) => (4, 3),
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
    fn a_quarter_of_at_least_three_hundred_is_nothing_at_all() {
        let plan = plan(Seeds::Score, None);
        assert!(plan.len() >= 300, "{}", plan.len());
        let nulls = plan.iter().filter(|s| matches!(s.what, What::Null(_))).count();
        assert!(4 * nulls >= plan.len(), "{nulls} of {}", plan.len());
        for null in Null::ALL {
            assert!(plan.iter().any(|s| s.what == What::Null(null)), "{null:?}");
        }
    }

    #[test]
    fn development_and_scoring_share_no_seed() {
        let seeds = |s: Seeds| plan(s, None).into_iter().map(|s| s.seed).collect::<Vec<_>>();
        let scored = seeds(Seeds::Score);
        assert!(seeds(Seeds::Dev).iter().all(|seed| !scored.contains(seed)));
    }

    #[test]
    fn the_quick_subset_has_every_group_and_every_null() {
        let quick = quick(Seeds::Dev);
        assert!((26..=34).contains(&quick.len()), "{}", quick.len());
        for null in Null::ALL {
            assert!(quick.iter().any(|s| s.what == What::Null(null)), "{null:?}");
        }
        assert!(quick.iter().any(|s| matches!(s.what, What::Outside(_))));
        assert!(quick.iter().any(|s| matches!(s.what, What::Trap(_))));
    }
}
