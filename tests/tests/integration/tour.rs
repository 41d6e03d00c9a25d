//! `sinew tour`: everything it shows is real, and nothing is left of it.

use std::fs;
use std::path::Path;
use std::process::Command;

use sinew_tests::{Process, entries, run, sinew};

/// The tour, with its folder for temporary files where it can be looked into.
fn tour(temporary: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(sinew());
    command.args(["tour", "--seed", "7"]).args(more).env("TMPDIR", temporary);
    command
}

/// Processes that were started for a tour with this folder.
fn started_in(temporary: &Path) -> Vec<String> {
    let there = temporary.to_str().expect("a temporary folder's name");
    let processes = fs::read_dir("/proc").expect("processes").flatten();
    let of = |name: &str| fs::read(Path::new("/proc").join(name).join("environ")).unwrap_or_default();
    processes
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| name.bytes().all(|b| b.is_ascii_digit()))
        .filter(|name| String::from_utf8_lossy(&of(name)).contains(&format!("TMPDIR={there}\0")))
        .collect()
}

#[test]
fn it_shows_a_wire_and_a_diagnosis_and_leaves_nothing() {
    let here = tempfile::tempdir().expect("a temporary folder");
    let temporary = tempfile::tempdir().expect("another one");
    let kept = here.path().join("kept");
    let keep = ["--keep", kept.to_str().expect("a temporary folder's name")];
    let seen = Process::start(&mut tour(temporary.path(), &keep)).finish().expect(0);
    let mut rest = seen.stdout.as_str();
    let shown = [
        "1 · A wire moves",
        "$ sinew run tour/tour.toml",
        "$ sinew status",
        "wire    length",
        "2 · A program dies",
        "wire    program",
        "outputs at zero",
        "faults    none",
        "3 · Physics is missing",
        "$ sinew conceal riddle",
        "$ sinew diagnose riddle/rig.toml riddle/recording.csv",
        "remains",
        "$ sinew reveal riddle",
        "Hidden: ",
        "Found:  ",
    ];
    for word in shown {
        let at = rest.find(word).unwrap_or_else(|| panic!("{word}, in this order: {seen:#?}"));
        rest = &rest[at + word.len()..];
    }
    assert_eq!(entries(temporary.path()), [] as [&str; 0]);
    assert_eq!(started_in(temporary.path()), [] as [&str; 0]);
    assert_eq!(entries(&kept.join("riddle")), ["answer", "answer.sealed", "recording.csv", "rig.toml"]);
    // before the work, not after it
    run(["tour", keep[0], keep[1]]).refused(&["kept", "is there already", "--keep"]);
}

#[test]
fn who_ends_it_half_way_finds_no_driver_and_no_file() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let mut process = Process::start(&mut tour(temporary.path(), &[]));
    process.wait_for_word("stroke=80%");
    assert!(started_in(temporary.path()).len() > 1, "its driver runs");
    process.signal(libc::SIGINT);
    let ended = process.finish().expect(0);
    assert!(ended.stdout.contains("leaves nothing behind"), "{ended:#?}");
    assert_eq!(entries(temporary.path()), [] as [&str; 0]);
    assert_eq!(started_in(temporary.path()), [] as [&str; 0]);
}
