//! The book for a terminal: the summary by chapter and verdict, and the list of rows.

use std::fmt::Write as _;

use crate::book::{Book, rows};
use crate::chapter::Chapter;
use crate::row::{How, Verdict};

/// How many rows of each chapter come to what, and those that are no success.
pub fn summary(book: &Book) -> String {
    let mut out = String::new();
    let mut line = |name: &str, counts: &[usize], about: &str| {
        let _ = write!(out, "{name:<11}");
        for (count, word) in counts.iter().zip(Verdict::WORDS) {
            let _ = write!(out, " {:>width$}", count, width = word.len());
        }
        let _ = writeln!(out, "  {about}");
    };
    for chapter in &book.chapters {
        line(&chapter.to_string(), &book.counts(Some(*chapter)), chapter.about());
    }
    let all = book.counts(None);
    line("all", &all, &format!("of {} rows", book.done.len()));
    let head = Verdict::WORDS.join(" ");
    let unexplained = book.done.iter().filter(|done| matches!(done.verdict, Verdict::Unexplained(_)));
    let mut more = String::new();
    for done in unexplained {
        let _ = writeln!(more, "{}, {}, {}: {}", done.row.chapter, done.row.place, done.row.title, done.verdict);
    }
    format!("{:<11} {head}\n{out}{more}", "")
}

/// Every row of chapters, without running any: where the thesis has it, what it is, where the code has it.
pub fn list(chapters: &[Chapter]) -> String {
    let mut out = String::new();
    for row in chapters.iter().copied().flat_map(rows) {
        let declared = match row.how {
            How::Computed(_) => "agrees",
            How::Differs(..) => "differs",
            How::NotGiven(_) => "not reproducible",
            How::NotBuilt(_) => "not yet built",
        };
        let code: Vec<String> = row.code.iter().map(|code| format!("{}: {}", code.file, code.item)).collect();
        let (chapter, place) = (row.chapter.to_string(), row.place.to_string());
        let _ = writeln!(out, "{chapter:<11} {place:<17} {declared:<16}  {}", row.title);
        if !code.is_empty() {
            let _ = writeln!(out, "{:<46}  {}", "", code.join("; "));
        }
    }
    out
}
