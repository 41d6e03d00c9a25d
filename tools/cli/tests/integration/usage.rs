//! Bad use of any command: exit 2, a message naming what is wrong, a hint naming what would be right.

use crate::support::{FURNACE, RIG, Scratch};

#[test]
fn words_that_mean_nothing_are_refused_with_a_hint() {
    let scratch = Scratch::new();
    scratch.sinew(["walk"]).refused(&["walk", "sinew --help"]);
    scratch.sinew(["run", "--fro", "3"]).refused(&["--fro", "sinew run --help"]);
    scratch.sinew(["run", "--for", "-3"]).refused(&["--for"]);
    scratch.sinew(["run", "--for", "0"]).refused(&["more than 0"]);
    scratch.sinew(["run", "--for", "soon"]).refused(&["seconds as a number"]);
    scratch.sinew(["simulate", "rig.toml"]).refused(&["RECORDING", "sinew simulate --help"]);
    scratch.sinew(["set", "wire"]).refused(&["SETPOINT", "sinew set --help"]);
    scratch.sinew(["bench", "loop", "--channels", "65"]).refused(&["65", "sinew bench --help"]);
    scratch.sinew(["bench", "loop", "--rate", "1"]).refused(&["10 to 10000 Hz"]);
    scratch.sinew(["bench", "everything"]).refused(&["everything"]);
}

#[test]
fn help_goes_to_stdout_and_is_no_error() {
    let scratch = Scratch::new();
    assert!(scratch.sinew(["--help"]).done().contains("sinew run"));
    assert!(scratch.sinew(["set", "--help"]).done().contains("stroke=40%"));
    assert!(scratch.sinew(["bench", "loop", "--help"]).done().contains("--channels 64"));
    let long = scratch.sinew(["--version"]).done();
    assert!(long.starts_with("sinew ") && long.contains("\nfor ") && long.contains("\nfeatures: "), "{long}");
    assert_eq!(scratch.sinew(["-V"]).done().trim_end(), long.lines().next().unwrap());
}

#[test]
fn setpoints_are_judged_before_a_driver_is_looked_for() {
    let scratch = Scratch::new();
    let set = |setpoint: &'static str| scratch.sinew(["set", "wire", setpoint]);
    set("length=155").refused(&["lacks its unit", "mm, cm or m"]);
    set("length=155in").refused(&["`in` is not a unit of length", "mm, cm or m"]);
    set("stroke=40in").refused(&["`in` is not a unit of stroke", "stroke=40%"]);
    set("stroke=140%").refused(&["outside the stroke"]);
    set("force=2kg").refused(&["`kg`", "N or mN"]);
    set("speed=1").refused(&["unknown quantity `speed`"]);
    set("duty=nan").refused(&["duty"]);
    scratch.sinew(["set", "wire", "off", "--hold", "0"]).refused(&["more than 0"]);
}

#[test]
fn without_a_driver_every_client_says_how_to_start_one() {
    let scratch = Scratch::new();
    for args in [
        vec!["status"],
        vec!["status", "--json"],
        vec!["monitor"],
        vec!["set", "wire", "off"],
        vec!["reset", "wire"],
        vec!["stop"],
        vec!["status", "--rig", "bench"],
    ] {
        let ran = scratch.sinew(args.iter().copied());
        assert_eq!(ran.code(), 1, "{args:?}: {}", ran.stderr());
        assert!(ran.stderr().contains("sinew run") && ran.stderr().contains("running"), "{}", ran.stderr());
    }
    scratch.sinew(["status", "--rig", "be nch"]).refused(&["be nch"]);
}

#[test]
fn a_rig_that_cannot_be_read_or_driven_is_refused_before_anything_runs() {
    let scratch = Scratch::new();
    scratch.sinew(["run", "nowhere.toml"]).refused(&["nowhere.toml", "cannot be read"]);
    scratch.file("typo.toml", RIG.replace("rate_hz", "rat_hz"));
    scratch.sinew(["run", "typo.toml"]).refused(&["typo.toml:4", "rat_hz", "rate_hz"]);
    scratch.sinew(["doctor", "typo.toml"]).refused(&["typo.toml:4"]);
    scratch.file("furnace.toml", FURNACE);
    scratch.sinew(["run", "furnace.toml"]).refused(&["furnace.toml", "pwm"]);
    scratch.file("rig.toml", RIG);
    scratch.sinew(["run", "rig.toml", "--report", "no/such/report.json"]).refused(&["no/such", "mkdir -p no/such"]);
    scratch.sinew(["run", "rig.toml", "--report", "."]).refused(&["is a folder"]);
}

#[test]
fn doctor_says_what_is_lacking_and_what_to_type() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    let text = scratch.sinew(["doctor", "rig.toml"]).done();
    assert!(text.contains("tensile-bench") && text.contains("shared_memory"), "{text}");
    let report: serde_json::Value = serde_json::from_str(&scratch.sinew(["doctor", "--json"]).done()).unwrap();
    assert_eq!(report["schema"], "sinew.doctor/1");
    for check in report["checks"].as_array().unwrap() {
        let said = check["verdict"] == "good" || check["cost"].as_str().is_some_and(|cost| !cost.is_empty());
        assert!(said, "{check}");
    }
}
