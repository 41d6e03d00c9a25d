//! `sinew simulate`: good input gives what the physics gives, bad input is refused with its place and remedy.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Read;
use std::path::Path;

use crate::support::{FURNACE, RIG, Scratch, WORK_LOOP};
use flate2::read::GzDecoder;
use sinew_physics::{Inputs, Wire};
use sinew_rig::Rig;

/// A table's columns by name, in order.
struct Table {
    names: Vec<String>,
    columns: BTreeMap<String, Vec<f64>>,
}

impl Table {
    fn parse(text: &str) -> Table {
        let mut lines = text.lines();
        let names: Vec<String> = lines.next().expect("a header").split(',').map(str::to_string).collect();
        let mut columns: BTreeMap<String, Vec<f64>> = names.iter().map(|name| (name.clone(), Vec::new())).collect();
        for line in lines {
            for (name, cell) in names.iter().zip(line.split(',')) {
                columns.get_mut(name).expect("its column").push(cell.parse().unwrap_or(f64::NAN));
            }
        }
        Table { names, columns }
    }

    fn read(path: &Path) -> Table {
        Table::parse(&std::fs::read_to_string(path).expect("a file"))
    }

    #[track_caller]
    fn get(&self, name: &str) -> &[f64] {
        self.columns.get(name).unwrap_or_else(|| panic!("no {name} in {:?}", self.names))
    }
}

/// Rows of a heating pulse with uneven steps.
fn pulse() -> String {
    let mut text = "time_s,duty,position_m\n".to_string();
    let mut time_s = 3.0;
    for row in 0..400 {
        let duty = if (40..250).contains(&row) { 0.6 } else { 0.05 };
        writeln!(text, "{time_s:.4},{duty},0.001").unwrap();
        time_s += if row % 7 == 0 { 0.02 } else { 0.01 };
    }
    text
}

#[test]
fn rows_are_those_of_the_recording_and_values_those_of_the_physics() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    let inputs = Table::read(&scratch.file("in.csv", pulse()));
    assert_eq!(scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "out.csv"]).done(), "");
    let out = Table::read(&scratch.path("out.csv"));
    assert_eq!(out.get("time_s"), inputs.get("time_s"));
    assert_eq!(out.get("duty"), inputs.get("duty"));
    assert_eq!(
        out.names,
        [
            "time_s",
            "duty",
            "current_a",
            "v1_v",
            "v2_v",
            "v3_v",
            "force_n",
            "position_m",
            "power_w",
            "temperature_c",
            "martensite"
        ]
    );

    let model = Rig::parse(RIG, "rig").unwrap().channels[0].model.clone();
    let row_inputs = |duty| Inputs { drive: duty, ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(&model, &row_inputs(inputs.get("duty")[0])).unwrap();
    let time = inputs.get("time_s");
    for row in 0..time.len() {
        let dt = if row + 1 < time.len() { time[row + 1] - time[row] } else { time[row] - time[row - 1] };
        wire.step(&row_inputs(inputs.get("duty")[row]), dt);
        let expected = wire.outputs();
        for (name, expected) in [
            ("current_a", expected.current_a),
            ("v2_v", expected.v2_v),
            ("v3_v", expected.v3_v),
            ("force_n", expected.force_n),
            ("position_m", expected.position_m),
            ("power_w", expected.power_w),
            ("temperature_c", expected.temperature_c),
            ("martensite", expected.martensite),
        ] {
            assert_eq!(out.get(name)[row], expected, "{name} in row {row}");
        }
    }
    // and the wire did something: it went through its transformation
    let martensite = out.get("martensite");
    assert!(martensite.iter().cloned().fold(1.0, f64::min) < 0.01, "it never got hot");
}

#[test]
fn stdout_and_gzip_carry_the_same_as_a_file() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    scratch.file("in.csv", pulse());
    scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "out.csv"]).done();
    scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "out.csv.gz"]).done();
    let plain = std::fs::read_to_string(scratch.path("out.csv")).unwrap();
    let mut unpacked = String::new();
    GzDecoder::new(std::fs::File::open(scratch.path("out.csv.gz")).unwrap()).read_to_string(&mut unpacked).unwrap();
    assert_eq!(unpacked, plain);
    assert_eq!(scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "-"]).done(), plain);
}

