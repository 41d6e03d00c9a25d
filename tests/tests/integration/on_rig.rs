//! `sinew test … --rig NAME`: the routines of the test machine on a wire of a running driver, as an ordinary client of it.

use std::process::Command;
use std::time::Duration;

use serde_json::Value;
use sinew_ipc::Mode;
use sinew_tests::{Driver, Process, RATE_HZ, Rig, SENSING_DUTY, run, sinew, wait_until};

/// A wire that is so thin that it is cold in seconds, under a mass.
fn thin() -> Rig {
    let mut rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = {RATE_HZ:?}\n"));
    rig.add(
        "\n[[channel]]\nname = \"hung\"\n\
         wire = { diameter_mm = 0.05, length_mm = 160.0 }\n\
         taps = { ls_mm = 150.0 }\n\
         drive = { supply_v = 7.0, shunt_ohm = 0.5 }\n\
         load = { mass_kg = 0.03, damping_n_s_per_m = 5.0 }\n",
    );
    rig
}

/// `sinew test ROUTINE … --rig NAME`, at work.
fn begin(rig: &Rig, args: &[&str]) -> Process {
    Process::start(Command::new(sinew()).arg("test").args(args).args(["--rig", &rig.name]))
}

/// A minute of a duty.
fn long(rig: &Rig) -> String {
    let path = rig.file("long.csv");
    std::fs::write(&path, "time_s,duty\n0,0.2\n30,0.2\n60,0.2\n").unwrap();
    path.display().to_string()
}

/// Waits until the wire is heated by it.
fn heats(client: &sinew_ipc::Client) {
    wait_until("the wire to be heated", || client.latest().channels()[0].duty > 0.1);
}

#[test]
fn a_sweep_runs_on_a_running_rig_and_its_recording_is_what_the_model_takes() {
    let rig = thin();
    let (driver, observer) = Driver::ready(&rig);
    let out = rig.file("sweep");
    let folder = out.display().to_string();
    let args = ["constant-force-sweep", "--frequencies", "0.5Hz", "--cycles", "1", "--out", &folder, "--json"];
    let report = begin(&rig, &args).finish().expect(0).json();
    assert_eq!((&report["ending"], &report["partial"]), (&Value::from("complete"), &Value::from(false)), "{report:#}");
    let said = |key: &str| report["running"][key].as_str().unwrap_or("").to_string();
    assert!(said("position").contains("dual measurement, taps 150 mm apart"), "{report:#}");
    assert!(said("load").contains("a mass of 0.03 kg"), "{report:#}");
    let findings = report["findings"].as_array().unwrap();
    let found = |key: &str| findings.iter().find(|f| f["key"] == key).and_then(|f| f["value"].as_f64()).unwrap();
    assert!((0.3..6.0).contains(&found("stroke_mm")), "{report:#}");
    assert!(found("force_error_n") < 0.1, "{report:#}");
    // nothing is left behind at the driver
    let left = observer.latest().channels()[0];
    assert_eq!((left.mode(), left.owner, left.fault()), (Mode::Off, 0, None));
    for name in ["report.html", "report.json", "picture.svg", "rig.toml", "constant-force-sweep.mcap"] {
        assert!(out.join(name).is_file(), "{name}");
    }
    let file = |name: &str| out.join(name).display().to_string();
    let simulated = rig.file("simulated.csv").display().to_string();
    run(["simulate", &file("rig.toml"), &file("constant-force-sweep.mcap"), "-o", &simulated]).expect(0);
    // every cycle of the time that counts, at the loop's rate
    let info = run(["recording", "info", &file("constant-force-sweep.mcap"), "--json"]).expect(0).json();
    let (cycles, rows) = (info["cycles"].as_f64().unwrap(), report["rows"].as_f64().unwrap());
    assert!(cycles > 0.9 * 5.0 * rows, "{cycles} cycles, {rows} rows");
    driver.stop();
}

#[test]
fn killed_in_the_middle_of_heating_it_leaves_the_wire_off() {
    let rig = thin();
    let (driver, observer) = Driver::ready(&rig);
    let tester = begin(&rig, &["programme", &long(&rig)]);
    heats(&observer);
    assert_eq!(observer.latest().channels()[0].owner, tester.pid());
    let refused = observer.set_duty("hung", 0.3, Duration::from_secs(1)).unwrap_err();
    assert!(refused.message().contains("claimed"), "{refused}");
    tester.kill();
    wait_until("the lease to run out", || observer.latest().channels()[0].mode() == Mode::Lapsed);
    let left = observer.latest().channels()[0];
    assert_eq!((left.duty, left.fault()), (SENSING_DUTY, None));
    let report = driver.stop();
    assert_eq!(report["leases_lapsed"], 1, "{report:#}");
}

