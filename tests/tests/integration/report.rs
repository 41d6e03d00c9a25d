//! What a run tells: `run --report` and `status --json` have the form the contract of the command line gives them.

use serde_json::Value;
use sinew_ipc::Mode;
use sinew_tests::{Driver, Process, RATE_HZ, Rig, wait_until};
use std::fs;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(120);

#[track_caller]
fn close(value: &Value, expected: f64) {
    let found = value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{found}, expected {expected}");
}

/// The contract's keys, read from the contract's own example where it is beside the checkout, and the same in any case.
const RUN_KEYS: [&str; 12] = [
    "schema",
    "seconds",
    "rate_hz",
    "channels",
    "cycles",
    "missed",
    "lateness_us",
    "cycle_us",
    "allocations_in_loop",
    "rt",
    "faults",
    "channel",
];

#[test]
fn the_report_has_the_contracts_form_and_the_runs_numbers() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    client.set_stroke("left", 0.3, LONG).unwrap();
    wait_until("some cycles", || client.latest().cycle > 500);
    let report = driver.stop();
    for key in RUN_KEYS {
        assert!(report.get(key).is_some(), "no {key}: {report:#}");
    }
    let last = client.latest();
    close(&report["rate_hz"], RATE_HZ);
    assert_eq!((report["channels"].as_u64(), report["cycles"].as_u64()), (Some(2), Some(last.cycle)), "{report:#}");
    assert_eq!(report["missed"].as_u64(), Some(last.missed), "{report:#}");
    assert_eq!(report["rig"], rig.name.as_str());
    // The channels in the rig's order, as they were at the end.
    for (i, name) in ["left", "right"].into_iter().enumerate() {
        let (told, state) = (&report["channel"][i], last.channels()[i]);
        assert_eq!(told["name"], name);
        close(&told["length_m"], state.length_m);
        assert_eq!(told["fault"], Value::Null);
    }
    // The means of real time, one by one: whatever was refused comes with what to type.
    let rows = report["rt"]["rows"].as_array().unwrap_or_else(|| panic!("{report:#}"));
    assert!(!rows.is_empty());
    for row in rows {
        let remedy = row["remedy"].as_str().unwrap();
        assert_eq!(row["granted"].as_bool().unwrap(), remedy.is_empty(), "{row:#}");
    }
}

#[test]
fn an_earlier_report_is_replaced_as_a_whole_and_only_at_the_end() {
    let rig = Rig::bench(&["left"], "");
    let path = rig.file("report.json");
    let earlier = "x".repeat(1 << 20);
    fs::write(&path, &earlier).unwrap();
    let process = Process::start(rig.command(&["--for", "300"]).arg("--report").arg(&path));
    let client = {
        wait_until("the driver", || sinew_ipc::Client::connect(&rig.name).is_ok());
        rig.client()
    };
    wait_until("a cycle", || client.latest().cycle > 0);
    assert_eq!(fs::read_to_string(&path).unwrap(), earlier);
    process.signal(libc::SIGTERM);
    process.finish().expect(0);
    let report: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).expect("nothing but the new one");
    sinew_tests::check_report(&report);
}

#[test]
fn a_killed_driver_leaves_an_earlier_report_alone() {
    let rig = Rig::bench(&["left"], "");
    let path = rig.file("report.json");
    fs::write(&path, "an earlier report").unwrap();
    let process = Process::start(rig.command(&["--for", "60"]).arg("--report").arg(&path));
    wait_until("the driver", || sinew_ipc::Client::connect(&rig.name).is_ok());
    process.kill();
    assert_eq!(fs::read_to_string(&path).unwrap(), "an earlier report");
}

