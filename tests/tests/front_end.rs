//! Driver and front-end as two processes with a pseudo-terminal between them: what happens to the wires when one of the two,
//! or the line, fails. What the front-end says of its outputs counts, not what the driver believes.
//!
//! Slow periods and long silences: on a busy machine both processes are late by many milliseconds.

use std::time::Duration;

use serde_json::Value;
use sinew_ipc::{Client, Fault, Mode};
use sinew_tests::{Driver, Process, Rig, front_end, wait_until};

const LONG: Duration = Duration::from_secs(120);
const RATE_HZ: f64 = 50.0;
const WATCHDOG_PERIODS: u64 = 10;
const SILENCE_NS: u64 = WATCHDOG_PERIODS * 20_000_000;
const DUTY: f64 = 0.15;

fn bench(names: &[&str]) -> Rig {
    let mut rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = {RATE_HZ:?}\n"));
    for name in names {
        rig.add(&Rig::wire(name));
    }
    let port = rig.file("front-end");
    rig.add(&format!(
        "\n[backend]\nkind = \"serial\"\nserial.port = \"{}\"\nserial.watchdog_periods = {WATCHDOG_PERIODS}\n",
        port.display()
    ));
    rig
}

/// A front-end process for a rig's wires, once its line is there.
struct FrontEnd(Process);

impl FrontEnd {
    fn start(rig: &Rig, more: &[&str]) -> FrontEnd {
        let mut command = std::process::Command::new(front_end());
        command.arg(rig.path()).arg("--link").arg(rig.file("front-end")).args(["--for", "300"]).args(more);
        let mut process = Process::start(&mut command);
        process.wait_for_word("\"event\":\"port\"");
        FrontEnd(process)
    }

    /// What it has told so far; the last line may be half written.
    fn events(&self) -> Vec<Value> {
        self.0.stdout().lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// The events after the first `seen` that switched powered outputs off for silence.
    fn silences(&self, seen: usize) -> Vec<Value> {
        let off = |event: &Value| event["event"] == "off" && event["why"] == "watchdog" && event["powered"] == true;
        self.events().into_iter().skip(seen).filter(off).collect()
    }
}

/// Gets a wire driven, with a reset wherever one is needed: lines are slow on busy machines.
#[track_caller]
fn drive(client: &Client, name: &str) {
    wait_until("the wire to be driven", || {
        let state = client.latest().channels()[0];
        match state.mode() {
            Mode::Duty if state.length_m.is_finite() => return true,
            Mode::Fault => drop(client.reset(name)),
            Mode::Duty | Mode::Waiting => {}
            _ => drop(client.set_duty(name, DUTY, LONG)),
        }
        std::thread::sleep(Duration::from_millis(40));
        false
    });
}

#[test]
fn two_processes_walk() {
    let rig = bench(&["left", "right"]);
    let front_end = FrontEnd::start(&rig, &[]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    drive(&client, "left");
    assert_eq!(client.info().simulated, 0, "the driver does not simulate these wires");
    for stroke in [0.6, 0.3] {
        wait_until("the wire to get where it is told", || {
            let state = client.latest().channels()[0];
            match state.mode() {
                Mode::Fault => drop(client.reset("left")),
                Mode::Waiting => {}
                _ => drop(client.set_stroke("left", stroke, LONG)),
            }
            std::thread::sleep(Duration::from_millis(40));
            (state.length_m - state.target_m).abs() < 0.4e-3
        });
    }
    let stderr = |driver: &Driver| driver.process.stderr();
    assert!(stderr(&driver).contains("sinew-host 0.1.0"), "{}", stderr(&driver));
    driver.stop();
    wait_until("outputs off", || {
        front_end.events().iter().any(|event| event["event"] == "off" && event["why"] == "driver")
    });
}

#[test]
fn a_killed_driver_leaves_no_wire_on_and_the_next_one_needs_no_hand() {
    let rig = bench(&["wire"]);
    let front_end = FrontEnd::start(&rig, &[]);
    for _ in 0..2 {
        let driver = Driver::start(&rig);
        drive(&rig.client(), "wire");
        let seen = front_end.events().len();
        driver.process.kill();
        wait_until("outputs off", || !front_end.silences(seen).is_empty());
        let silent_ns = front_end.silences(seen)[0]["silent_ns"].as_u64().expect("a time");
        assert!(silent_ns >= SILENCE_NS, "not before its time: {silent_ns}");
    }
}

#[test]
fn a_stopped_driver_leaves_no_wire_on_and_finds_it_latched() {
    let rig = bench(&["wire"]);
    let front_end = FrontEnd::start(&rig, &[]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    drive(&client, "wire");
    let seen = front_end.events().len();
    driver.process.signal(libc::SIGSTOP);
    wait_until("outputs off", || !front_end.silences(seen).is_empty());
    driver.process.signal(libc::SIGCONT);
    wait_until("the fault to be latched", || client.latest().channels()[0].fault().is_some());
    drive(&client, "wire");
    driver.stop();
}

#[test]
fn a_front_end_that_is_gone_is_a_fault_and_comes_back_without_a_new_driver() {
    let rig = bench(&["wire"]);
    let front_end = FrontEnd::start(&rig, &[]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    drive(&client, "wire");
    front_end.0.kill();
    wait_until("the fault", || client.latest().channels()[0].fault() == Some(Fault::Backend));
    let refused = client.reset("wire");
    assert!(refused.is_err(), "the cause is still there: {refused:?}");
    let front_end = FrontEnd::start(&rig, &[]);
    drive(&client, "wire");
    assert!(front_end.events().iter().any(|event| event["event"] == "running"));
    let said = driver.process.stderr();
    assert!(said.contains("is gone") && said.contains("is back"), "{said}");
    driver.stop();
}

#[test]
fn on_a_bad_line_wires_are_driven_or_off_and_the_driver_goes_on() {
    let rig = bench(&["wire"]);
    let front_end = FrontEnd::start(&rig, &["--lose", "0.02", "--damage", "0.02", "--swap", "0.02"]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    // Often enough that something has gone wrong in between.
    for _ in 0..5 {
        drive(&client, "wire");
        let cycle = client.latest().cycle;
        wait_until("fifty cycles", || client.latest().cycle > cycle + 50);
    }
    let report = driver.stop();
    assert!(report["cycles"].as_u64() > Some(250), "{report:#}");
    wait_until("outputs off", || {
        let last = front_end.events().into_iter().rfind(|event| event["event"] == "off" || event["event"] == "running");
        last.is_some_and(|last| last["event"] == "off")
    });
}

#[test]
fn a_front_end_that_is_not_there_is_said_with_its_remedy() {
    let rig = bench(&["wire"]);
    sinew_tests::run([std::ffi::OsString::from("run"), rig.path().into()])
        .refused(&["front-end cannot be opened", "is it plugged in"]);
}
