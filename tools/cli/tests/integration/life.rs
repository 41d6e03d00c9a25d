//! `sinew life`: the account that `sinew run` keeps, across runs.

use serde_json::Value;

use crate::support::Scratch;

fn wires(scratch: &Scratch, args: &[&str]) -> Vec<Value> {
    let text = scratch.sinew(["life"].into_iter().chain(args.iter().copied()).chain(["--json"])).done();
    let answer: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(answer["schema"], "sinew.life/1");
    answer["wire"].as_array().expect("a list").clone()
}

fn number(wire: &Value, path: &str) -> f64 {
    wire.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {wire}"))
}

/// The walking hexapod: what two runs add is there, a new wire begins anew, a damaged file is said and left alone.
#[test]
fn an_account_is_kept_across_runs() {
    let scratch = Scratch::new();
    let hexapod = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/hexapod.toml");
    let none = scratch.sinew(["life"]);
    assert!(none.done().is_empty() && none.stderr().contains("no account yet"));
    let walk = |seconds| {
        let ran = scratch.sinew(["run", hexapod, "--speed", "max", "--for", seconds, "--no-monitor"]);
        ran.done();
        ran.stderr()
    };
    assert!(walk("20").contains("has used most"));
    let once = wires(&scratch, &[]);
    assert_eq!(once.len(), 18);
    walk("20");
    let twice = wires(&scratch, &[hexapod, "front_left_femur"]);
    let [wire] = twice.as_slice() else { panic!("{twice:?}") };
    let before = once.iter().find(|wire| wire["channel"] == "front_left_femur").expect("it was driven");
    assert_eq!((number(before, "/runs"), number(wire, "/runs")), (1.0, 2.0));
    assert!((number(wire, "/hours_watched") * 3600.0 - 40.0).abs() < 0.1, "{wire}");
    let (cycles, used) = (number(wire, "/cycles"), number(wire, "/used/middle"));
    assert!(cycles > 1.5 * number(before, "/cycles") && used > 1.5 * number(before, "/used/middle"), "{wire}");
    let (least, most) = (number(wire, "/used/least"), number(wire, "/used/most"));
    assert!(0.0 < least && least < used && used < most && most < 0.01, "{wire}");
    assert_eq!((&wire["broken_in"], &wire["simulated"]), (&"no".into(), &true.into()));
    let text = scratch.sinew(["life", hexapod]).done();
    assert!(text.starts_with("hexapod (simulated)\n") && text.lines().count() == 20, "{text}");

    let said = scratch.sinew(["life", hexapod, "front_left_femur", "--new-wire"]).done();
    let old = said.trim().rsplit(' ').next().expect("a path");
    assert!(std::path::Path::new(old).is_file(), "{said}");
    assert_eq!(number(&wires(&scratch, &[hexapod, "front_left_femur"])[0], "/cycles"), 0.0);

    let place = scratch.path("state/life/simulated/hexapod/front_left_coxa.json");
    let whole = std::fs::read(&place).expect("an account");
    let half = &whole[..whole.len() / 2];
    std::fs::write(&place, half).expect("the folder is writable");
    let words = ["front_left_coxa.json", "--new-wire"];
    scratch.sinew(["life", hexapod, "front_left_coxa"]).refused(&[]);
    let asked = scratch.sinew(["life"]);
    assert_eq!(asked.code(), 2);
    assert!(asked.stdout().contains("rear_right_tibia"), "the others are shown");
    assert!(words.iter().all(|word| asked.stderr().contains(word)), "{}", asked.stderr());
    let said = walk("2");
    assert!(said.contains("no account of front_left_coxa in this run"), "{said}");
    assert_eq!(std::fs::read(&place).expect("it is there"), half, "it is not written over");
}

#[test]
fn what_is_asked_for_has_to_be_there() {
    let scratch = Scratch::new();
    let hexapod = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/hexapod.toml");
    scratch.sinew(["life", hexapod, "front_left_femor"]).refused(&["front_left_femor", "front_left_femur"]);
    scratch.sinew(["life", "nothing.toml"]).refused(&["nothing.toml"]);
    scratch.file("monday.csv", "time_s,duty\n0,0\n1,0\n2,0\n");
    scratch.sinew(["life", "--of", "monday.csv"]).refused(&["monday.csv", "--rig"]);
    scratch.sinew(["life", "--of", "monday.csv", "--rig", hexapod]).refused(&["18 channels", "--channel"]);
    scratch.sinew(["life", "--of", "none.mcap"]).refused(&["none.mcap"]);
}

/// A longer life takes more wire, and says by how much less that wire is asked for.
#[test]
fn a_design_can_be_asked_for_a_life() {
    let scratch = Scratch::new();
    let of = |more: &[&str]| -> Value {
        let args = ["design", "--force", "2N", "--stroke", "6mm", "--json"];
        serde_json::from_str(&scratch.sinew(args.into_iter().chain(more.iter().copied())).done()).expect("JSON")
    };
    let (table, long) = (of(&[]), of(&["--life", "1e6"]));
    assert_eq!((number(&table, "/allowed_stress_pa"), number(&table, "/allowed_strain")), (170e6, 0.04));
    let length = |answer: &Value| number(answer, &format!("/wires/{}/length_m", answer["chosen"]));
    assert!((length(&table) - 0.15).abs() < 1e-9 && length(&long) > 3.0 * length(&table), "{}", length(&long));
    assert!(number(&long, "/allowed_strain") < 0.02 && number(&long, "/allowed_stress_pa") <= 170e6);
    scratch.sinew(["design", "--force", "2N", "--stroke", "6mm", "--life", "1e12"]).refused(&["can be asked for"]);
}
