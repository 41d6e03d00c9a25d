//! The black box of a running driver: what happened before a fault is in a file that every tool reads; and where there can be
//! none, the driver goes on.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sinew_ipc::{ChannelState, Fault};
use sinew_recording::session::{Ended, FAULT, NOTE, Session};
use sinew_tests::{Driver, Process, Rig, entries, run, wait_for, wait_until};

/// Short, so that the test is.
const BLACK_BOX: &str = "\n[black_box]\nbefore_s = 2.0\nafter_s = 0.5\n";

fn breaks(channel: &str, kind: &str, start_s: f64) -> String {
    format!(
        "\n[[simulation.fault]]\nchannel = \"{channel}\"\nkind = \"{kind}\"\nstart_s = {start_s:?}\nend_s = 1000.0\n"
    )
}

fn boxes(folder: &Path) -> Vec<PathBuf> {
    let names = if folder.is_dir() { entries(folder) } else { Vec::new() };
    names.into_iter().filter(|name| !name.starts_with('.')).map(|name| folder.join(name)).collect()
}

#[test]
fn a_fault_leaves_a_recording_of_the_time_before_it() {
    let rig = Rig::bench(
        &["left", "right", "whole"],
        &[BLACK_BOX, &breaks("right", "open_wire", 8.0), &breaks("left", "probe_lost", 8.1)].concat(),
    );
    let (driver, client) = Driver::ready(&rig);
    // What the driver published: number and time of each cycle, and how many periods were missed before it.
    let mut stream = client.stream().unwrap();
    let mut published = Vec::new();
    let folder = rig.file("black-box");
    let mut read_on = || {
        while let Some(cycle) = stream.next().unwrap() {
            published.push((cycle.header.cycle, cycle.header.monotonic_ns, cycle.header.missed));
        }
        published.last().map_or(0, |(_, ns, _)| *ns)
    };
    let file = wait_for("the black box", || {
        read_on();
        boxes(&folder).pop()
    });
    // It may be quicker than the stream: what is in it was published before now.
    let found_ns = sinew_ipc::monotonic_ns();
    wait_until("the cycles of until now", || read_on() >= found_ns);
    assert_eq!(stream.lost(), 0);

    let name = file.file_name().unwrap().to_string_lossy().into_owned();
    assert!(name.starts_with(&rig.name) && name.ends_with("-right-open_wire.mcap"), "{name}");
    run(["recording".as_ref(), "doctor".as_ref(), file.as_os_str()]).expect(0);

    let session = Session::open(&file).unwrap_or_else(|e| panic!("{e}"));
    let about = session.about();
    assert_eq!((about.rig.as_str(), about.kind.as_str(), about.simulated), (rig.name.as_str(), "driver", true));
    assert_eq!(about.rig_toml.as_deref(), Some(fs::read_to_string(rig.path()).unwrap().as_str()));
    assert!(about.extra["black_box"].starts_with("right: open_wire: "), "{:?}", about.extra);
    assert_eq!(about.extra["faults"], "2");

    // Every period of two seconds before and half a second after, the fault in its place.
    let fault_cycle: u64 = about.extra["fault_cycle"].parse().unwrap();
    let right = session.layout().channel("right").unwrap();
    let mut cycles = session.cycles();
    let mut kept = Vec::new();
    let mut fault_s = None;
    while let Some(cycle) = cycles.next().unwrap_or_else(|e| panic!("{e}")) {
        let state = &cycle.bytes()[right * size_of::<ChannelState>()..][..size_of::<ChannelState>()];
        let fault = u32::from_le_bytes(*state[std::mem::offset_of!(ChannelState, fault)..].first_chunk().unwrap());
        assert_eq!(fault == Fault::OpenWire.code(), cycle.head.cycle >= fault_cycle, "cycle {}", cycle.head.cycle);
        if cycle.head.cycle == fault_cycle {
            fault_s = Some(session.time_s(&cycle.head));
        }
        kept.push((cycle.head.cycle, cycle.head.monotonic_ns, cycle.head.missed));
    }
    // All that were published from two seconds before the fault to half a second after it: no cycle is missing, none is too many.
    let fault_ns = kept.iter().find(|(cycle, ..)| *cycle == fault_cycle).expect("the fault is among them").1;
    let is_due = |ns: u64| ns + 2_000_000_000 >= fault_ns && ns <= fault_ns + 500_000_000;
    let due: Vec<_> = published.into_iter().filter(|(_, ns, _)| is_due(*ns)).collect();
    assert_eq!(kept, due);
    let count = kept.len() as u64;
    assert_eq!(kept[kept.len() - 1].0 - kept[0].0 + 1, count, "no cycle is missing");
    let before_s = fault_s.expect("the fault is among them");
    assert!(before_s > 1.5 && before_s <= 2.0, "{before_s} s before the fault");
    let ending = session.ending().unwrap();
    assert_eq!((ending.ended, ending.lost, ending.cycles), (Some(Ended::Complete), 0, count));

    let events = session.events().unwrap();
    let of = |kind: &str, channel: &str| events.iter().find(|event| event.kind == kind && event.channel == channel);
    assert_eq!(of(FAULT, "right").unwrap().cycle, fault_cycle, "{events:#?}");
    assert!(of(FAULT, "left").unwrap().cycle > fault_cycle, "{events:#?}");
    let note = of(NOTE, "").unwrap();
    assert!(note.cycle == fault_cycle && note.text.contains("first cause right: open_wire"), "{note:?}");

    // A recording like any other.
    let info = run(["recording".as_ref(), "info".as_ref(), file.as_os_str(), "--json".as_ref()]).expect(0).json();
    assert_eq!(info["cycles"].as_u64(), Some(count), "{info:#}");
    run(["replay".as_ref(), file.as_os_str()]).expect(0);

    let report = driver.stop();
    assert_eq!(report["black_boxes"], Value::from(vec![file.to_string_lossy()]), "{report:#}");
    assert_eq!(boxes(&folder), [file], "one file for both faults, and no half one beside it");
    let order = entries(&folder).into_iter().filter(|name| name.ends_with(".order"));
    assert_eq!((entries(&folder).len(), order.count()), (2, 1), "and the order in which they were written");
}

