//! The death of every thread, one by one, by a panic and by an end nobody asked for: outputs zero and an exit code where a driver must not
//! go on, a published lack where it may. Never a driver that looks healthy and is deaf.
//!
//! Which thread is to die, and how, is said by a file that programs with debug assertions look into; others do not know it, and then
//! these tests say so and are skipped. What the front-end says of its outputs and the true temperature of its wires count.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde_json::Value;
use sinew_ipc::{Client, Fault, Mode};
use sinew_tests::{Driver, Finished, Process, Rig, recorded_so_far, run, sinew, wait_for, wait_until};
use sinew_threads::{Comes, STRIKE_FILE, Thread};

use crate::{front_end, linux};

const LONG: Duration = Duration::from_secs(120);
/// The ways a thread dies.
pub const WAYS: [&str; 2] = ["panic", "end"];
/// Threads whose death the tests here cause.
pub const STRUCK: [Thread; 17] = [
    Thread::Main,
    Thread::Loop,
    Thread::Publisher,
    Thread::Desk,
    Thread::Signals,
    Thread::Words,
    Thread::Janitor,
    Thread::BlackBox,
    Thread::Line,
    Thread::Mender,
    Thread::Recorder,
    Thread::Writer,
    Thread::Watcher,
    Thread::Reader,
    Thread::Herald,
    Thread::Account,
    Thread::Feeder,
];

/// Whether the programs under test let threads be struck; says so where they do not.
pub fn can_strike() -> bool {
    let can = cfg!(debug_assertions) && std::env::var_os("SINEW_BINARY").is_none();
    if !can {
        eprintln!("skipped: these programs were built without debug assertions, and their threads cannot be struck");
    }
    can
}

/// The file by which the threads of a program are struck.
pub struct Strike(PathBuf);

impl Strike {
    /// For a program that is to be started.
    pub fn of(rig: &Rig, command: &mut Command) -> Strike {
        Strike::by(rig.file("strike"), command)
    }

    /// The same, by a file at this place.
    pub fn by(path: PathBuf, command: &mut Command) -> Strike {
        let _ = fs::remove_file(&path);
        command.env(STRIKE_FILE, &path);
        Strike(path)
    }

    /// Strikes.
    pub fn strike(&self, thread: Thread, how: &str) {
        // Whole or not at all: it is looked at all the time.
        let part = self.0.with_extension("part");
        fs::write(&part, format!("{} {how}\n", thread.row().name)).expect("the folder is writable");
        fs::rename(&part, &self.0).expect("the folder is writable");
    }
}

/// A driver whose threads may be struck.
fn driver(rig: &Rig, more: &[&str]) -> (Process, Strike, PathBuf) {
    let report = rig.file("report.json");
    let mut command = rig.command(&["--for", "300"]);
    // Somebody to tell how the driver does, where that is asked for; nobody listens there.
    command.env("NOTIFY_SOCKET", rig.file("manager"));
    command.args(more).arg("--report").arg(&report);
    let strike = Strike::of(rig, &mut command);
    let process = Process::start(&mut command);
    is_there(rig);
    (process, strike, report)
}

/// Waits until a driver of the rig runs.
pub fn is_there(rig: &Rig) {
    wait_until("the driver", || Client::connect(&rig.name).is_ok_and(|client| client.latest().cycle > 0));
}

fn read(report: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(report).expect("a report")).expect("JSON")
}

fn names(value: &Value) -> Vec<&str> {
    value.as_array().expect("a list").iter().filter_map(Value::as_str).collect()
}

/// The last true temperature of the first wire, °C, and the time of it, s.
fn truth(file: &Path) -> Option<(f64, f64)> {
    let text = fs::read_to_string(file).ok()?;
    // The last line may be half written.
    let line = text.lines().rev().nth(1)?;
    let mut cells = line.split(',').map(|cell| cell.parse::<f64>());
    Some((cells.next()?.ok()?, cells.next()?.ok()?))
}

