//! `sinew demo`: driver, machine and robot program together, and what is left of them.

use std::fs;
use std::path::Path;
use std::process::Command;

use sinew_tests::browser::Browser;
use sinew_tests::{Process, entries, sinew, wait_for, wait_until};
use sinew_threads::Thread;
use tempfile::TempDir;

use crate::threads::{Strike, WAYS, can_strike};

/// A demonstrator whose driver nobody else finds.
pub struct Demo {
    folder: TempDir,
    pub command: Command,
}

impl Demo {
    pub fn of(args: &[&str]) -> Demo {
        let folder = tempfile::Builder::new().prefix("sd-").tempdir_in("/tmp").expect("a temporary folder");
        let mut command = Command::new(sinew());
        command.arg("demo").args(args);
        command.env("SINEW_RUNTIME_DIR", folder.path()).env("SINEW_STATE_DIR", folder.path());
        Demo { folder, command }
    }

    fn start(&mut self) -> Process {
        Process::start(&mut self.command)
    }

    /// Starts it for a browser, which goes to its page.
    fn show(&mut self, browser: &mut Browser) -> Process {
        let mut process = self.start();
        process.wait_for_word("http://");
        let url = wait_for("the address", || process.stdout().lines().next().map(str::to_owned));
        browser.open(&url);
        process
    }

    /// Whether a driver runs there.
    fn is_driven(&self) -> bool {
        entries(self.folder.path()).iter().any(|name| name.ends_with(".lock"))
    }
}

/// The robot program of a demonstrator that runs: a child of its process.
fn robot(demo: &Process) -> u32 {
    wait_for("the robot program", || {
        let children = fs::read_to_string(format!("/proc/{0}/task/{0}/children", demo.pid())).ok()?;
        children.split_whitespace().find_map(|pid| {
            let line = fs::read(Path::new("/proc").join(pid).join("cmdline")).ok()?;
            String::from_utf8_lossy(&line).contains("--robot").then(|| pid.parse().ok())?
        })
    })
}

#[test]
fn a_ball_is_put_down_and_balanced_and_nothing_is_left() {
    let mut demo = Demo::of(&["ball-on-beam", "--for", "8", "--no-monitor", "--seed", "2"]);
    let process = demo.start();
    let robot = robot(&process);
    let ended = process.finish().expect(0);
    // How well it does is the trials' to say: here the machine may be busy. That a ball lies there means that the wire has levelled the beam.
    assert!(ended.stdout.contains("the ball waits for a level beam") && ended.stdout.contains("\nball "), "{ended:?}");
    assert!(ended.stdout.lines().last().is_some_and(|line| line.starts_with("ball-on-beam, ")), "{ended:?}");
    assert!(ended.stderr.contains("faults    none") || ended.stderr.contains("cycle_overrun"), "{ended:?}");
    assert!(!Path::new("/proc").join(robot.to_string()).exists(), "the robot program has ended");
    assert!(!demo.is_driven());
    assert_eq!(
        entries(demo.folder.path()).iter().filter(|name| !name.starts_with('.')).count(),
        0,
        "neither boxes nor accounts"
    );
}

#[test]
fn a_robot_program_that_dies_ends_it_and_is_named() {
    let mut demo = Demo::of(&["servo", "--for", "60", "--no-monitor"]);
    let process = demo.start();
    let robot = robot(&process);
    wait_until("it to run", || process.stdout().contains('°'));
    assert!(Command::new("kill").args(["-9", &robot.to_string()]).status().expect("kill").success());
    let ended = process.finish().expect(1);
    assert!(ended.stderr.contains("error: the robot program has ended (signal: 9"), "{ended:?}");
    assert!(!demo.is_driven(), "and the driver with it, in order");
}

#[test]
fn a_robot_program_without_its_sensor_ends_its_driver() {
    if !can_strike() {
        return;
    }
    for how in WAYS {
        let mut demo = Demo::of(&["servo", "--for", "60", "--no-monitor"]);
        let strike = Strike::by(demo.folder.path().join("strike"), &mut demo.command);
        let process = demo.start();
        robot(&process);
        wait_until("it to run", || process.stdout().contains('°'));
        strike.strike(Thread::Feeder, how);
        let ended = process.finish().expect(1);
        let does = Thread::Feeder.row().does;
        assert!(ended.stderr.contains(&format!("the thread that {does} has died")), "{how}: {ended:?}");
        assert!(!demo.is_driven(), "{how}");
    }
}

#[test]
fn a_browser_shows_the_machine_itself() {
    let Some(mut browser) = Browser::start(1280, 800) else { return };
    let mut demo = Demo::of(&["bowden-servo", "--for", "60", "--scope"]);
    let process = demo.show(&mut browser);
    browser.wait("document.querySelectorAll('#picture line').length >= 2");
    browser.wait("$('picture').getAttribute('aria-label').includes('that are asked for')");
    // it moves: the horn is where it was not
    let horn = "document.querySelector('#picture line:last-of-type').getAttribute('x2')";
    let before = browser.eval(horn);
    browser.wait(&format!("{horn} !== '{}'", before.as_str().expect("a place")));
    process.signal(libc::SIGTERM);
    process.finish().expect(0);
    assert!(!demo.is_driven());
}

