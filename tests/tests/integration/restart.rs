//! Drivers that are killed and started again, with wires that go on being what they are: the front-end's, which outlives them all. Their true
//! temperature stays within what they may have, whoever drives them in between.
//!
//! (Whether the same demand gets the same duty again is measured on a simulated clock: `sinew-trust restart`.)

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use sinew_ipc::{Client, Mode};
use sinew_tests::{Driver, Process, Rig, front_end, wait_until};
use tempfile::TempDir;

use crate::access::{STRANGER, can_be_others, programs};

const LONG: Duration = Duration::from_secs(120);
const LOOK: Duration = Duration::from_millis(20);
/// Slow, on a machine with other work.
const RATE_HZ: f64 = 50.0;
/// How far beyond its limit a wire may come, K.
const PROMISED_K: f64 = 10.0;
/// What the wires are told to do: half of the stroke, and more than they may have for long.
const WIRES: [&str; 2] = ["half", "full"];

fn bench(rate_hz: f64, port: Option<&Path>) -> Rig {
    let mut rig = Rig::named(|name| format!("[rig]\nname = \"{name}\"\nrate_hz = {rate_hz:?}\n"));
    for name in WIRES {
        rig.add(&Rig::wire(name));
    }
    let port = port.map_or_else(|| rig.file("front-end"), Path::to_path_buf);
    rig.add(&format!(
        "\n[backend]\nkind = \"serial\"\nserial.port = \"{}\"\nserial.watchdog_periods = 8\n",
        port.display()
    ));
    rig
}

/// The wires and their front-end, and how hot they really are.
struct Wires {
    rig: Rig,
    /// In memory: a front-end that waits for a disk is late.
    folder: TempDir,
    _front_end: Process,
}

impl Wires {
    #[track_caller]
    fn start() -> Wires {
        let rig = bench(RATE_HZ, None);
        let folder = tempfile::Builder::new().prefix("sinew-truth-").tempdir_in("/dev/shm").expect("a folder");
        let mut command = Command::new(front_end());
        command.arg(rig.path()).arg("--link").arg(rig.file("front-end")).args(["--for", "300"]);
        let mut front_end = Process::start_to_be_told(command.arg("--truth").arg(folder.path().join("truth.csv")));
        front_end.wait_for_word("\"event\":\"port\"");
        Wires { rig, folder, _front_end: front_end }
    }

    fn truth(&self) -> String {
        fs::read_to_string(self.folder.path().join("truth.csv")).expect("written all along")
    }

    /// The hottest that any of them ever was, °C.
    fn hottest_c(&self) -> f64 {
        let rows = self.truth();
        let whole = rows.lines().skip(1).filter(|row| row.split(',').count() == 1 + WIRES.len());
        whole.flat_map(|row| row.split(',').skip(1)).filter_map(|value| value.parse().ok()).fold(0.0, f64::max)
    }

    /// How hot they are now, °C.
    fn now_c(&self) -> Vec<f64> {
        let rows = self.truth();
        let mut whole = rows.lines().rev().skip(1).filter(|row| row.split(',').count() == 1 + WIRES.len());
        whole.next().map(|row| row.split(',').skip(1).filter_map(|v| v.parse().ok()).collect()).unwrap_or_default()
    }

    #[track_caller]
    fn stayed_within(&self, limit_c: f64) {
        let hottest_c = self.hottest_c();
        assert!(hottest_c <= limit_c + PROMISED_K, "{hottest_c} °C, may have {limit_c} °C");
    }
}

fn limit_c(client: &Client) -> f64 {
    client.info().channels()[0].max_temperature_c
}

/// Whether the sensors have proved themselves and nothing is wrong.
fn is_ready(client: &Client) -> bool {
    client.latest().channels().iter().all(|state| !matches!(state.mode(), Mode::Waiting | Mode::Fault))
}

/// Makes the demands, as soon as they are taken.
#[track_caller]
fn demand(client: &Client) {
    wait_until("demands to be taken", || {
        thread::sleep(10 * LOOK);
        let full = client.info().channels()[1].max_duty;
        // A front-end that is a process is late on a busy machine.
        for name in client
            .latest()
            .channels()
            .iter()
            .zip(WIRES)
            .filter(|(state, _)| state.fault().is_some())
            .map(|(_, name)| name)
        {
            let _ = client.reset(name);
        }
        is_ready(client)
            && client.set_stroke(WIRES[0], 0.5, LONG).is_ok()
            && client.set_duty(WIRES[1], full, LONG).is_ok()
    });
}

