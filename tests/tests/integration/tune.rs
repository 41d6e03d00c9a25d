//! `sinew tune` through the real binary: it says the λ, its margin and where there is none, and writes what it says.

use std::fs;

use sinew_tests::{Finished, Rig, run};

/// One hanging wire with comments and an order of its own, at most so many watts.
fn bench(watts: f64, more: &str) -> Rig {
    Rig::named(|name| {
        format!(
            "[rig]\nname = \"{name}\"     # a bench\nrate_hz = 1000.0\n\n[[channel]]\nname = \"wire\"      # the one wire\n\
             wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\ntaps = {{ l0_mm = 0.0, ls_mm = 150.0 }}\n\
             drive = {{ supply_v = 6.0, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = 0.2, damping_n_s_per_m = 40.0 }}\n{more}\n[channel.limits]\nmaximum_power_w = {watts:?} # no more\n"
        )
    })
}

#[track_caller]
fn tune(rig: &Rig, more: &[&str]) -> Finished {
    let path = rig.path();
    run(["tune", path.to_str().unwrap()].iter().chain(more))
}

#[test]
fn it_finds_what_the_thesis_found() {
    let rig = bench(3.0, "");
    let answer = tune(&rig, &["--uncertainty", "0", "--cool-freely", "--json"]).expect(0).json();
    assert_eq!((&answer["schema"], &answer["rig"]), (&"sinew.tune/1".into(), &rig.name.clone().into()));
    let wire = &answer["channels"][0];
    // Chapter 11 runs this wire with λ = 10 on 3 W …
    let lambda = wire["lambda_per_s"].as_f64().unwrap();
    assert!((10.0..16.0).contains(&lambda), "{wire}");
    // … lengthening it falls behind …
    assert!(wire["as_modelled"]["cooling_per_s"].as_f64().unwrap() < 5.0, "{wire}");
    assert!(wire["power_share"].as_f64().unwrap() > 0.9, "{wire}");
    // … and 1 W is too little for that.
    let weak = tune(&bench(1.0, ""), &["--uncertainty", "0", "--cool-freely", "--json"]).expect(0).json();
    assert!(weak["channels"][0]["lambda_per_s"].as_f64().unwrap() < 2.0, "{weak}");
}

#[test]
fn uncertainty_costs_and_where_there_is_no_lambda_it_says_what_to_change() {
    let rig = bench(3.0, "");
    let lambda = |uncertainty: &str| {
        tune(&rig, &["--uncertainty", uncertainty, "--json"]).expect(0).json()["channels"][0]["lambda_per_s"].as_f64()
    };
    let all = ["0", "10%", "0.2", "30%"].map(|u| lambda(u).unwrap());
    assert!(all.windows(2).all(|pair| pair[1] < pair[0]), "{all:?}");
    let text = tune(&rig, &[]).expect(0);
    for words in ["wire: ", "as modelled", "every ±30 %", "lambda_per_s = ", "margin: "] {
        assert!(text.stdout.contains(words), "{words:?}: {text:?}");
    }
    assert_eq!(text.stderr, "");

    let weak = bench(1.0, "");
    let before = fs::read_to_string(weak.path()).unwrap();
    let found = tune(&weak, &["--write", "--json"]).expect(0);
    for words in ["warning: wire: no λ", "more (supply_v, maximum_power_w)", "thinner wire", "nothing written"] {
        assert!(found.stderr.contains(words), "{words:?}: {found:?}");
    }
    let answer = found.json();
    assert!(answer["channels"][0]["lambda_per_s"].is_null() && answer["written"].as_array().unwrap().is_empty());
    assert!(!answer["channels"][0]["warnings"].as_array().unwrap().is_empty());
    assert_eq!(fs::read_to_string(weak.path()).unwrap(), before);
}

#[test]
fn what_is_written_is_what_was_said_and_nothing_else_changes() {
    let rig = bench(3.0, "");
    let before = fs::read_to_string(rig.path()).unwrap();
    tune(&rig, &[]).expect(0);
    assert_eq!(fs::read_to_string(rig.path()).unwrap(), before, "without --write nothing is");
    let answer = tune(&rig, &["--write", "--json"]).expect(0).json();
    let lambda = answer["channels"][0]["lambda_per_s"].as_f64().unwrap();
    assert_eq!(answer["written"][0], "wire");
    let after = fs::read_to_string(rig.path()).unwrap();
    let line = format!("lambda_per_s = {lambda:?}");
    assert!(after.contains(&line), "{after}");
    for kept in before.lines() {
        assert!(after.lines().any(|line| line == kept), "{kept:?} is gone from\n{after}");
    }
    // Read back it is in force, and a second time changes nothing.
    let again = tune(&rig, &["--write", "--json"]).expect(0).json();
    assert_eq!(again["channels"][0]["now_per_s"].as_f64(), Some(lambda));
    assert_eq!(fs::read_to_string(rig.path()).unwrap(), after);
}

#[test]
fn channels_are_chosen_and_a_law_without_a_lambda_gets_none() {
    let rig = bench(3.0, "control = { algorithm = \"pi\" }\n");
    let found = tune(&rig, &["--write"]).expect(0);
    assert!(
        found.stderr.contains("algorithm \"pi\" has no λ") && found.stderr.contains("nothing written"),
        "{found:?}"
    );

    let two = Rig::bench(&["left", "right"], "");
    let answer = tune(&two, &["--channel", "right", "--json"]).expect(0).json();
    assert_eq!(answer["channels"].as_array().unwrap().len(), 1);
    assert_eq!(answer["channels"][0]["name"], "right");
    assert_eq!(tune(&two, &["--json"]).expect(0).json()["channels"].as_array().unwrap().len(), 2);
}

#[test]
fn bad_use_says_what_would_be_right() {
    let rig = bench(3.0, "");
    tune(&rig, &["--uncertainty", "300%"]).refused(&["0 to 90 %"]);
    tune(&rig, &["--uncertainty", "much"]).refused(&["30%"]);
    tune(&rig, &["--range", "90-10%"]).refused(&["rise"]);
    tune(&rig, &["--range", "half"]).refused(&["10-90%"]);
    tune(&rig, &["--channel", "wier"]).refused(&["wier", "did you mean \"wire\"?"]);
    run(["tune", "nowhere.toml"]).refused(&["nowhere.toml"]);
    run(["tune"]).refused(&["RIG.toml"]);
    let power = Rig::named(|name| {
        format!(
            "[rig]\nname = \"{name}\"\nrate_hz = 1000.0\n\n[[channel]]\nname = \"wire\"\n\
             wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\ndrive = {{ kind = \"power\" }}\nload = {{ mass_kg = 0.2 }}\n"
        )
    });
    tune(&power, &[]).refused(&["\"pwm\"", "wire"]);
    let help = run(["tune", "--help"]).expect(0).stdout;
    assert!(help.contains("Examples:") && help.contains("--uncertainty"), "{help}");
}
