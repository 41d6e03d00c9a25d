//! Drivers that start, refuse to start, are stopped, and are killed: nothing of them is in the way of the next.

use serde_json::Value;
use sinew_ipc::{Client, DriverHealth, DriverState, Error, Fault, Outcome};
use sinew_tests::{Driver, Process, RATE_HZ, Rig, check_report, entries, sinew, wait_until};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const LONG: Duration = Duration::from_secs(120);

#[test]
fn a_second_driver_refuses_and_names_the_first() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    client.set_stroke("left", 0.2, LONG).unwrap();
    let report = rig.file("second.json");
    fs::write(&report, "an earlier report").unwrap();
    let second = Process::start(rig.command(&["--for", "1"]).arg("--report").arg(&report)).finish();
    assert!(matches!(second.code, Some(1 | 2)), "{second:?}");
    assert!(second.stderr.contains(&driver.pid().to_string()), "{second:?}");
    assert!(second.stderr.contains(&rig.name) && second.stderr.contains("hint: "), "{second:?}");
    assert_eq!(fs::read_to_string(&report).unwrap(), "an earlier report", "a run that never was has no report");

    // The first has not noticed.
    let before = client.latest();
    wait_until("the first driver to go on", || client.latest().cycle > before.cycle + 50);
    assert_eq!(client.latest().channels()[0].target_m, before.channels()[0].target_m);
    assert_eq!(client.info().pid, driver.pid());
    driver.stop();
}

fn ends_in_order(end: impl FnOnce(&Driver, &Client)) -> serde_json::Value {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    client.set_duty("left", 0.2, LONG).unwrap();
    client.set_stroke("right", 0.5, LONG).unwrap();
    wait_until("the wires to be powered", || client.latest().channels().iter().all(|c| c.duty > 0.1));
    end(&driver, &client);
    let report = driver.stopped();
    // The last state anybody sees has outputs at zero, and clients are told that it is over.
    let last = client.latest();
    assert_eq!(last.state(), DriverState::Stopped);
    assert!(last.channels().iter().all(|c| c.duty == 0.0), "{last:?}");
    assert_eq!(client.health(), DriverHealth::Stopped);
    let error = client.set_duty("left", 0.1, LONG).unwrap_err();
    assert!(matches!(error, Error::DriverGone { stopped: true, .. }), "{error}");
    let error = Client::connect(&rig.name).err().expect("nobody is there");
    assert!(matches!(error, Error::NotRunning { .. }), "{error}");
    assert_eq!(report["ended"], "stopped", "{report:#}");
    report
}

#[test]
fn sigterm_ends_at_zero_outputs_with_a_report() {
    ends_in_order(|driver, _| driver.process.signal(libc::SIGTERM));
}

#[test]
fn ctrl_c_ends_at_zero_outputs_with_a_report() {
    ends_in_order(|driver, _| driver.process.signal(libc::SIGINT));
}

#[test]
fn a_client_can_stop_the_driver() {
    ends_in_order(|_, client| assert_eq!(client.stop().unwrap().outcome, Outcome::Taken.code()));
}

#[test]
fn the_command_line_can_stop_the_driver() {
    ends_in_order(|driver, client| {
        let rig = client.info().rig.to_string();
        let said = sinew_tests::run(["stop", "--rig", &rig]).expect(0).stdout;
        assert!(said.contains(&rig) && said.contains(&driver.pid().to_string()), "{said}");
    });
}

#[test]
fn a_driver_ends_by_itself_after_the_time_it_was_given() {
    let rig = Rig::bench(&["left", "right"], "");
    let path = rig.file("report.json");
    Process::start(rig.command(&["--for", "1.5"]).arg("--report").arg(&path)).finish().expect(0);
    let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    check_report(&report);
    assert_eq!(report["ended"], "duration", "{report:#}");
    let periods = report["cycles"].as_u64().unwrap() + report["missed"].as_u64().unwrap();
    // A cycle that comes late by several periods may be the last one.
    assert!((750..1500).contains(&periods), "{report:#}");
}