/// Strikes a thread of a driver that heats a wire behind a front-end, which outlives it; how it ended and its report.
fn ends(thread: Thread, how: &str) -> (Finished, Value) {
    assert_eq!(thread.row().comes, Comes::End);
    let rig = front_end::bench(&["left"]);
    let csv = rig.file("truth.csv");
    let front_end = front_end::FrontEnd::start(&rig, &["--truth", csv.to_str().expect("a plain path")]);
    let (driver, strike, report) = driver(&rig, &[]);
    let client = rig.client();
    front_end::drive(&client, "left");
    wait_until("a warm wire", || truth(&csv).is_some_and(|(_, hot_c)| hot_c > 45.0));
    strike.strike(thread, how);
    let finished = driver.finish();
    front_end.is_told_off();
    // By the driver, not by its own watchdog.
    let off = front_end.events().into_iter().rfind(|event| event["event"] == "off").expect("it is off");
    assert_ne!(off["why"], "watchdog", "{off}");
    let (from_s, hot_c) = truth(&csv).expect("a truth");
    let cooled = wait_for("time after the end", || truth(&csv).filter(|(at_s, _)| *at_s > from_s + 0.5));
    assert!(cooled.1 < hot_c - 1.0, "{hot_c} °C, and {} °C later", cooled.1);
    assert_eq!(client.health(), sinew_ipc::DriverHealth::Stopped);
    let report = read(&report);
    assert_eq!(report["outputs_confirmed_zero"], true, "{report:#}");
    (finished, report)
}

#[track_caller]
fn ends_with_words(thread: Thread) {
    if !can_strike() {
        return;
    }
    for how in WAYS {
        let (finished, report) = ends(thread, how);
        let finished = finished.expect(1);
        let does = thread.row().does;
        assert!(finished.stderr.contains(&format!("error: the thread that {does} has died")), "{how}: {finished:?}");
        assert_eq!(report["ended"], "panicked", "{how}: {report:#}");
        assert_eq!(names(&report["threads_died"]), [thread.row().name], "{how}");
    }
}

#[test]
fn a_driver_ends_with_its_loop() {
    ends_with_words(Thread::Loop);
}

#[test]
fn a_driver_ends_with_its_publisher() {
    ends_with_words(Thread::Publisher);
}

#[test]
fn a_driver_ends_with_its_desk() {
    ends_with_words(Thread::Desk);
}

#[test]
fn a_driver_ends_when_it_could_hear_no_signal_any_more() {
    ends_with_words(Thread::Signals);
}

#[test]
fn a_driver_ends_when_its_service_manager_would_hear_nothing_any_more() {
    ends_with_words(Thread::Herald);
}

#[test]
fn a_driver_ends_with_what_shows_it() {
    if !can_strike() {
        return;
    }
    let (finished, report) = ends(Thread::Main, "panic");
    assert_eq!((finished.code, report["ended"].as_str()), (Some(1), Some("panicked")), "{finished:?}");
    assert_eq!(names(&report["threads_died"]), ["main"]);
    // That it ends is the end of a run.
    let (finished, report) = ends(Thread::Main, "end");
    assert_eq!((finished.code, report["ended"].as_str()), (Some(0), Some("stopped")), "{finished:?}");
}

/// Waits until the death of a thread is published, in every way it can be seen, and the driver goes on.
fn is_published(rig: &Rig, client: &Client, thread: Thread) {
    let row = thread.row();
    assert_eq!(row.comes, Comes::Less);
    wait_until("the death to be published", || client.loop_stats().dead_threads().any(|dead| dead.thread == thread));
    let status = rig.ask(&["status", "--json"]).expect(0).json();
    assert_eq!(names(&status["threads_died"]), [row.name]);
    let status = rig.ask(&["status"]).expect(0).stdout;
    assert!(status.contains(row.words), "{status}");
    let line = rig.ask(&["monitor", "--for", "1.5"]).expect(0).stdout;
    assert!(line.contains(&format!("threads died: {}", row.name)), "{line}");
    let cycle = client.latest().cycle;
    wait_until("the loop to go on", || client.latest().cycle > cycle + 20);
}

/// A driver of a simulated wire at work.
fn at_work(rig: &Rig) -> Client {
    let client = rig.client();
    wait_until("sensors", || client.latest().channels().iter().all(|channel| channel.mode() == Mode::Off));
    client.set_duty("wire", 0.1, LONG).expect("it may be powered");
    client
}

