//! The figures: how often the answers are right, by group, and how sure such a share is.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use sinew_concealed::generator::case::Answer;
use sinew_concealed::generator::plan::Spec;
use sinew_concealed::judged::{Judged, Level};
use sinew_concealed::reported::{Reported, Took};

/// A share with its 90 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Share {
    /// How many are so.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// 5 % on either side of a normal distribution.
const Z_90: f64 = 1.644_853_626_951_472_7;

impl Share {
    /// Wilson's interval.
    pub fn new(count: usize, of: usize) -> Share {
        if of == 0 {
            return Share { count, of, low: 0.0, high: 1.0 };
        }
        let (n, p, z2) = (of as f64, count as f64 / of as f64, Z_90 * Z_90);
        let middle = (p + 0.5 * z2 / n) / (1.0 + z2 / n);
        let half = Z_90 / (1.0 + z2 / n) * (p * (1.0 - p) / n + 0.25 * z2 / (n * n)).sqrt();
        Share { count, of, low: (middle - half).max(0.0), high: (middle + half).min(1.0) }
    }

    /// How many of `all` are so.
    pub fn of<'a>(all: impl IntoIterator<Item = &'a Judged>, is: impl Fn(&Judged) -> bool) -> Share {
        let (mut count, mut of) = (0, 0);
        for judged in all {
            of += 1;
            count += usize::from(is(judged));
        }
        Share::new(count, of)
    }

    /// The share itself; 0 of nothing is NaN.
    pub fn value(&self) -> f64 {
        self.count as f64 / self.of as f64
    }
}

/// Outside the catalogue and driven by time itself: no recording under another programme can be predicted.
const TIME_DRIVEN: [&str; 2] = ["ambient that swings", "creep of the crimp"];

/// Error and coverage of effects' sizes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sizes {
    /// Median of |reported − true| over |true − null|.
    pub median_error: f64,
    /// 90 % intervals that hold the truth.
    pub covered: Share,
    /// Median of their width over that of the true model's, fitted to the same recordings.
    pub median_width: f64,
}

/// Time and memory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// Median time, s.
    pub median_s: f64,
    /// 95 of a hundred take no longer, s.
    pub p95_s: f64,
    /// Longest time, s.
    pub most_s: f64,
    /// Largest memory, MiB.
    pub most_mib: f64,
    /// Cases.
    pub of: usize,
}

/// Everything that is required, and what explains it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Cases.
    pub cases: usize,
    /// Nulls on which physics is reported to be missing.
    pub false_alarms: Share,
    /// Nulls on which something is suspected, but nothing named.
    pub suspected: Share,
    /// Alarms by kind of null.
    pub false_alarms_by_kind: BTreeMap<String, Share>,
    /// Singles on which physics is reported to be missing, by level.
    pub detected: BTreeMap<Level, Share>,
    /// Singles at 3× and 10×: the right equation is blamed.
    pub equation: Share,
    /// … the right effect is first.
    pub first: Share,
    /// … the right effect is named or in the declared class.
    pub named: Share,
    /// The right effect first, by level.
    pub first_by_level: BTreeMap<Level, Share>,
    /// Pairs, each leaving 3× by itself, of which both are named.
    pub pairs: Share,
    /// Pairs of which both are named or in a declared class.
    pub pairs_in_class: Share,
    /// Triples of which all are named.
    pub triples: Share,
    /// Members of triples that are named.
    pub triple_members: Share,
    /// Cases with a right name at 3× and 10× that have a wrong one beside it.
    pub spurious: Share,
    /// Of everything reported to be unknown: what is outside the catalogue, traps apart.
    pub unknown_precision: Share,
    /// chi on the second recording of what is outside the catalogue, time-driven ones apart: median.
    pub outside_held_median: f64,
    /// Second truth, 3× and 10×: right effect first.
    pub second_first: Share,
    /// Nulls of the second truth: parameters off, and what remains is of the curves.
    pub second_nulls: Share,
    /// Laws of the laboratory's own, 3× and 10×: named first.
    pub own: Share,
    /// Outside the catalogue, at 3× and 10×: reported so.
    pub outside_said: Share,
    /// … given a wrong name.
    pub outside_wrong: Share,
    /// Of those given a wrong name: what was put into the model predicts the second recording to within noise.
    pub outside_alike: Share,
    /// … the right equation blamed.
    pub outside_equation: Share,
    /// chi of the improved rig on the second recording, catalogue cases at 3× and 10×: median.
    pub held_median: f64,
    /// … at most 1.15.
    pub held_good: Share,
    /// Effects' sizes where the right one is named, at 3× and 10×.
    pub sizes: Sizes,
    /// The reference model's parameters on nulls: 90 % intervals that hold the truth.
    pub parameters: Share,
    /// Broken recordings refused, or warned of and left alone.
    pub traps: Share,
    /// Runs that ended without an answer where one was due.
    pub no_answer: usize,
    /// Long cases, by the clock.
    pub long: Cost,
    /// All others, on one thread each, by what that thread computed.
    pub short: Cost,
}

