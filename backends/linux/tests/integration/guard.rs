//! The guard process: a driver in a separate process is killed, stopped, or loses its guard, and the outputs are at zero
//! within the stated time. `SINEW_TRIES` repeats each that often (default 3), `-- --nocapture` prints the times.

use std::env;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::bench::{Bench, bench, guarded, wired};
use rustix::process::{Pid, Signal, kill_process};
use sinew_backend::{Backend, Sample};
use sinew_linux_backend::LinuxRig;
use sinew_linux_tree::Scans;
use sinew_rig::LinuxSampling;

const CHANNELS: usize = 4;
const RATE_HZ: f64 = 1000.0;
/// What makes this test's program a driver, and of which tree.
const ROOT: &str = "SINEW_TEST_ROOT";
/// Where waiting becomes a failure.
const PATIENCE: Duration = Duration::from_secs(60);
/// A machine that is busy may let the guard wait; the figures are in docs/linux-backend.md.
const AT_LATEST: Duration = Duration::from_secs(5);

/// Not a test: the driver of the others, in a process of its own. It drives all outputs until something ends it.
#[test]
fn a_driver_in_a_process_of_its_own() {
    let Ok(root) = env::var(ROOT) else { return };
    let rig = wired(CHANNELS, RATE_HZ, Scans::OnPhase, LinuxSampling::Buffer, &root);
    let mut backend = LinuxRig::new(guarded(&rig)).unwrap();
    backend.bring_up().unwrap();
    println!("\nguard {}", backend.guard_process().unwrap());
    let mut samples = [Sample::NONE; CHANNELS];
    let (mut count, mut failed) = (0u64, false);
    loop {
        // never the same twice, so that each is written
        count += 1;
        let duty = 0.5 + 0.001 * (count % 100) as f64;
        let answer = backend.exchange(&[duty; CHANNELS], &mut samples);
        if answer.is_err() != failed {
            failed = answer.is_err();
            println!("\nexchange {answer:?}");
        }
        thread::sleep(Duration::from_secs_f64(1.0 / RATE_HZ));
    }
}

struct Driver {
    child: Child,
    guard: Pid,
    said: BufReader<std::process::ChildStdout>,
}

impl Driver {
    fn start(bench: &Bench) -> Driver {
        let mut child = Command::new(env::current_exe().unwrap())
            .args(["--exact", "guard::a_driver_in_a_process_of_its_own", "--nocapture"])
            .env(ROOT, bench.tree.root())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stdout.take().unwrap());
        let guard = word(&mut said, "guard ").parse().unwrap();
        let driver = Driver { child, guard: Pid::from_raw(guard).unwrap(), said };
        wait("all outputs driven", || bench.duties().iter().all(|duty| *duty > 0.4) && bench.enable_is_high());
        driver
    }

    fn id(&self) -> Pid {
        Pid::from_raw(self.child.id() as i32).unwrap()
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The rest of the next line that begins with `begin`.
fn word(said: &mut impl BufRead, begin: &str) -> String {
    let mut line = String::new();
    loop {
        line.clear();
        assert!(said.read_line(&mut line).unwrap() > 0, "the driver ended before it said \"{begin}\"");
        if let Some(rest) = line.trim().strip_prefix(begin) {
            return rest.to_string();
        }
    }
}

fn wait(what: &str, is_so: impl Fn() -> bool) {
    let since = Instant::now();
    while !is_so() {
        assert!(since.elapsed() < PATIENCE, "waited {PATIENCE:?} in vain for: {what}");
        thread::sleep(Duration::from_micros(200));
    }
}

/// Does something to a driver and returns how long after it the last output went to zero.
fn time_to_zero(bench: &Bench, act: impl FnOnce()) -> Duration {
    let since = Instant::now();
    act();
    wait("supply off and all outputs at zero", || {
        !bench.enable_is_high() && bench.duties().iter().all(|duty| *duty == 0.0)
    });
    let kernel = bench.tree.kernel();
    let last = (0..CHANNELS).filter_map(|channel| kernel.output(channel).changed).max().unwrap();
    last.saturating_duration_since(since)
}

fn repeated(what: &str, mut once: impl FnMut(&Bench) -> Duration) {
    let Some(bench) = bench(CHANNELS, RATE_HZ, Scans::OnPhase, LinuxSampling::Buffer) else { return };
    let tries = env::var("SINEW_TRIES").ok().and_then(|tries| tries.parse().ok()).unwrap_or(3);
    let mut times: Vec<Duration> = (0..tries).map(|_| once(&bench)).collect();
    times.sort_unstable();
    let (median, worst) = (times[times.len() / 2], times[times.len() - 1]);
    println!("{what}: {tries} times, zero after {median:.1?} (median), {worst:.1?} (worst)");
    assert!(worst < AT_LATEST, "{what}: zero after {worst:?}");
}

#[test]
fn a_killed_driver_leaves_nothing_heated() {
    repeated("killed", |bench| {
        let driver = Driver::start(bench);
        let time = time_to_zero(bench, || kill_process(driver.id(), Signal::KILL).unwrap());
        let guard = driver.guard;
        drop(driver);
        wait("the guard to end", || rustix::process::test_kill_process(guard).is_err());
        assert_eq!(bench.duties(), [0.0; CHANNELS]);
        assert!(!bench.enable_is_high());
        time
    });
}

#[test]
fn a_stopped_driver_leaves_nothing_heated_and_hears_of_it_when_it_goes_on() {
    repeated("stopped", |bench| {
        let mut driver = Driver::start(bench);
        let time = time_to_zero(bench, || kill_process(driver.id(), Signal::STOP).unwrap());
        thread::sleep(Duration::from_millis(50));
        assert_eq!(bench.duties(), [0.0; CHANNELS], "it stays so");
        assert!(!bench.enable_is_high(), "it stays so");
        kill_process(driver.id(), Signal::CONT).unwrap();
        let answer = word(&mut driver.said, "exchange ");
        assert!(answer.contains("Timeout"), "{answer}");
        wait("driven again", || bench.duties().iter().all(|duty| *duty > 0.4) && bench.enable_is_high());
        time
    });
}

#[test]
fn without_a_guard_nothing_is_heated() {
    repeated("guard killed", |bench| {
        let mut driver = Driver::start(bench);
        let time = time_to_zero(bench, || kill_process(driver.guard, Signal::KILL).unwrap());
        assert!(word(&mut driver.said, "exchange ").contains("Unavailable"));
        assert!(word(&mut driver.said, "exchange ").contains("Ok"), "another guard, without a hand");
        wait("driven again", || bench.duties().iter().all(|duty| *duty > 0.4));
        time
    });
    repeated("guard stopped", |bench| {
        let mut driver = Driver::start(bench);
        let time = time_to_zero(bench, || kill_process(driver.guard, Signal::STOP).unwrap());
        assert!(word(&mut driver.said, "exchange ").contains("Unavailable"));
        kill_process(driver.guard, Signal::CONT).unwrap();
        wait("driven again", || bench.duties().iter().all(|duty| *duty > 0.4));
        time
    });
}

#[test]
fn the_guard_outlives_signals_to_the_whole_family() {
    repeated("family terminated", |bench| {
        let driver = Driver::start(bench);
        for signal in [Signal::TERM, Signal::INT, Signal::HUP] {
            kill_process(driver.guard, signal).unwrap();
        }
        time_to_zero(bench, || kill_process(driver.id(), Signal::TERM).unwrap())
    });
}
