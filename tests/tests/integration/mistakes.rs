//! Mistakes that people make at first, each made here as they make it, and what they are told: the place, what is wrong, what to do.
//!
//! The texts stand in `mistakes.txt`, to be read by people; `SINEW_BLESS=1 cargo test -p sinew-tests --test integration mistakes::` writes them anew.
//! A text that changed is read again before it is blessed.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use sinew_tests::{Process, checkout, sinew, wait_until};

/// What it is, the files it takes besides [`FILES`], and the command. `{}` in a name of the rig is this test's own.
struct Mistake {
    what: &'static str,
    files: &'static [(&'static str, &'static str)],
    words: &'static [&'static str],
    /// Whether a driver of the rig file runs meanwhile.
    beside_a_driver: bool,
}

const fn plain(what: &'static str, words: &'static [&'static str]) -> Mistake {
    Mistake { what, files: &[], words, beside_a_driver: false }
}

const fn with(
    what: &'static str,
    file: &'static [(&'static str, &'static str)],
    words: &'static [&'static str],
) -> Mistake {
    Mistake { what, files: file, words, beside_a_driver: false }
}

/// A mistake that only a driver that runs can find.
const fn beside_a_driver(mistake: Mistake) -> Mistake {
    Mistake { beside_a_driver: true, ..mistake }
}

/// What lies beside every mistake: a rig file, and a short recording.
const FILES: [(&str, &str); 2] = [("bench.toml", BENCH), ("run.csv", ROWS)];

const ROWS: &str = "time_s,duty,position_m\n0.00,0.1,0.160\n0.01,0.1,0.160\n0.02,0.1,0.160\n0.03,0.1,0.160\n";

const BENCH: &str = "\
[rig]
name = \"mistakes\"
rate_hz = 200

[[channel]]
name = \"left\"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
taps = { l0_mm = 10.0, ls_mm = 140.0 }
drive = { supply_v = 6.0, shunt_ohm = 0.1, switch_ohm = 0.02 }
load = { mass_kg = 0.13, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.6 }
";

/// The rig file with one line more, or another one.
macro_rules! bench {
    ($($text:tt)*) => {
        concat!("[rig]\nname = \"mistakes\"\nrate_hz = 200\n", $($text)*)
    };
}

/// A channel that is right but for what is given.
macro_rules! channel {
    ($text:literal) => {
        concat!("[[channel]]\nname = \"left\"\n", $text, "\ndrive = { supply_v = 6.0 }\nload = { mass_kg = 0.13 }\n")
    };
}