fn median(values: Vec<f64>) -> f64 {
    quantile(values, 0.5)
}

/// Linear between order statistics; NaN of nothing.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.retain(|v| !v.is_nan());
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let place = share * last as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    if low == high { values[low] } else { values[low] + (place - low as f64) * (values[high] - values[low]) }
}

/// The figures of all cases.
pub fn figures(all: &[Judged]) -> Figures {
    let group = |name: &'static str| all.iter().filter(move |j| j.group() == name);
    let level = |j: &&Judged| Level::of(j.answer.level);
    let visible = || group("single").filter(move |j| level(j) >= Level::Three);
    let by_level = |is: fn(&Judged) -> bool| {
        Level::ALL.map(|l| (l, Share::of(group("single").filter(|j| level(j) == l), is))).into_iter().collect()
    };
    let kinds: BTreeSet<&String> = group("null").map(|j| &j.answer.kind).collect();
    // of several, each must leave something by itself; of what is outside, the whole
    let several = || group("several").filter(|j| j.answer.levels.values().all(|l| Level::of(*l) >= Level::Three));
    let pairs = || several().filter(|j| j.answer.accept.len() == 2);
    let outside = || group("outside").filter(|j| level(j) >= Level::Three);
    let catalogue = || visible().chain(several());
    let held: Vec<f64> = catalogue().map(|j| j.reported.held.unwrap_or(f64::INFINITY)).collect();
    let members: Vec<bool> = several()
        .filter(|j| j.answer.accept.len() > 2)
        .flat_map(|j| j.answer.accept.iter().map(|truth| j.alarms() && j.names(truth)))
        .collect();
    Figures {
        cases: all.len(),
        false_alarms: Share::of(group("null"), |j| j.alarms()),
        suspected: Share::of(group("null"), |j| !j.alarms() && !j.reported.suspected.is_empty()),
        false_alarms_by_kind: kinds
            .into_iter()
            .map(|k| (k.clone(), Share::of(group("null").filter(|j| j.answer.kind == *k), |j| j.alarms())))
            .collect(),
        detected: by_level(|j| j.alarms()),
        equation: Share::of(visible(), Judged::equation_right),
        first: Share::of(visible(), Judged::first_right),
        named: Share::of(visible(), Judged::all_in_class),
        first_by_level: by_level(Judged::first_right),
        pairs: Share::of(pairs(), Judged::all_named),
        pairs_in_class: Share::of(pairs(), Judged::all_in_class),
        triples: Share::of(several().filter(|j| j.answer.accept.len() > 2), Judged::all_named),
        triple_members: Share::new(members.iter().filter(|found| **found).count(), members.len()),
        spurious: Share::of(catalogue().filter(|j| j.names_one()), Judged::has_spurious),
        unknown_precision: Share::of(all.iter().filter(|j| j.group() != "trap" && j.reported.reports_unknown()), |j| {
            j.group() == "outside"
        }),
        outside_held_median: median(
            outside()
                .filter(|j| !TIME_DRIVEN.contains(&j.answer.kind.as_str()))
                .map(|j| j.reported.held.unwrap_or(f64::INFINITY))
                .collect(),
        ),
        second_first: Share::of(visible().filter(|j| j.answer.generator == 2), Judged::first_right),
        second_nulls: Share::of(group("null").filter(|j| j.answer.generator == 2), |j| {
            !j.alarms() && j.reported.verdict.is_some() && j.reported.remains.contains("curves")
        }),
        own: Share::of(group("own").filter(|j| level(j) >= Level::Three), Judged::first_right),
        outside_said: Share::of(outside(), Judged::outside_said),
        outside_wrong: Share::of(outside(), Judged::wrong_name),
        outside_alike: Share::of(outside().filter(|j| j.false_effect()), Judged::predicts),
        outside_equation: Share::of(outside(), Judged::equation_right),
        held_good: Share::new(held.iter().filter(|chi| **chi <= 1.15).count(), held.len()),
        held_median: median(held),
        sizes: sizes(catalogue()),
        parameters: parameters(group("null")),
        traps: Share::of(group("trap"), Judged::survives_trap),
        no_answer: all.iter().filter(|j| j.reported.verdict.is_none() && (j.group() != "trap" || j.crashed())).count(),
        long: cost(all.iter().filter(|j| j.long), |took| took.seconds),
        // many at once on a machine that may be busy
        short: cost(all.iter().filter(|j| !j.long && j.group() != "trap"), |took| took.computing_s),
    }
}

