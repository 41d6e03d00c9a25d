//! `sinew thesis`: what it prints, what it writes, what it refuses.

use crate::support::Scratch;

#[test]
fn chapters_there_are_none_of_are_refused() {
    let scratch = Scratch::new();
    scratch.sinew(["thesis", "13"]).refused(&["13", "2, 3, 4"]);
    scratch.file("taken", "");
    scratch.sinew(["thesis", "5", "--out", "taken"]).refused(&["taken", "--out"]);
}

#[test]
fn rows_are_listed_without_being_run() {
    let scratch = Scratch::new();
    let list = scratch.sinew(["thesis", "--list"]).done();
    for expected in ["eq. 17", "fig. 58", "table 3, eq. 14", "displayed, 41st", "model/physics/src/kinetics.rs"] {
        assert!(list.contains(expected), "{expected}");
    }
    assert!(!scratch.sinew(["thesis", "4", "--list"]).done().contains("eq. 17"));
}

#[test]
fn a_chapter_becomes_a_page_that_stands_alone() {
    let scratch = Scratch::new();
    let summary = scratch.sinew(["thesis", "a", "3", "--out", "book"]).done();
    assert!(summary.contains("chapter 3") && summary.contains("appendix A") && summary.contains("not yet built"));
    let page = std::fs::read_to_string(scratch.path("book/index.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<svg") && page.contains("thesis a 3"));
    assert!(
        !page.contains("<script") && !page.contains("src=") && !page.contains("http:") && !page.contains("https:"),
        "it fetches nothing"
    );
}
