//! The answer for a whole rig: a page of what its wires share, with a link to each wire's own, and some lines for a
//! terminal.

use maud::{Markup, html};
use sinew_diagnosis::{Diagnosis, Grade, RigDiagnosis, SharedFinding, Verdict};
use sinew_plot::quantity::{chi, estimate, number, probability};
use sinew_plot::{Section, Sheet};

use crate::about::About;
use crate::page::{made_by, made_from};
use crate::terminal::Lines;
use crate::words::{self, list};

/// The page of a whole rig, beside a folder of every wire's with the channel's name.
pub(crate) fn page(diagnosis: &RigDiagnosis, about: &About) -> Markup {
    Sheet {
        title: format!("{}: {}", about.rig, words::verdict(diagnosis.verdict)),
        class: diagnosis.verdict.name(),
        heading: html! { "Diagnosis of " b { (about.rig) } ", " (diagnosis.channels.len()) " wires" },
        sections: vec![
            Section::unlisted(answer(diagnosis)),
            Section::new("shared", "Shared", shared(diagnosis)),
            Section::new("wires", "Wires", wires(diagnosis)),
            Section::new("warnings", "Warnings", warnings(diagnosis)),
            Section::new("again", "Reproduce", again(diagnosis, about)),
        ],
    }
    .page()
}

/// The same for a terminal of `width` columns.
pub(crate) fn text(diagnosis: &RigDiagnosis, width: usize, colour: bool) -> String {
    let mut lines = Lines::new(width, colour);
    lines.headline(&headline(diagnosis), diagnosis.verdict, diagnosis.channels.values().all(Diagnosis::is_explained));
    for finding in &diagnosis.shared {
        lines.says("shared", &said(finding));
    }
    if diagnosis.shared.is_empty() {
        lines.says("shared", "nothing that these recordings show");
    }
    for (name, wire) in &diagnosis.channels {
        let chis = format!(
            "chi {} as given, {} recalibrated, {} improved",
            chi(wire.left.chi_as_given),
            chi(wire.left.chi),
            chi(wire.left.chi_improved)
        );
        lines.says("wire", &format!("{name}: {}; {chis}", words::headline(wire)));
    }
    lines.warnings(&diagnosis.warnings);
    lines.end()
}

fn headline(diagnosis: &RigDiagnosis) -> String {
    let confirmed = diagnosis.shared.iter().filter(|finding| finding.grade != Grade::Suspected);
    let ids = confirmed.map(|finding| finding.id.clone()).collect::<Vec<_>>();
    let wires = diagnosis.channels.iter().filter(|(_, wire)| !wire.verdict.is_complete());
    let names = wires.map(|(name, _)| name.clone()).collect::<Vec<_>>();
    let unexplained = diagnosis.channels.iter().filter(|(_, wire)| !wire.is_explained());
    let unexplained = unexplained.map(|(name, _)| name.clone()).collect::<Vec<_>>();
    match (ids.is_empty(), names.is_empty()) {
        (true, true) if !unexplained.is_empty() => {
            format!("Nothing that is missing is found, but not all is explained: {}", list(&unexplained))
        }
        (true, true) if diagnosis.verdict == Verdict::Agrees => "The simulation agrees with the recordings".into(),
        (true, true) => "The physics suffices; parameters were off".into(),
        (true, false) => format!("Physics is missing in {}; the wires share nothing", list(&names)),
        (false, true) => format!("Physics is missing that the wires share: {}", list(&ids)),
        (false, false) => format!("Physics is missing that the wires share: {}; and in {}", list(&ids), list(&names)),
    }
}