#[test]
fn it_ends_in_order_when_it_is_interrupted_or_taken_over() {
    let rig = thin();
    let (driver, observer) = Driver::ready(&rig);
    let out = rig.file("played");
    let folder = out.display().to_string();
    let programme = long(&rig);
    let args = ["programme", &programme, "--out", &folder, "--json"];

    let tester = begin(&rig, &args);
    heats(&observer);
    tester.signal(libc::SIGINT);
    let report = tester.finish().expect(0).json();
    assert_eq!(report["partial"], Value::from(true), "{report:#}");
    let left = observer.latest().channels()[0];
    assert_eq!((left.mode(), left.owner), (Mode::Off, 0));
    run(["recording", "info", &out.join("programme.mcap").display().to_string()]).expect(0);

    // by a higher priority: what the new owner asks for stays in force
    let tester = begin(&rig, &args);
    heats(&observer);
    observer.claim(&[0], 9, Duration::from_secs(60)).unwrap();
    observer.set_duty("hung", 0.1, Duration::from_secs(60)).unwrap();
    let ended = tester.finish().expect(1);
    assert!(ended.stderr.contains("programme: ended by the rig: ") && ended.stderr.contains("claimed"), "{ended:#?}");
    assert!(ended.stderr.contains("what was recorded until then is whole"), "{ended:#?}");
    assert_eq!(ended.json()["partial"], Value::from(true));
    let left = observer.latest().channels()[0];
    assert_eq!((left.mode(), left.duty), (Mode::Duty, 0.1));
    run(["recording", "info", &out.join("programme.mcap").display().to_string()]).expect(0);
    driver.stop();
}

#[test]
fn a_fault_ends_it_and_keeps_what_was_recorded() {
    let mut rig = thin();
    rig.add("\n[[simulation.fault]]\nchannel = \"hung\"\nkind = \"open_wire\"\nstart_s = 12.0\nend_s = 1000.0\n");
    let (driver, observer) = Driver::ready(&rig);
    let out = rig.file("played");
    let programme = long(&rig);
    let ended = begin(&rig, &["programme", &programme, "--out", &out.display().to_string()]).finish().expect(1);
    assert!(ended.stderr.contains("ended by the rig: fault open_wire"), "{ended:#?}");
    assert!(
        ended.stderr.contains("hint: ") && ended.stderr.contains("what was recorded until then is whole"),
        "{ended:#?}"
    );
    assert!(ended.stdout.contains("partial"), "{ended:#?}");
    assert_eq!(observer.latest().channels()[0].mode(), Mode::Fault);
    // and nothing is begun on it again before somebody has looked after it
    begin(&rig, &["programme", &programme]).finish().refused(&["hung has a fault: open_wire", "sinew reset hung"]);
    driver.stop();
}

#[test]
fn what_a_rig_has_not_is_refused_before_anything_is_heated() {
    let mut rig = thin();
    rig.add(
        "\n[[channel]]\nname = \"flexor\"\nwire = { diameter_mm = 0.05, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\ndrive = { supply_v = 12.0 }\n\
         \n[[channel]]\nname = \"extensor\"\nwire = { diameter_mm = 0.05, length_mm = 160.0 }\ntaps = { ls_mm = 150.0 }\ndrive = { supply_v = 12.0 }\n\
         \n[[joint]]\nname = \"knee\"\nagonist = \"flexor\"\nantagonist = \"extensor\"\nradius_mm = 8.0\ninertia_kg_mm2 = 2.5\n",
    );
    let (driver, observer) = Driver::ready(&rig);
    let moved = rig.file("moved.csv");
    std::fs::write(&moved, "time_s,power_w,position_m\n0,0.1,0\n1,0.1,0\n2,0.1,0\n").unwrap();
    let moved = moved.display().to_string();
    let hung = ["--channel", "hung"];
    let cases: [(&[&str], &[&str]); 12] = [
        (
            &["direct-strain"],
            &["direct-strain needs a cross-head that pulls the wire's end, and a load cell", "constant-force-sweep"],
        ),
        (&["direct-load"], &["needs a cross-head that changes the load"]),
        (&["constant-strain-sweep"], &["needs a clamp that holds the wire's end"]),
        (&["constant-force-sweep", "--chamber", "60C"], &["--chamber: the running rig", "has no chamber"]),
        (&["constant-force-sweep", "--load", "1N"], &["--load: the running rig", "[channel.load]"]),
        (&["position-regulation", "--controller", "pid"], &["--controller: the running rig", "[channel.control]"]),
        (&["position-regulation", "--places", "1,30%"], &["--places: a strain of 30.000 % is out of hung's reach"]),
        (&["constant-force-sweep", "--heating", "power=0-5W"], &["a heating of 5.000 W is more than hung takes"]),
        (&["constant-force-sweep", "--truth", "true.toml"], &["--truth: the wire of a running rig is what it is"]),
        (&["programme", &moved], &["position_m moves the wire's end", "take the column out"]),
        (&["break-in", "--channel", "flexor"], &["channel \"flexor\" turns joint \"knee\" against another wire"]),
        (&["break-in", "--channel", "hing"], &["hing", "hung"]),
    ];
    for (args, words) in cases {
        let chosen: &[&str] = if args.contains(&"--channel") { &[] } else { &hung };
        begin(&rig, &[args, chosen].concat()).finish().refused(words);
    }
    run(["test", "break-in", "--rig", "nobody"]).refused(&["nobody"]);
    let state = observer.latest().channels()[0];
    assert_eq!(
        (state.mode(), state.owner, state.duty),
        (Mode::Off, 0, SENSING_DUTY),
        "nobody has asked anything of it"
    );
    driver.stop();
}