#[test]
fn a_hexapod_stands_up_and_walks() {
    let mut demo = Demo::of(&["walker", "--for", "14", "--no-monitor", "--seed", "2"]);
    let process = demo.start();
    let robot = robot(&process);
    let ended = process.finish().expect(0);
    let last = ended.stdout.lines().last().unwrap_or_default();
    // In what time is the trials' to say: here the machine may be busy. It has to have stepped, with one tripod and the other.
    let walked_m = last.split("walked ").nth(1).and_then(|rest| rest.split(' ').next()?.parse::<f64>().ok());
    assert!(last.starts_with("walker, 14 s: ") && walked_m.is_some_and(|metres| metres > 0.02), "{ended:?}");
    let feet: Vec<String> = ended
        .stdout
        .lines()
        .filter_map(|line| Some(line.split_once("feet ")?.1.chars().take_while(|foot| "●○".contains(*foot)).collect()))
        .collect();
    // on uneven ground not all of the six reach it before they have stepped
    assert!(feet.iter().any(|stand| stand.matches('●').count() > 3), "{ended:?}");
    assert!(feet.iter().any(|stand| stand == "●○○●●○" || stand == "○●●○○●"), "{ended:?}");
    assert!(!Path::new("/proc").join(robot.to_string()).exists(), "the robot program has ended");
    assert!(!demo.is_driven());
}

#[test]
fn a_browser_shows_a_hexapod_from_above_and_from_the_side() {
    let Some(mut browser) = Browser::start(1280, 800) else { return };
    let mut demo = Demo::of(&["walker", "--for", "60", "--scope"]);
    let process = demo.show(&mut browser);
    // six feet in each of two views
    browser.wait("document.querySelectorAll('#picture circle').length === 12");
    browser.wait("$('picture').getAttribute('aria-label').includes('m ahead')");
    // it walks: a foot is lifted, and the marks on the ground pass
    browser.wait("$('picture').getAttribute('aria-label').includes('○')");
    let ahead = "parseFloat($('picture').getAttribute('aria-label'))";
    browser.wait(&format!("{ahead} > 0.01"));
    process.signal(libc::SIGTERM);
    process.finish().expect(0);
    assert!(!demo.is_driven());
}

#[test]
fn a_torso_lifts_its_arms_and_is_given_a_ball() {
    let mut demo = Demo::of(&["torso", "--for", "10", "--no-monitor", "--seed", "2"]);
    let process = demo.start();
    let robot = robot(&process);
    let ended = process.finish().expect(0);
    // How long it stays on the paddle is the trials' to say: here the machine may be busy. That a ball lies there means that four wires have levelled it.
    assert!(
        ended.stdout.contains("the ball waits for a level paddle: ") && ended.stdout.contains("\nball "),
        "{ended:?}"
    );
    assert!(ended.stdout.contains(" mm ahead, ") && ended.stdout.contains(" mm left, paddle "), "{ended:?}");
    assert!(ended.stdout.lines().last().is_some_and(|line| line.starts_with("torso, ")), "{ended:?}");
    assert!(!Path::new("/proc").join(robot.to_string()).exists(), "the robot program has ended");
    assert!(!demo.is_driven());
}

#[test]
fn a_browser_shows_a_torso_with_its_ball() {
    let Some(mut browser) = Browser::start(1280, 800) else { return };
    let mut demo = Demo::of(&["torso", "--for", "60", "--scope"]);
    let process = demo.show(&mut browser);
    // a head and six joints in each of two views, and then a ball in each of three
    browser.wait("document.querySelectorAll('#picture circle').length === 14");
    browser.wait("$('picture').getAttribute('aria-label').includes('mm ahead')");
    browser.wait("document.querySelectorAll('#picture circle').length === 17");
    // it rolls
    let ball = "document.querySelector('#picture circle:last-of-type').getAttribute('cx')";
    let before = browser.eval(ball);
    browser.wait(&format!("{ball} !== '{}'", before.as_str().expect("a place")));
    process.signal(libc::SIGTERM);
    process.finish().expect(0);
    assert!(!demo.is_driven());
}

#[test]
fn what_there_is_not_is_said_with_what_there_is() {
    let listed = Demo::of(&[]).start().finish().expect(0);
    assert!(listed.stdout.contains("sinew demo ball-on-beam") && listed.stdout.contains("sinew demo servo"));
    let slip = Demo::of(&["ball-on-bean"]).start().finish().expect(2);
    assert!(slip.stderr.contains("hint: `sinew demo ball-on-beam`"), "{slip:?}");
}

#[test]
fn what_is_kept_is_a_rig_that_runs_and_the_program_as_it_stands_in_the_examples() {
    let there = tempfile::tempdir().expect("a temporary folder");
    let kept = there.path().join("bench");
    let name = kept.to_str().expect("a temporary folder's name");
    Demo::of(&["servo", "--keep", name]).start().finish().expect(0);
    assert_eq!(entries(&kept), ["servo.rs", "servo.toml"]);
    let example = sinew_tests::checkout().join("examples/servo.rs");
    assert_eq!(fs::read(kept.join("servo.rs")).unwrap(), fs::read(example).unwrap());
    sinew_tests::run(["check".as_ref(), kept.join("servo.toml").as_os_str()]).expect(0);
    let again = Demo::of(&["servo", "--keep", name]).start().finish().expect(2);
    assert!(again.stderr.contains("is there already"), "{again:?}");
}
