//! The presentation of a result: the rows shown, their inks, plots, numbers and words.

use maud::{Markup, html};
use sinew_plot::quantity::{NONE, fixed};
use sinew_plot::{Axis, Ink, Line, Plot, sample};

use crate::answer::Answer;
use crate::row::{FREQUENCIES_HZ, Row, STEPS, Trace};
use crate::score::Place;
use crate::{BAND, Ran};

/// A plot over the page's whole width, and one of two side by side, px.
pub(super) const WIDE: (f64, f64) = (940.0, 300.0);

pub(super) const HALF: (f64, f64) = (460.0, 260.0);

/// Most points of a line.
pub(super) const POINTS: usize = 700;

/// The wire that is drawn, unless it was not run.
pub(super) const SHOWN: &str = "figure";

/// A law that makes nothing of the estimate.
pub(super) const INDIFFERENT: &str = "pi";

/// What the reachable error is called in legends.
pub(super) const REACHABLE: &str = "least error that was found for whoever knows everything in advance";

/// What is drawn of an answer.
pub(super) struct View<'a> {
    pub(super) answer: &'a Answer,
    pub(super) ran: &'a [Ran],
    /// The plant that is drawn.
    pub(super) plant: &'a str,
    /// Laws in the rig file's order, which gives each its ink.
    pub(super) controllers: Vec<&'a str>,
    /// Frequencies, and the errors that can be reached there.
    pub(super) reachable: (Vec<f64>, Vec<f64>),
}

impl<'a> View<'a> {
    pub(super) fn of(answer: &'a Answer, ran: &'a [Ran]) -> View<'a> {
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

    pub(super) fn ink_of_law(&self, row: &Row) -> Ink {
        Ink::Series(self.controllers.iter().position(|word| *word == row.controller).unwrap_or(0) as u8)
    }

    pub(super) fn row(&self, place: &Place, plant: &str) -> Option<&'a Row> {
        self.answer.rows.iter().find(|row| {
            row.plant == plant
                && row.controller == place.controller
                && row.estimator == place.estimator
                && row.sensing == place.sensing
        })
    }

    /// Each law's best row on the plant that is drawn, the best law first.
    pub(super) fn laws(&self) -> Vec<&'a Row> {
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
    pub(super) fn estimators(&self, controller: &str) -> Vec<&'a Row> {
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
    pub(super) fn indifferent(&self) -> &'a str {
        let winner = self.answer.winner().map_or("", |best| best.controller.as_str());
        self.controllers.iter().copied().find(|word| *word == INDIFFERENT).unwrap_or(winner)
    }

    pub(super) fn traces(&self, row: &Row) -> Option<&'a crate::Traces> {
        let same = |other: &Row| {
            (&other.controller, &other.estimator, &other.sensing, &other.plant)
                == (&row.controller, &row.estimator, &row.sensing, &row.plant)
        };
        self.ran.iter().find(|ran| same(&ran.row))?.traces.as_ref()
    }

    /// The steps over time, and the end of each step close to its reference.
    pub(super) fn step_plots(&self, laws: &[&'a Row], size: (f64, f64)) -> Vec<(String, Plot<'a>)> {
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

    pub(super) fn sine_plot(&'a self, laws: &[&'a Row], size: (f64, f64)) -> Plot<'a> {
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
    pub(super) fn draught_plots(&self, rows: &[&'a Row], size: (f64, f64)) -> Vec<(String, Plot<'a>)> {
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
pub(super) fn words(word: &str) -> String {
    word.replace('_', " ")
}

pub(super) fn percent(value: f64) -> String {
    fixed(value, if value.abs() < 9.995 { 2 } else { 1 })
}

pub(super) fn optional(value: Option<f64>, decimals: usize) -> String {
    value.map_or(NONE.into(), |value| fixed(value, decimals))
}

pub(super) fn legend(entries: &[(Ink, String)]) -> Markup {
    html! { ul.legend { @for (ink, name) in entries { li { (sample(*ink)) (name) } } } }
}

pub(super) fn figure(caption: &str, plot: &Plot<'_>) -> Markup {
    html! { figure { figcaption { (caption) } div.scroll { (plot.draw()) } } }
}

/// Laws that are drawn over each other; more would be a tangle.
pub(super) const DRAWN: usize = 5;

/// A bar for a share of 0 to 1.
pub(super) fn bar(share: f64) -> Markup {
    let width = if share.is_finite() { (100.0 * share.clamp(0.0, 1.0)).round() } else { 0.0 };
    html! {
        svg.bar.short viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true" {
            rect.rail width="100" height="10" {}
            rect.filled width=(width) height="10" {}
        }
    }
}

pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
