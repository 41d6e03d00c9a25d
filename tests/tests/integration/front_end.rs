//! Driver and front-end as two processes with a pseudo-terminal between them: what happens to the wires when one of the two,
//! or the line, fails. What the front-end says of its outputs counts, not what the driver believes.
//!
//! Slow periods and long silences: on a busy machine both processes are late by many milliseconds.

use std::process::Command;
use std::time::Duration;

use serde_json::Value;
use sinew_ipc::{ChannelState, Client, Error, Fault, Mode, Reason};
use sinew_tests::{Driver, Process, Rig, front_end, run, wait_for, wait_until};

const LONG: Duration = Duration::from_secs(120);
const RATE_HZ: f64 = 50.0;
const WATCHDOG_PERIODS: u64 = 10;
const SILENCE_NS: u64 = WATCHDOG_PERIODS * 20_000_000;
const DUTY: f64 = 0.15;
/// Number of a backend that did not answer in time, as in [`ChannelState::backend`].
const TIMEOUT: u32 = 5;
/// How often somebody looks who waits for a channel.
const LOOK: Duration = Duration::from_millis(40);

pub fn bench(names: &[&str]) -> Rig {
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
pub struct FrontEnd(pub Process);

impl FrontEnd {
    #[track_caller]
    pub fn start(rig: &Rig, more: &[&str]) -> FrontEnd {
        let mut command = Command::new(front_end());
        command.arg(rig.path()).arg("--link").arg(rig.file("front-end")).args(["--for", "300"]).args(more);
        let mut process = Process::start_to_be_told(&mut command);
        process.wait_for_word("\"event\":\"port\"");
        FrontEnd(process)
    }

    /// What it has told so far; the last line may be half written.
    pub fn events(&self) -> Vec<Value> {
        self.0.stdout().lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// Waits until, after its first `seen` events, its own watchdog has switched powered outputs off, and not before its time.
    #[track_caller]
    fn is_off_by_itself(&self, seen: usize) {
        let off = wait_for("outputs off by the front-end's own watchdog", || {
            let powered = |event: &Value| event["why"] == "watchdog" && event["powered"] == true;
            self.events().into_iter().skip(seen).find(powered)
        });
        let silent_ns = off["silent_ns"].as_u64().expect("a time");
        assert!(silent_ns >= SILENCE_NS, "{silent_ns}");
    }

    /// Waits until it is told to go off, as the last thing it says.
    #[track_caller]
    pub fn is_told_off(&self) {
        wait_until("outputs off by the driver", || {
            let last = self.events().into_iter().rfind(|event| event["event"] == "off" || event["event"] == "running");
            last.is_some_and(|last| last["event"] == "off")
        });
    }
}

fn state(client: &Client) -> ChannelState {
    client.latest().channels()[0]
}

/// Gets a wire driven and measured, with a reset wherever one is needed: front-ends that are processes are late on busy machines.
#[track_caller]
pub fn drive(client: &Client, name: &str) {
    wait_until("the wire to be driven", || {
        let state = state(client);
        match state.mode() {
            Mode::Duty if state.measured_length_m.is_finite() => return true,
            Mode::Fault => drop(client.reset(name)),
            Mode::Duty | Mode::Waiting => {}
            _ => drop(client.set_duty(name, DUTY, LONG)),
        }
        std::thread::sleep(LOOK);
        false
    });
}

/// Waits for the fault of a backend that has failed as a whole.
#[track_caller]
fn is_latched(client: &Client) {
    wait_until("the fault of the backend", || state(client).fault() == Some(Fault::Backend));
    assert_eq!(state(client).duty, 0.0);
}

#[test]
fn two_processes_heat_wires_and_measure_them() {
    let rig = bench(&["left", "right"]);
    let front_end = FrontEnd::start(&rig, &[]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    drive(&client, "left");
    assert_eq!(client.info().simulated, 0, "the driver does not simulate these wires");
    for stroke in [0.6, 0.3] {
        wait_until("the wire to get where it is told", || {
            let state = state(&client);
            match state.mode() {
                Mode::Fault => drop(client.reset("left")),
                Mode::Waiting => {}
                _ => drop(client.set_stroke("left", stroke, LONG)),
            }
            std::thread::sleep(LOOK);
            (state.measured_length_m - state.target_m).abs() < 0.4e-3
        });
    }
    let said = driver.process.stderr();
    assert!(said.contains("sinew-host 0.1.0"), "{said}");
    driver.stop();
    front_end.is_told_off();
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
        front_end.is_off_by_itself(seen);
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
    front_end.is_off_by_itself(seen);
    driver.process.signal(libc::SIGCONT);
    wait_until("the fault to be latched", || state(&client).fault().is_some());
    drive(&client, "wire");
    driver.stop();
}

#[test]
fn a_pulled_line_is_a_fault_and_once_it_is_back_a_reset_is_enough() {
    let rig = bench(&["wire"]);
    let mut front_end = FrontEnd::start(&rig, &[]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    drive(&client, "wire");
    let seen = front_end.events().len();
    front_end.0.tell("disconnect");
    is_latched(&client);
    front_end.is_off_by_itself(seen);
    match client.reset("wire") {
        Err(Error::Refused(refusal)) => assert_eq!(refusal.reason, Reason::CauseRemains(Fault::Backend)),
        other => panic!("the cause is still there: {other:?}"),
    }
    front_end.0.tell("connect");
    wait_until("the line to be had back", || driver.process.stderr().contains("is back"));
    assert!(state(&client).fault().is_some(), "nothing but a reset clears it");
    drive(&client, "wire");

    // Nothing passes for longer than anybody bears, though the line is there: samples are missed before anybody calls it silent.
    let seen = front_end.events().len();
    let mut stream = client.stream().expect("a stream");
    front_end.0.tell("stall 0.6");
    wait_until("the fault of the wire", || state(&client).fault() == Some(Fault::NoSample));
    // In some cycle: it is silent for less than half a second.
    wait_until("the line to be called silent", || {
        stream.next().expect("the driver runs").is_some_and(|cycle| cycle.channels[0].backend == TIMEOUT)
    });
    front_end.is_off_by_itself(seen);
    drive(&client, "wire");
    driver.stop();
    front_end.is_told_off();
}

#[test]
fn a_front_end_that_dies_is_a_fault_and_another_one_in_its_place_needs_no_new_driver() {
    let rig = bench(&["wire"]);
    let front_end = FrontEnd::start(&rig, &[]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    drive(&client, "wire");
    front_end.0.kill();
    is_latched(&client);
    let front_end = FrontEnd::start(&rig, &[]);
    drive(&client, "wire");
    assert!(front_end.events().iter().any(|event| event["event"] == "running"));
    let said = driver.process.stderr();
    assert!(said.contains("is gone") && said.contains("is back"), "{said}");
    driver.stop();
    front_end.is_told_off();
}

#[test]
fn on_a_bad_line_wires_are_driven_or_off_and_the_driver_goes_on() {
    let rig = bench(&["wire"]);
    let mut front_end = FrontEnd::start(&rig, &["--lose", "0.02", "--damage", "0.02", "--swap", "0.02"]);
    let driver = Driver::start(&rig);
    let client = rig.client();
    // Often enough that something has gone wrong in between.
    for _ in 0..3 {
        drive(&client, "wire");
        let cycle = client.latest().cycle;
        wait_until("fifty cycles", || client.latest().cycle > cycle + 50);
    }
    for order in ["lose 0", "damage 0", "swap 0"] {
        front_end.0.tell(order);
    }
    drive(&client, "wire");
    let report = driver.stop();
    assert!(report["cycles"].as_u64() > Some(150), "{report:#}");
    front_end.is_told_off();
}

#[test]
fn a_front_end_that_is_not_there_is_said_with_its_remedy() {
    let rig = bench(&["wire"]);
    run(["run".into(), rig.path().into_os_string()]).refused(&["front-end cannot be opened", "plug it in"]);
}
