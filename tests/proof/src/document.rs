//! docs/proof.md: the figures beside what is required, the confusion matrix and every failure.
//!
//! What others write into that page, between two markers, is kept.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use sinew_concealed::judged::{Judged, Level};
use sinew_concealed::second::mechanisms::NOVEL;

use crate::frozen::Hashes;
use crate::score::{Cost, Share, confusion, figures};

/// Between these the page belongs to others: to whoever writes of real recordings, and to `compare.py`.
const KEPT: [[&str; 2]; 2] = [
    ["<!-- real recordings: begin -->", "<!-- real recordings: end -->"],
    ["<!-- comparison: begin -->", "<!-- comparison: end -->"],
];

/// Reasons for what is not reached, in words of a person; may be empty.
const NOTES: &str = include_str!("../notes.md");

/// Causes of failures, in words of a person: a line `NAME: cause` each.
const CAUSES: &str = include_str!("../causes.txt");

/// A percentage with its interval.
fn percent(share: &Share) -> String {
    if share.of == 0 {
        return "–".into();
    }
    let (value, low, high) = (100.0 * share.value(), 100.0 * share.low, 100.0 * share.high);
    format!("{value:.0} % ({low:.0}–{high:.0}), {} of {}", share.count, share.of)
}

fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".into() }
}

/// Whether a target is met; a figure of nothing is neither.
fn met(is: bool, known: bool) -> &'static str {
    match (known, is) {
        (false, _) => "–",
        (true, true) => "yes",
        (true, false) => "**no**",
    }
}

/// One line of the table of figures.
fn line(text: &mut String, what: &str, target: &str, found: &str, met: &str) {
    let _ = writeln!(text, "| {what} | {target} | {found} | {met} |");
}

/// The page. `hashes` are those of the committed plan, none for development seeds; `before` is what the page was.
pub fn page(all: &[Judged], hashes: Option<&Hashes>, before: &str) -> String {
    let mut text = String::new();
    let seeds_words = match hashes {
        None => "**development** seeds: not what is to be believed".to_string(),
        Some(Hashes { plan, generators }) => format!(
            "scoring seeds, which were never used to tune anything (plan sha256 {plan}, generators sha256 {generators}, \
             committed in `tests/proof/plan.csv` before the first scored run)"
        ),
    };
    let _ = writeln!(
        text,
        "# Evaluation of the diagnosis on concealed cases\n\nHow well the diagnosis does where the truth is known: \
         {} concealed cases from {seeds_words}.\n\
         `cargo run --release -p sinew-proof` makes them, diagnoses them, scores them and writes this page (but for the \
         real recordings, the comparison and the notes).\n",
        all.len()
    );
    text.push_str(METHOD);
    text.push_str("\n| never used in development | equation | found in |\n|---|---|---|\n");
    for novel in &NOVEL {
        let _ = writeln!(text, "| {} | {} | {} |", novel.name, novel.equation, novel.equations.join(", "));
    }
    text.push_str("\n## Figures\n\n");
    table(&mut text, all);
    if !NOTES.trim().is_empty() {
        let _ = writeln!(text, "\n## Targets not reached\n\n{}", NOTES.trim());
    }
    text.push_str("\n## Detection by level and by kind\n\n");
    levels(&mut text, all);
    text.push_str("\n## Confusion matrix\n\n");
    matrix(&mut text, all);
    text.push_str("\n## Pairs and triples\n\n");
    several(&mut text, all);
    text.push_str("\n## Too faint\n\n");
    faint(&mut text, all);
    text.push_str("\n## Traps\n\n");
    traps(&mut text, all);
    text.push_str("\n## Every failure\n\n");
    failures(&mut text, all);
    let _ = writeln!(text, "\n{}", kept(before));
    text
}

/// The sections that others write, as they stand.
fn kept(before: &str) -> String {
    let sections = KEPT.map(|[begin, end]| match (before.find(begin), before.find(end)) {
        (Some(from), Some(to)) if to > from => before[from..to + end.len()].to_string(),
        _ => format!("{begin}\n{end}"),
    });
    sections.join("\n\n")
}

const METHOD: &str = "\
## How the cases are made

Two generators, neither of which shares code with the simulator that the diagnosis fits with; a test keeps it so.