/// As a service manager does it: at once, again and again, also before anything was asked of the one before.
#[test]
fn a_loop_of_kills_and_restarts_burns_no_wire() {
    let wires = Wires::start();
    let mut limit = 0.0;
    for round in 0..9 {
        let driver = Driver::start(&wires.rig);
        if round % 3 == 0 {
            let client = wires.rig.client();
            demand(&client);
            thread::sleep(Duration::from_millis(1500));
            limit = limit_c(&client);
        }
        driver.process.kill();
    }
    wires.stayed_within(limit);
    assert!(wires.hottest_c() > 100.0, "it was heated: {} °C", wires.hottest_c());
}

#[test]
fn another_rig_file_on_the_same_outputs_goes_on_from_the_same_heat() {
    let wires = Wires::start();
    let other = bench(RATE_HZ, Some(&wires.rig.file("front-end")));
    let mut limit = 0.0;
    for round in 0..6 {
        let rig = if round % 2 == 0 { &wires.rig } else { &other };
        let driver = Driver::start(rig);
        let client = rig.client();
        demand(&client);
        thread::sleep(Duration::from_millis(1500));
        limit = limit_c(&client);
        drop(client);
        driver.process.kill();
    }
    wires.stayed_within(limit);
    assert!(wires.hottest_c() > 100.0, "it was heated: {} °C", wires.hottest_c());
}

/// Its wires were heated by somebody else's driver: nothing that was remembered of them holds.
#[test]
fn another_users_session_in_between_makes_the_history_unknown() {
    if !can_be_others() {
        return;
    }
    let wires = Wires::start();
    // A cold wire that is known to be cold.
    let (driver, client) = Driver::ready(&wires.rig);
    let limit = limit_c(&client);
    wait_until("a wire that is known to be cold", || client.latest().channels()[1].temperature_c < 40.0);
    drop(client);
    driver.process.kill();

    // The exclusion of a terminal that is a line outlives its last user only here, where its other end stays open.
    let line = fs::File::open(wires.rig.file("front-end")).expect("root may");
    rustix::termios::ioctl_tiocnxcl(&line).expect("a terminal");
    drop(line);
    let pty = fs::canonicalize(wires.rig.file("front-end")).expect("a link to the line");
    fs::set_permissions(&pty, Permissions::from_mode(0o666)).expect("ours");
    let folder = tempfile::Builder::new().prefix("so-").tempdir().expect("a folder");
    fs::set_permissions(folder.path(), Permissions::from_mode(0o777)).expect("ours");
    let other = bench(RATE_HZ, Some(&pty));
    let copy = folder.path().join("rig.toml");
    fs::copy(other.path(), &copy).expect("room for a copy");
    fs::set_permissions(&copy, Permissions::from_mode(0o644)).expect("ours");
    let as_stranger = |program: &str| {
        let mut command = Command::new("setpriv");
        command
            .arg(format!("--reuid={}", STRANGER.id))
            .arg("--regid=64300")
            .arg(format!("--groups={}", STRANGER.group));
        command.arg(programs().join(program)).current_dir(folder.path());
        let own = folder.path().join("own");
        command.env("SINEW_RUNTIME_DIR", &own).env("SINEW_STATE_DIR", &own);
        command
    };
    let mut theirs = Process::start(as_stranger("sinew").args(["run", "rig.toml", "--no-monitor", "--for", "60"]));
    wait_until("the wires to be hot", || {
        thread::sleep(LOOK);
        assert!(theirs.ended().is_none(), "{}", theirs.stderr());
        Process::start(as_stranger("sinew").args(["set", WIRES[1], "duty=80%", "--hold", "60", "--rig", &other.name]))
            .finish();
        wires.now_c().get(1).is_some_and(|now_c| *now_c > 110.0)
    });
    theirs.kill();

    let driver = Driver::start(&wires.rig);
    let client = wires.rig.client();
    let mut most_c: f64 = 0.0;
    let mut under_k: f64 = 0.0;
    let since = Instant::now();
    while since.elapsed() < Duration::from_secs(2) {
        let believed_c = client.latest().channels()[1].temperature_c;
        most_c = most_c.max(believed_c);
        under_k = under_k.max(wires.now_c().get(1).map_or(0.0, |now_c| now_c - believed_c));
        thread::sleep(LOOK);
    }
    // The front-end says for how long nothing was put out, and the wire has cooled since.
    assert!(most_c > 0.7 * limit, "believed at {most_c} °C, limit {limit} °C");
    assert!(under_k < PROMISED_K, "published {under_k} K under the truth");
    demand(&client);
    thread::sleep(Duration::from_secs(2));
    wires.stayed_within(limit);
    drop(client);
    driver.stop();
}