/// A parameter's distance from its null is its size: gains and skews of 1 do nothing.
fn null_of(key: &str, answer: &Answer) -> f64 {
    match key {
        "v3" | "current" | "heating_skew" | "cooling_skew" => 1.0,
        // the left-out second modulus is the first one
        "martensite_modulus_gpa" => answer.parameters.get("austenite_modulus_gpa").copied().unwrap_or(0.0),
        _ => 0.0,
    }
}

fn sizes<'a>(all: impl Iterator<Item = &'a Judged>) -> Sizes {
    let (mut errors, mut covered, mut widths) = (Vec::new(), Vec::new(), Vec::new());
    for judged in all {
        for (id, keys) in &judged.answer.sizes {
            let Some(named) = judged.reported.effects.iter().find(|e| judged.is_same(&e.id, id)) else { continue };
            for key in keys {
                let Some(truth) = judged.answer.effects.get(id).and_then(|p| p.get(key)) else { continue };
                // the two names of one circuit have a key each
                let found = if named.id == *id { named.sizes.get(key) } else { named.sizes.values().next() };
                let (Some([value, low, high]), null) = (found, null_of(key, &judged.answer)) else { continue };
                let size = (truth - null).abs();
                if size > 1e-9 {
                    errors.push((value - truth).abs() / size);
                    covered.push(low <= truth && truth <= high);
                    let best = judged.answer.deviations.get(id).map_or(f64::NAN, |sd| 2.0 * Z_90 * sd * size);
                    widths.push((high - low) / best);
                }
            }
        }
    }
    let held = covered.iter().filter(|c| **c).count();
    Sizes { median_error: median(errors), covered: Share::new(held, covered.len()), median_width: median(widths) }
}

fn parameters<'a>(nulls: impl Iterator<Item = &'a Judged>) -> Share {
    let (mut held, mut of) = (0, 0);
    for judged in nulls.filter(|j| !j.alarms()) {
        for (key, [low, high]) in &judged.reported.parameters {
            if let Some(truth) = judged.answer.parameters.get(key) {
                of += 1;
                held += usize::from(low <= truth && truth <= high);
            }
        }
    }
    Share::new(held, of)
}

