//! The page: who wins and why, what the thesis found, steps, sines, estimates, what is misjudged, every row.

use maud::{Markup, html};
use sinew_plot::quantity::{NONE, fixed};
use sinew_plot::{Axis, Ink, Line, Panels, Plot, Section, Sheet, TWO_IN_A_ROW, sample};

use crate::answer::Answer;
use crate::findings::Finding;
use crate::row::{FREQUENCIES_HZ, Figures, Row, SINE, STEPS, Trace};
use crate::score::{self, Place, TARGETS, WORST};
use crate::{BAND, Family, Ran, sensing};

/// A plot over the page's whole width, and one of two side by side, px.
const WIDE: (f64, f64) = (940.0, 300.0);
const HALF: (f64, f64) = (460.0, 260.0);
/// Most points of a line.
const POINTS: usize = 700;
/// The wire that is drawn, unless it was not run.
const SHOWN: &str = "figure";
/// Choices of the ranking that are in sight at once.
const IN_SIGHT: usize = 12;
/// A law that makes nothing of the estimate.
const INDIFFERENT: &str = "pi";
/// Laws that are drawn over each other; more would be a tangle.
const DRAWN: usize = 5;

/// The page: `report.html`.
pub fn page(answer: &Answer, ran: &[Ran]) -> String {
    let view = View::of(answer, ran);
    let sections = vec![
        Section::unlisted(winner(&view)),
        Section::new("ranking", "Ranking", ranking(&view)),
        Section::new("findings", "Findings", findings(answer)),
        Section::new("steps", "Steps", steps(&view)),
        Section::new("sines", "Sines", sines(&view)),
        Section::new("estimates", "Estimates", estimates(&view)),
        Section::new("misjudged", "Misjudged", misjudged(&view)),
        Section::new("joints", "Joints", joints(answer)),
        Section::new("sensing", "Sensing", measured(&answer.sensing)),
        Section::new("bound", "Bound", bound()),
        Section::new("rows", "Rows", rows(answer)),
        Section::new("again", "Reproduce", again(answer)),
    ];
    Sheet {
        title: "sinew bench control".into(),
        class: "agrees",
        heading: html! { "Every controller and estimator on the same plants" },
        sections,
    }
    .page()
    .into_string()
}

/// The pictures of the documentation, each with the name of its file.
pub fn pictures(answer: &Answer, ran: &[Ran]) -> Vec<(&'static str, String)> {
    let view = View::of(answer, ran);
    let laws = view.laws();
    let legend = |laws: &[&Row]| -> Vec<(Ink, String)> {
        laws.iter().map(|row| (view.ink_of_law(row), words(&row.controller))).collect()
    };
    let drawn = &laws[..laws.len().min(DRAWN)];
    let steps = Panels {
        title: String::new(),
        row: TWO_IN_A_ROW,
        legend: [(Ink::Measured, "reference".to_owned())].into_iter().chain(legend(drawn)).collect(),
        panels: view.step_plots(drawn, HALF),
    };
    let reach = [(Ink::Measured, REACHABLE.to_owned())].into_iter().filter(|_| !view.reachable.0.is_empty());
    let sines = Panels {
        title: String::new(),
        row: TWO_IN_A_ROW,
        legend: reach.chain(legend(&laws)).collect(),
        panels: vec![("Error on sines".into(), view.sine_plot(&laws, WIDE))],
    };
    let estimators = view.estimators(view.indifferent());
    let draughts = Panels {
        title: String::new(),
        row: TWO_IN_A_ROW,
        legend: [(Ink::Measured, "true temperature".to_owned())]
            .into_iter()
            .chain(estimators.iter().enumerate().map(|(i, row)| (Ink::Series(i as u8), words(&row.estimator))))
            .collect(),
        panels: view.draught_plots(&estimators, HALF),
    };
    let drawings = [("steps.svg", steps), ("sines.svg", sines), ("draught.svg", draughts)];
    drawings
        .into_iter()
        .filter(|(_, panels)| !panels.panels.is_empty())
        .map(|(name, panels)| (name, panels.draw().into_string()))
        .collect()
}

/// What is drawn of an answer.
struct View<'a> {
    answer: &'a Answer,
    ran: &'a [Ran],
    /// The plant that is drawn.
    plant: &'a str,
    /// Laws in the rig file's order, which gives each its ink.
    controllers: Vec<&'a str>,
    /// Frequencies, and the errors that can be reached there.
    reachable: (Vec<f64>, Vec<f64>),
}

/// What the reachable error is called in legends.
const REACHABLE: &str = "least error that was found for whoever knows everything in advance";