1. **The same physics, computed otherwise** (`tools/concealed/src/generator/`). The load moves by leapfrog, heat and \
phase by Heun's method in steps of 0.1 ms, hysteresis is a rate law with energy-conserving projection onto the \
outer curves, cold ends are a row of cells. It meets the reference trajectories to 0.03 % of their range, and at \
the true parameters and effects the project's simulator leaves chi 1.00 of its recordings (both are tests).
2. **Another structure** (`tools/concealed/src/second/`). The phase is an ensemble of 40 plays between ramps with \
temperatures from no closed form (Preisach: wiping-out and congruency are tests), heat goes by enthalpy and \
balances to rounding, friction is a bristle, a hanging mass has its pulley's inertia. In half of the cases loss \
follows Churchill and Chu's correlation, ends are cold or the spring is guided with friction. Converters average \
over the on-phase, amplifiers have a slow part, the encoder has lines. Steady temperatures, cold ends, swings and \
the first law are met in closed form (tests). What such a truth holds anyway (other shapes of the curves, cold \
ends, a loss that rises with temperature, a guide's friction) is neither right nor wrong where it is named.

- **Benches** differ in wire (0.1–0.38 mm, 100–400 mm), alloy, load (hanging mass, stiff spring, soft spring), \
supply, taps, sensors (all; position and resistance; position and force; resistance; position) and noise; every \
fifth is *unlike development*: 0.05, 0.076 or 0.45 mm, 50–80 mm or 0.6–1.1 m, 45–80 or 210–280 MPa. The true \
parameters are drawn from the priors of the rig file, cut at 2 σ, and so is what the rig file states as known: \
diameter (1 σ of 1 %), length (0.5 %), taps (0.7 %), supply (0.4 %), shunt (2 %), mass and preload (1.5 %), spring \
(3 %), and the gains of load cell and encoder (1 %). Recordings are 30–60 s at 100 Hz under random stairs, ramps, \
full and partial loops; some are 90 s at 200 Hz. The diagnosis sees one recording or, in every other case, two \
under different programmes; one more only judges it.
- **Level** of an effect: what remains of it, RMS over the noise over all sensors, once every uncertain parameter \
and constant and the sizes of all *other* concealed effects have been refitted by the generator's own least \
squares. Effects are sized to leave 1, 3 or 10, within what rigs show; where that cannot be reached, the level \
reached is the one that counts. A level between 0.5 and 1.7 is counted as 1×, up to 5.5 as 3×, beyond as 10×. What \
leaves less than half the noise is too faint, listed, and counted in no figure. Pairs and triples count where each \
member leaves 3×, what is outside the catalogue where it leaves 3× and more; the tables list all.
- **Nulls**: parameters off, the rig file exactly right, coloured noise (lag-one correlation 0.3–0.9), a coarse \
converter, missing samples, a uniform wire computed with axial nodes, and two kinds of the second truth.
- **Outside the catalogue**: thirteen mechanisms of the first generator, and eight of the second that were never \
used in development. Four of the thirteen come once more as candidates in a laboratory's own file of laws, beside \
three that are not there.
- `thermal.neighbour` is not concealed: a recording of one channel does not hold the other wire's temperature. \
`electrical.supply_sag` and `electrical.lead_resistance` are the same circuit where the supply is recorded ahead of \
its own resistance, so either name is right.
- **Intervals** in brackets are Wilson's, 90 %.
";

fn table(text: &mut String, all: &[Judged]) {
    let f = figures(all);
    text.push_str("| | target | found | reached |\n|---|---|---|---|\n");
    let at_least = |share: &Share, target: f64| met(share.value() >= target, share.of > 0);
    let at_most = |share: &Share, target: f64| met(share.value() <= target, share.of > 0);
    let mut least = |what: &str, share: &Share, target: f64| {
        line(text, what, &format!("≥ {:.0} %", 100.0 * target), &percent(share), at_least(share, target));
    };
    least("3× and 10×: right effect named, or in its declared class", &f.named, 0.97);
    least("3× and 10×: right equation", &f.equation, 0.97);
    least("3×: missing physics reported", &f.detected[&Level::Three], 0.95);
    least("3×: right effect first", &f.first_by_level[&Level::Three], 0.88);
    least("pairs: both named", &f.pairs, 0.9);
    least("triples: all named", &f.triples, 0.65);
    least("outside the catalogue: said, no false effect of a share above 0.1", &f.outside_said, 0.9);
    least("outside the catalogue: right equation", &f.outside_equation, 0.85);
    least("second truth, 3× and 10×: right effect first", &f.second_first, 0.8);
    least("second truth, nulls: nothing named, and curves remain", &f.second_nulls, 0.8);
    least("precision of \"unknown\"", &f.unknown_precision, 0.9);
    least("laws of the laboratory's own, 3× and 10×: named first", &f.own, 0.9);
    let mut most = |what: &str, share: &Share, target: f64| {
        line(text, what, &format!("≤ {:.0} %", 100.0 * target), &percent(share), at_most(share, target));
    };
    most("false alarms on nulls", &f.false_alarms, 0.03);
    most("nulls on which something is suspected", &f.suspected, 0.1);
    most("spurious effects beside right ones", &f.spurious, 0.03);
    let wrong = "outside the catalogue: wrong name that does not predict the second recording either";
    most(wrong, &f.outside_wrong, 0.08);
    line(text, "pairs: both named or in a declared class", "", &percent(&f.pairs_in_class), "");
    line(text, "triples: members named", "", &percent(&f.triple_members), "");
    let alike = "of false names: the second recording is predicted to within its noise all the same";
    line(text, alike, "", &percent(&f.outside_alike), "");
    let outside = f.outside_held_median;
    let reached = met(outside <= 1.5, f.outside_said.of > 0);
    let what = "chi on the recording kept back, outside the catalogue, time-driven ones apart: median";
    line(text, what, "≤ 1.5", &number(outside, 2), reached);
    let reached = met(f.held_median <= 1.15, f.held_good.of > 0);
    let held = format!("{}; at most 1.15 in {}", number(f.held_median, 2), percent(&f.held_good));
    line(text, "chi on the recording kept back, catalogue cases: median", "≤ 1.15", &held, reached);
    let error = f.sizes.median_error;
    let found = format!("{} %", number(100.0 * error, 1));
    line(text, "effect's size: median error", "≤ 15 %", &found, met(error <= 0.15, error.is_finite()));
    let covered = &f.sizes.covered;
    let is = (0.87..=0.93).contains(&covered.value());
    let what = "effect's size: 90 % intervals that hold the truth";
    line(text, what, "87–93 %", &percent(covered), met(is, covered.of > 0));
    let width = f.sizes.median_width;
    let found = format!("{}×", number(width, 2));
    let what = "effect's size: median width of the interval, over the true model's";
    line(text, what, "≤ 2×", &found, met(width <= 2.0, width.is_finite()));
    line(text, "parameters on nulls: 90 % intervals that hold the truth", "", &percent(&f.parameters), "");
    for (cost, what) in [(f.long, "90 s at 200 Hz, 2 threads"), (f.short, "30–60 s at 100 Hz, 1 thread's computing")]
    {
        let Cost { median_s, p95_s, most_s, of, .. } = cost;
        let [middle, high, longest] = [median_s, p95_s, most_s].map(|s| number(s, 1));
        let found = format!("{middle} / {high} / {longest} s ({of} cases)");
        let is = median_s <= 3.0 && p95_s <= 10.0 && most_s <= 30.0;
        let what = format!("time: median / 95 % / longest, {what}");
        line(text, &what, "3 / 10 / 30 s", &found, met(is, of > 0));
    }
    let most = f.long.most_mib.max(f.short.most_mib);
    line(text, "memory: largest", "≤ 300 MB", &format!("{} MiB", number(most, 0)), met(most <= 286.0, true));
    line(text, "traps refused, or warned of and left alone", "", &percent(&f.traps), "");
    line(text, "runs without an answer where one was due", "", &f.no_answer.to_string(), "");
}

fn levels(text: &mut String, all: &[Judged]) {
    let f = figures(all);
    text.push_str("| single effects, level left after refitting | missing physics reported | right effect first |\n");
    text.push_str("|---|---|---|\n");
    for level in Level::ALL {
        let (detected, first) = (percent(&f.detected[&level]), percent(&f.first_by_level[&level]));
        let _ = writeln!(text, "| {} | {detected} | {first} |", level.words());
    }
    text.push_str("\n| nulls | false alarms |\n|---|---|\n");
    for (kind, share) in &f.false_alarms_by_kind {
        let _ = writeln!(text, "| {kind} | {} |", percent(share));
    }
    text.push_str("\n| outside the catalogue | level | reported | blamed equation | chi, second recording |\n");
    text.push_str("|---|---|---|---|---|\n");
    for j in all.iter().filter(|j| j.answer.group == "outside") {
        let equation = j.reported.equation.as_deref().unwrap_or("–");
        let right = if j.equation_right() { "" } else { " (wrong)" };
        let unknown = if j.reported.reports_unknown() && j.first() != "unknown" { ", and unknown" } else { "" };
        let first = j.first();
        let held = number(j.reported.held.unwrap_or(f64::NAN), 2);
        let (kind, level) = (&j.answer.kind, j.answer.level);
        let _ = writeln!(text, "| {kind} | {level:.1} | {first}{unknown} | {equation}{right} | {held} |");
    }
}

fn matrix(text: &mut String, all: &[Judged]) {
    let counts = confusion(all);
    let plain = ["nothing", "unknown", "no answer"];
    let names: BTreeSet<&str> = counts
        .keys()
        .chain(counts.values().flat_map(BTreeMap::keys))
        .map(String::as_str)
        .filter(|n| n.contains('.'))
        .collect();
    let numbers: BTreeMap<&str, usize> = names.iter().enumerate().map(|(i, name)| (*name, i + 1)).collect();
    text.push_str(
        "Rows: what was concealed, at every level. Columns: what was reported first, by the number of its row; – nothing, \
         ? unknown physics, ✕ no answer.\n\n| | |",
    );
    for (_, number) in numbers.iter() {
        let _ = write!(text, " {number} |");
    }
    text.push_str(" – | ? | ✕ |\n|---|---|");
    text.push_str(&"---|".repeat(numbers.len() + plain.len()));
    text.push('\n');
    let rows = names.iter().copied().chain(["nothing", "outside the catalogue"]);
    for name in rows {
        let label = numbers.get(name).map_or_else(String::new, ToString::to_string);
        let _ = write!(text, "| {label} | {name} |");
        for said in names.iter().copied().chain(plain) {
            let count = counts.get(name).and_then(|row| row.get(said)).copied().unwrap_or(0);
            let cell = match count {
                0 => String::new(),
                n if said == name => format!("**{n}**"),
                n => n.to_string(),
            };
            let _ = write!(text, " {cell} |");
        }
        text.push('\n');
    }
}

fn several(text: &mut String, all: &[Judged]) {
    text.push_str("| case | concealed, with the level each leaves alone | reported | right |\n|---|---|---|---|\n");
    for j in all.iter().filter(|j| j.answer.group == "several") {
        let there: Vec<String> = j.answer.levels.iter().map(|(id, level)| format!("{id} {level:.1}")).collect();
        let right = if j.right() { "yes" } else { "no" };
        let _ = writeln!(text, "| {} | {} | {} | {right} |", j.answer.name, there.join(", "), everything_said(j));
    }
}

/// What refitting hides: counted nowhere.
fn faint(text: &mut String, all: &[Judged]) {
    text.push_str("Less than half the noise is left of these: they count in no figure.\n\n");
    text.push_str("| case | concealed | level meant | level left |\n|---|---|---|---|\n");
    for j in all {
        let a = &j.answer;
        let Some(target) = a.target else { continue };
        for (id, level) in a.levels.iter().filter(|(_, level)| Level::of(**level) == Level::Hidden) {
            let _ = writeln!(text, "| {} | {id} | {target:.0} | {level:.2} |", a.name);
        }
    }
}

fn traps(text: &mut String, all: &[Judged]) {
    text.push_str("| trap | reported | right |\n|---|---|---|\n");
    for j in all.iter().filter(|j| j.answer.group == "trap") {
        let said = match &j.reported.verdict {
            None => format!("refused: {}", one_line(&j.reported.trouble)),
            Some(verdict) => format!("{verdict}; {}", one_line(&j.reported.warnings.join("; "))),
        };
        let _ = writeln!(text, "| {} | {said} | {} |", j.answer.kind, if j.right() { "yes" } else { "no" });
    }
}

/// The text of a table's cell, without what belongs to this machine: paths.
fn one_line(words: &str) -> String {
    let words: Vec<String> = words
        .split_whitespace()
        .map(|word| match word.rsplit_once('/') {
            Some((folder, file)) if folder.starts_with('/') => file.to_string(),
            _ => word.to_string(),
        })
        .collect();
    let text = words.join(" ").replace('|', "/");
    if text.chars().count() > 160 { text.chars().take(157).chain("…".chars()).collect() } else { text }
}

fn everything_said(j: &Judged) -> String {
    match j.reported.verdict.as_deref() {
        None => "no answer".into(),
        Some(verdict) if j.reported.effects.is_empty() => verdict.into(),
        Some(_) => {
            let ids: Vec<&str> = j.reported.effects.iter().map(|e| e.id.as_str()).collect();
            let unknown = if j.reported.reports_unknown() { ", and unknown" } else { "" };
            ids.join(", ") + unknown
        }
    }
}

/// What a person found to be the cause of a failure; empty where nobody looked.
fn cause(name: &str) -> &'static str {
    CAUSES.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": ")).unwrap_or_default()
}

