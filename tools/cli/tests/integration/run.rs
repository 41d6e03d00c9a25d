//! The driver as a process, commanded by others: taken, refused, stopped in order, and found by its name.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{RIG, Scratch, program};
use serde_json::Value;

/// A running driver; killed if a test fails before it is stopped.
struct Driver<'a> {
    scratch: &'a Scratch,
    child: Child,
}

impl<'a> Driver<'a> {
    /// Starts it on the contract's rig, at leisure, and waits until its wire has been measured. Its periods are longer than a busy
    /// machine is late: a loop that misses one after the other gives up.
    fn start(scratch: &'a Scratch) -> Driver<'a> {
        scratch.file("rig.toml", RIG.replace("rate_hz = 100.0", "rate_hz = 50.0\nrealtime = \"off\""));
        let child = program()
            .args(["run", "rig.toml", "--report", "report.json"])
            .current_dir(scratch.path("."))
            .env("SINEW_RUNTIME_DIR", scratch.runtime())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the driver starts");
        let driver = Driver { scratch, child };
        driver.until("a measured length", |status| status["channel"][0]["length_m"].is_f64());
        driver
    }

    fn status(&self) -> Option<Value> {
        let ran = self.scratch.sinew(["status", "--json"]);
        (ran.code() == 0).then(|| serde_json::from_str(&ran.stdout()).expect("JSON"))
    }

    /// Looks again and again until something is so.
    #[track_caller]
    fn until(&self, what: &str, so: impl Fn(&Value) -> bool) -> Value {
        let patience = Instant::now() + Duration::from_secs(60);
        let mut last = None;
        while Instant::now() < patience {
            last = self.status();
            match &last {
                Some(status) if so(status) => return status.clone(),
                _ => std::thread::sleep(Duration::from_millis(20)),
            }
        }
        panic!("no {what}: {last:#?}")
    }

    /// Waits for its end; gives its exit code and its report.
    fn ended(&mut self) -> (i32, Value) {
        let status = self.child.wait().expect("it ends");
        let report = std::fs::read_to_string(self.scratch.path("report.json")).expect("a report");
        (status.code().expect("an exit code"), serde_json::from_str(&report).expect("JSON"))
    }
}

impl Drop for Driver<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_driver_is_commanded_refuses_what_it_must_and_stops_in_order() {
    let scratch = Scratch::new();
    let mut driver = Driver::start(&scratch);
    let pid = driver.child.id();

    // a second one for the same rig names the first
    let second = scratch.sinew(["run", "rig.toml", "--for", "1"]);
    assert_eq!(second.code(), 1, "{}", second.stderr());
    assert!(
        second.stderr().contains(&pid.to_string()) && second.stderr().contains("sinew stop"),
        "{}",
        second.stderr()
    );

    // a command is taken, seen, and lapses
    let taken = scratch.sinew(["set", "wire", "stroke=30%", "--hold", "60"]).done();
    assert!(taken.contains("stroke 30.0 %") && taken.contains("for 60 s"), "{taken}");
    let status = driver.until("length mode", |status| status["channel"][0]["mode"] == "length");
    assert_eq!(status["schema"], "sinew.status/1");
    assert_eq!(status["pid"], pid);
    let (target, lease) = (&status["channel"][0]["target_m"], &status["channel"][0]["lease_s"]);
    assert!(target.as_f64().is_some_and(|m| m > 0.16 && m < 0.17), "{target}");
    assert!(lease.as_f64().is_some_and(|s| s > 0.0 && s <= 60.0), "{lease}");
    driver.until("motion", |status| status["channel"][0]["stroke"].as_f64().is_some_and(|stroke| stroke > 0.1));
    assert!(scratch.sinew(["set", "wire", "off"]).done().contains("off"));
    driver.until("off", |status| status["channel"][0]["mode"] == "off");

    // a refusal uses the units of the command
    scratch.sinew(["set", "wire", "length=150mm"]).refused(&["150.00 mm", "outside"]);
    scratch.sinew(["set", "wires", "off"]).refused(&["no channel \"wires\"", "did you mean \"wire\"?"]);
    scratch.sinew(["set", "wire", "stroke=30%", "--hold", "9999999"]).refused(&["hold", "--hold from"]);
    scratch.sinew(["status", "--rig", "other"]).refused(&["other", "tensile-bench"]);
    assert!(scratch.sinew(["reset", "wire"]).done().contains("no fault"));