#[test]
fn a_simulation_drives_a_simulation_to_the_same_end() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    scratch.file("in.csv", pulse());
    scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "once.csv"]).done();
    scratch.sinew(["simulate", "rig.toml", "once.csv", "-o", "twice.csv", "--ignore-columns"]).done();
    let read = |name| std::fs::read_to_string(scratch.path(name)).unwrap();
    assert_eq!(read("once.csv"), read("twice.csv"));
}

#[test]
fn supply_ambient_and_disturbance_are_inputs_where_present() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    let row = |extra: &str| {
        let mut text = "time_s,duty,supply_v,ambient_c,disturbance_n\n".to_string();
        for row in 0..200 {
            writeln!(text, "{:.2},0.2,{extra}", f64::from(row) * 0.01).unwrap();
        }
        text
    };
    let last = |name: &str, text: String, column: &str| {
        let path = format!("{name}.csv");
        let out = format!("{name}-out.csv");
        scratch.file(&path, text);
        scratch.sinew(["simulate", "rig.toml", &path, "-o", &out]).done();
        *Table::read(&scratch.path(&out)).get(column).last().unwrap()
    };
    let usual = last("usual", row("6.0,25.0,0.0"), "temperature_c");
    assert!(last("supply", row("7.0,25.0,0.0"), "temperature_c") > usual + 5.0);
    assert!(last("ambient", row("6.0,35.0,0.0"), "temperature_c") > usual + 5.0);
    let hanging = last("still", row("6.0,25.0,0.0"), "force_n");
    assert!((last("pulled", row("6.0,25.0,0.5"), "force_n") - hanging - 0.5).abs() < 0.01);
}

#[test]
fn furnaces_and_imposed_positions_are_driven_by_their_columns() {
    let scratch = Scratch::new();
    scratch.file("furnace.toml", FURNACE);
    let mut text = "time_s,temperature_c,force_n,position_m\n".to_string();
    for row in 0..200 {
        let (t, up) = (f64::from(row), f64::from(row.min(200 - row)));
        writeln!(text, "{t},{},{},0.001", 30.0 + up, 20.0 + 0.01 * t).unwrap();
    }
    let inputs = Table::read(&scratch.file("furnace.csv", text));
    scratch.sinew(["simulate", "furnace.toml", "furnace.csv", "-o", "furnace-out.csv"]).done();
    let out = Table::read(&scratch.path("furnace-out.csv"));
    assert_eq!(out.names, ["time_s", "temperature_c", "force_n", "position_m", "martensite"]);
    assert_eq!(out.get("temperature_c"), inputs.get("temperature_c"));
    assert_eq!(out.get("force_n"), inputs.get("force_n"));
    let position = out.get("position_m");
    assert!(position[0] - position[100] > 0.03 * 0.1, "cold {} m, hot {} m", position[0], position[100]);

    scratch.file("loop.toml", WORK_LOOP);
    let mut text = "time_s,power_w,position_m,force_n\n".to_string();
    for row in 0..200 {
        let t = 0.1 * f64::from(row);
        let power = if row % 60 < 25 { 3.0 } else { 0.0 };
        writeln!(text, "{t:.1},{power},{},50.0", 0.002 + 0.001 * t.sin()).unwrap();
    }
    let inputs = Table::read(&scratch.file("loop.csv", text));
    scratch.sinew(["simulate", "loop.toml", "loop.csv", "-o", "loop-out.csv"]).done();
    let out = Table::read(&scratch.path("loop-out.csv"));
    assert_eq!(out.names, ["time_s", "power_w", "position_m", "force_n", "temperature_c", "martensite"]);
    assert_eq!(out.get("power_w"), inputs.get("power_w"));
    assert_eq!(out.get("position_m"), inputs.get("position_m"));
    let force = out.get("force_n");
    assert!(force.iter().all(|f| f.is_finite() && *f >= 0.0));
    assert!(force.iter().cloned().fold(0.0, f64::max) > 10.0, "heated at a held length, the wire pulls");
}

