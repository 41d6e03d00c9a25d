//! `sinew test`: routines, their files, and what is refused before anything runs.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use sinew_recording::session::Session;

use crate::support::{Scratch, program};

const RIG: &str = include_str!("../../../../examples/test-machine.toml");

fn scratch() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    scratch
}

#[test]
fn all_routines_are_listed_and_have_help() {
    let scratch = scratch();
    let list = scratch.sinew(["test", "list"]).done();
    let listed: serde_json::Value =
        serde_json::from_str(&scratch.sinew(["test", "list", "--json"]).done()).expect("JSON");
    for entry in listed.as_array().expect("a list") {
        let name = entry["name"].as_str().expect("a name");
        assert!(list.contains(name), "{list}");
        let help = scratch.sinew(["test", name, "--help"]).done();
        assert!(help.contains("Examples:") && help.contains(&format!("sinew test {name}")), "{help}");
    }
    assert_eq!(listed.as_array().map(Vec::len), Some(10));
}

#[test]
fn a_file_is_played_and_what_is_none_is_refused_in_words() {
    let scratch = scratch();
    let rows: String =
        (0..200).map(|i| format!("{},{},{}\n", f64::from(i) * 0.05, 0.1 * f64::from(i % 2), 1e-3)).collect();
    scratch.file("next.csv", format!("time_s,current_a,position_m\n{rows}"));
    let args = ["test", "programme", "rig.toml", "next.csv", "--out", "next", "--json"];
    let report: serde_json::Value = serde_json::from_str(&scratch.sinew(args).done()).expect("JSON");
    assert_eq!((&report["routine"], &report["partial"]), (&"programme".into(), &false.into()));
    assert!(scratch.path("next/programme.mcap").is_file());
    scratch.file("duty.csv", "time_s,duty\n0,0.1\n1,0.2\n2,0.1\n");
    scratch.sinew(["test", "programme", "rig.toml", "duty.csv"]).refused(&["a driver switches", "--rig NAME"]);
    scratch.file("far.csv", "time_s,current_a,position_m\n0,0,0\n1,0,0.5\n2,0,0\n");
    scratch.sinew(["test", "programme", "rig.toml", "far.csv"]).refused(&["machine's limit", "max_strain"]);
}

#[test]
fn a_routine_leaves_a_recording_that_the_model_answers_and_a_report() {
    let scratch = scratch();
    let args = ["test", "constant-strain-sweep", "rig.toml", "--frequencies", "0.2,0.5Hz", "--out", "out", "--json"];
    let report: serde_json::Value = serde_json::from_str(&scratch.sinew(args).done()).expect("JSON");
    assert_eq!((&report["schema"], &report["partial"]), (&"sinew.test/1".into(), &false.into()));
    let swing = report["findings"].as_array().expect("findings").iter().find(|f| f["key"] == "swing_n").expect("swing");
    assert!(swing["value"].as_f64() > Some(0.1) && swing["sigma"].as_f64() > Some(0.0), "{swing}");
    for file in ["report.html", "report.json", "picture.svg", "rig.toml", "constant-strain-sweep.mcap"] {
        assert!(scratch.path("out").join(file).is_file(), "{file}");
    }
    let recording = "out/constant-strain-sweep.mcap";
    scratch.sinew(["simulate", "out/rig.toml", recording, "-o", "simulated.csv"]).done();
    // the wire is as in the rig file: the measurement equals the model's prediction, to within the noise
    let fitted = scratch.sinew(["identify", "out/rig.toml", recording, "-o", "fitted.toml", "--json"]).done();
    let fitted: serde_json::Value = serde_json::from_str(&fitted).expect("JSON");
    let chi = |column: &str| fitted["fit"]["as_given"][column]["chi"].as_f64().expect("chi");
    assert!(chi("force_n") < 1.2 && chi("v3_v") < 1.2, "{}", fitted["fit"]);
}

#[test]
fn what_cannot_be_run_is_refused_with_what_could() {
    let scratch = scratch();
    let test = |args: &[&'static str]| scratch.sinew(["test"].into_iter().chain(args.iter().copied()));
    test(&["pull", "rig.toml"]).refused(&["pull"]);
    test(&["direct-strain", "rig.toml", "--strain", "0-9%"]).refused(&["machine.max_strain"]);
    test(&["direct-strain", "rig.toml", "--strain", "4"]).refused(&["lacks its unit"]);
    test(&["direct-load", "rig.toml", "--load", "0-20N"]).refused(&["machine.max_force_n"]);
    test(&["constant-force-sweep", "rig.toml", "--heating", "power=1V"]).refused(&["lacks its unit"]);
    test(&["constant-force-sweep", "rig.toml", "--frequencies", "1-50Hz"]).refused(&["machine.rate_hz"]);
    test(&["constant-force-sweep", "rig.toml", "--chamber", "200C"]).refused(&["chamber_max_c"]);
    test(&["position-regulation", "rig.toml", "--controller", "magic"]).refused(&["time_optimal"]);
    test(&["position-tracking", "rig.toml", "--heating", "voltage=5V"]).refused(&["power=4W"]);
    test(&["direct-strain", "nowhere.toml"]).refused(&["nowhere.toml"]);
    test(&["characterise", "rig.toml"]).refused(&["--out"]);
}

/// How many rows are safe in a recording that is still being written.
fn rows_so_far(recording: &Path) -> usize {
    let Ok(session) = Session::open(recording) else { return 0 };
    let mut rows = session.cycles();
    std::iter::from_fn(|| rows.next().ok().flatten().map(drop)).count()
}

#[test]
fn an_interrupt_ends_it_with_a_partial_report_and_exit_code_0() {
    let scratch = scratch();
    let mut running = program()
        .args(["test", "direct-strain", "rig.toml", "--real-time", "--out", "out", "--json"])
        .current_dir(scratch.path(""))
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program runs");
    let (recording, patience) = (scratch.path("out/direct-strain.mcap"), Instant::now() + Duration::from_secs(60));
    while rows_so_far(&recording) <= 10 {
        assert!(Instant::now() < patience, "no rows in the recording");
        std::thread::sleep(Duration::from_millis(20));
    }
    let sent = Command::new("kill").args(["-INT", &running.id().to_string()]).status().expect("kill");
    assert!(sent.success());
    let code = running.wait().expect("it ends").code();
    assert_eq!(code, Some(0));
    let report = std::fs::read_to_string(scratch.path("out/report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["partial"], true);
    assert!(report["rows"].as_u64() > Some(10), "{report}");
    scratch.sinew(["simulate", "out/rig.toml", "out/direct-strain.mcap", "-o", "simulated.csv"]).done();
}