/// Ends it in order; its report and what it has said.
fn ended_in_order(driver: Process, report: &Path, thread: Thread) -> (Value, Finished) {
    driver.signal(libc::SIGTERM);
    let finished = driver.finish().expect(0);
    let report = read(report);
    assert_eq!((&report["ended"], names(&report["threads_died"])), (&Value::from("stopped"), vec![thread.row().name]));
    (report, finished)
}

/// A driver that this thread is taken from goes on, publishes that, and says these words in the end.
fn goes_on_without(thread: Thread, words: &str) {
    if !can_strike() {
        return;
    }
    for how in WAYS {
        let rig = Rig::bench(&["wire"], "");
        let (driver, strike, report) = driver(&rig, &[]);
        let client = at_work(&rig);
        strike.strike(thread, how);
        is_published(&rig, &client, thread);
        client.set_duty("wire", 0.05, LONG).expect("it takes commands");
        let (_, finished) = ended_in_order(driver, &report, thread);
        assert!(finished.stderr.contains(words), "{finished:?}");
    }
}

#[test]
fn a_driver_whose_janitor_has_died_says_so_and_goes_on() {
    goes_on_without(Thread::Janitor, "the thread that clears away what dead clients leave has died");
}

#[test]
fn a_driver_whose_black_box_has_died_says_so_and_goes_on() {
    if !can_strike() {
        return;
    }
    for how in WAYS {
        let more = "\n[[simulation.fault]]\nchannel = \"wire\"\nkind = \"open_wire\"\nstart_s = 5.0\n\n[black_box]\nafter_s = 0.1\n";
        let rig = Rig::bench(&["wire"], more);
        let (driver, strike, report) = driver(&rig, &[]);
        let client = at_work(&rig);
        strike.strike(Thread::BlackBox, how);
        is_published(&rig, &client, Thread::BlackBox);
        wait_until("a fault", || client.latest().channels()[0].fault() == Some(Fault::OpenWire));
        let (report, _) = ended_in_order(driver, &report, Thread::BlackBox);
        assert_eq!(report["black_boxes"].as_array().map(Vec::len), Some(0), "{report:#}");
        let error = report["black_box_error"].as_str().expect("an error");
        assert!(error.contains("has died"), "{error}");
    }
}

#[test]
fn a_driver_whose_accounts_are_not_written_any_more_says_so_and_goes_on() {
    goes_on_without(Thread::Account, "nothing was added to them");
}

#[test]
fn a_driver_whose_words_have_died_is_seen_by_others_and_ends_in_order() {
    if !can_strike() {
        return;
    }
    for how in WAYS {
        let rig = Rig::bench(&["wire"], "");
        let (driver, strike, report) = driver(&rig, &[]);
        let client = at_work(&rig);
        strike.strike(Thread::Words, how);
        is_published(&rig, &client, Thread::Words);
        ended_in_order(driver, &report, Thread::Words);
    }
}

#[test]
fn a_driver_that_opens_no_lost_line_any_more_says_so_and_leaves_its_wires_off() {
    if !can_strike() {
        return;
    }
    for how in WAYS {
        let rig = front_end::bench(&["left"]);
        let front_end = front_end::FrontEnd::start(&rig, &[]);
        let (driver, strike, report) = driver(&rig, &[]);
        let client = rig.client();
        front_end::drive(&client, "left");
        strike.strike(Thread::Line, how);
        is_published(&rig, &client, Thread::Line);
        // a fault that a busy machine has latched meanwhile would hide the one that is waited for
        front_end::drive(&client, "left");
        front_end.0.kill();
        wait_until("the fault", || client.latest().channels()[0].fault() == Some(Fault::Backend));
        let front_end = front_end::FrontEnd::start(&rig, &[]);
        // Long enough for a line that is looked for ten times a second.
        std::thread::sleep(Duration::from_millis(500));
        assert!(client.reset("left").is_err(), "nobody has opened the line");
        assert!(front_end.events().iter().all(|event| event["event"] != "running"));
        driver.signal(libc::SIGTERM);
        let finished = driver.finish();
        assert!(finished.stderr.contains("the thread that opens a lost line again has died"), "{finished:?}");
        assert_eq!(names(&read(&report)["threads_died"]), ["line"]);
    }
}