impl<'a> View<'a> {
    fn of(answer: &'a Answer, ran: &'a [Ran]) -> View<'a> {
        let mut controllers: Vec<&str> = Vec::new();
        for row in &answer.rows {
            if !controllers.contains(&row.controller.as_str()) {
                controllers.push(&row.controller);
            }
        }
        let there = answer.plants.iter().any(|about| about.plant == SHOWN);
        let first = answer.plants.first().map_or(SHOWN, |about| about.plant);
        let plant = if there { SHOWN } else { first };
        let reachable = answer.reachable.iter().filter(|one| one.plant == plant);
        let reachable = reachable.map(|one| (one.frequency_hz, one.rms_percent)).unzip();
        View { answer, ran, plant, controllers, reachable }
    }

    fn ink_of_law(&self, row: &Row) -> Ink {
        Ink::Series(self.controllers.iter().position(|word| *word == row.controller).unwrap_or(0) as u8)
    }

    fn row(&self, place: &Place, plant: &str) -> Option<&'a Row> {
        self.answer.rows.iter().find(|row| {
            row.plant == plant
                && row.controller == place.controller
                && row.estimator == place.estimator
                && row.sensing == place.sensing
        })
    }

    /// Each law's best row on the plant that is drawn, the best law first.
    fn laws(&self) -> Vec<&'a Row> {
        let mut laws: Vec<&Row> = Vec::new();
        for place in &self.answer.ranking {
            if laws.iter().all(|row| row.controller != place.controller)
                && let Some(row) = self.row(place, self.plant)
            {
                laws.push(row);
            }
        }
        laws
    }

    /// Each estimator under a law, measured as the winner measures.
    fn estimators(&self, controller: &str) -> Vec<&'a Row> {
        let Some(best) = self.answer.winner() else { return Vec::new() };
        let mut found: Vec<&Row> = Vec::new();
        for row in &self.answer.rows {
            if row.plant == self.plant
                && row.controller == controller
                && row.sensing == best.sensing
                && found.iter().all(|other| other.estimator != row.estimator)
            {
                found.push(row);
            }
        }
        found
    }

    /// The law under which estimators are compared: one that needs none, so that all see the same; else the winner.
    fn indifferent(&self) -> &'a str {
        let winner = self.answer.winner().map_or("", |best| best.controller.as_str());
        self.controllers.iter().copied().find(|word| *word == INDIFFERENT).unwrap_or(winner)
    }

    fn traces(&self, row: &Row) -> Option<&'a crate::Traces> {
        let same = |other: &Row| {
            (&other.controller, &other.estimator, &other.sensing, &other.plant)
                == (&row.controller, &row.estimator, &row.sensing, &row.plant)
        };
        self.ran.iter().find(|ran| same(&ran.row))?.traces.as_ref()
    }

    /// The steps over time, and the end of each step close to its reference.
    fn step_plots(&self, laws: &[&'a Row], size: (f64, f64)) -> Vec<(String, Plot<'a>)> {
        let traces: Vec<(Ink, &Trace)> =
            laws.iter().filter_map(|row| Some((self.ink_of_law(row), &self.traces(row)?.steps))).collect();
        let Some((_, first)) = traces.first() else { return Vec::new() };
        let end = first.time_s.last().copied().unwrap_or(1.0);
        let reference = [Line { x: &first.time_s, y: &first.reference, ink: Ink::Measured }];
        let lines = |of: fn(&Trace) -> &[f64]| {
            traces.iter().map(move |(ink, trace)| Line { x: &trace.time_s, y: of(trace), ink: *ink })
        };
        let plot = |title: &str, x: Axis, y: Axis, lines: Vec<Line<'a>>| Plot {
            title: title.into(),
            size,
            x,
            y,
            names_x: true,
            bands: Vec::new(),
            noise: None,
            lines,
            points: POINTS,
        };
        let stroke: Vec<Line<'a>> = reference.into_iter().chain(lines(|trace| &trace.stroke)).collect();
        let first_step = end / STEPS.len() as f64;
        let begins = |trace: &Trace| trace.time_s.partition_point(|time| *time < first_step);
        let close = |trace: &'a Trace, y: &'a [f64], ink: Ink| {
            let count = begins(trace);
            Line { x: &trace.time_s[..count], y: &y[..count], ink }
        };
        let close: Vec<Line<'a>> = std::iter::once(close(first, &first.reference, Ink::Measured))
            .chain(traces.iter().map(|(ink, trace)| close(trace, &trace.stroke, *ink)))
            .collect();
        vec![
            (
                "Stroke (true length, 0 cold, 1 hot)".into(),
                plot(
                    "Steps over time",
                    Axis::spanning("Time", "s", 0.0, end),
                    Axis::spanning("", "1", -0.05, 0.9),
                    stroke,
                ),
            ),
            (
                "The first step, close to its reference".into(),
                plot(
                    "The first step close to its reference",
                    Axis::spanning("Time", "s", 0.0, first_step),
                    Axis::spanning("", "1", STEPS[0] - 8.0 * BAND, STEPS[0] + 8.0 * BAND),
                    close,
                ),
            ),
        ]
    }

    fn sine_plot(&'a self, laws: &[&'a Row], size: (f64, f64)) -> Plot<'a> {
        let reachable = Line { x: &self.reachable.0, y: &self.reachable.1, ink: Ink::Measured };
        let lines = laws.iter().filter_map(|row| {
            let figures = row.figures.as_ref()?;
            Some(Line { x: &FREQUENCIES_HZ, y: &figures.tracking_percents, ink: self.ink_of_law(row) })
        });
        let lines = std::iter::once(reachable).chain(lines);
        let [low, .., high] = FREQUENCIES_HZ;
        Plot {
            title: "RMS error over frequency".into(),
            size,
            x: Axis::decades("Frequency", "Hz", low, high),
            y: Axis::decades("", "%", 0.1, 40.0),
            names_x: true,
            bands: Vec::new(),
            noise: None,
            lines: lines.collect(),
            points: POINTS,
        }
    }

    /// True and estimated temperature through the draught and through the steps.
    fn draught_plots(&self, rows: &[&'a Row], size: (f64, f64)) -> Vec<(String, Plot<'a>)> {
        let traces: Vec<&crate::Traces> = rows.iter().filter_map(|row| self.traces(row)).collect();
        let Some(first) = traces.first() else { return Vec::new() };
        let plot = |title: &str, pick: fn(&crate::Traces) -> &Trace| {
            let truth = pick(first);
            let all = || traces.iter().map(move |traces| pick(traces));
            let end = truth.time_s.last().copied().unwrap_or(1.0);
            let values = all().flat_map(|trace| trace.estimated_c.iter().chain(&trace.temperature_c)).copied();
            let estimates = all().enumerate().map(|(i, trace)| Line {
                x: &trace.time_s[..],
                y: &trace.estimated_c[..],
                ink: Ink::Series(i as u8),
            });
            let truth = Line { x: &truth.time_s[..], y: &truth.temperature_c[..], ink: Ink::Measured };
            Plot {
                title: title.into(),
                size,
                x: Axis::spanning("Time", "s", 0.0, end),
                y: Axis::around("", "°C", values),
                names_x: true,
                bands: Vec::new(),
                noise: None,
                lines: std::iter::once(truth).chain(estimates).collect(),
                points: POINTS,
            }
        };
        vec![
            ("Held at 50 %, a draught from 0 s on: temperature, °C".into(), plot("Through a draught", |t| &t.draught)),
            ("Steps: temperature, °C".into(), plot("Through the steps", |t| &t.steps)),
        ]
    }
}

