//! `sinew run` on Linux's own outputs, lines and converters, with a simulated kernel behind the files: a driver that is killed, converters
//! that have nothing new, a bus that hangs, the supply's line, an emergency stop, a stage that conducts in the dark. What the files say of the outputs counts, not what the driver believes.
//!
//! Without FUSE (it takes `/dev/fuse` and root) these tests say so and are skipped.

use std::fs;
use std::process::Command;
use std::time::{Duration, Instant};

use sinew_ipc::{Client, Fault, Mode};
use sinew_tests::{Driver, PATIENCE, Process, Rig, linux_tree, wait_until};

const LONG: Duration = Duration::from_secs(120);
pub const RATE_HZ: f64 = 50.0;
const DUTY: f64 = 0.15;
/// How often somebody looks who waits for a channel.
const LOOK: Duration = Duration::from_millis(40);
/// Lines of the simulated kernel: the supply's, the emergency stop's contact and its button.
const ENABLE: u32 = 17;
const STOP: u32 = 27;
const RESET: u32 = 22;
/// Longer than the guard bears silence, ms.
const GUARD_MS: u64 = 200;

/// A rig of one wire whose files lie in a folder of the test's own.
pub fn bench(rate_hz: f64) -> Rig {
    let mut rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = {rate_hz:?}\n"));
    let root = rig.file("root");
    fs::create_dir(&root).expect("the folder is writable");
    rig.add(&Rig::wire("wire"));
    rig.add("linux = { pwm = \"pwmchip0/0\"");
    for (key, input) in [("v1", 0), ("v2", 1), ("v3", 2), ("supply", 3)] {
        rig.add(&format!(", {key} = \"2-0048:in_voltage{input}\""));
    }
    rig.add(&format!(
        ", current = \"2-0048:in_current0\" }}\n\n[backend]\nkind = \"linux\"\n\n[backend.linux]\nroot = \"{}\"\n\
         sampling = \"buffer\"\nphase = \"synchronised\"\ntrigger = \"pwm-on-phase\"\nguard_ms = {GUARD_MS}\n",
        root.display()
    ));
    rig
}

/// A simulated kernel in a process of its own, told to end in the end: killed, it would leave its mount behind.
pub struct Tree(Process);

