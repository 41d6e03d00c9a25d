//! The tables of laws, of a wire and of a joint, and estimators are the single source. Copies in places that may not depend on this
//! crate or are not Rust are generated from them: the words of the rig file, and the tables of docs/control-laws.md.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-control --test integration tables::` writes them.

use std::fmt::Write as _;
use std::path::Path;

use sinew_control::{AlgorithmKind, EstimatorKind, JointAlgorithmKind, KEYS_OF_JOINT_LAWS, KEYS_OF_LAWS};

/// A file of the project, by its path from the top.
fn path(of: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(of)
}

/// Compares a file with what it should say, or writes that.
fn says(of: &str, expected: &str) {
    if std::env::var_os("SINEW_BLESS").is_some() {
        std::fs::write(path(of), expected).unwrap();
    }
    let found = std::fs::read_to_string(path(of)).unwrap_or_default();
    assert!(found == expected, "{of} is not what the tables of control say; run with SINEW_BLESS=1");
}

/// The text of a page with what stands between two marks replaced.
fn with_table(page: &str, mark: &str, table: &str) -> String {
    let (open, close) = (format!("<!-- {mark} -->\n"), format!("<!-- /{mark} -->"));
    let start = page.find(&open).expect(mark) + open.len();
    let end = start + page[start..].find(&close).expect(mark);
    format!("{}{table}{}", &page[..start], &page[end..])
}

fn laws() -> String {
    let mut out = "| word | law | defaults |\n|---|---|---|\n".to_string();
    for row in AlgorithmKind::ALL.map(AlgorithmKind::row) {
        let star = if row.needs_estimate { " *" } else { "" };
        writeln!(out, "| `{}`{star} | {} | {} |", row.word, row.law, row.defaults).unwrap();
    }
    out
}

fn joint_laws() -> String {
    let mut out = "| word | law | defaults |\n|---|---|---|\n".to_string();
    for row in JointAlgorithmKind::ALL.map(JointAlgorithmKind::row) {
        writeln!(out, "| `{}` | {} | {} |", row.word, row.law, row.defaults).unwrap();
    }
    out
}

fn estimators() -> String {
    let mut out = "| word | estimates by | temperature trusted by the supervisor |\n|---|---|---|\n".to_string();
    for row in EstimatorKind::ALL.map(EstimatorKind::row) {
        let trusted = if row.is_protective { "yes" } else { "no" };
        writeln!(out, "| `{}` | {} | {trusted} |", row.word, row.says.concat().trim().trim_end_matches('.')).unwrap();
    }
    out
}

#[test]
fn the_page_carries_the_tables() {
    let page = std::fs::read_to_string(path("docs/control-laws.md")).unwrap();
    let page = with_table(&with_table(&page, "laws", &laws()), "joint laws", &joint_laws());
    says("docs/control-laws.md", &with_table(&page, "estimators", &estimators()));
}

/// Rows of a declaration of words: each with its line of docs and its word, and what else the row says.
fn rows(out: &mut String, rows: &[(&str, &str, &[&str])], more: impl Fn(usize) -> String, end: char, indent: &str) {
    for (index, (variant, word, says)) in rows.iter().enumerate() {
        for line in *says {
            writeln!(out, "{indent}///{line}").unwrap();
        }
        writeln!(out, "{indent}{variant} = \"{word}\"{}{end}", more(index)).unwrap();
    }
}

/// `rig` is below this crate and cannot ask it: so the words that a rig file may choose from are written there, the default first.
#[test]
fn the_rig_file_has_the_words_of_the_tables() {
    let mut out = "//! The words of the control laws, of a wire and of a joint, and of the estimators, and which keys each law takes.\n//!\n\
        //! Written from the tables in `control/src/laws/mod.rs`, `control/src/joint/mod.rs` and `control/src/estimators/mod.rs`, which own\n\
        //! them: do not edit.\n\
        //! `SINEW_BLESS=1 cargo test -p sinew-control --test integration tables::` writes it anew.\n\n\
        use crate::declare::rows::*;\n\n"
        .to_string();
    let laws = AlgorithmKind::ALL.map(|kind| (kind.row().variant, kind.word(), kind.row().says));
    let takes = |index: usize| {
        let row = AlgorithmKind::ALL[index].row();
        assert!(row.takes.iter().all(|key| KEYS_OF_LAWS.contains(key)), "{row:?}");
        format!(", takes {:?}", row.takes)
    };
    let head = |about: &str, name: &str, default: &str| {
        format!("#[rustfmt::skip]\nlaws! {{\n    /// {about}\n    pub enum {name}, default {default};\n")
    };
    out += &head("The control law of a wire.", "Algorithm", laws[0].0);
    rows(&mut out, &laws, takes, ';', "    ");
    out += "}\n\n";
    let laws = JointAlgorithmKind::ALL.map(|kind| (kind.row().variant, kind.word(), kind.row().says));
    let takes = |index: usize| {
        let row = JointAlgorithmKind::ALL[index].row();
        assert!(row.takes.iter().all(|key| KEYS_OF_JOINT_LAWS.contains(key)), "{row:?}");
        format!(", takes {:?}", row.takes)
    };
    out += &head("The control law of a joint.", "JointAlgorithm", laws[0].0);
    rows(&mut out, &laws, takes, ';', "    ");
    let about = "What the wire's temperature and phase are estimated by.";
    let estimators = EstimatorKind::ALL.map(|kind| (kind.row().variant, kind.word(), kind.row().says));
    let default = estimators[0].0;
    writeln!(out, "}}\n\nwords! {{\n    /// {about}\n    pub enum Estimator, default {default} {{").unwrap();
    rows(&mut out, &estimators, |_| String::new(), ',', "        ");
    out += "    }\n}\n";
    says("model/rig/src/tables/control/generated.rs", &out);
}
