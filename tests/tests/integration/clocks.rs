//! A driver's stamps beside other clocks: a client's, in another process than the driver, and a recording's afterwards, with a system clock that is
//! set meanwhile.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use sinew_recording::session::Session;
use sinew_tests::{Driver, Process, RATE_HZ, Rig, recorded_so_far, run, sinew, wait_for, wait_until};

fn system_ns() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64
}

#[test]
fn a_client_and_a_recording_agree_on_the_time_of_day_of_a_drivers_stamps() {
    let rig = Rig::bench(&["left"], "");
    let (driver, client) = Driver::ready(&rig);
    let file = rig.file("walk.mcap");
    let mut command = Command::new(sinew());
    let recorder =
        Process::start(command.arg("record").arg(&file).args(["--rig", &rig.name, "--for", "1.5", "--json"]));

    // by the standard library, independently: a cycle that came between two times of day was sampled at most so long before
    let before = system_ns();
    let cycle = client.latest().cycle;
    wait_until("a new cycle", || client.latest().cycle > cycle + 1);
    let stamp = client.latest().monotonic_ns;
    let after = system_ns();
    let clocks = client.clocks();
    let at = clocks.system(stamp);
    let (error, period) = (at.error_ns as i64, (1e9 / RATE_HZ) as i64);
    assert!(before - period - error <= at.ns && at.ns <= after + error, "{before} {at:?} {after}");
    assert_eq!(clocks.reading().driver_at_system(at.ns).ns, stamp);

    recorder.finish().expect(0);
    let session = Session::open(&file).unwrap();
    let history = session.clock_history().unwrap().unwrap();
    assert!(history.readings().len() >= 2, "at the start and at the end: {history:?}");
    assert!(session.clocks().unwrap().starts_with(&history.readings()[..1]), "the same, one by one");
    assert_eq!(history.steps().count(), 0);
    let recorded = history.system(stamp).unwrap();
    assert!(recorded.ns.abs_diff(at.ns) <= recorded.error_ns + at.error_ns, "{recorded:?} {at:?}");
    let about = session.about();
    assert!(about.unix_ns(stamp).abs_diff(recorded.ns as u64) <= 2 * recorded.error_ns, "log_time is by the same");
    driver.stop();
}

/// The shim that the trust tests set clocks by; `None` without a C compiler.
fn shim(folder: &Path) -> Option<std::path::PathBuf> {
    let library = folder.join("clock.so");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/trust/shim/clock.c");
    let built = Command::new("cc").args(["-shared", "-fPIC", "-O2", "-o"]).arg(&library).arg(source).status();
    built.is_ok_and(|built| built.success()).then_some(library)
}

#[test]
fn a_recording_says_when_the_system_clock_was_set_and_its_own_times_do_not_jump() {
    let rig = Rig::bench(&["left"], "");
    let place = rig.file("clocks");
    let Some(library) = shim(place.parent().unwrap()) else { return eprintln!("skipped: no C compiler") };
    fs::write(&place, [0; 16]).unwrap();
    let (driver, _) = Driver::ready(&rig);
    let file = rig.file("set.mcap");
    let mut command = Command::new(sinew());
    command.arg("record").arg(&file).args(["--rig", &rig.name, "--json"]);
    let recorder = Process::start(command.env("LD_PRELOAD", &library).env("TRUST_CLOCKS", &place));
    let second = |least: f64| {
        wait_for("cycles in the file", || {
            Some(recorded_so_far(&file).len()).filter(|cycles| *cycles as f64 > least * RATE_HZ)
        })
    };
    second(1.0);
    // in place: the shim has the page mapped
    use std::os::unix::fs::FileExt;
    let clock = fs::OpenOptions::new().write(true).open(&place).unwrap();
    clock.write_all_at(&1_200_000_000i64.to_ne_bytes(), 0).unwrap();
    second(3.0);
    recorder.signal(libc::SIGINT);
    recorder.finish().expect(0);
    driver.stop();

    let info = run(["recording".as_ref(), "info".as_ref(), file.as_os_str(), "--json".as_ref()]).expect(0).json();
    let steps = info["clocks"]["steps"].as_array().unwrap();
    let figure = |key: &str| steps[0][key].as_f64().unwrap();
    assert_eq!(steps.len(), 1, "{info:#}");
    assert!((figure("by_s") - 1.2).abs() < 1e-4, "{info:#}");
    let (after_s, before_s) = (figure("after_s"), figure("before_s"));
    assert!(after_s < before_s && before_s - after_s < 1.0 && before_s > 0.5, "{info:#}");
    let text = run(["recording".as_ref(), "info".as_ref(), file.as_os_str()]).expect(0).stdout;
    assert!(text.contains("set forward by 1.200 s at"), "{text}");

    let session = Session::open(&file).unwrap();
    let history = session.clock_history().unwrap().unwrap();
    let (first, last) = session.span().unwrap().unwrap();
    let ahead = |ns: u64| history.system(ns).unwrap().ns - session.about().unix_ns(ns) as i64;
    assert!(ahead(first.monotonic_ns).abs() < 1_000_000);
    assert!((ahead(last.monotonic_ns) - 1_200_000_000).abs() < 1_000_000, "log_time goes on as it began");
    run(["recording".as_ref(), "doctor".as_ref(), file.as_os_str()]).expect(0);
}