impl Drop for Tree {
    fn drop(&mut self) {
        self.0.signal(libc::SIGTERM);
        let since = Instant::now();
        while self.0.ended().is_none() && since.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// The simulated kernel of a rig; `None`, with a word about it, where there is no FUSE. `slower` than its driver, if that is not 1.
pub fn tree(rig: &Rig, slower: f64) -> Option<Tree> {
    tree_with(rig, slower, &[])
}

fn tree_with(rig: &Rig, slower: f64, scans: &[&str]) -> Option<Tree> {
    let text = fs::read_to_string(rig.path()).expect("written before");
    let file = rig.file("kernel.toml");
    let rate = |factor: f64| format!("rate_hz = {:?}", RATE_HZ / factor);
    fs::write(&file, text.replace(&rate(1.0), &rate(slower))).expect("the folder is writable");
    let mut process = Process::start_to_be_told(Command::new(linux_tree()).arg(file).arg(rig.file("root")).args(scans));
    let mut there = false;
    wait_until("the files", || {
        there = process.stderr().contains("is shown under");
        there || process.ended().is_some()
    });
    if !there {
        assert!(process.stderr().contains("/dev/fuse"), "{}", process.stderr());
        eprintln!("skipped: no FUSE here ({})", process.stderr().trim());
    }
    there.then(|| Tree(process))
}

/// What the files say is put out, ns of each period; 0 before anybody has exported the output.
pub fn put_out(rig: &Rig) -> u64 {
    let folder = rig.file("root").join("sys/class/pwm/pwmchip0/pwm0");
    let number = |file: &str| fs::read_to_string(folder.join(file)).ok()?.trim().parse::<u64>().ok();
    number("duty_cycle").unwrap_or(0) * number("enable").unwrap_or(0)
}

/// Gets the wire heated and measured, with a reset wherever one is needed: the kernel is a process here, late on a busy machine.
#[track_caller]
pub fn drive(rig: &Rig, client: &Client) {
    wait_until("the wire to be driven", || {
        let state = client.latest().channels()[0];
        match state.mode() {
            Mode::Duty if state.measured_length_m.is_finite() => return put_out(rig) > 1_000_000,
            Mode::Fault => drop(client.reset("wire")),
            Mode::Duty | Mode::Waiting => {}
            _ => drop(client.set_duty("wire", DUTY, LONG)),
        }
        std::thread::sleep(LOOK);
        false
    });
}

#[test]
fn a_killed_driver_leaves_no_output_on_and_the_next_one_needs_no_hand() {
    let rig = bench(RATE_HZ);
    let Some(_tree) = tree(&rig, 1.0) else { return };
    for _ in 0..2 {
        let driver = Driver::start(&rig);
        drive(&rig, &rig.client());
        driver.process.kill();
        wait_until("outputs off by the guard", || put_out(&rig) == 0);
    }
    let driver = Driver::start(&rig);
    drive(&rig, &rig.client());
    driver.stop();
    assert_eq!(put_out(&rig), 0);
}

/// The level of a line, as its file says it.
fn level(rig: &Rig, line: u32) -> u64 {
    let text = fs::read_to_string(rig.file("root").join(format!("sys/class/gpio/gpio{line}/value")));
    text.expect("exported for good").trim().parse().expect("a level")
}

/// Presses the button that resets the emergency stop, until its supply is back.
#[track_caller]
fn press_the_button(rig: &Rig, tree: &mut Tree, client: &Client) {
    tree.0.tell("whole 0 estop_reset");
    std::thread::sleep(4 * LOOK);
    tree.0.tell("fault 0 estop_reset");
    wait_until("the emergency stop to be released, and its channel to be reset", || {
        std::thread::sleep(LOOK);
        client.reset("wire").is_ok()
    });
    tree.0.tell("whole 0 estop_reset");
    wait_until("the supply", || level(rig, ENABLE) == 1);
    assert_eq!(client.latest().channels()[0].mode(), Mode::Off, "a reset starts nothing");
}

fn is_stopped(client: &Client) -> bool {
    let state = client.latest().channels()[0];
    state.fault() == Some(Fault::EmergencyStop) && state.duty == 0.0
}

#[test]
fn the_supplys_line_and_the_emergency_stop_from_start_to_kill() {
    let mut rig = bench(RATE_HZ);
    rig.add(&format!(
        "\n[backend.enable]\nsignal = \"level\"\nline = \"/sys/class/gpio/gpio{ENABLE}/value\"\n\n[backend.estop]\nfitted = true\n\
         line = \"/sys/class/gpio/gpio{STOP}/value\"\nreset_line = \"/sys/class/gpio/gpio{RESET}/value\"\n"
    ));
    // Converted at any moment, so that a current shows in the dark, too.
    let text = fs::read_to_string(rig.path()).expect("written before");
    fs::write(rig.path(), text.replace("phase = \"synchronised\"\ntrigger = \"pwm-on-phase\"\n", "phase = \"free\"\n"))
        .expect("the folder is writable");
    let Some(mut tree) = tree_with(&rig, 1.0, &["32"]) else { return };
    assert_eq!((level(&rig, ENABLE), level(&rig, STOP)), (0, 1));

    // It starts latched: nothing is supplied before somebody has pressed the button.
    let driver = Driver::start(&rig);
    let client = rig.client();
    wait_until("the latch", || is_stopped(&client));
    assert!(client.reset("wire").is_err());
    assert_eq!((level(&rig, ENABLE), put_out(&rig)), (0, 0));
    press_the_button(&rig, &mut tree, &client);
    drive(&rig, &client);
    assert_eq!(level(&rig, ENABLE), 1);

    // Pressed: everything off. Released: off all the same, whatever clients ask for.
    tree.0.tell("fault 0 estop_open");
    wait_until("the stop", || is_stopped(&client) && put_out(&rig) == 0 && level(&rig, ENABLE) == 0);
    tree.0.tell("whole 0 estop_open");
    std::thread::sleep(4 * LOOK);
    assert!(client.reset("wire").is_err() && client.set_duty("wire", DUTY, LONG).is_err());
    assert!(is_stopped(&client) && put_out(&rig) == 0 && level(&rig, ENABLE) == 0);
    press_the_button(&rig, &mut tree, &client);
    drive(&rig, &client);

    // Killed: the guard takes both, and the next one starts latched.
    driver.process.kill();
    wait_until("everything off by the guard", || put_out(&rig) == 0 && level(&rig, ENABLE) == 0);
    drop(client);
    let driver = Driver::start(&rig);
    let client = rig.client();
    wait_until("the latch", || is_stopped(&client));
    assert_eq!((level(&rig, ENABLE), put_out(&rig)), (0, 0));
    press_the_button(&rig, &mut tree, &client);
    drive(&rig, &client);

    // A stage that conducts while nothing is asked for: seen in the dark, and its supply taken for good.
    client.off("wire").expect("it may be off");
    tree.0.tell("fault 0 stage_on");
    wait_until("the supply taken", || level(&rig, ENABLE) == 0);
    wait_until("the fault", || client.latest().channels()[0].fault() == Some(Fault::StageOn));
    assert!(client.reset("wire").is_err(), "nothing but a new start ends it");
    assert_eq!(put_out(&rig), 0);
    driver.stop();
    assert_eq!((level(&rig, ENABLE), put_out(&rig)), (0, 0));
}

#[test]
fn converters_with_nothing_new_are_a_fault_and_not_a_wait() {
    let rig = bench(RATE_HZ);
    // Nine periods of ten bring nothing.
    let Some(_tree) = tree(&rig, 10.0) else { return };
    let driver = Driver::start(&rig);
    let client = rig.client();
    for _ in 0..2 {
        wait_until("the fault", || client.latest().channels()[0].fault() == Some(Fault::NoSample));
        wait_until("outputs off", || put_out(&rig) == 0);
        // It is not the reset's to wait for a sample that does not come.
        assert!(client.reset("wire").is_err(), "the cause is still there");
    }
    assert!(client.latest().channels()[0].measured_length_m.is_nan());
    driver.stop();
}

#[test]
fn a_bus_that_hangs_holds_the_loop_up_and_is_a_fault_once_it_goes_on() {
    let rig = bench(RATE_HZ);
    let Some(tree) = tree(&rig, 1.0) else { return };
    let driver = Driver::start(&rig);
    let client = rig.client();
    drive(&rig, &client);
    tree.0.signal(libc::SIGSTOP);
    let cycle = client.latest().cycle;
    std::thread::sleep(Duration::from_millis(4 * GUARD_MS));
    assert!(client.latest().cycle <= cycle + 2, "every call of a bus that hangs waits");
    tree.0.signal(libc::SIGCONT);
    wait_until("a fault of the whole", || {
        matches!(client.latest().channels()[0].fault(), Some(Fault::Backend | Fault::CycleOverrun))
    });
    wait_until("outputs off", || put_out(&rig) == 0);
    drive(&rig, &client);
    driver.stop();
    assert_eq!(put_out(&rig), 0);
}