#[test]
fn a_report_may_go_to_stdout_alone() {
    let rig = Rig::bench(&["left"], "");
    let said = Process::start(&mut rig.command(&["--for", "0.5", "--report", "-"])).finish().expect(0);
    check_report(&said.json());
}

#[test]
fn a_killed_driver_is_noticed_and_the_next_one_starts_at_once() {
    let rig = Rig::bench(&["left", "right"], "");
    for round in 0..3 {
        let (driver, client) = Driver::ready(&rig);
        client.set_duty("left", 0.1, LONG).unwrap();
        let mut faults = client.faults();
        assert_eq!(faults.poll(), None, "round {round}");
        driver.process.kill();
        wait_until("the client to notice", || client.health() == DriverHealth::Died);
        assert!(!client.is_alive());
        let error = client.set_duty("left", 0.1, LONG).unwrap_err();
        assert!(matches!(error, Error::DriverGone { stopped: false, .. }), "{error}");
        // What was last known can still be read, and each channel says that its driver has died.
        assert_eq!(client.latest().channels().len(), 2);
        assert_eq!([faults.poll(), faults.poll()].map(|c| c.and_then(|c| c.after)), [Some(Fault::DriverDied); 2]);
        // The client of the dead one does not mistake the next driver for it.
        let next = Driver::start(&rig);
        assert_eq!(client.health(), DriverHealth::Died);
        drop(faults);
        drop(client);
        let client = rig.client();
        assert_eq!(client.info().pid, next.pid());
        // Nothing of the old driver's orders is left.
        wait_until("sensors", || client.latest().channels().iter().all(|c| c.mode() == sinew_ipc::Mode::Off));
        next.stop();
    }
}

/// All processes of this test in a runtime folder of their own, so that whatever stays behind can be seen.
struct House {
    folder: tempfile::TempDir,
}

impl House {
    fn new() -> House {
        // Short: a socket's path has little room.
        House { folder: tempfile::Builder::new().prefix("sw-").tempdir_in("/tmp").unwrap() }
    }

    fn process(&self, command: &mut Command) -> Process {
        Process::start(command.env("SINEW_RUNTIME_DIR", self.folder.path()))
    }

    fn sinew(&self, args: &[&str]) -> sinew_tests::Finished {
        self.process(Command::new(sinew()).args(args)).finish()
    }

    /// Runs whose folders are there.
    fn runs(&self) -> Vec<String> {
        entries(self.folder.path()).into_iter().filter(|name| self.folder.path().join(name).is_dir()).collect()
    }

    fn wait_for_driver(&self) {
        wait_until("the driver", || self.sinew(&["status"]).code == Some(0));
    }
}

fn shared_memory_of(runs: &[String]) -> Vec<String> {
    let ours = |name: &String| runs.iter().any(|run| name.contains(run.as_str()));
    entries(Path::new("/dev/shm")).into_iter().filter(ours).collect()
}

#[test]
fn after_a_killed_driver_and_a_killed_client_nothing_is_left_over() {
    let rig = Rig::bench(&["left", "right"], "");
    let house = House::new();
    let robot = Path::new(env!("CARGO_BIN_EXE_sinew-test-robot"));
    let mut runs = Vec::new();
    for _ in 0..2 {
        let driver = house.process(&mut rig.command(&["--for", "300"]));
        house.wait_for_driver();
        let mut holder = house.process(Command::new(robot).args([&rig.name, "hold", "left", "0.2", "2"]));
        holder.wait_for_word("holding");
        let mut reader = house.process(Command::new(robot).args([&rig.name, "stream"]));
        reader.wait_for_word("streaming");
        runs.extend(house.runs());
        assert!(!shared_memory_of(&house.runs()).is_empty(), "this is where it would be seen");
        reader.kill();
        driver.kill();
        // The robot that lives on is told.
        let told = holder.finish().expect(3);
        assert!(told.stderr.contains("died") && told.stderr.contains(&rig.name), "{told:?}");
    }
    // Whatever the dead have left, the next driver starts, and takes it away.
    let report = rig.file("report.json");
    let driver = house.process(rig.command(&["--for", "300"]).arg("--report").arg(&report));
    house.wait_for_driver();
    runs.sort();
    runs.dedup();
    assert_eq!(runs.len(), 2, "{runs:?}");
    let now = house.runs();
    assert!(runs.iter().all(|run| !now.contains(run)), "folders of {runs:?} are still among {now:?}");
    assert_eq!(shared_memory_of(&runs), [""; 0], "shared memory of dead drivers");
    house.sinew(&["set", "left", "stroke=20%"]).expect(0);
    let stopped = house.sinew(&["stop"]).expect(0);
    assert!(stopped.stdout.contains(&rig.name));
    driver.finish().expect(0);
    check_report(&serde_json::from_str(&fs::read_to_string(report).unwrap()).unwrap());
    // And after one that stopped in order there is nothing at all.
    assert_eq!(house.runs(), [""; 0]);
    assert_eq!(shared_memory_of(&now), [""; 0]);
    assert!(!entries(house.folder.path()).iter().any(|name| name.ends_with(".lock")));
}