/// A word of the rig file as a reader wants it.
fn words(word: &str) -> String {
    word.replace('_', " ")
}

fn percent(value: f64) -> String {
    fixed(value, if value.abs() < 9.995 { 2 } else { 1 })
}

fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or(NONE.into(), |value| fixed(value, decimals))
}

fn winner(view: &View<'_>) -> Markup {
    let answer = view.answer;
    let Some(best) = answer.winner() else {
        return html! { section #answer { h1 { "Nothing was ranked" } p { "None of the rows is on a plant that counts." } } };
    };
    let default = &answer.default;
    let is_default = (&best.controller, &best.estimator, &best.sensing)
        == (&default.controller, &default.estimator, &default.sensing);
    let figures = view.row(best, view.plant).and_then(|row| row.figures.as_ref());
    html! {
        section #answer {
            p.verdict { (answer.rows.len()) " rows, " (answer.plants.len()) " plants, " (answer.seeds.len()) @if answer.seeds.len() == 1 { " seed" } @else { " seeds" } }
            h1 { (capitalised(&words(&best.controller))) " with the " (words(&best.estimator)) " estimator wins" }
            p.lead {
                @if is_default { "It is what a fresh rig file has." }
                @else {
                    "A fresh rig file has " b { (words(&default.controller)) } " with " b { (words(&default.estimator)) }
                    @if let Some(place) = place_of_default(answer) { ", place " (place) " here." } @else { ", which was not run." }
                }
                " Its figures on the wire of the figures (" code { (view.plant) } "):"
            }
            @if let Some(figures) = figures {
                ol.figures {
                    @for target in &TARGETS {
                        @let value = (target.figure)(figures);
                        li {
                            span.name { (capitalised(target.name)) }
                            span.value.good[value <= target.most] { (percent(value)) @if target.unit == "%" { " %" } }
                            span.about { "wanted: at most " (target.most) @if target.unit == "%" { " % of the stroke" } }
                        }
                    }
                }
            }
        }
    }
}