#[test]
fn a_driver_that_mends_nothing_any_more_says_so_and_goes_on() {
    if !can_strike() {
        return;
    }
    for how in WAYS {
        let rig = linux::bench(linux::RATE_HZ);
        let Some(_tree) = linux::tree(&rig, 1.0) else { return };
        let (driver, strike, report) = driver(&rig, &[]);
        let client = rig.client();
        linux::drive(&rig, &client);
        strike.strike(Thread::Mender, how);
        is_published(&rig, &client, Thread::Mender);
        assert!(linux::put_out(&rig) > 0, "the wire is driven still");
        ended_in_order(driver, &report, Thread::Mender);
        assert_eq!(linux::put_out(&rig), 0);
    }
}

/// Strikes a thread of `sinew record`; how it ended, and the file.
fn recorder_ends(rig: &Rig, thread: Thread, how: &str) -> (Finished, PathBuf) {
    let file = rig.file(&format!("{}-{how}.mcap", thread.row().name));
    let mut command = Command::new(sinew());
    command.arg("record").arg(&file).args(["--rig", &rig.name]);
    let strike = Strike::of(rig, &mut command);
    let recorder = Process::start(&mut command);
    wait_until("a chunk of the recording", || !recorded_so_far(&file).is_empty());
    strike.strike(thread, how);
    (recorder.finish().expect(1), file)
}

#[test]
fn a_recording_ends_with_either_of_its_threads_and_the_driver_does_not_notice() {
    if !can_strike() {
        return;
    }
    let rig = Rig::bench(&["wire"], "");
    let driver = Driver::start(&rig);
    let client = at_work(&rig);
    for how in WAYS {
        let (finished, file) = recorder_ends(&rig, Thread::Recorder, how);
        let words = "error: the thread that takes the cycles of a recording from the driver has died";
        assert!(finished.stderr.contains(words), "{finished:?}");
        run(["recording".as_ref(), "doctor".as_ref(), file.as_os_str()]).expect(0);

        let (finished, file) = recorder_ends(&rig, Thread::Writer, how);
        assert!(
            finished.stderr.contains("error: the thread that writes the cycles of a recording has died"),
            "{finished:?}"
        );
        assert!(finished.stderr.contains("sinew recording recover"), "{finished:?}");
        run(["recording".as_ref(), "recover".as_ref(), file.as_os_str()]).expect(0);
    }
    assert_eq!(client.latest().channels()[0].duty, 0.1);
    driver.stop();
}

#[test]
fn a_scope_and_a_bridge_end_with_what_watches_the_driver() {
    if !can_strike() {
        return;
    }
    let rig = Rig::bench(&["wire"], "");
    let driver = Driver::start(&rig);
    let watching = [&["scope"][..], &["bridge", "foxglove", "--listen", "127.0.0.1:0"]];
    for (how, what) in WAYS.into_iter().flat_map(|how| watching.map(|what| (how, what))) {
        let mut command = Command::new(sinew());
        command.args(what).args(["--rig", &rig.name]);
        let strike = Strike::of(&rig, &mut command);
        let mut scope = Process::start(&mut command);
        scope.wait_for_word("://");
        strike.strike(Thread::Watcher, how);
        let finished = scope.finish().expect(1);
        assert!(
            finished.stderr.contains("error: the thread that watches the driver for those who look on has died"),
            "{finished:?}"
        );
    }
    driver.stop();
}

#[test]
fn a_replay_whose_reader_dies_is_no_replay_of_a_shorter_recording() {
    if !can_strike() {
        return;
    }
    let rig = Rig::bench(&["wire"], "");
    let driver = Driver::start(&rig);
    let file = rig.file("whole.mcap");
    run(["record".as_ref(), file.as_os_str(), "--rig".as_ref(), rig.name.as_ref(), "--for".as_ref(), "2".as_ref()])
        .expect(0);
    driver.stop();
    for how in WAYS {
        let mut command = Command::new(sinew());
        command.arg("replay").arg(&file);
        let strike = Strike::of(&rig, &mut command);
        strike.strike(Thread::Reader, how);
        let finished = Process::start(&mut command).finish().expect(1);
        assert!(finished.stderr.contains("error: the thread that reads a recording ahead has died"), "{finished:?}");
    }
}
