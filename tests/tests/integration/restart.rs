//! A driver that is killed and started again, with a wire that goes on being what it is: the front-end's, which outlives it. The same demand gets
//! the same duty as from one that was never disturbed, and the true temperature stays within what the wire may have, whoever drives it in
//! between.
//!
//! `cargo test -p sinew-tests --test integration restart:: -- --nocapture` prints the table of docs/trust.md.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use sinew_ipc::{Client, Mode};
use sinew_tests::{Driver, Process, Rig, front_end, sinew, wait_until};

use crate::access::{STRANGER, can_be_others, programs};

const LONG: Duration = Duration::from_secs(120);
const LOOK: Duration = Duration::from_millis(20);
/// Slow: several rigs at once, on a machine with other work.
const RATE_HZ: f64 = 50.0;
/// A demand has to have its duty again so long after it was made again.
const SETTLED: Duration = Duration::from_secs(3);
/// What a duty is averaged over.
const AVERAGED: Duration = Duration::from_millis(400);
/// How far beyond its limit a wire may come, K.
const PROMISED_K: f64 = 10.0;
/// What the wires are told to do: half of the stroke, and more than they may have for long.
const WIRES: [&str; 2] = ["half", "full"];
/// Longest that the undisturbed one is watched.
const WATCHED: Duration = Duration::from_secs(18);
/// Attempts at a measurement on a machine that lets its driver wait for too long.
const ATTEMPTS: usize = 4;

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
    _front_end: Process,
}

impl Wires {
    #[track_caller]
    fn start() -> Wires {
        let rig = bench(RATE_HZ, None);
        let mut command = Command::new(front_end());
        command.arg(rig.path()).arg("--link").arg(rig.file("front-end")).args(["--for", "300"]);
        let mut front_end = Process::start_to_be_told(command.arg("--truth").arg(rig.file("truth.csv")));
        front_end.wait_for_word("\"event\":\"port\"");
        Wires { rig, _front_end: front_end }
    }

    /// The hottest that any of them ever was, °C.
    fn hottest_c(&self) -> f64 {
        let rows = fs::read_to_string(self.rig.file("truth.csv")).expect("written all along");
        let whole = rows.lines().skip(1).filter(|row| row.split(',').count() == 1 + WIRES.len());
        whole.flat_map(|row| row.split(',').skip(1)).filter_map(|value| value.parse().ok()).fold(0.0, f64::max)
    }

    /// How hot they are now, °C.
    fn now_c(&self) -> Vec<f64> {
        let rows = fs::read_to_string(self.rig.file("truth.csv")).expect("written all along");
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
        thread::sleep(LOOK);
        let full = client.info().channels()[1].max_duty;
        is_ready(client)
            && client.set_stroke(WIRES[0], 0.5, LONG).is_ok()
            && client.set_duty(WIRES[1], full, LONG).is_ok()
    });
}

/// The duties of both wires, averaged around a time from now on; `None` where something has gone wrong meanwhile.
fn duties_in(client: &Client, wait: Duration) -> Option<[f64; 2]> {
    thread::sleep(wait.saturating_sub(AVERAGED / 2));
    let (since, mut cycle) = (Instant::now(), 0);
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    while since.elapsed() < AVERAGED {
        let latest = client.latest();
        if latest.channels().iter().any(|state| state.fault().is_some()) {
            return None;
        }
        if latest.cycle != cycle {
            cycle = latest.cycle;
            count += 1.0;
            sum.iter_mut().zip(latest.channels()).for_each(|(sum, state)| *sum += state.duty);
        }
        thread::sleep(Duration::from_millis(4));
    }
    Some(sum.map(|sum| sum / count))
}

/// The duties of a driver that nobody disturbs, by the time since the demand.
fn undisturbed() -> Option<Vec<(Duration, [f64; 2])>> {
    let wires = Wires::start();
    let driver = Driver::start(&wires.rig);
    let client = wires.rig.client();
    demand(&client);
    let since = Instant::now();
    let mut found = Vec::new();
    while since.elapsed() < WATCHED {
        let duties = duties_in(&client, AVERAGED / 2)?;
        found.push((since.elapsed().saturating_sub(AVERAGED / 2), duties));
    }
    wires.stayed_within(limit_c(&client));
    drop(client);
    driver.stop();
    Some(found)
}

/// What comes to pass in a run that is disturbed.
#[derive(Debug, Clone, Copy)]
struct Moment {
    what: &'static str,
    /// The driver is killed so long after the demand; `None`: before there was one.
    killed: Option<f64>,
    /// The next one comes after so long, s.
    pause_s: f64,
    /// And so many in between are killed as soon as they run.
    more: usize,
}

