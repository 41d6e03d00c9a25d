//! The example program against a driver of no wires: it commands every leg, renews its leases, and leaves everything off.

use crate::common::*;
use sinew_ipc::*;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command as Program, Stdio};
use std::sync::{Arc, Mutex};

fn gait() -> PathBuf {
    // Tests are in target/PROFILE/deps, examples in target/PROFILE/examples.
    let path = std::env::current_exe().unwrap().parent().unwrap().with_file_name("examples").join("gait");
    assert!(path.exists(), "build it first: cargo build -p sinew-ipc --example gait");
    path
}

fn names() -> Vec<String> {
    let mut names = Vec::new();
    for place in ["front", "middle", "rear"] {
        for side in ["left", "right"] {
            names.extend(["coxa", "femur", "tibia"].map(|joint| format!("{place}_{side}_{joint}")));
        }
    }
    names
}

type Log = Arc<Mutex<Vec<Command>>>;

/// A hexapod that writes down every command.
fn hexapod(rig: &str) -> (Driver, Log) {
    let log = Log::default();
    let kept = log.clone();
    let driver = Driver::with(&info_of(rig, &names(), 500.0), move |command| {
        kept.lock().unwrap().push(*command);
        decide(command)
    });
    (driver, log)
}

fn assert_walked_and_switched_off(log: &Log) {
    let log = log.lock().unwrap();
    let mut last = BTreeMap::new();
    for command in log.iter() {
        match command.kind().unwrap() {
            CommandKind::Stroke => {
                assert!((0.0..=1.0).contains(&command.value) && command.hold_s >= 0.2, "{command:?}");
            }
            kind => assert_eq!(kind, CommandKind::Off),
        }
        last.insert(command.channel, command.kind().unwrap());
    }
    assert_eq!(last.len(), 18);
    assert!(last.values().all(|kind| *kind == CommandKind::Off));
    assert!(log.iter().filter(|c| c.kind() == Some(CommandKind::Stroke)).count() >= 36);
}

fn start(arguments: &[&str]) -> Child {
    Program::new(gait()).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[test]
fn it_walks_for_as_long_as_it_is_told() {
    let rig = rig("gait");
    let (_driver, log) = hexapod(&rig);
    let out = start(&[&rig, "2.5"]).wait_with_output().unwrap();
    let text = String::from_utf8(out.stdout).unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(
        text.contains("rms error") && text.contains("lost cycles 0") && text.ends_with("all channels off\n"),
        "{text}"
    );
    assert_walked_and_switched_off(&log);
}

#[test]
fn ctrl_c_ends_it_with_every_channel_off() {
    let rig = rig("gaitc");
    let (_driver, log) = hexapod(&rig);
    let mut child = start(&[&rig]);
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().starts_with("walking"));
    until("it commands", || log.lock().unwrap().len() >= 54);
    assert!(Program::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert!(child.wait().unwrap().success());
    assert_eq!(lines.map_while(Result::ok).last().unwrap(), "all channels off");
    assert_walked_and_switched_off(&log);
}

#[test]
fn without_a_driver_or_with_one_that_stops_it_says_so() {
    let rig = rig("gaitn");
    let out = start(&[&rig]).wait_with_output().unwrap();
    assert_eq!(out.status.code(), Some(1));
    let text = String::from_utf8(out.stderr).unwrap();
    assert!(text.contains("no driver for rig") && text.contains("sinew run"), "{text}");

    let (driver, log) = hexapod(&rig);
    let child = start(&[&rig]);
    until("it commands", || log.lock().unwrap().len() >= 18);
    drop(driver);
    let out = child.wait_with_output().unwrap();
    assert_eq!(out.status.code(), Some(1));
    let text = String::from_utf8(out.stderr).unwrap();
    assert!(text.contains("has stopped"), "{text}");
}