#[test]
fn without_a_driver_there_is_none_and_with_two_one_has_to_be_chosen() {
    let house = House::new();
    for command in ["status", "stop", "monitor"] {
        let said = house.sinew(&[command]);
        assert!(matches!(said.code, Some(1 | 2)), "{said:?}");
        assert!(said.stderr.contains("no driver is running") && said.stderr.contains("sinew run"), "{said:?}");
    }
    let (one, two) = (Rig::bench(&["wire"], ""), Rig::bench(&["wire"], ""));
    let first = house.process(&mut one.command(&["--for", "300"]));
    house.wait_for_driver();
    let second = house.process(&mut two.command(&["--for", "300"]));
    wait_until("the second driver", || house.sinew(&["status", "--rig", &two.name]).code == Some(0));
    house.sinew(&["status"]).refused(&[&one.name, &two.name, "--rig"]);
    house.sinew(&["set", "wire", "stroke=10%"]).refused(&[&one.name, &two.name, "--rig"]);
    house.sinew(&["status", "--rig", "no-such-rig"]).refused(&["no-such-rig", &one.name, &two.name]);
    house.sinew(&["stop", "--rig", &one.name]).expect(0);
    first.finish().expect(0);
    assert_eq!(house.sinew(&["status", "--json"]).expect(0).json()["rig"], two.name.as_str());
    house.sinew(&["stop"]).expect(0);
    second.finish().expect(0);
}

/// The first thing anybody tries: no rig file at all.
#[test]
fn the_built_in_hexapod_walks_by_itself_and_lends_a_wire_to_whoever_asks() {
    let rig = Rig::bench(&["unused"], "");
    let house = House::new();
    let report = rig.file("report.json");
    let run = ["run", "--no-monitor", "--for", "300", "--report"];
    let driver = house.process(Command::new(sinew()).args(run).arg(&report));
    house.wait_for_driver();
    let wires = || house.sinew(&["status", "--json"]).expect(0).json()["channel"].as_array().unwrap().clone();
    let mut ranges = vec![(f64::MAX, f64::MIN); 18];
    wait_until("all eighteen wires to walk", || {
        let wires = wires();
        assert_eq!(wires.len(), 18);
        for (wire, range) in wires.iter().zip(&mut ranges) {
            assert!(wire["fault"].is_null(), "{wire:#}");
            if let Some(stroke) = wire["stroke"].as_f64() {
                *range = (range.0.min(stroke), range.1.max(stroke));
            }
        }
        ranges.iter().all(|(low, high)| high - low > 0.15)
    });
    let (asked, others): (Vec<_>, Vec<_>) = {
        house.sinew(&["set", "front_left_femur", "stroke=60%", "--hold", "5"]).expect(0);
        wires().into_iter().partition(|wire| wire["name"] == "front_left_femur")
    };
    assert_eq!(asked[0]["mode"], "length", "{:#}", asked[0]);
    assert!(asked[0]["lease_s"].as_f64().unwrap() <= 5.0, "{:#}", asked[0]);
    assert!(others.len() == 17 && others.iter().all(|wire| wire["mode"] == "program"), "{others:#?}");
    // And it goes on walking with it once the lease is over, without anybody having to reset anything.
    wait_until("the wire to walk again", || {
        wires().iter().all(|wire| wire["mode"] == "program" && wire["fault"].is_null())
    });
    driver.signal(libc::SIGINT);
    driver.finish().expect(0);
    let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(report).unwrap()).unwrap();
    check_report(&report);
    assert_eq!((report["rig"].as_str(), report["channels"].as_u64()), (Some("hexapod"), Some(18)));
    assert_eq!(report["faults"].as_array().unwrap().len(), 0, "{report:#}");
}

