//! The errors of the estimators, and of the sensed length.

use maud::{Markup, html};
use sinew_plot::Ink;
use sinew_plot::quantity::fixed;

use super::view::{HALF, View, figure, legend, optional, percent, words};
use crate::sensing;

pub(super) fn estimates(view: &View<'_>) -> Markup {
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

/// Chapter 7's experiment.
pub(super) fn measured(report: &sensing::Report) -> Markup {
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

pub(super) fn sweep(row: &sensing::Row, what: &str) -> Markup {
    html! {
        tr {
            th scope="row" { (words(&row.estimator)) } td { (what) } td.n { (fixed(row.load_gf, 0)) }
            td.n { (fixed(row.rms_mm, 3)) } td.n { (fixed(row.max_mm, 3)) } td.n { (fixed(row.bias_mm, 3)) } td.n { (percent(row.rms_percent)) }
        }
    }
}

pub(super) fn condition(condition: sensing::Condition) -> &'static str {
    match condition {
        sensing::Condition::Clean => "nothing",
        sensing::Condition::ProbeLoss => "probe lost",
        sensing::Condition::ContactResistance => "contact resistance",
        sensing::Condition::TwinnedStart => "twinned start",
    }
}
