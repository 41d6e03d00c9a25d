//! Every row, with the command that reproduces it.

use maud::{Markup, html};
use sinew_plot::quantity::fixed;

use super::view::{optional, percent, words};
use crate::answer::Answer;
use crate::row::{Figures, Row};
use crate::score;

pub(super) fn rows(answer: &Answer) -> Markup {
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

pub(super) fn line(row: &Row) -> Markup {
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

pub(super) fn again(answer: &Answer) -> Markup {
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
