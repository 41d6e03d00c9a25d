//! `sinew diagnose` and `sinew identify` through the real binary: whatever is wrong with what they are given is refused with
//! its place and remedy, exit 2 and never a verdict; nothing is left half-written.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use sinew_tests::{Finished, Process, Rig, entries, run, sinew, wait_until};

const RIG: &str = "
[[channel]]
name = \"wire\"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
taps = { l0_mm = 10.0, ls_mm = 140.0 }
drive = { supply_v = 6.0, shunt_ohm = 0.1, switch_ohm = 0.02 }
load = { mass_kg = 0.13, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.6 }
";

/// Columns of the recording that is taken apart, with the noise of each.
const COLUMNS: [(&str, f64); 6] =
    [("time_s", 0.0), ("duty", 0.0), ("current_a", 4e-4), ("v3_v", 1.5e-3), ("force_n", 3e-3), ("position_m", 1.5e-5)];

/// A rig, and a good recording of it as rows of cells.
struct Bench {
    rig: Rig,
    rows: Vec<[f64; COLUMNS.len()]>,
}

impl Bench {
    /// Twenty seconds at 50 Hz of stairs, simulated, with noise.
    fn new() -> Bench {
        let rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = 50.0\n{RIG}"));
        let duties = [0.05, 0.32, 0.12, 0.24, 0.02, 0.36, 0.16, 0.28, 0.1, 0.02];
        let mut inputs = "time_s,duty\n".to_string();
        for i in 0..1000 {
            writeln!(inputs, "{:.2},{}", f64::from(i) * 0.02, duties[i as usize / 100]).unwrap();
        }
        fs::write(rig.file("inputs.csv"), inputs).unwrap();
        let (rig_file, inputs) = (rig.path(), rig.file("inputs.csv"));
        let done = run([Path::new("simulate"), &rig_file, &inputs, Path::new("-o"), Path::new("-")]).expect(0);
        let mut lines = done.stdout.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let places = COLUMNS.map(|(name, _)| names.iter().position(|n| *n == name).unwrap());
        let mut random = Random(1);
        let rows = lines.map(|line| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            std::array::from_fn(|i| cells[places[i]] + COLUMNS[i].1 * random.normal())
        });
        Bench { rows: rows.collect(), rig }
    }

    /// Writes the recording with these columns, each cell changed as wanted.
    fn recording(&self, name: &str, columns: &[&str], change: impl Fn(usize, &str, f64) -> f64) -> PathBuf {
        let mut text = columns.join(",") + "\n";
        for (row, cells) in self.rows.iter().enumerate() {
            let cell = |column: &&str| {
                let place = COLUMNS.iter().position(|(name, _)| name == column).unwrap();
                let value = change(row, column, cells[place]);
                if value.is_nan() { String::new() } else { value.to_string() }
            };
            text += &(columns.iter().map(cell).collect::<Vec<_>>().join(",") + "\n");
        }
        self.file(name, &text)
    }

    fn all(&self, name: &str, change: impl Fn(usize, &str, f64) -> f64) -> PathBuf {
        self.recording(name, &COLUMNS.map(|(name, _)| name), change)
    }

    fn good(&self) -> PathBuf {
        self.all("good.csv", |_, _, value| value)
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.rig.file(name);
        fs::write(&path, text).unwrap();
        path
    }

    fn diagnose(&self, recordings: &[&Path], more: &[&str]) -> Finished {
        let out = self.rig.file("out");
        let rig = self.rig.path();
        let args = [Path::new("diagnose"), &rig].into_iter().chain(recordings.iter().copied());
        run(args.chain([Path::new("--out"), &out]).chain(more.iter().map(Path::new)))
    }

    /// Refused by both commands with these words, and nothing is there afterwards that was not there before.
    #[track_caller]
    fn refuses(&self, recording: &Path, words: &[&str]) {
        let here = self.rig.path();
        let before = entries(here.parent().unwrap());
        self.diagnose(&[recording], &[]).refused(words);
        self.diagnose(&[recording], &["--json"]).refused(words);
        let fitted = self.rig.file("fitted.toml");
        run([Path::new("identify"), &here, recording, Path::new("-o"), &fitted]).refused(words);
        assert_eq!(entries(here.parent().unwrap()), before, "something was left behind");
    }
}