#[test]
fn bad_input_names_its_place_and_remedy_and_leaves_no_output() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    let refused = |text: &str, needles: &[&str]| {
        scratch.file("in.csv", text);
        scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "out.csv"]).refused(needles);
        assert!(!scratch.path("out.csv").exists());
    };
    refused("", &["in.csv", "empty"]);
    refused("time_s,duty\n", &["in.csv", "no rows"]);
    refused("time_s,duty\n0,0.1\n1,0.1\n", &["in.csv", "2 samples"]);
    refused("duty\n0.1\n0.1\n0.1\n", &["time_s"]);
    refused("time_s,position_m\n0,0\n1,0\n2,0\n", &["in.csv", "duty", "pwm"]);
    refused("time_s,duty\n0,0.1\n1,0.1\n1,0.1\n", &["in.csv:4", "time has to increase"]);
    refused("time_s,duty\n0,0.1\n1,\n2,0.1\n", &["in.csv:3", "duty", "no value"]);
    refused("time_s,duty\n0,0.1\n1,1.5\n2,0.1\n", &["in.csv:3", "not in 0 to 1"]);
    refused("time_s,duty\n0,0.1\n1,full\n2,0.1\n", &["in.csv:3", "full", "not a number"]);
    refused("time_s,duty\n0,0.1\n1,inf\n2,0.1\n", &["in.csv:3", "infinite"]);
    refused("time_s,duty,pos\n0,0.1,0\n1,0.1,0\n2,0.1,0\n", &["pos", "--ignore-columns"]);
    refused("time_s;duty\n0;0.1\n1;0.1\n2;0.1\n", &["in.csv", "expected commas"]);
    refused("time_s,duty\n0,0.1\n1,0.1,7\n2,0.1\n", &["in.csv:3", "cells"]);
}

#[test]
fn an_ignored_column_is_passed_over() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    scratch.file("in.csv", "time_s,duty,pos\n0,0.1,0\n1,0.1,0\n2,0.1,0\n");
    let out = Table::parse(&scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "-", "--ignore-columns"]).done());
    assert!(!out.names.contains(&"pos".to_string()));
    assert_eq!(out.get("time_s"), [0.0, 1.0, 2.0]);
}

#[test]
fn files_and_channels_that_are_not_there_are_named() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG);
    scratch.file("in.csv", pulse());
    scratch.sinew(["simulate", "no.toml", "in.csv", "-o", "-"]).refused(&["no.toml", "cannot be read"]);
    scratch.sinew(["simulate", "rig.toml", "no.csv", "-o", "-"]).refused(&["no.csv", "cannot be read"]);
    scratch.sinew(["simulate", "rig.toml", "in.csv"]).refused(&["--output", "sinew simulate --help"]);
    scratch
        .sinew(["simulate", "rig.toml", "in.csv", "-o", "-", "--channel", "wires"])
        .refused(&["no channel \"wires\"", "did you mean \"wire\"?"]);
    let two = format!("{RIG}\n[[channel]]\nname = \"other\"\nwire = {{ diameter_mm = 0.125, length_mm = 100.0 }}\n");
    let two = two + "drive = { supply_v = 6.0 }\nload = { mass_kg = 0.1, damping_n_s_per_m = 20.0, preload_n = 1.0 }\n";
    scratch.file("two.toml", two);
    scratch.sinew(["simulate", "two.toml", "in.csv", "-o", "-"]).refused(&["2 channels", "wire, other"]);
    let out = scratch.sinew(["simulate", "two.toml", "in.csv", "-o", "-", "--channel", "other"]).done();
    assert!(!Table::parse(&out).names.contains(&"v2_v".to_string()), "that wire has no taps");
    scratch.file("bad.toml", RIG.replace("diameter_mm = 0.125", "diameter_mm = -1"));
    scratch.sinew(["simulate", "bad.toml", "in.csv", "-o", "-"]).refused(&["bad.toml:10", "diameter_mm"]);
    // as with `run --report`: a folder that is not there is the user's to make, and found out before the work
    scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "no/such/out.csv"]).refused(&["no/such/out.csv", "mkdir"]);
}

#[test]
fn foreign_columns_are_mapped_by_the_rig_file() {
    let scratch = Scratch::new();
    let columns = "[recording.columns]\nduty = { column = \"PWM\", scale = 0.01 }\n";
    scratch.file("rig.toml", format!("{RIG}\n{columns}"));
    scratch.file("in.csv", "time_s,PWM\n0,10\n1,20\n2,30\n");
    let out = Table::parse(&scratch.sinew(["simulate", "rig.toml", "in.csv", "-o", "-"]).done());
    for (found, expected) in out.get("duty").iter().zip([0.1, 0.2, 0.3]) {
        assert!((found - expected).abs() < 1e-12);
    }
}