fn place_of_default(answer: &Answer) -> Option<usize> {
    let default = &answer.default;
    let is = |place: &Place| {
        place.controller == default.controller
            && place.estimator == default.estimator
            && place.sensing == default.sensing
    };
    Some(answer.ranking.iter().position(is)? + 1)
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn ranking(view: &View<'_>) -> Markup {
    let places = &view.answer.ranking;
    let table = |places: &[Place], from: usize| {
        html! {
            div.scroll {
                table {
                    thead {
                        tr {
                            th.n scope="col" { "" } th scope="col" { "controller" } th scope="col" { "estimator" } th scope="col" { "sensing" }
                            th.n scope="col" { "score" } th scope="col" {} th.n scope="col" { "known" } th.n scope="col" { "misjudged" }
                        }
                    }
                    tbody {
                        @for (i, place) in places.iter().enumerate() {
                            tr.chosen[from + i == 0] {
                                td.n.muted { (from + i + 1) }
                                th scope="row" { (words(&place.controller)) }
                                td { (words(&place.estimator)) }
                                td { (words(&place.sensing)) }
                                td.n { (fixed(place.score, 2)) }
                                td { (bar(place.score / WORST)) }
                                td.n { (fixed(place.known, 2)) }
                                td.n { (fixed(place.misjudged, 2)) }
                            }
                        }
                    }
                }
            }
        }
    };
    let in_sight = places.len().min(IN_SIGHT);
    html! {
        section #ranking {
            h2 { "Ranking" }
            p {
                "The score of a row is the mean of its figures over what is wanted of them: "
                @for (i, target) in TARGETS.iter().enumerate() {
                    @if i > 0 { ", " }
                    (target.name) " ≤ " (target.most) @if target.unit == "%" { " %" }
                }
                ". A figure counts at most " (WORST) " times; a fault makes all of them count so. 1 would be everything just reached. "
                "A choice's score is the mean over the plants its driver knows and over those it misjudges, half each; the thesis' own plants do not count."
            }
            (table(&places[..in_sight], 0))
            @if places.len() > in_sight {
                details { summary { (places.len() - in_sight) " more" } (table(&places[in_sight..], in_sight)) }
            }
        }
    }
}

/// A bar for a share of 0 to 1.
fn bar(share: f64) -> Markup {
    let width = if share.is_finite() { (100.0 * share.clamp(0.0, 1.0)).round() } else { 0.0 };
    html! {
        svg.bar.short viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true" {
            rect.rail width="100" height="10" {}
            rect.filled width=(width) height="10" {}
        }
    }
}

fn findings(answer: &Answer) -> Markup {
    html! {
        section #findings {
            h2 { "What the thesis found" }
            div.scroll {
                table {
                    thead { tr { th scope="col" { "finding" } th scope="col" { "here" } th scope="col" { "again?" } } }
                    tbody { @for finding in &answer.findings { (found(finding)) } }
                }
            }
        }
    }
}

fn found(finding: &Finding) -> Markup {
    html! {
        tr {
            th scope="row" { (finding.finding) }
            td { (finding.here) br; small.muted { "Counts if: " (finding.criterion) "." } }
            td {
                @match finding.reproduced {
                    Some(true) => b.good { "yes" },
                    Some(false) => b.bad { "no" },
                    None => span.muted { (NONE) },
                }
            }
        }
    }
}

fn legend(entries: &[(Ink, String)]) -> Markup {
    html! { ul.legend { @for (ink, name) in entries { li { (sample(*ink)) (name) } } } }
}

fn figure(caption: &str, plot: &Plot<'_>) -> Markup {
    html! { figure { figcaption { (caption) } div.scroll { (plot.draw()) } } }
}