/// A few random numbers without a dependency: noise only has to be uneven here.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Nearly normal: the sum of twelve uniform ones.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

#[test]
fn a_recording_without_what_is_needed_is_refused() {
    let bench = Bench::new();
    let no_drive = bench.recording("nodrive.csv", &["time_s", "position_m"], |_, _, v| v);
    bench.refuses(&no_drive, &["nodrive.csv:1", "duty", "[recording.columns]"]);
    let no_sensor = bench.recording("nosensor.csv", &["time_s", "duty"], |_, _, v| v);
    bench.refuses(&no_sensor, &["nosensor.csv", "no measured column", "position_m"]);
    let no_time = bench.recording("notime.csv", &["duty", "position_m"], |_, _, v| v);
    bench.refuses(&no_time, &["notime.csv:1", "time_s"]);
    bench.refuses(&bench.file("empty.csv", ""), &["empty.csv", "empty"]);
    bench.refuses(&bench.file("header.csv", "time_s,duty,position_m\n"), &["header.csv"]);
    let two = bench.file("two.csv", "time_s,duty,position_m\n0,0.1,0.007\n0.02,0.1,0.007\n");
    bench.refuses(&two, &["two.csv", "at least 3"]);
    let few = "time_s,duty,position_m\n".to_string()
        + &(0..50).map(|i| format!("{i},0.1,0.00{}\n", i % 10)).collect::<String>();
    bench.refuses(&bench.file("few.csv", &few), &["few.csv", "50 samples", "100"]);
    bench.refuses(&bench.rig.file("nowhere.csv"), &["nowhere.csv", "cannot be read"]);
}

#[test]
fn missing_samples_are_refused_in_inputs_and_where_nothing_else_is_left() {
    let bench = Bench::new();
    let holes = bench.all("holes.csv", |row, column, v| if row == 7 && column == "duty" { f64::NAN } else { v });
    bench.refuses(&holes, &["holes.csv:9", "duty"]);
    let sensors = ["time_s", "duty", "position_m"];
    let nothing =
        bench.recording("nothing.csv", &sensors, |_, column, v| if column == "position_m" { f64::NAN } else { v });
    bench.refuses(&nothing, &["nothing.csv", "position_m", "missing"]);
    let stuck = bench.recording("stuck.csv", &sensors, |_, column, v| if column == "position_m" { 0.005 } else { v });
    bench.refuses(&stuck, &["stuck.csv", "position_m", "stands at 0.005"]);
}

#[test]
fn other_units_are_refused_with_the_scale_that_mends_them() {
    let bench = Bench::new();
    let times = |column: &'static str, factor: f64| {
        let name = format!("{column}{factor}.csv");
        bench.all(&name, |_, c, v| if c == column { factor * v } else { v })
    };
    bench.refuses(&times("position_m", 1e3), &["position_m1000.csv", "position_m"]);
    bench.refuses(&times("position_m", 1e-3), &["position_m", "scale = 1000"]);
    bench.refuses(&times("position_m", -1.0), &["position_m", "sign", "scale = -1"]);
    bench.refuses(&times("force_n", 1e3), &["force_n", "scale = 0.001"]);
    bench.refuses(&times("v3_v", 1e3), &["v3_v", "scale = 0.001"]);
    bench.refuses(&times("current_a", 1e3), &["current_a", "scale = 0.001"]);
    bench.refuses(&times("duty", 100.0), &["duty", "scale = 0.01"]);
    bench.refuses(&times("time_s", 0.001), &["time_s0.001.csv", "is 0.02 s long"]);
    bench.refuses(&times("time_s", 0.4), &["the clock cannot be right", "time_s = {"]);
}