#[test]
fn a_rig_that_cannot_be_driven_is_refused_and_no_report_is_touched() {
    let mistakes: [(&str, &str, &[&str]); 8] = [
        ("diameter_mm = 0.125", "diamter_mm = 0.125", &["rig.toml:7", "diamter_mm"]),
        ("supply_v = 6.5", "supply_v = nan", &["rig.toml:9", "supply_v", "nan"]),
        ("rate_hz = 500.0", "rate_hz = 1.0", &["rig.toml", "rate_hz"]),
        ("supply_v = 6.5", "kind = \"temperature\"", &["rig.toml", "pwm"]),
        ("mass_kg = 0.08", "mass_kg = 0", &["rig.toml:10", "mass_kg"]),
        ("ls_mm = 150.0", "ls_mm = 170.0", &["rig.toml:8", "ls_mm"]),
        ("[[channel]]", "[[channel]", &["rig.toml:5"]),
        ("name = \"left\"", "name = \"left wire\"", &["rig.toml:6", "left wire"]),
    ];
    for (from, to, words) in mistakes {
        let good = Rig::bench(&["left"], "");
        let text = fs::read_to_string(good.path()).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{from}");
        fs::write(good.path(), text.replace(from, to)).unwrap();
        let report = good.file("report.json");
        fs::write(&report, "an earlier report").unwrap();
        let before = entries(good.path().parent().unwrap());
        Process::start(good.command(&["--for", "1"]).arg("--report").arg(&report)).finish().refused(words);
        assert_eq!(fs::read_to_string(&report).unwrap(), "an earlier report", "{to}");
        assert_eq!(entries(good.path().parent().unwrap()), before);
    }
    let rig = Rig::bench(&["left"], "");
    fs::remove_file(rig.path()).unwrap();
    Process::start(&mut rig.command(&["--for", "1"])).finish().refused(&["rig.toml"]);
    // A report that has no place is found out before the run.
    let rig = Rig::bench(&["left"], "");
    Process::start(&mut rig.command(&["--for", "1", "--report", "/no/such/folder/report.json"]))
        .finish()
        .refused(&["/no/such/folder"]);
}

#[test]
fn simulated_time_passes_as_fast_as_asked_for_and_no_faster() {
    let rig = Rig::bench(&["wire"], "");
    let begun = Instant::now();
    let report = rig.file("report.json");
    let run = |speed: &str| {
        let words = ["--speed", speed, "--for", "20", "--report", report.to_str().expect("UTF-8")];
        Process::start(&mut rig.command(&words)).finish()
    };
    run("20").expect(0);
    assert!(begun.elapsed() >= Duration::from_secs(1), "20 simulated seconds in {:?}", begun.elapsed());
    let report: Value = serde_json::from_str(&fs::read_to_string(&report).expect("a report")).expect("JSON");
    let counted = (report["cycles"].as_u64(), report["missed"].as_u64());
    assert_eq!(counted, (Some((20.0 * RATE_HZ) as u64), Some(0)), "{report:#}");
    run("max").expect(0);
    run("0.5").refused(&["1 to 10000, or max"]);

    let elsewhere = Rig::bench(&["wire"], "\n[backend]\nkind = \"serial\"\nserial.port = \"/dev/null\"\n");
    Process::start(&mut elsewhere.command(&["--speed", "2"])).finish().refused(&["are not simulated"]);
}