fn steps(view: &View<'_>) -> Markup {
    let laws = view.laws();
    let drawn = &laws[..laws.len().min(DRAWN)];
    let entries: Vec<(Ink, String)> = [(Ink::Measured, "reference".to_owned())]
        .into_iter()
        .chain(drawn.iter().map(|row| (view.ink_of_law(row), words(&row.controller))))
        .collect();
    html! {
        section #steps {
            h2 { "Steps" }
            p { "Each law with the estimator it does best with, on " code { (view.plant) } ", first seed. Settled is within ±" (100.0 * BAND) " % of the stroke for good." }
            (legend(&entries))
            @for (caption, plot) in view.step_plots(drawn, WIDE) { (figure(&caption, &plot)) }
            (step_table(&laws))
        }
    }
}

fn step_table(rows: &[&Row]) -> Markup {
    html! {
        div.scroll {
            table.steps {
                thead {
                    tr {
                        th scope="col" rowspan="2" { "controller" }
                        th.n scope="colgroup" colspan="3" { "shorter" }
                        th.n scope="colgroup" colspan="3" { "longer" }
                        th.n scope="col" rowspan="2" { "settled" br; "at all" }
                        th.n scope="colgroup" colspan="2" { "overshoot, %" }
                        th.n scope="col" rowspan="2" { "steady" br; "RMS, %" }
                        th.n scope="col" rowspan="2" { "limit" br; "cycle, ± %" }
                        th.n scope="col" rowspan="2" { "energy" br; "J" }
                        th.n scope="col" rowspan="2" { "switch-" br; "ings, 1/s" }
                    }
                    tr {
                        @for _ in 0..2 { th.n scope="col" { "settled, s" } th.n scope="col" { "bound, s" } th.n scope="col" { "ratio" } }
                        th.n scope="col" { "median" } th.n scope="col" { "worst" }
                    }
                }
                tbody {
                    @for row in rows {
                        @if let Some(f) = &row.figures {
                            tr {
                                th scope="row" { (words(&row.controller)) }
                                td.n { (optional(f.settling_up_s, 2)) } td.n.muted { (optional(f.bound_up_s, 2)) } td.n { (optional(f.ratio_up, 2)) }
                                td.n { (optional(f.settling_down_s, 2)) } td.n.muted { (optional(f.bound_down_s, 2)) } td.n { (optional(f.ratio_down, 2)) }
                                td.n { (fixed(100.0 * f.settled, 0)) " %" }
                                td.n { (percent(f.overshoot_percent)) } td.n { (percent(f.overshoot_worst_percent)) }
                                td.n { (percent(f.steady_rms_percent)) }
                                td.n { (percent(f.limit_cycle_percent)) }
                                td.n { (fixed(f.energy_j, 1)) }
                                td.n { (fixed(f.switchings_per_s, 1)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn sines(view: &View<'_>) -> Markup {
    let laws = view.laws();
    let entries: Vec<(Ink, String)> = [(Ink::Measured, REACHABLE.to_owned())]
        .into_iter()
        .filter(|_| !view.reachable.0.is_empty())
        .chain(laws.iter().map(|row| (view.ink_of_law(row), words(&row.controller))))
        .collect();
    let reachable = |frequency: f64| {
        let place = view.reachable.0.iter().position(|one| *one == frequency)?;
        view.reachable.1.get(place).copied()
    };
    html! {
        section #sines {
            h2 { "Sines" }
            p {
                "RMS error on a sine of " (100.0 * SINE.0) " % of the stroke from peak to peak around " (100.0 * SINE.1)
                " %, in % of the stroke, on " code { (view.plant) } ". Doing nothing but standing in the middle would give "
                (fixed(100.0 * SINE.0 / 8f64.sqrt(), 1)) " %."
            }
            (legend(&entries))
            (figure("RMS error, % of the stroke", &view.sine_plot(&laws, WIDE)))
            div.scroll {
                table {
                    thead { tr { th scope="col" { "controller" } @for f in FREQUENCIES_HZ { th.n scope="col" { (f) " Hz" } } } }
                    tbody {
                        @if !view.reachable.0.is_empty() {
                            tr {
                                th.muted scope="row" { "least that was found" }
                                @for f in FREQUENCIES_HZ { td.n.muted { (reachable(f).map_or(NONE.into(), percent)) } }
                            }
                        }
                        @for row in &laws {
                            @if let Some(figures) = &row.figures {
                                tr {
                                    th scope="row" { (words(&row.controller)) }
                                    @for value in &figures.tracking_percents { td.n { (percent(*value)) } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn estimates(view: &View<'_>) -> Markup {
    let rows = view.estimators(view.indifferent());
    let entries: Vec<(Ink, String)> = [(Ink::Measured, "true".to_owned())]
        .into_iter()
        .chain(rows.iter().enumerate().map(|(i, row)| (Ink::Series(i as u8), words(&row.estimator))))
        .collect();
    let best = view.answer.winner().map_or("", |best| best.controller.as_str());
    html! {
        section #estimates {
            h2 { "Estimates" }
            p {
                "Each estimator on " code { (view.plant) } " under " (words(view.indifferent()))
                ", which makes nothing of the estimate, so that all see the same wire. The draught takes half as much heat again, and nobody tells the driver."
            }
            (legend(&entries))
            div.pair { @for (caption, plot) in view.draught_plots(&rows, HALF) { (figure(&caption, &plot)) } }
            div.scroll {
                table {
                    thead {
                        tr {
                            th scope="col" { "estimator" }
                            th.n scope="col" { "temperature" br; "RMS, K" } th.n scope="col" { "martensite" br; "RMS" }
                            th.n scope="col" { "length" br; "RMS, %" } th.n scope="col" { "draught: temperature" br; "off after 1 s, K" }
                        }
                    }
                    tbody {
                        @for row in &rows {
                            @if let Some(f) = &row.figures {
                                tr {
                                    th scope="row" { (words(&row.estimator)) }
                                    td.n { (percent(f.temperature_rms_k)) } td.n { (fixed(f.martensite_rms, 3)) } td.n { (percent(f.length_rms_percent)) }
                                    td.n { (fixed(f.draught.temperature_error_k, 1)) }
                                }
                            }
                        }
                    }
                }
            }
            p { "What they make of " (words(best)) ": how far a disturbance moves the wire from where it is held, in % of the stroke, and how far off the temperature then is." }
            div.scroll {
                table {
                    thead {
                        tr {
                            th scope="col" { "estimator" } th.n scope="col" { "draught" br; "+50 %" } th.n scope="col" { "its temperature" br; "off after 1 s, K" }
                            th.n scope="col" { "load" br; "+20 %" } th.n scope="col" { "supply" br; "−10 %" } th.n scope="col" { "steps: settled" br; "over the bound, up" } th.n scope="col" { br; "down" }
                        }
                    }
                    tbody {
                        @for row in view.estimators(best) {
                            @if let Some(f) = &row.figures {
                                tr {
                                    th scope="row" { (words(&row.estimator)) }
                                    td.n { (percent(f.draught.deviation_percent)) } td.n { (fixed(f.draught.temperature_error_k, 1)) }
                                    td.n { (percent(f.load_step.deviation_percent)) } td.n { (percent(f.supply_sag.deviation_percent)) }
                                    td.n { (optional(f.ratio_up, 2)) } td.n { (optional(f.ratio_down, 2)) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Scores of each law's best choice on every plant.
fn misjudged(view: &View<'_>) -> Markup {
    let answer = view.answer;
    let laws = view.laws();
    let cell = |row: Option<&Row>| match row.and_then(score::of_row) {
        Some(score) => html! {
            td.n.heat style={ "--share:" (fixed(100.0 * (score / WORST).clamp(0.0, 1.0), 0)) "%" } { (fixed(score, 1)) }
        },
        None => html! { td.n.muted { (NONE) } },
    };
    let on = |law: &Row, plant: &str| {
        answer.rows.iter().find(|row| {
            (&row.controller, &row.estimator, &row.sensing) == (&law.controller, &law.estimator, &law.sensing)
                && row.plant == plant
        })
    };
    html! {
        section #misjudged {
            h2 { "Plants, known and misjudged" }
            p { "The score of each law with its best estimator; paler is better." }
            div.scroll {
                table.heats {
                    thead {
                        tr {
                            th scope="col" { "plant" }
                            @for law in &laws { th.n.turned scope="col" { span { (words(&law.controller)) } } }
                        }
                    }
                    @for (family, title) in [(Family::Known, "known"), (Family::Misjudged, "misjudged"), (Family::Thesis, "the thesis' own (not in the ranking)")] {
                        @let plants: Vec<_> = answer.plants.iter().filter(|about| about.family == family).collect();
                        @if !plants.is_empty() {
                            tbody {
                                tr { th.muted colspan=(laws.len() + 1) scope="rowgroup" { (title) } }
                                @for about in plants {
                                    tr {
                                        th scope="row" { code { (about.plant) } br; small.muted { (about.about) } }
                                        @for law in &laws { (cell(on(law, about.plant))) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Two wires that turn a joint against each other.
fn joints(answer: &Answer) -> Markup {
    let pairs: Vec<&Row> = answer.rows.iter().filter(|row| row.family == Family::Pair).collect();
    let about = |row: &Row| {
        answer.plants.iter().find(|about| about.plant == row.plant).map(|about| about.about).unwrap_or_default()
    };
    html! {
        section #joints {
            h2 { "Two wires on a joint" }
            @if pairs.is_empty() {
                p.muted { "Not in this run." }
            } @else {
                p {
                    "What pulls the lone wire long again is its load, as fast as the air cools it. On a joint the other wire pulls: with the joint's own law, at the same sines, in % of the agonist's stroke. "
                    "No bound is known here, and none of it is in the ranking."
                }
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" rowspan="2" { "pair" } th.n scope="colgroup" colspan=(FREQUENCIES_HZ.len()) { "RMS error on sines, %" }
                                th.n scope="col" rowspan="2" { "steady" br; "RMS, %" } th.n scope="col" rowspan="2" { "over-" br; "shoot, %" }
                                th.n scope="col" rowspan="2" { "draught:" br; "moved, %" } th.n scope="col" rowspan="2" { "tempera-" br; "ture, K" } th.n scope="col" rowspan="2" { "energy" br; "J" }
                            }
                            tr { @for f in FREQUENCIES_HZ { th.n scope="col" { (f) " Hz" } } }
                        }
                        tbody {
                            @for row in &pairs {
                                @if let Some(f) = &row.figures {
                                    tr {
                                        th scope="row" { code { (row.plant) } br; small.muted { (about(row)) } }
                                        @for value in &f.tracking_percents { td.n { (percent(*value)) } }
                                        td.n { (percent(f.steady_rms_percent)) } td.n { (percent(f.overshoot_percent)) }
                                        td.n { (percent(f.draught.deviation_percent)) } td.n { (fixed(f.draught.temperature_error_k, 1)) } td.n { (fixed(f.energy_j, 1)) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Chapter 7's experiment.
fn measured(report: &sensing::Report) -> Markup {
    let word = |value: &dyn std::fmt::Debug| words(&format!("{value:?}").to_lowercase());
    let clean = |row: &&sensing::Row| {
        row.condition == sensing::Condition::Clean && row.noise == "part" && row.taps == sensing::Place::Long
    };
    html! {
        section #sensing {
            h2 { "The length, measured" }
            p {
                "Chapter 7's experiment in simulation: a wire under 100 to 300 gf, heated and cooled slowly; RMS error of single samples over all loads. The thesis found "
                (report.thesis.dual_mm) " mm, " (report.thesis.dual_percent) " % of the stroke, by two taps and " (report.thesis.resistance_percent) " % by resistance alone."
            }
            div.scroll {
                table {
                    thead {
                        tr {
                            th scope="col" { "taps" } th scope="col" { "heated by" } th scope="col" { "noise" }
                            th.n scope="col" { "two taps, mm" } th.n scope="col" { "two taps, %" } th.n scope="col" { "resistance, %" }
                        }
                    }
                    tbody {
                        @for row in &report.summary {
                            tr {
                                th scope="row" { (word(&row.taps)) } td { (word(&row.heating)) } td { (row.noise) }
                                td.n { (fixed(row.dual_mm, 3)) } td.n { (percent(row.dual_percent)) } td.n { (percent(row.resistance_percent)) }
                            }
                        }
                    }
                }
            }
            p.muted {
                "Noise: " (report.noises.iter().map(|n| format!("“{}” {:.2} mV and {:.2} mA RMS", n.name, 1e3 * n.voltage_v, 1e3 * n.current_a)).collect::<Vec<_>>().join(", "))
                ". “Part” is the converter the thesis names; “implied” is what would make its own arrangement err by its own figure."
            }
            details {
                summary { "Each load with its estimators: long taps, the part's noise" }
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" { "estimator" } th scope="col" { "heated by" } th.n scope="col" { "load, gf" }
                                th.n scope="col" { "RMS, mm" } th.n scope="col" { "largest, mm" } th.n scope="col" { "mean, mm" } th.n scope="col" { "RMS, %" }
                            }
                        }
                        tbody { @for row in report.rows.iter().filter(clean) { (sweep(row, &word(&row.heating))) } }
                    }
                }
            }
            details {
                summary { "With a probe lost, a bad contact, a twinned start" }
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" { "estimator" } th scope="col" { "what is wrong" } th.n scope="col" { "load, gf" }
                                th.n scope="col" { "RMS, mm" } th.n scope="col" { "largest, mm" } th.n scope="col" { "mean, mm" } th.n scope="col" { "RMS, %" }
                            }
                        }
                        tbody {
                            @for row in report.rows.iter().filter(|row| row.condition != sensing::Condition::Clean && row.heating == sensing::Heating::Pulses) {
                                (sweep(row, condition(row.condition)))
                            }
                        }
                    }
                }
            }
        }
    }
}

fn sweep(row: &sensing::Row, what: &str) -> Markup {
    html! {
        tr {
            th scope="row" { (words(&row.estimator)) } td { (what) } td.n { (fixed(row.load_gf, 0)) }
            td.n { (fixed(row.rms_mm, 3)) } td.n { (fixed(row.max_mm, 3)) } td.n { (fixed(row.bias_mm, 3)) } td.n { (percent(row.rms_percent)) }
        }
    }
}

fn condition(condition: sensing::Condition) -> &'static str {
    match condition {
        sensing::Condition::Clean => "nothing",
        sensing::Condition::ProbeLoss => "probe lost",
        sensing::Condition::ContactResistance => "contact resistance",
        sensing::Condition::TwinnedStart => "twinned start",
    }
}

fn bound() -> Markup {
    html! {
        section #bound {
            h2 { "The time-optimal bound" }
            p {
                "How fast the wire can be within ±" (100.0 * BAND) " % of the stroke for good, for whoever knows the wire, its load and the state it is in exactly, "
                "measures without noise or delay, and needs no sensing pulse. The power may be anything between none and the largest the channel is allowed; the optimum is at "
                "one end or the other until the wire arrives, so what is searched are the switching times: full power, then none, then the power that holds the temperature (for a longer wire the other way round). "
                "A load that rings gets two more switches. The search runs on a clone of the simulated wire, taken at the moment of the step in the state the row's own driver has brought it to."
            }
            p.muted {
                "A driver can come near it and not below: it samples once a period, its power takes effect a period later, and 2 % of it are always on so that there is something to measure. "
                "The bounds of a row are those of its first seed; of a load that rings, those of the default's, for all rows."
            }
        }
    }
}

fn rows(answer: &Answer) -> Markup {
    html! {
        section #rows {
            h2 { "Every row" }
            @for about in &answer.plants {
                details {
                    summary { code { (about.plant) } ": " (about.about) }
                    div.scroll {
                        table {
                            thead {
                                tr {
                                    th scope="col" { "controller" } th scope="col" { "estimator" } th scope="col" { "sensing" } th.n scope="col" { "score" }
                                    th.n scope="col" { "shorter" br; "/ bound" } th.n scope="col" { "longer" br; "/ bound" } th.n scope="col" { "over-" br; "shoot, %" }
                                    th.n scope="col" { "steady, %" } th.n scope="col" { "cycle, %" } th.n scope="col" { "0.25 Hz, %" } th.n scope="col" { "1 Hz, %" }
                                    th.n scope="col" { "T, K" } th.n scope="col" { "draught" br; "T, K" } th scope="col" {}
                                }
                            }
                            tbody { @for row in answer.rows.iter().filter(|row| row.plant == about.plant) { (line(row)) } }
                        }
                    }
                }
            }
        }
    }
}

fn line(row: &Row) -> Markup {
    let names = html! { th scope="row" { (words(&row.controller)) } td { (words(&row.estimator)) } td { (words(&row.sensing)) } };
    match &row.figures {
        None => html! { tr { (names) td colspan="11" { "refused: " (row.refused.as_deref().unwrap_or("")) } } },
        Some(f @ Figures { overshoot_percent, steady_rms_percent, limit_cycle_percent, .. }) => html! {
            tr {
                (names)
                td.n { (optional(score::of_row(row), 2)) }
                td.n { (optional(f.ratio_up, 2)) } td.n { (optional(f.ratio_down, 2)) } td.n { (percent(*overshoot_percent)) }
                td.n { (percent(*steady_rms_percent)) } td.n { (percent(*limit_cycle_percent)) }
                td.n { (percent(f.tracking_percent(0.25))) } td.n { (percent(f.tracking_percent(1.0))) }
                td.n { (percent(f.temperature_rms_k)) } td.n { (fixed(f.draught.temperature_error_k, 1)) }
                td { (f.faults.join(", ")) }
            }
        },
    }
}

fn again(answer: &Answer) -> Markup {
    html! {
        section #again {
            h2 { "Reproduce" }
            pre { (answer.command) }
            p.muted {
                "sinew " (answer.version) ", seeds " (answer.seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", "))
                ". Simulated time, one thread a row: the same command gives the same numbers whatever the machine. All figures are in bench.json."
            }
        }
    }
}