#[test]
fn a_rig_and_a_recording_that_do_not_belong_together_are_refused() {
    let bench = Bench::new();
    let good = bench.good();
    let with = |from: &str, to: &str| {
        let text = fs::read_to_string(bench.rig.path()).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{from}");
        let rig = bench.file("other.toml", &text.replace(from, to));
        let out = bench.rig.file("out");
        run([Path::new("diagnose"), &rig, &good, Path::new("--out"), &out])
    };
    with("diameter_mm = 0.125", "diameter_mm = 0.25").refused(&["good.csv", "resistance", "diameter_mm"]);
    with("length_mm = 160.0", "length_mm = 600.0").refused(&["good.csv", "resistance", "length_mm"]);
    with("supply_v = 6.0", "supply_v = 1.5").refused(&["good.csv", "v3_v", "supply_v"]);
    with("preload_n = 2.6", "preload_n = 26.0").refused(&["good.csv"]);
    with("supply_v = 6.0", "kind = \"temperature\"").refused(&["good.csv", "temperature_c", "kind = \"pwm\""]);
    let missing = bench.rig.file("missing.toml");
    let out = bench.rig.file("out");
    run([Path::new("diagnose"), &missing, &good, Path::new("--out"), &out])
        .refused(&["missing.toml", "cannot be read"]);
    bench.diagnose(&[&good], &["--channel", "wrie"]).refused(&["wrie", "did you mean \"wire\"?"]);
    assert!(!out.exists());
}

#[test]
fn a_recording_is_given_once_and_never_judges_itself() {
    let bench = Bench::new();
    let good = bench.good();
    let copy = bench.all("copy.csv", |_, _, v| v);
    bench.diagnose(&[&good, &good], &[]).refused(&["same recording", "once"]);
    bench.diagnose(&[&good], &["--holdout", good.to_str().unwrap()]).refused(&["same recording", "not fitted"]);
    bench.diagnose(&[&good], &["--holdout", copy.to_str().unwrap()]).refused(&["copy.csv", "good.csv", "not fitted"]);
    bench.diagnose(&[&good], &["--holdout", "nowhere.csv"]).refused(&["nowhere.csv"]);
    assert!(!bench.rig.file("out").exists());
}

#[test]
fn nothing_that_goes_in_is_overwritten_and_a_place_is_found_first() {
    let bench = Bench::new();
    let good = bench.good();
    let rig = bench.rig.path();
    let diagnose = |rig: &Path, out: &Path| run([Path::new("diagnose"), rig, &good, Path::new("--out"), out]);
    let improved = bench.file("improved.toml", &fs::read_to_string(&rig).unwrap());
    diagnose(&improved, improved.parent().unwrap()).refused(&["improved.toml", "overwrite"]);
    diagnose(&rig, &good).refused(&["good.csv", "not a folder"]);
    diagnose(&rig, &good.join("deeper")).refused(&["good.csv", "not a folder"]);
    let identify = |out: &Path| run([Path::new("identify"), &rig, &good, Path::new("-o"), out]);
    identify(&rig).refused(&["rig.toml", "overwrite"]);
    identify(&good).refused(&["good.csv", "overwrite"]);
    identify(rig.parent().unwrap()).refused(&["folder"]);
    identify(&bench.rig.file("no/such/fitted.toml")).refused(&["no/such", "mkdir -p"]);
    for args in [&["diagnose"][..], &["diagnose", "rig.toml", "a.csv"], &["identify", "rig.toml", "a.csv"]] {
        assert_eq!(run(args).expect(2).stdout, "");
    }
    bench.diagnose(&[&good], &["--jobs", "0"]).refused(&["--jobs"]);
    bench.diagnose(&[&good], &["--seed", "soon"]).refused(&["--seed"]);
}

/// A recording of this wire in air that cools it better than the rig file believes: position alone.
fn cooled_better(bench: &Bench) -> PathBuf {
    let truth = fs::read_to_string(bench.rig.path()).unwrap() + "material = { convection_w_per_m2_k = 140.0 }\n";
    let truth = bench.file("truth.toml", &truth);
    recorded(bench, "cooled.csv", &[&truth, &bench.rig.file("inputs.csv")])
}

/// What its position sensor shows where `simulate` is given these arguments.
fn recorded(bench: &Bench, name: &str, simulate: &[&Path]) -> PathBuf {
    let args = simulate.iter().map(|path| path.as_os_str().to_owned());
    let simulated = run(["simulate".into()].into_iter().chain(args).chain(["-o".into(), "-".into()])).expect(0).stdout;
    let mut lines = simulated.lines();
    let place = lines.next().unwrap().split(',').position(|name| name == "position_m").unwrap();
    let mut random = Random(2);
    let mut text = "time_s,duty,position_m\n".to_string();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let position: f64 = cells[place].parse().unwrap();
        writeln!(text, "{},{},{}", cells[0], cells[1], position + 1.5e-5 * random.normal()).unwrap();
    }
    bench.file(name, &text)
}