    // its lines for those without a screen
    let lines = scratch.sinew(["monitor", "--for", "3"]).done();
    assert!(lines.contains("cycle ") && lines.contains("faults none"), "{lines}");

    let stopped = scratch.sinew(["stop"]).done();
    assert!(stopped.contains("stopped") && stopped.contains(&pid.to_string()), "{stopped}");
    let (code, report) = driver.ended();
    assert_eq!(code, 0);
    assert_eq!(report["schema"], "sinew.run/1");
    for key in ["seconds", "rate_hz", "channels", "cycles", "missed", "lateness_us", "cycle_us", "faults", "rt"] {
        assert!(!report[key].is_null(), "{key}: {report}");
    }
    assert_eq!(report["allocations_in_loop"], 0);
    assert_eq!(report["channel"][0]["name"], "wire");
    assert_eq!(report["channel"][0]["duty"], 0.0, "outputs are at zero");
    assert_eq!(scratch.sinew(["status"]).code(), 1);
}

#[test]
fn sigterm_is_an_orderly_end_and_so_is_ctrl_z() {
    // A driver that only stood still would leave its wires heated.
    for signal in ["-TERM", "-TSTP"] {
        let scratch = Scratch::new();
        let mut driver = Driver::start(&scratch);
        let killed = Command::new("kill").args([signal, &driver.child.id().to_string()]).status().expect("kill");
        assert!(killed.success());
        let patience = Instant::now() + Duration::from_secs(60);
        while driver.child.try_wait().expect("a child").is_none() {
            assert!(Instant::now() < patience, "{signal} does not end it");
            std::thread::sleep(Duration::from_millis(10));
        }
        let (code, report) = driver.ended();
        assert_eq!(code, 0);
        assert_eq!(report["ended"], "stopped");
    }
}

#[test]
fn a_killed_driver_leaves_nothing_in_the_way() {
    let scratch = Scratch::new();
    let mut driver = Driver::start(&scratch);
    driver.child.kill().expect("kill");
    driver.child.wait().expect("it ends");
    assert_eq!(scratch.sinew(["status"]).code(), 1);
    let report = scratch.sinew(["run", "rig.toml", "--for", "0.2", "--report", "-"]).done();
    let report: Value = serde_json::from_str(&report).expect("nothing but the report on stdout");
    assert_eq!(report["ended"], "duration");
}

#[test]
fn a_terminal_nobody_reads_keeps_no_signal_from_the_outputs() {
    let scratch = Scratch::new();
    scratch.file("rig.toml", RIG.replace("rate_hz = 100.0", "rate_hz = 50.0\nrealtime = \"off\""));
    // stdout and stderr are a pipe that is full and is never read.
    let (reader, writer) = std::io::pipe().expect("a pipe");
    let flags = rustix::fs::fcntl_getfl(&writer).expect("flags");
    rustix::fs::fcntl_setfl(&writer, flags | rustix::fs::OFlags::NONBLOCK).expect("not waiting");
    while rustix::io::write(&writer, &[b'x'; 4096]).is_ok() {}
    rustix::fs::fcntl_setfl(&writer, flags).expect("waiting");
    let child = program()
        .args(["run", "rig.toml", "--no-monitor", "--report", "report.json"])
        .current_dir(scratch.path("."))
        .env("SINEW_RUNTIME_DIR", scratch.runtime())
        .stdout(writer.try_clone().expect("a second end"))
        .stderr(writer)
        .spawn()
        .expect("the driver starts");
    let mut driver = Driver { scratch: &scratch, child };
    driver.until("a measured length", |status| status["channel"][0]["length_m"].is_f64());
    // Long enough for lines that find no room.
    std::thread::sleep(Duration::from_secs(2));
    let id = driver.child.id();
    rustix::process::kill_process(
        rustix::process::Pid::from_raw(id as i32).expect("a process"),
        rustix::process::Signal::TERM,
    )
    .expect("a signal");
    let (code, report) = driver.ended();
    drop(reader);
    assert_eq!((code, report["outputs_confirmed_zero"].as_bool()), (0, Some(true)), "{report:#}");
}
