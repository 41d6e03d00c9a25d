//! The results of the laws: on steps, on sines, on misjudged plants, on joints, and the bounds of every law.

use maud::{Markup, html};
use sinew_plot::Ink;
use sinew_plot::quantity::{NONE, fixed};

use super::view::{DRAWN, REACHABLE, View, WIDE, figure, legend, optional, percent, words};
use crate::answer::Answer;
use crate::row::{FREQUENCIES_HZ, Row, SINE_MIDDLE, SINE_SWING};
use crate::score::{self, WORST};
use crate::{BAND, Family};

pub(super) fn steps(view: &View<'_>) -> Markup {
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

pub(super) fn step_table(rows: &[&Row]) -> Markup {
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

pub(super) fn sines(view: &View<'_>) -> Markup {
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
                "RMS error on a sine of " (100.0 * SINE_SWING) " % of the stroke from peak to peak around " (100.0 * SINE_MIDDLE)
                " %, in % of the stroke, on " code { (view.plant) } ". Doing nothing but standing in the middle would give "
                (fixed(100.0 * SINE_SWING / 8f64.sqrt(), 1)) " %."
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

/// Scores of each law's best choice on every plant.
pub(super) fn misjudged(view: &View<'_>) -> Markup {
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
pub(super) fn joints(answer: &Answer) -> Markup {
    let pairs: Vec<&Row> = answer.rows.iter().filter(|row| row.family == Family::Pair).collect();
    let of = |plant: &str| {
        pairs
            .iter()
            .filter(|row| row.plant == plant)
            .filter_map(|row| Some((row, row.figures.as_ref()?)))
            .collect::<Vec<_>>()
    };
    html! {
        section #joints {
            h2 { "Two wires on a joint" }
            @if pairs.is_empty() {
                p.muted { "Not in this run." }
            } @else {
                p {
                    "What pulls the lone wire long again is its load, as fast as the air cools it. On a joint the other wire pulls: with the joint's own laws, at the same sines, in % of the agonist's stroke. "
                    "No bound is known here, and none of it is in the ranking."
                }
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" rowspan="2" { "law" } th.n scope="colgroup" colspan=(FREQUENCIES_HZ.len()) { "RMS error on sines, %" }
                                th.n scope="col" rowspan="2" { "steady" br; "RMS, %" } th.n scope="col" rowspan="2" { "over-" br; "shoot, %" }
                                th.n scope="col" rowspan="2" { "draught:" br; "moved, %" } th.n scope="col" rowspan="2" { "pull:" br; "moved, %" } th.n scope="col" rowspan="2" { "tempera-" br; "ture, K" } th.n scope="col" rowspan="2" { "energy" br; "J" }
                            }
                            tr { @for f in FREQUENCIES_HZ { th.n scope="col" { (f) " Hz" } } }
                        }
                        @for about in answer.plants.iter().filter(|about| !of(about.plant).is_empty()) {
                            tbody {
                                tr { th scope="rowgroup" colspan=(FREQUENCIES_HZ.len() + 7) { code { (about.plant) } " " small.muted { (about.about) } } }
                                @for (row, f) in of(about.plant) {
                                    tr {
                                        th scope="row" { code { (row.controller) } }
                                        @for value in &f.tracking_percents { td.n { (percent(*value)) } }
                                        td.n { (percent(f.steady_rms_percent)) } td.n { (percent(f.overshoot_percent)) }
                                        td.n { (percent(f.draught.deviation_percent)) } td.n { (percent(f.load_step.deviation_percent)) } td.n { (fixed(f.draught.temperature_error_k, 1)) } td.n { (fixed(f.energy_j, 1)) }
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

pub(super) fn bound() -> Markup {
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