#[test]
fn identify_finds_a_parameter_and_writes_it_into_the_rig_file() {
    let bench = Bench::new();
    let recording = cooled_better(&bench);
    let (rig, fitted) = (bench.rig.path(), bench.rig.file("fitted.toml"));
    let identify = |rig: &Path, more: &[&str]| {
        let args = [Path::new("identify"), rig, &recording, Path::new("-o"), &fitted];
        run(args.into_iter().chain(more.iter().map(Path::new))).expect(0)
    };
    let said = identify(&rig, &["--json"]).json();
    assert_eq!(said["schema"], "sinew.identify/1");
    let convection = &said["parameters"]["convection_w_per_m2_k"];
    let of = |key: &str| convection[key].as_f64().unwrap();
    assert_eq!(of("given"), 121.2);
    assert!((of("value") - 140.0).abs() < 5.0 && of("low") < of("value") && of("value") < of("high"), "{convection}");
    let chi = |stage: &str| said["fit"][stage]["position_m"]["chi"].as_f64().unwrap();
    assert!(chi("as_given") > 10.0 && (0.9..1.1).contains(&chi("recalibrated")), "{said}");
    // what was written is a rig file that explains the recording
    let written = fs::read_to_string(&fitted).unwrap();
    let table = identify(&rig, &["--seed", "1"]);
    assert_eq!(fs::read_to_string(&fitted).unwrap(), written, "same input and seed, same answer");
    assert!(table.stdout.contains("convection_w_per_m2_k") && table.stdout.contains("90 % interval"), "{table:#?}");
    assert!(table.stderr.contains("written: "), "{table:#?}");
    fs::write(bench.rig.file("again.toml"), written).unwrap();
    let again = identify(&bench.rig.file("again.toml"), &["--json"]).json();
    assert!(again["fit"]["as_given"]["position_m"]["chi"].as_f64().unwrap() < 1.2, "{again}");
    let printed = run([Path::new("identify"), &rig, &recording, Path::new("-o"), Path::new("-")]).expect(0);
    assert!(printed.stdout.contains("[rig]") && printed.stderr.contains("90 % interval"), "{printed:#?}");
}

#[test]
fn diagnose_writes_the_whole_answer_and_says_no_more_than_is_so() {
    let bench = Bench::new();
    let recording = cooled_better(&bench);
    let done = bench.diagnose(&[&recording], &["--json", "--jobs", "2"]).expect(0);
    let out = bench.rig.file("out");
    let said = done.json();
    assert_eq!(fs::read_to_string(out.join("diagnosis.json")).unwrap(), done.stdout);
    assert_eq!(said["schema"], "sinew.diagnosis/1");
    assert!(["parameters_off", "agrees"].contains(&said["verdict"].as_str().unwrap()), "{}", said["verdict"]);
    assert_eq!(said["effects"].as_array().map(Vec::len), Some(0), "{said}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.to_lowercase().starts_with("<!doctype html>") && page.contains("--jobs 2"));
    let improved = out.join("improved.toml");
    let inputs = bench.rig.file("inputs.csv");
    run([Path::new("simulate"), &improved, &inputs, Path::new("-o"), Path::new("-")]).expect(0);
    assert_eq!(entries(&out), ["diagnosis.json", "improved.toml", "report.html"]);
    // the answer is the same on any number of threads, and the ten lines say it too
    let again = bench.diagnose(&[&recording], &["--jobs", "1", "--picture"]).expect(0);
    let mut pictured: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("diagnosis.json")).unwrap()).unwrap();
    let files = std::mem::replace(&mut pictured["files"], serde_json::json!({}));
    assert_eq!(files.as_object().unwrap().keys().collect::<Vec<_>>(), ["picture.svg"]);
    assert_eq!(pictured, said, "the same but for the picture");
    assert!(fs::read_to_string(out.join("picture.svg")).unwrap().starts_with("<svg"));
    assert!(again.stdout.contains("chi") && !again.stdout.contains('\u{1b}'), "{again:#?}");
    assert!(again.stderr.contains("report.html"), "{again:#?}");
    // an answer without a picture leaves none of an earlier one, and nothing that is not the earlier one's
    fs::write(out.join("next.csv"), "my own").unwrap();
    let bare = bench.diagnose(&[&recording], &[]).expect(0);
    assert_eq!(entries(&out), ["diagnosis.json", "improved.toml", "next.csv", "report.html"]);
    assert!(bare.stderr.contains("left as it is") && bare.stderr.contains("next.csv"), "{bare:#?}");
    // nor what has been changed since
    bench.diagnose(&[&recording], &["--picture"]).expect(0);
    fs::write(out.join("picture.svg"), "<svg>retouched</svg>").unwrap();
    bench.diagnose(&[&recording], &[]).expect(0);
    assert_eq!(fs::read_to_string(out.join("picture.svg")).unwrap(), "<svg>retouched</svg>");
}