const MISTAKES: &[Mistake] = &[
    // Words
    plain("a command that there is none of", &["rnu"]),
    plain("an option that there is none of", &["run", "--duration", "5"]),
    plain("an option without its value", &["run", "bench.toml", "--report"]),
    plain("a rig file that is not there", &["run", "bnech.toml"]),
    plain("a folder in place of a rig file", &["check", "."]),
    plain("a recording in place of a rig file", &["check", "run.csv"]),
    plain("rig file and recording the wrong way round", &["simulate", "run.csv", "bench.toml", "-o", "out.csv"]),
    plain("no driver is running", &["status"]),
    plain("set without a driver", &["set", "left", "stroke=40%"]),
    plain("monitor without a driver", &["monitor"]),
    plain("record without a driver", &["record", "walk.mcap", "--for", "1"]),
    plain("stop without a driver", &["stop"]),
    plain("a driver by a name that none has", &["status", "--rig", "hexapdo"]),
    plain("a setpoint without its unit", &["set", "left", "stroke=40"]),
    plain("a setpoint in words", &["set", "left", "up"]),
    plain("a channel without a setpoint", &["set", "left"]),
    plain("a setpoint beyond the stroke", &["set", "left", "stroke=140%"]),
    beside_a_driver(plain("a way beyond the stroke", &["set", "left", "stroke=12mm"])),
    beside_a_driver(plain("a length that the wire does not have", &["set", "left", "length=150mm"])),
    beside_a_driver(with(
        "a way beyond the stroke, later in a file",
        &[("gait.csv", "time_s,left\n0,40%\n2,stroke=12mm\n")],
        &["play", "gait.csv"],
    )),
    with("play without a driver", &[("gait.csv", "time_s,left\n0,40%\n")], &["play", "gait.csv"]),
    // Rig files
    with(
        "a key with a typing error",
        &[("bench.toml", bench!("rate_hertz = 500\n", channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }")))],
        &["check", "bench.toml"],
    ),
    with(
        "a key without its unit",
        &[("bench.toml", bench!(channel!("wire = { diameter = 0.125, length_mm = 160.0 }")))],
        &["check", "bench.toml"],
    ),
    with(
        "metres for millimetres",
        &[("bench.toml", bench!(channel!("wire = { diameter_mm = 0.125, length_mm = 0.16 }")))],
        &["check", "bench.toml"],
    ),
    with(
        "a diameter in micrometres",
        &[("bench.toml", bench!(channel!("wire = { diameter_mm = 125, length_mm = 160.0 }")))],
        &["check", "bench.toml"],
    ),
    with(
        "a decimal comma",
        &[("bench.toml", bench!(channel!("wire = { diameter_mm = 0,125, length_mm = 160.0 }")))],
        &["check", "bench.toml"],
    ),
    with(
        "a text for a number",
        &[("bench.toml", bench!(channel!("wire = { diameter_mm = \"0.125\", length_mm = 160.0 }")))],
        &["check", "bench.toml"],
    ),
    with(
        "a bracket that is not closed",
        &[("bench.toml", bench!("[[channel]\n", "name = \"left\""))],
        &["check", "bench.toml"],
    ),
    with(
        "two channels of one name",
        &[(
            "bench.toml",
            bench!(
                channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }"),
                channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }")
            ),
        )],
        &["check", "bench.toml"],
    ),
    with("no channel at all", &[("bench.toml", bench!())], &["check", "bench.toml"]),
    with(
        "a wire that no supplier has",
        &[("bench.toml", bench!(channel!("wire = { kind = \"flexinol-150\", length_mm = 160.0 }")))],
        &["check", "bench.toml"],
    ),
    with(
        "taps that lie outside the wire",
        &[(
            "bench.toml",
            bench!(channel!(
                "wire = { diameter_mm = 0.125, length_mm = 160.0 }\ntaps = { l0_mm = 10.0, ls_mm = 200.0 }"
            )),
        )],
        &["check", "bench.toml"],
    ),
    with(
        "a law that there is none of",
        &[(
            "bench.toml",
            bench!(channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }\ncontrol = { algorithm = \"lqr\" }")),
        )],
        &["check", "bench.toml"],
    ),
    with(
        "a backend that there is none of",
        &[(
            "bench.toml",
            bench!("[backend]\nkind = \"arduino\"\n", channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }")),
        )],
        &["run", "bench.toml"],
    ),
    with(
        "a serial port that is not there",
        &[(
            "bench.toml",
            bench!(
                "[backend]\nkind = \"serial\"\nserial.port = \"/dev/ttyACM7\"\n",
                channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }\ntaps = { l0_mm = 10.0, ls_mm = 140.0 }")
            ),
        )],
        &["run", "bench.toml", "--for", "1", "--no-monitor"],
    ),
    with(
        "a rate that no loop has",
        &[(
            "bench.toml",
            "[rig]\nname = \"mistakes\"\nrate_hz = 1000000\n[[channel]]\nname = \"left\"\nwire = { diameter_mm = 0.125, length_mm = 160.0 }\n",
        )],
        &["check", "bench.toml"],
    ),
    with(
        "a program file that is not there",
        &[(
            "bench.toml",
            bench!("program = \"gait.csv\"\n", channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }")),
        )],
        &["run", "bench.toml", "--for", "1", "--no-monitor"],
    ),
    with(
        "a program that is misspelt",
        &[(
            "bench.toml",
            bench!("program = \"wlak\"\n", channel!("wire = { diameter_mm = 0.125, length_mm = 160.0 }")),
        )],
        &["check", "bench.toml"],
    ),
    with("setpoints without a unit", &[("gait.csv", "time_s,left\n0,0.4\n")], &["play", "gait.csv"]),
    // Recordings
    plain("a recording that is not there", &["diagnose", "bench.toml", "monday.csv", "--out", "answer"]),
    plain("a recording that is too short", &["diagnose", "bench.toml", "run.csv", "--out", "answer"]),
    plain("a diagnosis without a place for it", &["diagnose", "bench.toml", "run.csv"]),
    with(
        "a recording with semicolons",
        &[("run.csv", "time_s;duty;position_m\n0.00;0.1;0.160\n0.01;0.1;0.159\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with(
        "a recording with decimal commas",
        &[("run.csv", "time_s;duty;position_m\n0,00;0,1;0,160\n0,01;0,1;0,159\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with(
        "columns of a laboratory's own",
        &[("run.csv", "Time [ms],PWM [%],Position [mm]\n0,10,160\n10,10,159\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with(
        "a unit that is not the column's",
        &[("run.csv", "time_s,duty,position_mm\n0.00,0.1,160\n0.01,0.1,159\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with(
        "a duty in per cent",
        &[("run.csv", "time_s,duty,position_m\n0.00,10,0.160\n0.01,10,0.159\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with(
        "a clock that goes back",
        &[("run.csv", "time_s,duty\n0.00,0.1\n0.02,0.1\n0.01,0.1\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with(
        "a cell that is no number",
        &[("run.csv", "time_s,duty\n0.00,0.1\n0.01,n/a\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with(
        "a row with a cell too few",
        &[("run.csv", "time_s,duty,position_m\n0.00,0.1,0.16\n0.01,0.1\n")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    with("an empty file", &[("run.csv", "")], &["simulate", "bench.toml", "run.csv", "-o", "out.csv"]),
    with(
        "a spreadsheet by another name",
        &[("run.csv", "PK\u{3}\u{4}\u{14}\u{0}\u{6}\u{0}")],
        &["simulate", "bench.toml", "run.csv", "-o", "out.csv"],
    ),
    plain("a recording that is no session", &["replay", "run.csv"]),
    plain("an answer over what goes in", &["simulate", "bench.toml", "run.csv", "-o", "run.csv"]),
    plain("an output in a folder that is not there", &["simulate", "bench.toml", "run.csv", "-o", "results/out.csv"]),
    plain("a picture in a format that there is none of", &["plot", "run.csv", "-o", "run.pdf"]),
    plain(
        "a quantity that is not in the recording",
        &["plot", "run.csv", "-o", "run.svg", "--quantity", "tempreature"],
    ),
    plain(
        "a mapping that is not there",
        &["import", "run.csv", "--rig", "bench.toml", "-o", "out.csv", "--map", "map.toml"],
    ),
    plain("an effect that there is none of", &["conceal", "riddle", "--effect", "mechanical.frictoin"]),
    plain("no bundle", &["repeat", "run.csv"]),
    plain("a force without its unit", &["design", "--force", "2", "--stroke", "5mm"]),
    plain("a routine that there is none of", &["test", "bend", "bench.toml"]),
];

/// What is told of a mistake, made in a folder of its own.
fn told(mistake: &Mistake) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in FILES.iter().chain(mistake.files) {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    let sinew = |words: &[&str]| {
        let mut command = Command::new(sinew());
        command.args(words).current_dir(folder.path()).stdin(Stdio::null());
        // A place of its own for what drivers leave, so that nobody else's driver is found.
        command.env("SINEW_RUNTIME_DIR", folder.path().join("runtime")).env_remove("RUST_LOG");
        command.env("SINEW_STATE_DIR", folder.path().join("state"));
        command
    };
    let _driver = mistake.beside_a_driver.then(|| {
        let driver = Process::start(&mut sinew(&["run", "bench.toml", "--no-monitor", "--for", "300"]));
        let is_off = |said: &str| said.lines().any(|line| line.starts_with("left") && line.contains(" off "));
        wait_until("its wire to be measured", || {
            let status = sinew(&["status"]).output().expect("sinew starts");
            is_off(&String::from_utf8_lossy(&status.stdout))
        });
        driver
    });
    let done = sinew(mistake.words).output().expect("sinew starts");
    let said = String::from_utf8_lossy(&done.stderr).replace(&folder.path().display().to_string(), "DIR");
    let code = done.status.code().unwrap_or(-1);
    assert!(matches!(code, 1 | 2), "{}: exit code {code}: {said}", mistake.what);
    assert!(done.stdout.is_empty(), "{}: on stdout: {}", mistake.what, String::from_utf8_lossy(&done.stdout));
    assert!(!said.contains("panicked"), "{}: {said}", mistake.what);
    format!("exit code {code}\n{said}")
}

#[test]
fn each_is_told_with_its_place_and_remedy() {
    let mut text = String::from(
        "Mistakes that people make at first, and what they are told (tests/tests/integration/mistakes.rs).\n",
    );
    let mut without_remedy = Vec::new();
    for mistake in MISTAKES {
        let told = told(mistake);
        // clap's own words have their remedy in another form
        if !told.contains("\nhint: ") && !told.contains("For more information, try '--help'") {
            without_remedy.push(mistake.what);
        }
        writeln!(text, "\n## {}\n$ sinew {}\n{}", mistake.what, mistake.words.join(" "), told.trim_end())
            .expect("a text");
    }
    let path = checkout().join("tests/tests/integration/mistakes.txt");
    if std::env::var_os("SINEW_BLESS").is_some() {
        fs::write(&path, &text).expect("the list is written");
    }
    let there = fs::read_to_string(Path::new(&path)).unwrap_or_default();
    assert!(without_remedy.is_empty(), "no remedy is told for: {without_remedy:?}");
    for (there, here) in there.split("\n## ").zip(text.split("\n## ")) {
        assert_eq!(there, here, "another text; read it, then run with SINEW_BLESS=1");
    }
    assert_eq!(there, text, "another list; read it, then run with SINEW_BLESS=1");
}

/// What is allowed and hardly meant is no mistake: it is asked about, on its line, and the exit code is 0.
#[test]
fn a_load_and_a_supply_for_another_wire_are_asked_about() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rig = "[rig]\nname = \"mistakes\"\n\n[[channel]]\nname = \"left\"\n\
               wire = { kind = \"flexinol-150-lt\", length_mm = 160.0 }\ndrive = { supply_v = 48.0 }\nload = { mass_kg = 5.0 }\n";
    fs::write(folder.path().join("bench.toml"), rig).expect("a file");
    let checked = |words: &[&str]| {
        let done = Command::new(sinew()).args(words).current_dir(folder.path()).output().expect("sinew starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).expect("text")
    };
    let text = checked(&["check", "bench.toml"]);
    for asked in [
        "Is this meant?",
        "bench.toml:8: channel \"left\": load.mass_kg",
        "bench.toml:7: channel \"left\": drive.supply_v",
    ] {
        assert!(text.contains(asked), "{asked}: {text}");
    }
    let json: serde_json::Value = serde_json::from_str(&checked(&["check", "bench.toml", "--json"])).expect("JSON");
    let keys: Vec<&str> =
        json["doubts"].as_array().expect("a list").iter().filter_map(|doubt| doubt["key"].as_str()).collect();
    assert_eq!(keys, ["load.mass_kg", "drive.supply_v"]);
}