/// A finding in a line.
fn said(finding: &SharedFinding) -> String {
    let sizes = finding.parameters.iter().map(|(key, size)| {
        let (value, interval) = estimate(size.value, size.low, size.high, &size.unit);
        format!("{key} {value} [{interval}]")
    });
    let mut line = format!(
        "{} of {}: {}; {}; chi of these wires {} without it, {} with it, p ≤ {}",
        finding.id,
        list(&finding.channels),
        list(&sizes.collect::<Vec<_>>()),
        finding.grade.says(),
        chi(finding.evidence.holdout_chi_before),
        chi(finding.evidence.holdout_chi_after),
        probability(finding.evidence.p_value).trim_start_matches("below ")
    );
    if !finding.cannot_be_told_apart_from.is_empty() {
        line += &format!("; cannot be told apart from {}", list(&finding.cannot_be_told_apart_from));
    }
    line
}

fn answer(diagnosis: &RigDiagnosis) -> Markup {
    html! {
        section #answer {
            p.verdict { (words::verdict(diagnosis.verdict)) }
            h1 { (headline(diagnosis)) }
            p.lead { (diagnosis.summary) }
        }
    }
}

fn shared(diagnosis: &RigDiagnosis) -> Markup {
    html! {
        section #shared {
            h2 { "What the wires share" }
            @if diagnosis.shared.is_empty() { p { "Nothing that these recordings show." } }
            @for finding in &diagnosis.shared {
                h3 { (finding.id) " of " (list(&finding.channels)) }
                p.lead { (finding.says) ". " b { (finding.grade.says()) } "." }
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" { "by" }
                                th.n scope="col" { "size" }
                                th.n scope="col" { "90 % interval" }
                            }
                        }
                        tbody {
                            @let of_all = finding.parameters.values().map(|size| ("all of them", size));
                            @let of_each = finding.by_channel.iter().map(|(name, size)| (name.as_str(), size));
                            @for (name, size) in of_all.chain(of_each) {
                                @let (value, interval) = estimate(size.value, size.low, size.high, &size.unit);
                                tr { th scope="row" { (name) } td.n { (value) } td.n { (interval) } }
                            }
                        }
                    }
                }
                p.muted { (said(finding)) "." }
            }
            @if !diagnosis.tried.is_empty() {
                h3 { "Everything they could have shared" }
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" { "shared" }
                                th scope="col" { "by" }
                                th.n scope="col" { "−2 Δ ln evidence" }
                            }
                        }
                        tbody {
                            @for tried in &diagnosis.tried {
                                tr {
                                    th scope="row" { (tried.id) }
                                    td { (list(&tried.channels)) }
                                    td.n { (number(tried.delta_bic.round())) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn wires(diagnosis: &RigDiagnosis) -> Markup {
    html! {
        section #wires {
            h2 { "Each wire, with what it shares in its model" }
            div.scroll {
                table {
                    thead {
                        tr {
                            th scope="col" { "wire" }
                            th scope="col" { "answer" }
                            @for stage in ["as given", "recalibrated", "improved"] {
                                th.n scope="col" { "chi " (stage) }
                            }
                        }
                    }
                    tbody {
                        @for (name, wire) in &diagnosis.channels {
                            tr {
                                th scope="row" { a href={ (name) "/report.html" } { (name) } }
                                td { (words::headline(wire)) }
                                td.n { (chi(wire.left.chi_as_given)) }
                                td.n { (chi(wire.left.chi)) }
                                td.n { (chi(wire.left.chi_improved)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn warnings(diagnosis: &RigDiagnosis) -> Markup {
    html! {
        section #warnings {
            h2 { "Warnings" }
            @if diagnosis.warnings.is_empty() { p { "None." } }
            ul { @for warning in &diagnosis.warnings { li { (warning) } } }
        }
    }
}

fn again(diagnosis: &RigDiagnosis, about: &About) -> Markup {
    html! {
        section #again {
            h2 { "How to reproduce this" }
            (made_from(about))
            p.muted {
                (made_by(about, &diagnosis.schema, diagnosis.seed))
                code { "improved.toml" } " the model of all wires, with what they share."
            }
        }
    }
}