fn cost<'a>(all: impl Iterator<Item = &'a Judged>, time: fn(&Took) -> f64) -> Cost {
    let took: Vec<Took> = all.map(|j| j.reported.took).collect();
    let times: Vec<f64> = took.iter().map(time).collect();
    Cost {
        median_s: median(times.clone()),
        p95_s: quantile(times.clone(), 0.95),
        most_s: times.into_iter().fold(0.0, f64::max),
        most_mib: took.iter().map(|t| t.memory_mib).fold(0.0, f64::max),
        of: took.len(),
    }
}

/// What was concealed, as a row of the confusion matrix.
pub fn row(answer: &Answer) -> String {
    match answer.group.as_str() {
        "null" => "nothing".into(),
        "outside" => "outside the catalogue".into(),
        _ => answer.kind.clone(),
    }
}

/// Counts of what was reported first, by what was concealed; pairs and traps have tables of their own.
pub fn confusion(all: &[Judged]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut matrix: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for judged in all.iter().filter(|j| matches!(j.group(), "null" | "single" | "outside")) {
        *matrix.entry(row(&judged.answer)).or_default().entry(judged.first().to_string()).or_default() += 1;
    }
    matrix
}

/// The judged case of a plan's entry.
pub fn judged(spec: &Spec, answer: Answer, reported: Reported) -> Judged {
    Judged { answer, reported, long: spec.long }
}

#[cfg(test)]
pub mod tests {
    use sinew_concealed::reported::{CRASHED, Named};

    use super::*;

    /// A case that conceals `accept`, and what might be reported on it.
    pub fn made_up(group: &str, accept: &[&str], level: f64, reported: Reported) -> Judged {
        let of = |id: &str| (id.to_string(), BTreeMap::from([("size".to_string(), 2.0)]));
        let answer = Answer {
            name: "d001".into(),
            seed: 1,
            group: group.into(),
            kind: if accept.is_empty() { group.into() } else { accept.join(" + ") },
            verdict: "physics_missing".into(),
            accept: accept.iter().map(ToString::to_string).collect(),
            same: vec![vec!["electrical.lead_resistance".into(), "electrical.supply_sag".into()]],
            equation: accept.first().and_then(|id| id.split('.').next()).map(String::from),
            equations: accept.iter().filter_map(|id| id.split('.').next()).map(String::from).collect(),
            effects: accept.iter().map(|id| of(id)).collect(),
            sizes: accept.iter().map(|id| (id.to_string(), vec!["size".to_string()])).collect(),
            target: Some(level),
            level,
            levels: accept.iter().map(|id| (id.to_string(), level)).collect(),
            deviations: accept.iter().map(|id| (id.to_string(), 0.05)).collect(),
            left_out: BTreeMap::new(),
            noise: BTreeMap::new(),
            parameters: BTreeMap::from([("h".to_string(), 1.0)]),
            generator: 1,
            unlike: false,
            allowed: Vec::new(),
        };
        Judged { answer, reported, long: false }
    }

    /// An answer that names these effects, each of a size of 2.2 in 1.9 to 2.1.
    pub fn names(ids: &[&str], class: &[&str]) -> Reported {
        let named = |id: &&str| Named {
            id: id.to_string(),
            class: class.iter().map(ToString::to_string).collect(),
            share: 0.5,
            sizes: BTreeMap::from([("size".to_string(), [2.2, 1.9, 2.1])]),
        };
        Reported {
            verdict: Some("physics_missing".into()),
            effects: ids.iter().map(named).collect(),
            equation: ids.first().and_then(|id| id.split('.').next()).map(String::from),
            held: Some(1.05),
            ..Reported::default()
        }
    }

    /// An answer without any effect.
    pub fn says(verdict: &str) -> Reported {
        Reported { verdict: Some(verdict.into()), ..Reported::default() }
    }

