//! One hostile account on the machine: whatever it puts where anybody may write, nobody else's driver is stopped by it, nothing of the driver's is
//! learnt, nothing of the account's is touched, and nothing it points to is followed.
//!
//! It takes root, to be other users; without it these tests say so and are skipped. `cargo test -p sinew-tests --test integration neighbours::
//! -- --nocapture` prints what it costs.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;
use sinew_tests::{Finished, Process, wait_until};

use crate::access::{Bench, COMMANDER, DRIVER, READER, STRANGER, User, both_groups, can_be_others};

/// What the hostile account puts into /dev/shm, and into /tmp under the very name of the driver's folder.
const CROWD: usize = 10_000;
const NAMESAKES: usize = 1000;

/// The driver's user has one folder in /tmp: one test at a time.
static FOLDER: Mutex<()> = Mutex::new(());

/// What somebody's program left where anybody may write, gone with the test.
struct Cleared {
    folder: &'static str,
    user: User,
}

impl Drop for Cleared {
    fn drop(&mut self) {
        for path in theirs(self.folder, self.user) {
            let _ = if path.is_dir() && !path.is_symlink() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
    }
}

/// What there is of a user's in a folder.
fn theirs(folder: &str, user: User) -> Vec<PathBuf> {
    let all = fs::read_dir(folder).expect("there").flatten().map(|entry| entry.path());
    all.filter(|path| fs::symlink_metadata(path).is_ok_and(|found| found.uid() == user.id)).collect()
}

fn named(paths: Vec<PathBuf>, begins: &str) -> Vec<PathBuf> {
    let bears = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(begins));
    paths.into_iter().filter(bears).collect()
}

/// A program of the driver's user, who has no folder of a login's.
fn without_a_login(bench: &Bench, args: &[&str]) -> Process {
    let mut command = bench.by(DRIVER, "sinew");
    Process::start(command.args(args).env_remove("SINEW_RUNTIME_DIR").env_remove("XDG_RUNTIME_DIR"))
}

fn ask(bench: &Bench, args: &[&str]) -> Finished {
    without_a_login(bench, &[args, &["--rig", &bench.rig.name]].concat()).finish()
}

