//! `docs/test-machine.md` says which routines run on a rig as the code does.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-machine --test integration reference::` writes the table into the page.

use std::path::Path;

use sinew_machine::RoutineKind;
use sinew_machine::plan::{rigs_table_markdown, rigs_table_text};

#[test]
fn the_page_carries_the_table_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/test-machine.md");
    let mut page = std::fs::read_to_string(&path).unwrap();
    let (open, close) = ("<!-- on-rigs -->\n", "<!-- /on-rigs -->");
    let start = page.find(open).expect("the page has the table") + open.len();
    let end = start + page[start..].find(close).expect("the table ends");
    if std::env::var_os("SINEW_BLESS").is_some() {
        page.replace_range(start..end, &rigs_table_markdown());
        std::fs::write(&path, &page).unwrap();
        return;
    }
    assert!(page[start..end] == rigs_table_markdown(), "docs/test-machine.md: run with SINEW_BLESS=1");
}

#[test]
fn every_routine_is_in_the_table_and_all_of_them_are_all() {
    let (text, markdown) = (rigs_table_text(), rigs_table_markdown());
    for kind in RoutineKind::OF_THESIS.into_iter().chain([RoutineKind::Programme, RoutineKind::BreakIn]) {
        assert!(RoutineKind::ALL.contains(&kind), "{kind:?}");
        assert!(text.contains(kind.word()) && markdown.contains(&format!("| `{}` |", kind.word())), "{kind:?}");
        assert_eq!(RoutineKind::ALL.iter().filter(|other| other.word() == kind.word()).count(), 1);
    }
}