const SLIPSTREAM: &str = r#"
[effects."own.slipstream"]
says = "The moving wire stirs the air around it."
enters = "heat"
formula = "-gain * surface * abs(velocity) * (temperature - ambient)"
[effects."own.slipstream".parameters.gain]
unit = "W s/(m³ K)"
null = 0.0
range = [0.0, 1e5]
plausible = [500.0, 20000.0]
about = "loss per surface, speed and degree"

[effects."own.draw"]
says = "A steady draw of heat that is not there."
enters = "heat"
formula = "-watt * step(time - 3 [s])"
[effects."own.draw".parameters]
watt = { unit = "mW", null = 0.0, range = [0.0, 1e3], about = "heat drawn off" }
"#;

#[test]
fn a_law_of_ones_own_is_found_among_all_others_and_written_where_it_acts() {
    let bench = Bench::new();
    let laws = bench.file("laws.toml", SLIPSTREAM);
    let truth = fs::read_to_string(bench.rig.path()).unwrap() + "effects.\"own.slipstream\" = { gain = 8000.0 }\n";
    let truth = bench.file("truth.toml", &truth);
    let inputs = bench.rig.file("inputs.csv");
    let recording = recorded(&bench, "windy.csv", &[&truth, &inputs, Path::new("--catalogue"), &laws]);
    let catalogue = ["--catalogue", laws.to_str().unwrap()];
    let done = bench.diagnose(&[&recording], &[&["--json"][..], &catalogue].concat()).expect(0);
    let said = done.json();
    assert_eq!(said["verdict"], "physics_missing", "{said:#}");
    let ids: Vec<&str> = said["effects"].as_array().unwrap().iter().map(|e| e["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["own.slipstream"], "{said:#}");
    let gain = &said["effects"][0]["parameters"]["gain"];
    let of = |key: &str| gain[key].as_f64().unwrap();
    assert!(of("low") < 8000.0 && 8000.0 < of("high") && of("high") - of("low") < 4000.0, "{gain}");
    assert!(said["sources"].to_string().contains("laws.toml") || done.stdout.contains("own.slipstream"));
    // the improved rig file needs the catalogue no more, and agrees
    let improved = bench.rig.file("out").join("improved.toml");
    let text = fs::read_to_string(&improved).unwrap();
    assert!(text.contains("abs(velocity)") && !text.contains("own.draw"), "{text}");
    // what would confirm it can be driven
    let next = bench.rig.file("out").join("next.csv");
    assert!(said["next_experiment"].as_str().unwrap().ends_with("Its drive is in next.csv."), "{said:#}");
    let driven = run([Path::new("simulate"), &improved, &next, Path::new("-o"), Path::new("-")]).expect(0).stdout;
    assert_eq!(driven.lines().count(), 3001, "a minute at 50 Hz");
    let improved = bench.file("better.toml", &text);
    let out = bench.rig.file("out");
    let again = run([Path::new("diagnose"), &improved, &recording, Path::new("--out"), &out, Path::new("--json")]);
    assert_eq!(again.expect(0).json()["verdict"], "agrees");
    assert!(!next.exists(), "no programme is proposed any more");
    // where nothing of one's own is missing, its being there changes nothing
    let good = bench.good();
    let (with, without) =
        (bench.diagnose(&[&good], &[&["--json"][..], &catalogue].concat()), bench.diagnose(&[&good], &["--json"]));
    assert_eq!(with.expect(0).json()["verdict"], without.expect(0).json()["verdict"]);
}

#[test]
fn a_law_that_is_wrong_is_refused_at_its_place() {
    let bench = Bench::new();
    let good = bench.good();
    let refused = |name: &str, from: &str, to: &str, words: &[&str]| {
        assert!(SLIPSTREAM.contains(from), "{from}");
        let laws = bench.file(name, &SLIPSTREAM.replacen(from, to, 1));
        bench.diagnose(&[&good], &["--catalogue", laws.to_str().unwrap()]).refused(words);
    };
    refused("name.toml", "abs(velocity)", "abs(speed)", &["name.toml:5", "no `speed` here", "^^^^^", "own-physics.md"]);
    refused("unit.toml", "- ambient", "- velocity", &["unit.toml:5", "K and m s^-1 cannot be added"]);
    refused("null.toml", "-gain *", "-(1e4 [W s/(m³ K)] + gain) *", &["null.toml:5", "has to be 0 there"]);
    refused("enters.toml", "\"heat\"", "\"heet\"", &["enters.toml:4", "did you mean \"heat\"?"]);
    bench.diagnose(&[&good], &["--catalogue", "nowhere.toml"]).refused(&["nowhere.toml", "cannot be read"]);
    // a formula that is no number only where this recording goes
    let root = "-gain * surface * abs(velocity) * sqrt((500 [K])^2 - (temperature + 425 [K])^2)";
    let laws = SLIPSTREAM.replace("-gain * surface * abs(velocity) * (temperature - ambient)", root);
    let laws = bench.file("root.toml", &laws);
    let set = fs::read_to_string(bench.rig.path()).unwrap() + "effects.\"own.slipstream\" = { gain = 1.0 }\n";
    let set = bench.file("set.toml", &set);
    let inputs = bench.rig.file("inputs.csv");
    let args = [Path::new("simulate"), &set, &inputs, Path::new("--catalogue"), &laws, Path::new("-o"), Path::new("-")];
    run(args).refused(&["own.slipstream"]);
}

#[test]
fn an_interrupt_leaves_nothing_behind() {
    let bench = Bench::new();
    let recording = cooled_better(&bench);
    let before = entries(bench.rig.path().parent().unwrap());
    let mut diagnose = Command::new(sinew());
    diagnose.arg("diagnose").arg(bench.rig.path()).arg(&recording).arg("--out").arg(bench.rig.file("out"));
    let mut running = Process::start(&mut diagnose);
    // What it reads and checks it does alone; the work that takes seconds is that of many threads.
    wait_until("it to be at work", || running.resources().threads > 1);
    assert_eq!(running.ended(), None, "it takes seconds");
    running.signal(libc::SIGINT);
    let ended = running.finish();
    assert_eq!((ended.code, ended.stdout.as_str()), (None, ""), "{ended:#?}");
    assert_eq!(entries(bench.rig.path().parent().unwrap()), before);
}

#[test]
fn a_huge_file_is_refused_within_bounded_memory() {
    let bench = Bench::new();
    // ten gigabytes of nothing behind a good beginning
    let sparse = bench.rig.file("sparse.csv");
    let mut file = fs::File::create(&sparse).unwrap();
    file.write_all(b"time_s,duty,position_m\n0,0.1,0.007\n0.02,0.1,0.007\n0.04,0.1,0.007\n").unwrap();
    file.set_len(10 << 30).unwrap();
    // and one row more than is taken
    let mut rows = String::from("time_s,duty,position_m\n");
    for i in 0..1_000_001 {
        writeln!(rows, "{i},0.1,0.007").unwrap();
    }
    let long = bench.file("long.csv", &rows);
    for (path, words) in [(&sparse, ["sparse.csv:5", "newline"]), (&long, ["long.csv", "at most 1000000 rows"])] {
        let mut limited = Command::new("sh");
        limited.args(["-c", "ulimit -v 1048576; exec \"$0\" \"$@\""]).arg(sinew());
        limited.arg("diagnose").arg(bench.rig.path()).arg(path).arg("--out").arg(bench.rig.file("out"));
        Process::start(&mut limited).finish().refused(&words);
    }
    assert!(!bench.rig.file("out").exists());
}

/// A recording of each of two wires that draw from one supply, from a true rig with a source resistance, as CSV.
fn two_wires(rig: &Rig, true_rig: &str) -> [PathBuf; 2] {
    let truth = sinew_rig::Rig::parse(true_rig, "truth.toml").unwrap();
    let times: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.02).collect();
    let duties = [0.05, 0.32, 0.12, 0.24, 0.02, 0.36, 0.16, 0.28, 0.1, 0.02];
    let mut run: Vec<(usize, sinew_recording::Recording)> = (0..2)
        .map(|wire| {
            let mut recording = sinew_recording::Recording::new("run", times.clone()).unwrap();
            let duty = (0..1000).map(|i| duties[(i + 70 * wire) / (100 - 20 * wire) % 10]).collect();
            recording.set(sinew_recording::Column::Duty, duty).unwrap();
            (wire, recording)
        })
        .collect();
    let given: Vec<(usize, &sinew_recording::Recording)> = run.iter().map(|(wire, run)| (*wire, run)).collect();
    let seen = sinew_recording::simulated_together(&truth, &given).unwrap();
    let mut random = Random(1);
    for ((_, recording), rows) in run.iter_mut().zip(seen) {
        for (name, rms) in &COLUMNS[2..] {
            let column = sinew_recording::Column::from_name(name).unwrap();
            let values =
                rows.iter().map(|(_, seen)| column.of_outputs(seen).unwrap() + rms * random.normal()).collect();
            recording.set(column, values).unwrap();
        }
    }
    [0, 1].map(|wire| {
        let path = rig.file(&format!("run-{wire}.csv"));
        sinew_recording::write(&path, &run[wire].1).unwrap();
        path
    })
}

#[test]
fn a_whole_rig_has_an_answer_for_every_wire_and_one_for_what_they_share() {
    let wires = |more: &str| {
        ["left", "right"].map(|name| format!("{}{more}\n", RIG.replace("\"wire\"", &format!("{name:?}")))).concat()
    };
    let rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = 50.0\n{}", wires("")));
    let sag = "effects.\"electrical.supply_sag\" = { source_ohm = 0.3, supply = \"bench\" }";
    let recordings = two_wires(&rig, &format!("[rig]\nname = \"truth\"\nrate_hz = 50.0\n{}", wires(sag)));
    let [left, right] = ["left", "right"];
    let of = |name: &str, path: &Path| PathBuf::from(format!("{name}={}", path.display()));
    let (rig_file, out) = (rig.path(), rig.file("answer"));
    let diagnose = |first: PathBuf| {
        let words = ["diagnose", "--whole-rig", "--json", "--out"].map(PathBuf::from);
        run(words.into_iter().chain([out.clone(), rig_file.clone(), first, of(right, &recordings[1])]))
    };
    let refused = diagnose(recordings[0].clone()).expect(2);
    assert!(refused.stderr.contains("CHANNEL=FILE") && !out.exists(), "{}", refused.stderr);

    let answer: serde_json::Value = serde_json::from_str(&diagnose(of(left, &recordings[0])).expect(0).stdout).unwrap();
    assert_eq!(answer["schema"], "sinew.diagnosis.rig/1");
    assert_eq!(answer["shared"][0]["id"], "shared.supply_resistance", "{}", answer["summary"]);
    for name in [left, right] {
        assert_eq!(answer["channels"][name]["effects"], serde_json::json!([]), "{}", answer["summary"]);
        assert!(out.join(name).join("report.html").is_file());
    }
    let improved = sinew_rig::Rig::load(&out.join("improved.toml")).unwrap();
    assert_eq!(improved.at_supply_of(0).collect::<Vec<_>>(), [1]);
    let found = improved.channels[0].model.effects.electrical.supply_sag.source_ohm;
    assert!((found - 0.3).abs() < 0.01, "{found}");
    assert!(fs::read_to_string(out.join("report.html")).unwrap().contains("left/report.html"));
}