/// Median time that a driver takes to start, run for a moment and end, s.
fn comes_and_goes_s(bench: &Bench) -> f64 {
    let rig = bench.rig.path();
    let mut times: Vec<f64> = (0..5)
        .map(|_| {
            let since = Instant::now();
            without_a_login(bench, &["run", rig.to_str().expect("UTF-8"), "--no-monitor", "--for", "0.1"])
                .finish()
                .expect(0);
            since.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Starts a driver and waits until it answers its own user.
fn drive(bench: &Bench) -> Process {
    let rig = bench.rig.path();
    let mut driver = without_a_login(bench, &["run", rig.to_str().expect("UTF-8"), "--no-monitor", "--for", "300"]);
    wait_until("the driver, seen by its own user", || {
        assert!(driver.ended().is_none(), "{}", driver.stderr());
        ask(bench, &["status"]).code == Some(0)
    });
    driver
}

#[test]
fn a_crowd_of_foreign_files_under_our_names_stops_nobody_and_is_left_alone() {
    if !can_be_others() {
        return;
    }
    let _alone = FOLDER.lock().unwrap_or_else(PoisonError::into_inner);
    let bench = Bench::new(&both_groups());
    let _gone = [
        Cleared { folder: "/dev/shm", user: STRANGER },
        Cleared { folder: "/tmp", user: STRANGER },
        Cleared { folder: "/dev/shm", user: DRIVER },
        Cleared { folder: "/tmp", user: DRIVER },
    ];
    let undisturbed_s = comes_and_goes_s(&bench);
    // As if nobody had been there before.
    drop(Cleared { folder: "/tmp", user: DRIVER });
    drop(Cleared { folder: "/dev/shm", user: DRIVER });

    let precious = bench.own_folder(DRIVER).join("precious");
    fs::write(&precious, "precious").expect("root may");
    let target = precious.to_str().expect("UTF-8");
    let (home, heat) = (format!("/tmp/sinew-{}", DRIVER.id), format!("/dev/shm/sinew-heat-{}", DRIVER.id));
    bench.intruder(STRANGER, &["take", &home, &heat]).finish().expect(0);
    let litter = |folder: &str, count: usize, prefix: &str| {
        let mut intruder = bench.intruder(STRANGER, &["litter", folder, &count.to_string(), prefix, target]);
        intruder.wait_for_word("littered");
        intruder
    };
    let crowds = [
        litter("/dev/shm", CROWD, "sinew_0123456789_"),
        litter("/dev/shm", NAMESAKES, &format!("sinew-heat-{}-", DRIVER.id)),
        litter("/tmp", NAMESAKES, &format!("sinew-{}-", DRIVER.id)),
    ];
    let count = || (theirs("/dev/shm", STRANGER).len(), theirs("/tmp", STRANGER).len());
    let before = count();
    assert!(before.0 > CROWD && before.1 > NAMESAKES, "{before:?}");

    let crowded_s = comes_and_goes_s(&bench);
    println!("a driver comes and goes in {undisturbed_s:.2} s, beside {CROWD} foreign files in {crowded_s:.2} s");
    let driver = drive(&bench);
    ask(&bench, &["set", "left", "stroke=20%", "--hold", "60"]).expect(0);
    // Clients that are killed are cleared away all the same.
    let own = || named(theirs("/dev/shm", DRIVER), "sinew_").len();
    let alone = own();
    let clients: Vec<Process> = (0..10)
        .map(|_| {
            let mut command = bench.by(DRIVER, "sinew-test-robot");
            command.arg(&bench.rig.name).arg("stream");
            let mut client = Process::start(command.env_remove("SINEW_RUNTIME_DIR").env_remove("XDG_RUNTIME_DIR"));
            client.wait_for_word("streaming");
            client
        })
        .collect();
    assert!(own() > alone, "they have memory of their own");
    clients.into_iter().for_each(Process::kill);
    let since = Instant::now();
    wait_until("what killed clients left to be cleared away", || own() <= alone);
    println!("ten killed clients are cleared away after {:.1} s", since.elapsed().as_secs_f64());

    // Nothing of the driver's is open to others.
    let ours: Vec<PathBuf> =
        [named(theirs("/dev/shm", DRIVER), "sinew"), named(theirs("/tmp", DRIVER), &format!("sinew-{}", DRIVER.id))]
            .concat();
    assert!(ours.iter().any(|path| path.starts_with("/tmp")), "its folder has another name: {ours:?}");
    for path in &ours {
        let mode = fs::symlink_metadata(path).expect("there").mode();
        assert_eq!(mode & 0o077, 0, "{}: {mode:o}", path.display());
    }
    let paths: Vec<&str> = ours.iter().map(|path| path.to_str().expect("UTF-8")).collect();
    for user in [STRANGER, READER, COMMANDER] {
        bench.intruder(user, &[&["files"], &paths[..]].concat()).finish().expect(0);
    }
    driver.signal(libc::SIGTERM);
    driver.finish().expect(0);
    assert_eq!(own(), 0, "nothing is left of it");
    for crowd in crowds {
        assert!(!crowd.stdout().contains("holds"), "{}", crowd.stdout());
        crowd.kill();
    }
    assert_eq!(count(), before, "foreign files are touched");
    assert_eq!(fs::read_to_string(&precious).expect("still there"), "precious");
}

/// Somebody who sees the name of a run as soon as there is a file of it, and is quicker than the driver at making the next one.
#[test]
fn a_chase_after_the_names_of_a_run_stops_no_start() {
    if !can_be_others() {
        return;
    }
    let _alone = FOLDER.lock().unwrap_or_else(PoisonError::into_inner);
    let bench = Bench::new(&both_groups());
    let _gone = Cleared { folder: "/dev/shm", user: STRANGER };
    let undisturbed_s = comes_and_goes_s(&bench);
    let mut chase = bench.intruder(STRANGER, &["chase", "15"]);
    chase.wait_for_word("chasing");
    let chased_s = comes_and_goes_s(&bench);
    let driver = drive(&bench);
    for _ in 0..5 {
        ask(&bench, &["set", "left", "stroke=20%", "--hold", "60"]).expect(0);
    }
    driver.signal(libc::SIGTERM);
    driver.finish().expect(0);
    let said = chase.finish().expect(0).stdout;
    println!("a driver comes and goes in {undisturbed_s:.2} s, chased in {chased_s:.2} s; the chaser {said}");
    assert!(!said.contains("made 0"), "he has made something: {said}");
}

/// Strangers who knock as often as they can keep nobody out.
#[test]
fn a_flood_of_knocks_at_the_door_keeps_nobody_out() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new(&both_groups());
    let driver = bench.drive();
    let door = bench.door();
    let time = |floods: &str| {
        let mut times: Vec<f64> = (0..9)
            .map(|_| {
                let since = Instant::now();
                bench.ask(COMMANDER, &["set", "left", "stroke=20%", "--hold", "60"]).expect(0);
                since.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!(
            "an order of a commander's, with its own program: {:.0} ms {floods}, at worst {:.0} ms",
            times[4], times[8]
        );
    };
    time("undisturbed");
    let mut floods: Vec<Process> =
        (0..3).map(|seed| bench.intruder(STRANGER, &["rubbish", &door, "6", &seed.to_string()])).collect();
    std::thread::sleep(Duration::from_millis(200));
    time("beside three floods");
    for flood in &mut floods {
        wait_until("the flood to end", || flood.ended().is_some());
    }
    let report: Value = bench.stop(driver);
    assert_eq!(report["unpublished"], 0, "{report:#}");
    assert!(!Path::new(&door).exists());
}