/// Everything that makes a driver's other threads busy, while the loop has to go on without a single allocation.
#[test]
fn whatever_clients_do_the_loop_allocates_nothing() {
    let faults = "\n[[simulation.fault]]\nchannel = \"right\"\nkind = \"open_wire\"\nstart_s = 3.0\nend_s = 4.0\n";
    let rig = Rig::bench(&["left", "right"], faults);
    let (driver, client) = Driver::ready(&rig);
    for round in 0..20 {
        let visitor = rig.client();
        let mut stream = visitor.stream().unwrap();
        visitor.set_stroke("left", 0.02 * f64::from(round), Duration::from_millis(5)).unwrap();
        visitor.set_duty("left", f64::NAN, LONG).unwrap_err();
        visitor.set_force("left", 1.7, LONG).unwrap();
        visitor.off("left").unwrap();
        wait_until("a cycle of the stream", || stream.next().unwrap().is_some());
    }
    wait_until("the fault", || client.latest().channels()[1].mode() == Mode::Fault);
    wait_until("the reset", || client.reset("right").is_ok());
    assert_eq!(client.loop_stats().allocations, 0);
    // `stop` checks the report's own count.
    let report = driver.stop();
    assert_eq!(report["faults_not_listed"], 0, "{report:#}");
}

#[test]
fn status_has_the_contracts_form() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    client.set_stroke("left", 0.4, LONG).unwrap();
    wait_until("the wire to warm up", || client.latest().channels()[0].temperature_c > 40.0);
    let status = rig.ask(&["status", "--json"]).expect(0).json();
    assert_eq!(status["schema"], "sinew.status/1");
    assert_eq!(status["rig"], rig.name.as_str());
    assert_eq!(status["pid"].as_u64(), Some(driver.pid().into()));
    assert_eq!(status["channels"], 2);
    assert_eq!(status["allocations_in_loop"], 0);
    close(&status["rate_hz"], RATE_HZ);
    assert!(status["cycles"].as_u64().unwrap() > 0);
    let channels = status["channel"].as_array().unwrap();
    assert_eq!(channels.len(), 2);
    for (channel, info) in channels.iter().zip(client.channels()) {
        let number = |key: &str| channel[key].as_f64().unwrap_or_else(|| panic!("{key}: {channel:#}"));
        assert_eq!(channel["name"], info.name.as_str());
        assert!(channel.get("fault").is_some_and(Value::is_null), "{channel:#}");
        assert!((0.0..=1.0).contains(&number("duty")), "{channel:#}");
        assert!((0.0..10.0).contains(&number("age_s")), "{channel:#}");
        assert!((20.0..200.0).contains(&number("temperature_c")), "{channel:#}");
        assert!((0.0..=1.0).contains(&number("martensite")), "{channel:#}");
        assert!((8.0..13.0).contains(&number("resistance_ohm")), "{channel:#}");
        assert!((0.0..6.0).contains(&number("power_w")), "{channel:#}");
        assert!((0.155..0.170).contains(&number("length_m")), "{channel:#}");
    }
    close(&channels[0]["target_m"], client.channels()[0].length_at_stroke(0.4));
    assert!(channels[0]["temperature_c"].as_f64() > channels[1]["temperature_c"].as_f64());
    assert_eq!(channels[1]["target_m"], Value::Null);
    // And in words.
    let text = rig.ask(&["status"]).expect(0).stdout;
    for word in [rig.name.as_str(), "left", "right", "length"] {
        assert!(text.contains(word), "no {word}: {text}");
    }
    assert!(!text.contains("NaN"), "{text}");
    driver.stop();
}

/// A driver that dies is not mistaken for one that works: `status` of its rig says that there is none.
#[test]
fn status_of_a_dead_driver_says_so() {
    let rig = Rig::bench(&["left"], "");
    let driver = Driver::start(&rig);
    driver.process.kill();
    let said = rig.ask(&["status", "--json"]);
    assert!(matches!(said.code, Some(1 | 2)) && said.stdout.is_empty(), "{said:?}");
    assert!(said.stderr.contains(&rig.name), "{said:?}");
}
