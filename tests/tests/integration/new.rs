//! `sinew new`: what it makes runs as it is, driver and first robot program; what it cannot make is told, and nothing is overwritten.

use sinew_ipc::Mode;
use sinew_tests::{Driver, Process, Rig, built, run, wait_until};
use std::ffi::OsStr;
use std::fs;
use std::process::Command;

use crate::python;

/// A bench made by `sinew new` in a folder beside its rig.
fn made(more: &[&str]) -> Rig {
    Rig::named(|name| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let bench = folder.path().join("bench");
        let words = ["new", name, "-o", bench.to_str().expect("UTF-8")];
        let said = run(words.iter().chain(more)).expect(0);
        assert!(said.stdout.contains("sinew run") && said.stdout.contains(&format!("{name}.toml")), "{}", said.stdout);
        fs::read_to_string(bench.join(format!("{name}.toml"))).expect("a rig file")
    })
}

/// The wires move by themselves, and then where the robot tells them: each answers with a line for every stroke it was told.
fn moves(rig: &Rig, mut robot: Command) {
    let (driver, observer) = Driver::ready(rig);
    let channels: Vec<String> = observer.channels().iter().map(|channel| channel.name.as_str().to_owned()).collect();
    wait_until("the wires to move by themselves", || {
        observer.latest().channels().iter().all(|channel| channel.mode() == Mode::Program && channel.duty > 0.02)
    });
    let said = Process::start(&mut robot).finish().expect(0);
    let told = said.stdout.lines().filter(|line| line.contains("% of")).collect::<Vec<_>>();
    assert_eq!(told.len(), 2 * channels.len(), "{said:?}");
    for channel in &channels {
        let reached = |stroke: &str| {
            let line = told.iter().find(|line| line.starts_with(&format!("{channel}: ")) && line.contains(stroke));
            let line = line.unwrap_or_else(|| panic!("{channel} is not told {stroke}: {said:?}"));
            line.split(": ")
                .nth(1)
                .and_then(|rest| rest.split(" %").next())
                .and_then(|share| share.trim().parse::<f64>().ok())
        };
        // Heated it gets there within its two seconds; how far it has cooled in two more depends on the wire.
        assert!(reached("of 40 %").is_some_and(|share| (share - 40.0).abs() <= 3.0), "{said:?}");
    }
    let report = driver.stop();
    assert_eq!(report["faults"].as_array().map(Vec::len), Some(0), "{report:#}");
    assert_eq!(report["leases_lapsed"], 0, "{report:#}");
}

#[test]
fn the_first_rig_runs_and_its_robot_in_rust_moves_it() {
    let rig =
        made(&["--wire", "flexinol-100-lt", "--length", "6in", "--weight", "80g", "--channels", "biceps,triceps"]);
    let mut robot = Command::new(built("examples/robot"));
    robot.arg(&rig.name);
    moves(&rig, robot);
}

#[test]
fn the_first_robot_in_python_moves_the_first_rig() {
    if !python::has(OsStr::new("python3"), "numpy") {
        return eprintln!("skipped");
    }
    let rig = made(&["--yes"]);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bench = folder.path().join("bench");
    run(["new", &rig.name, "--yes", "-o", bench.to_str().expect("UTF-8")]).expect(0);
    let package = python::installed();
    let mut robot = Command::new("python3");
    robot.arg("robot.py").current_dir(&bench).env("PYTHONDONTWRITEBYTECODE", "1");
    robot.env("PYTHONPATH", python::import_path(&[package.path()]));
    moves(&rig, robot);
}

#[test]
fn what_cannot_be_made_is_told_and_nothing_is_overwritten() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let within = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    fs::create_dir(within("there")).expect("the folder is writable");
    for (words, said) in [
        (vec!["new", "there", "-o", &within("there")], "is there already"),
        (vec!["new", "a b", "-o", &within("a")], "letters, digits"),
        (vec!["new", "arm", "-o", &within("b"), "--wire", "flexinol-15-lt"], "did you mean flexinol-"),
        (vec!["new", "arm", "-o", &within("c"), "--length", "160"], "has no unit: mm, cm, m, in"),
        (vec!["new", "arm", "-o", &within("d"), "--weight", "5V"], "is in \"V\", which is none of N"),
        (vec!["new", "arm", "-o", &within("e"), "--length", "1mm", "--supply", "2000V"], "supply_v"),
        (vec!["new", "arm", "-o", &within("f"), "--channels", "a,a"], "twice"),
        (
            vec!["new", "arm", "-o", &within("g"), "--language", "rust", "--sources", &within("there")],
            "holds no sources",
        ),
    ] {
        run(&words).refused(&[said]);
    }
    let left: Vec<_> = fs::read_dir(folder.path()).expect("ours").collect();
    assert_eq!(left.len(), 1, "nothing is made of what is refused: {left:?}");
    // What a wire is not made for is made, and said.
    let heavy = run(["new", "arm", "-o", &within("h"), "--weight", "1kg", "--yes"]).expect(0);
    assert!(heavy.stderr.contains("its data sheet has"), "{}", heavy.stderr);
}