    #[test]
    fn wilson_at_known_points() {
        // 5 of 100: 2.5 % to 9.9 % (any table of Wilson's 90 % interval)
        let share = Share::new(5, 100);
        assert!((share.low - 0.0245).abs() < 5e-4 && (share.high - 0.0992).abs() < 5e-4, "{share:?}");
        let none = Share::new(0, 10);
        assert!(none.low.abs() < 1e-12 && (none.high - 0.2129).abs() < 5e-4, "{none:?}");
        assert_eq!((Share::new(0, 0).low, Share::new(0, 0).high), (0.0, 1.0));
    }

    #[test]
    fn nulls_count_alarms_and_nothing_else() {
        let all = [
            made_up("null", &[], 0.0, says("agrees")),
            made_up("null", &[], 0.0, says("parameters_off")),
            made_up("null", &[], 0.0, says("unknown_physics")),
            made_up("null", &[], 0.0, names(&["thermal.draught"], &[])),
            made_up("null", &[], 0.0, Reported::refused("no")),
        ];
        let f = figures(&all);
        assert_eq!((f.false_alarms.count, f.false_alarms.of, f.no_answer), (2, 5, 1));
        assert_eq!(all.iter().map(Judged::right).collect::<Vec<_>>(), [true, true, false, false, false]);
    }

    #[test]
    fn singles_by_level_and_by_name() {
        let lag = "kinetic.lag";
        let all = [
            made_up("single", &[lag], 3.0, names(&[lag], &[])),
            made_up("single", &[lag], 10.0, names(&["kinetic.minor_loop"], &[lag])),
            made_up("single", &[lag], 10.0, names(&["thermal.sheath"], &[])),
            made_up("single", &[lag], 3.0, says("parameters_off")),
            made_up("single", &[lag], 1.0, names(&[lag], &[])),
            made_up("single", &[lag], 0.2, says("agrees")),
        ];
        let f = figures(&all);
        assert_eq!((f.detected[&Level::Three].count, f.detected[&Level::Three].of), (1, 2));
        assert_eq!((f.detected[&Level::Ten].count, f.detected[&Level::Ten].of), (2, 2));
        assert_eq!((f.first.count, f.first.of), (1, 4));
        assert_eq!((f.named.count, f.equation.count), (2, 2));
        assert!(all[5].right() && !all[1].right());
        assert_eq!(confusion(&all)[lag]["nothing"], 2);
        assert_eq!(confusion(&all)[lag]["thermal.sheath"], 1);
    }

    #[test]
    fn the_two_names_of_one_circuit_are_one() {
        let sag = made_up("single", &["electrical.supply_sag"], 10.0, names(&["electrical.lead_resistance"], &[]));
        let f = figures(std::slice::from_ref(&sag));
        assert!(sag.first_right());
        assert_eq!(f.sizes.covered.of, 1);
        let other = made_up("single", &["electrical.supply_sag"], 10.0, names(&["sensing.gain"], &[]));
        assert!(!other.first_right());
    }

    #[test]
    fn pairs_need_both() {
        let pair = ["thermal.draught", "mechanical.friction"];
        let all = [
            made_up("several", &pair, 5.0, names(&["mechanical.friction", "thermal.draught"], &[])),
            made_up("several", &pair, 5.0, names(&["thermal.draught"], &[])),
            made_up("several", &pair, 5.0, names(&["thermal.draught", "sensing.delay"], &["mechanical.friction"])),
            made_up("several", &["a.a", "b.b", "c.c"], 5.0, names(&["a.a", "c.c"], &[])),
            made_up("several", &pair, 1.0, says("agrees")),
        ];
        let f = figures(&all);
        assert_eq!((f.pairs.count, f.pairs.of, f.pairs_in_class.count), (1, 3, 2));
        assert_eq!((f.triple_members.count, f.triple_members.of), (2, 3));
        assert_eq!((f.triples.count, f.triples.of), (0, 1));
        assert_eq!((f.spurious.count, f.spurious.of), (1, 4));
        assert_eq!(all[3].failure(), Some("a member is missing"));
    }