const MOMENTS: [Moment; 6] = [
    Moment { what: "cold", killed: None, pause_s: 0.0, more: 0 },
    Moment { what: "warming up, 0.7 s after the demand", killed: Some(0.7), pause_s: 0.0, more: 0 },
    Moment { what: "hot, 3 s after it", killed: Some(3.0), pause_s: 0.0, more: 0 },
    Moment { what: "hot, 8 s after it", killed: Some(8.0), pause_s: 0.0, more: 0 },
    Moment { what: "hot, and the next comes 2 s later", killed: Some(5.0), pause_s: 2.0, more: 0 },
    Moment { what: "hot, and 8 more are killed at once", killed: Some(4.0), pause_s: 0.0, more: 8 },
];

/// What a moment came to.
struct Row {
    /// The demand was taken again so long after the kill, s.
    taken_s: f64,
    /// Then, three seconds later, since the first demand, and the duties.
    at: Duration,
    duties: [f64; 2],
    hottest_c: f64,
    limit_c: f64,
}

fn disturbed(moment: &Moment) -> Option<Row> {
    let wires = Wires::start();
    let driver = Driver::start(&wires.rig);
    let client = wires.rig.client();
    wait_until("sensors to prove themselves", || is_ready(&client));
    let mut since = None;
    if let Some(killed_s) = moment.killed {
        demand(&client);
        since = Some(Instant::now());
        duties_in(&client, Duration::from_secs_f64(killed_s))?;
    }
    drop(client);
    driver.process.kill();
    let killed = Instant::now();
    thread::sleep(Duration::from_secs_f64(moment.pause_s));
    for _ in 0..moment.more {
        // As soon as its loop runs.
        Driver::start(&wires.rig).process.kill();
    }
    let driver = Driver::start(&wires.rig);
    let client = wires.rig.client();
    demand(&client);
    let taken_s = killed.elapsed().as_secs_f64();
    let since = since.unwrap_or_else(Instant::now);
    let at = since.elapsed() + SETTLED;
    let duties = duties_in(&client, SETTLED)?;
    let limit_c = limit_c(&client);
    drop(client);
    driver.stop();
    Some(Row { taken_s, at, duties, hottest_c: wires.hottest_c(), limit_c })
}

#[test]
fn a_driver_that_was_killed_gives_the_same_demand_the_same_duty_three_seconds_later() {
    let rows: Mutex<Vec<(usize, Row)>> = Mutex::default();
    let undisturbed = thread::scope(|scope| {
        for (index, moment) in MOMENTS.iter().enumerate() {
            let rows = &rows;
            scope.spawn(move || {
                let row = (0..ATTEMPTS).find_map(|_| disturbed(moment));
                rows.lock()
                    .expect("nobody panics with it")
                    .push((index, row.unwrap_or_else(|| panic!("{}: a machine too busy to measure on", moment.what))));
            });
        }
        (0..ATTEMPTS).find_map(|_| undisturbed()).expect("a machine not too busy to measure on")
    });
    let mut rows = rows.into_inner().expect("nobody panicked with it");
    rows.sort_by_key(|(index, _)| *index);
    println!(
        "| killed when the wire is | taken again after, s | demand | duty, undisturbed | duty | difference | hottest, °C | limit, °C |"
    );
    println!("|---|--:|---|--:|--:|--:|--:|--:|");
    let mut worst: f64 = 0.0;
    for (index, row) in &rows {
        let near = undisturbed.iter().min_by_key(|(at, _)| at.abs_diff(row.at)).expect("it was watched");
        for (wire, words) in ["half of the stroke", "full duty, derated"].into_iter().enumerate() {
            let (wanted, found) = (near.1[wire], row.duties[wire]);
            worst = worst.max((found / wanted - 1.0).abs());
            println!(
                "| {} | {:.1} | {words} | {wanted:.3} | {found:.3} | {:+.1} % | {:.0} | {:.0} |",
                MOMENTS[*index].what,
                row.taken_s,
                100.0 * (found / wanted - 1.0),
                row.hottest_c,
                row.limit_c
            );
        }
        assert!(row.hottest_c <= row.limit_c + PROMISED_K, "{}: {} °C", MOMENTS[*index].what, row.hottest_c);
    }
    assert!(worst <= 0.05, "the duties differ by {:.1} %", 100.0 * worst);
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
    let _ = sinew();
}
