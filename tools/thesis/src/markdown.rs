//! The table of docs/thesis.md.

use std::fmt::Write as _;

use crate::book::{Book, apart};
use crate::found::{Check, Wanted};
use crate::row::{Done, Verdict};

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// What came out of a row, in one line.
fn numbers(done: &Done) -> String {
    let one = |check: &Check| {
        let mark = if check.holds() { "" } else { "**" };
        // what is left of nothing is rounding, another on every machine
        let is_nothing = matches!(check.wanted, Wanted::Near { value: 0.0, .. }) && check.holds();
        let value = if is_nothing { "nothing".into() } else { check.value() };
        format!("{}: {mark}{value}{mark} ({})", check.what, check.demand())
    };
    done.found.checks.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// How many rows come to what, then each chapter's rows, then what is apart.
pub fn markdown(book: &Book) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "| chapter | rows | {} |", Verdict::WORDS.join(" | "));
    let _ = writeln!(out, "|---|---|{}", "---|".repeat(Verdict::WORDS.len()));
    let mut line = |name: &str, counts: [usize; Verdict::WORDS.len()]| {
        let all: usize = counts.iter().sum();
        let counts = counts.map(|count| count.to_string()).join(" | ");
        let _ = writeln!(out, "| {name} | {all} | {counts} |");
    };
    for chapter in &book.chapters {
        line(&format!("{chapter}: {}", chapter.about()), book.counts(Some(*chapter)));
    }
    line("all", book.counts(None));
    for chapter in &book.chapters {
        let name = chapter.to_string();
        let _ = writeln!(out, "\n## {}{}: {}\n", name[..1].to_uppercase(), &name[1..], chapter.about());
        let _ = writeln!(
            out,
            "| place | what it is | in the code | the thesis states | what comes out (what is wanted) | verdict |"
        );
        let _ = writeln!(out, "|---|---|---|---|---|---|");
        for done in book.of(*chapter) {
            let row = &done.row;
            let code: Vec<String> = row.code.iter().map(|code| format!("`{}`: `{}`", code.file, code.item)).collect();
            let _ = writeln!(
                out,
                "| {} | {} | {} | {} | {} | {} |",
                row.place,
                cell(row.title),
                cell(&code.join("; ")),
                cell(row.states),
                cell(&numbers(done)),
                cell(&done.verdict.to_string()),
            );
        }
        let apart: Vec<String> = apart(*chapter).iter().map(|one| format!("{} ({})", one.place, one.shows)).collect();
        if !apart.is_empty() {
            let _ = writeln!(
                out,
                "\nPhotographs, drawings and diagrams, in which nothing could agree: {}.",
                apart.join(", ")
            );
        }
    }
    out
}
