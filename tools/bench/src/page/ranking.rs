//! The ranking with reasons, and the thesis' findings.

use maud::{Markup, html};
use sinew_plot::quantity::{NONE, fixed};

use super::view::{View, bar, capitalised, percent, words};
use crate::answer::Answer;
use crate::findings::Finding;
use crate::score::{Place, TARGETS, WORST};

/// Choices of the ranking that are in sight at once.
const IN_SIGHT: usize = 12;

pub(super) fn winner(view: &View<'_>) -> Markup {
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

pub(super) fn place_of_default(answer: &Answer) -> Option<usize> {
    let default = &answer.default;
    let is = |place: &Place| {
        place.controller == default.controller
            && place.estimator == default.estimator
            && place.sensing == default.sensing
    };
    Some(answer.ranking.iter().position(is)? + 1)
}

pub(super) fn ranking(view: &View<'_>) -> Markup {
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

pub(super) fn findings(answer: &Answer) -> Markup {
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

pub(super) fn found(finding: &Finding) -> Markup {
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
