//! The book as one page that stands alone.

use maud::{Markup, html};
use sinew_plot::{Section, Sheet, sample};

use crate::book::{Book, apart};
use crate::chapter::Chapter;
use crate::found::Picture;
use crate::row::{Done, Verdict};

/// The page: `index.html`, with the command that made it.
pub fn page(book: &Book, command: &str) -> String {
    let mut sections = vec![Section::unlisted(answer(book))];
    sections.extend(
        book.chapters
            .iter()
            .map(|chapter| Section::new(chapter.anchor(), chapter.word(), self::chapter(book, *chapter))),
    );
    sections.push(Section::new("again", "Reproduce", again(command)));
    Sheet {
        title: "sinew thesis".into(),
        class: "book",
        heading: html! { "The thesis " i { "Enabling Shape Memory Alloys as Actuators for Robotics" } ", page by page" },
        sections,
    }
    .page()
    .into_string()
}

fn answer(book: &Book) -> Markup {
    let [agree, differ, ..] = book.counts(None);
    let words = Verdict::WORDS;
    html! {
        section #answer {
            h1 { (agree + differ) " of " (book.done.len()) " rows agree, or differ with a proven reason" }
            p.lead {
                "A row for each equation, each table and each simulated or measured figure: what the thesis states, in our words, "
                "and what the project's own code computes. Tolerances stand in the source of each row. A row that \
                 differs says why and proves it; what is not there yet says so and is counted."
            }
            div.scroll {
                table {
                    thead { tr { th { "chapter" } @for word in words { th.n { (word) } } } }
                    tbody {
                        @for chapter in &book.chapters {
                            tr {
                                th scope="row" { a href={ "#" (chapter.anchor()) } { (chapter) } ", " (chapter.about()) }
                                @for count in book.counts(Some(*chapter)) { (count_cell(count)) }
                            }
                        }
                        tr.chosen { th scope="row" { "all" } @for count in book.counts(None) { (count_cell(count)) } }
                    }
                }
            }
        }
    }
}

fn count_cell(count: usize) -> Markup {
    html! { @if count == 0 { td.n.muted { "–" } } @else { td.n { (count) } } }
}

fn chapter(book: &Book, chapter: Chapter) -> Markup {
    let name = chapter.to_string();
    let apart = apart(chapter);
    html! {
        section id=(chapter.anchor()) {
            h2 { (name[..1].to_uppercase()) (name[1..]) ": " (chapter.about()) }
            @for done in book.of(chapter) { (entry(done)) }
            @if !apart.is_empty() {
                details {
                    summary { (apart.len()) " photographs, drawings and diagrams, in which nothing could agree" }
                    ul { @for one in &apart { li { (one.place) ": " (one.shows) } } }
                }
            }
        }
    }
}

fn entry(done: &Done) -> Markup {
    let row = &done.row;
    html! {
        article class=(done.verdict.class()) {
            h3 { (row.place) ": " (row.title) " " span.verdict { (done.verdict.word()) } }
            p { (row.states) }
            @if let Some(reason) = done.verdict.reason() {
                p.callout {
                    @match done.verdict {
                        Verdict::Differs(_) => { "It differs because " (reason) "." }
                        Verdict::NotGiven(_) => { "It cannot be made again; this is not given: " (reason) "." }
                        Verdict::NotBuilt(_) => { "There is no code for it yet; this is missing: " (reason) "." }
                        _ => { (reason) "." }
                    }
                }
            }
            @if !done.found.checks.is_empty() { (numbers(done)) }
            @if !done.found.picture.drawings.is_empty() { (picture(&done.found.picture)) }
            @if !row.code.is_empty() {
                p.muted {
                    "In the code: "
                    @for (i, code) in row.code.iter().enumerate() {
                        @if i > 0 { ", " }
                        code { (code.item) } " in " code { (code.file) }
                    }
                }
            }
        }
    }
}

fn numbers(done: &Done) -> Markup {
    html! {
        div.scroll {
            table {
                thead { tr { th { "what" } th.n { "the thesis" } th.n { "what comes out" } th { "" } } }
                tbody {
                    @for check in &done.found.checks {
                        tr {
                            td { (check.what) @if check.proof { small { " (why it differs)" } } }
                            td.n { (check.demand()) }
                            td.n { @if check.holds() { b.good { (check.value()) } } @else { b.bad { (check.value()) } } }
                            td { @if check.holds() { "✓" } @else { "✗" } }
                        }
                    }
                }
            }
        }
    }
}

fn picture(picture: &Picture) -> Markup {
    html! {
        @if !picture.legend.is_empty() {
            ul.legend { @for (ink, name) in &picture.legend { li { (sample(*ink)) (name) } } }
        }
        div.pair {
            @for drawing in &picture.drawings {
                @let (caption, plot) = drawing.plot();
                figure { figcaption { (caption) } div.scroll { (plot.draw()) } }
            }
        }
    }
}

fn again(command: &str) -> Markup {
    html! {
        section #again {
            h2 { "Reproduce" }
            pre { code { (command) } }
            p.muted { "sinew " (env!("CARGO_PKG_VERSION")) }
        }
    }
}