fn failures(text: &mut String, all: &[Judged]) {
    let wrong: Vec<&Judged> = all.iter().filter(|j| !j.right() && j.answer.group != "trap").collect();
    let _ = writeln!(
        text,
        "{} of {} cases, traps apart. A single effect counts as failed where another is reported first. chi is over all \
         sensors: of what refitting leaves (level), of the improved rig file on the second recording.\n",
        wrong.len(),
        all.len()
    );
    text.push_str("| case | seed | concealed | level | what went wrong | reported | reported as alike | chi, kept back | cause |\n");
    text.push_str("|---|---|---|---|---|---|---|---|---|\n");
    for j in wrong {
        let class: BTreeSet<&str> =
            j.reported.effects.iter().flat_map(|e| e.class.iter().map(String::as_str)).collect();
        let class: Vec<&str> = class.into_iter().collect();
        let trouble =
            if j.reported.trouble.is_empty() { String::new() } else { format!(": {}", one_line(&j.reported.trouble)) };
        let held = j.reported.held.map_or_else(|| "–".into(), |chi| number(chi, 2));
        let a = &j.answer;
        let said = everything_said(j);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.1} | {} | {said}{trouble} | {} | {held} | {} |",
            a.name,
            a.seed,
            a.kind,
            a.level,
            j.failure().unwrap_or_default(),
            class.join(", "),
            cause(&a.name)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_concealed::reported::Reported;

    use crate::score::tests::{made_up, names, says};

    fn hashes() -> Hashes {
        Hashes { plan: "ab".into(), generators: "cd".into() }
    }

    fn cases() -> Vec<Judged> {
        vec![
            made_up("null", &[], 0.0, says("agrees")),
            made_up("single", &["kinetic.lag"], 3.1, names(&["kinetic.minor_loop"], &["kinetic.lag"])),
            made_up("several", &["kinetic.lag", "thermal.sheath"], 3.1, names(&["kinetic.lag"], &[])),
            made_up("outside", &[], 9.0, says("unknown_physics")),
            made_up("trap", &[], 0.0, Reported::refused("/tmp/here/train.csv.gz: line 3 | too short")),
        ]
    }

    #[test]
    fn every_part_is_there_and_every_failure_is_listed() {
        let page = page(&cases(), None, "");
        for part in ["## Figures", "## Confusion matrix", "## Pairs and triples", "## Traps", "## Every failure"] {
            assert!(page.contains(part), "{part}");
        }
        let failures = page.split("## Every failure").nth(1).expect("the list");
        let row = "kinetic.lag | 3.1 | in the declared class, another first | kinetic.minor_loop | kinetic.lag";
        assert!(failures.contains(row), "{failures}");
        assert_eq!(failures.matches("d001").count(), 2);
        assert!(!page.contains("/tmp/"), "a path of this machine");
        assert!(page.contains("refused: train.csv.gz: line 3 / too short"));
        assert!(page.contains("**development**"));
    }

    #[test]
    fn what_others_wrote_is_kept() {
        let [[begin, end], [first, last]] = KEPT;
        let real = format!("{begin}\n## Real recordings\nas found\n{end}\n\n{first}\nothers\n{last}");
        let page = page(&cases(), Some(&hashes()), &format!("# Old\n{real}\nstood here before"));
        assert!(page.contains(&real) && !page.contains("# Old") && !page.contains("stood here before"));
        let again = super::page(&[], Some(&hashes()), &page);
        assert!(again.contains(&real));
    }

    #[test]
    fn a_share_shows_its_interval() {
        assert_eq!(percent(&Share::new(5, 100)), "5 % (2–10), 5 of 100");
        assert_eq!(percent(&Share::new(0, 0)), "–");
    }
}
