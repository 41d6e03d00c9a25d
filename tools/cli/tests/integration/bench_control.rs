//! `sinew bench control`: what it writes, what it prints, what it refuses.

use crate::support::Scratch;

#[test]
fn names_there_are_none_of_are_refused_before_anything_runs() {
    let scratch = Scratch::new();
    scratch.sinew(["bench", "control", "--controller", "sliding_mod"]).refused(&["sliding_mod", "sliding_mode"]);
    scratch.sinew(["bench", "control", "--estimator", "oracle"]).refused(&["oracle", "fused"]);
    scratch.sinew(["bench", "control", "--plant", "figur"]).refused(&["figur", "figure"]);
    scratch.sinew(["bench", "control", "--seeds", "0"]).refused(&["0"]);
    scratch.file("taken", "");
    scratch.sinew(["bench", "control", "--quick", "--out", "taken"]).refused(&["taken", "--out"]);
}

#[test]
fn rows_come_as_json_and_as_a_page_and_are_the_same_on_any_number_of_threads() {
    let scratch = Scratch::new();
    let row = ["bench", "control", "--quick", "--plant", "figure", "--controller", "pi", "--estimator", "enthalpy"];
    let with = |more: &[&'static str]| scratch.sinew(row.into_iter().chain(more.iter().copied())).done();
    let printed = with(&["--json", "--out", "bench", "--pictures", "pictures", "--jobs", "1"]);
    let written = std::fs::read_to_string(scratch.path("bench/bench.json")).unwrap();
    assert_eq!(printed, written);
    let json: serde_json::Value = serde_json::from_str(&printed).unwrap();
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(json["schema"], "sinew.bench.control/1");
    assert!(!rows.is_empty());
    for row in rows {
        assert_eq!(
            (&row["controller"], &row["estimator"], &row["plant"]),
            (&"pi".into(), &"enthalpy".into(), &"figure".into())
        );
        assert!(row["overshoot_percent"].as_f64().unwrap() >= 0.0);
    }
    let page = std::fs::read_to_string(scratch.path("bench/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<svg") && page.contains("bench control --quick"));
    assert!(std::fs::read_to_string(scratch.path("pictures/sines.svg")).unwrap().starts_with("<svg"));

    let again: serde_json::Value = serde_json::from_str(&with(&["--json", "--jobs", "2"])).unwrap();
    assert_eq!(again["rows"], json["rows"]);
    assert!(with(&[]).contains("score controller"));
}