    #[test]
    fn outside_is_said_or_wrongly_named() {
        let mut both = names(&["thermal.draught"], &[]);
        both.unknown = true;
        both.held = Some(1.02);
        let mut bent = names(&["thermal.draught"], &[]);
        bent.held = Some(1.3);
        let all = [
            made_up("outside", &[], 10.0, says("unknown_physics")),
            made_up("outside", &[], 10.0, bent),
            made_up("outside", &[], 10.0, both),
            made_up("outside", &[], 10.0, says("parameters_off")),
            made_up("outside", &[], 0.9, says("parameters_off")),
        ];
        let f = figures(&all);
        assert_eq!((f.outside_alike.count, f.outside_alike.of), (1, 2));
        // with a false effect of half of what was wrong, nothing was said; what predicts is no wrong name
        assert_eq!((f.outside_said.count, f.outside_wrong.count, f.outside_said.of), (1, 1, 4));
        assert_eq!((f.unknown_precision.count, f.unknown_precision.of), (2, 2));
    }

    /// What the second truth's structure holds is neither an alarm nor spurious, and does not stand first.
    #[test]
    fn what_a_structure_holds_is_neither_right_nor_wrong() {
        let mut null = made_up("null", &[], 0.0, names(&["kinetic.distributed"], &[]));
        let mut single = made_up("single", &["kinetic.lag"], 3.0, names(&["kinetic.distributed", "kinetic.lag"], &[]));
        assert!(null.alarms() && !single.first_right());
        for judged in [&mut null, &mut single] {
            judged.answer.allowed = vec!["kinetic.distributed".into()];
            judged.answer.generator = 2;
        }
        assert!(!null.alarms() && null.right() && single.first_right() && !single.has_spurious());
        let f = figures(&[null, single]);
        assert_eq!((f.false_alarms.count, f.second_first.count, f.spurious.count), (0, 1, 0));
    }

    #[test]
    fn quantiles_lie_between() {
        assert_eq!(quantile(vec![3.0, 1.0, 2.0], 0.5), 2.0);
        assert!((quantile((0..=100).map(f64::from).collect(), 0.95) - 95.0).abs() < 1e-12);
        assert!(quantile(Vec::new(), 0.5).is_nan());
    }

    #[test]
    fn sizes_are_counted_from_the_null() {
        let all = [made_up("single", &["kinetic.lag"], 10.0, names(&["kinetic.lag"], &[]))];
        let f = figures(&all);
        assert!((f.sizes.median_error - 0.1).abs() < 1e-12);
        assert_eq!((f.sizes.covered.count, f.sizes.covered.of), (1, 1));
        // 0.2 wide, where the true model has 2 · 1.645 · 5 % of 2
        assert!((f.sizes.median_width - 0.608).abs() < 1e-3, "{}", f.sizes.median_width);
        assert_eq!((f.held_good.count, f.held_good.of), (1, 1));
    }

    #[test]
    fn a_trap_is_survived_by_refusing_or_by_warning_without_physics() {
        let warned = Reported { warnings: vec!["clips".into()], ..says("agrees") };
        let all = [
            made_up("trap", &[], 0.0, Reported::refused("position_m is a thousand times too large")),
            made_up("trap", &[], 0.0, warned),
            made_up("trap", &[], 0.0, says("agrees")),
            made_up("trap", &[], 0.0, names(&["thermal.draught"], &[])),
            made_up("trap", &[], 0.0, Reported::refused(&format!("{CRASHED}: signal 6"))),
        ];
        let f = figures(&all);
        assert_eq!((f.traps.count, f.traps.of, f.no_answer), (2, 5, 1));
    }
}