#[test]
fn a_driver_that_ends_writes_what_there_is_and_says_so() {
    let rig = Rig::bench(&["wire"], &["\n[black_box]\nafter_s = 60.0\n", &breaks("wire", "open_wire", 1.0)].concat());
    let (driver, client) = Driver::ready(&rig);
    wait_until("the fault", || client.latest().channels()[0].fault().is_some());
    assert_eq!(boxes(&rig.file("black-box")), [] as [PathBuf; 0], "a minute has not passed");
    let report = driver.stop();
    let files = boxes(&rig.file("black-box"));
    assert_eq!(report["black_boxes"].as_array().map(Vec::len), Some(1), "{report:#}");
    let session = Session::open(&files[0]).unwrap();
    assert_eq!(session.ending().unwrap().ended, Some(Ended::DriverStopped));
    let note = session.events().unwrap().into_iter().find(|event| event.kind == NOTE).unwrap();
    assert!(note.text.contains("were at hand, not 10 s"), "{note:?}");
}

#[test]
fn without_a_place_to_write_there_is_a_warning_and_the_driver_goes_on() {
    let rig = Rig::bench(&["wire", "whole"], &[BLACK_BOX, &breaks("wire", "open_wire", 1.0)].concat());
    fs::write(rig.file("taken"), "").unwrap();
    let report = rig.file("report.json");
    let mut command = rig.command(&["--for", "3", "--report"]);
    let done = Process::start(command.arg(&report).env("SINEW_STATE_DIR", rig.file("taken"))).finish().expect(0);
    assert_eq!(done.stderr.matches("no black box of wire: open_wire").count(), 1, "{}", done.stderr);
    assert!(done.stderr.contains("set SINEW_STATE_DIR to another folder"), "{}", done.stderr);
    let report: Value = serde_json::from_str(&fs::read_to_string(&report).unwrap()).unwrap();
    assert_eq!(report["black_boxes"].as_array().map(Vec::len), Some(0), "{report:#}");
    assert!(report["black_box_error"].is_string() && report["cycles"].as_u64() > Some(100), "{report:#}");
    sinew_tests::check_report(&report);

    let rig = Rig::bench(&["wire"], &["\n[black_box]\nenabled = false\n", &breaks("wire", "open_wire", 0.5)].concat());
    let done = Process::start(&mut rig.command(&["--for", "2"])).finish().expect(0);
    assert!(!done.stderr.contains("black box") && !rig.file("black-box").exists(), "{}", done.stderr);
}
