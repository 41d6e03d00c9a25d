//! Terminals that nobody reads: a screen on them stands neither between a signal nor a death and the outputs.

use std::collections::BTreeSet;
use std::fs;
use std::io::{Read, Write};
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use sinew_ipc::{Client, DriverState, Mode};
use sinew_tests::{Rig, sinew, wait_for, wait_until};
use sinew_threads::{TABLE, Thread};

use crate::threads::{STRUCK, Strike, can_strike, is_there};

const LONG: Duration = Duration::from_secs(120);

/// A program with a terminal of its own, which is killed when it goes out of scope.
struct OnTerminal {
    child: Child,
    /// The other end of its terminal; what is not read there waits.
    screen: fs::File,
    /// Its own end, once more.
    theirs: OwnedFd,
}

impl OnTerminal {
    fn start(command: &mut Command) -> OnTerminal {
        OnTerminal::of_kind("xterm", command)
    }

    /// The same on a terminal of this kind.
    fn of_kind(kind: &str, command: &mut Command) -> OnTerminal {
        let (mut ours, mut theirs) = (-1, -1);
        let size = libc::winsize { ws_row: 30, ws_col: 100, ws_xpixel: 0, ws_ypixel: 0 };
        // SAFETY: both places are writable, the name and the settings may be left out, and the size is a plain value.
        let made = unsafe { libc::openpty(&mut ours, &mut theirs, std::ptr::null_mut(), std::ptr::null(), &size) };
        assert_eq!(made, 0, "{}", std::io::Error::last_os_error());
        // SAFETY: openpty has just made them, and nobody else owns them.
        let (screen, theirs) = unsafe { (fs::File::from_raw_fd(ours), OwnedFd::from_raw_fd(theirs)) };
        let end = || Stdio::from(theirs.try_clone().expect("a descriptor"));
        let terminal = theirs.as_raw_fd();
        // Whoever starts the tests may ignore some.
        let signals = [libc::SIGINT, libc::SIGTERM, libc::SIGHUP, libc::SIGTTOU, libc::SIGTTIN];
        command.stdin(end()).stdout(end()).stderr(end()).env("TERM", kind);
        // SAFETY: plain system calls, which may be made between fork and exec.
        unsafe {
            command.pre_exec(move || {
                for signal in signals {
                    libc::signal(signal, libc::SIG_DFL);
                }
                libc::setsid();
                match libc::ioctl(terminal, libc::TIOCSCTTY, 0) {
                    0 => Ok(()),
                    _ => Err(std::io::Error::last_os_error()),
                }
            });
        }
        OnTerminal { child: command.spawn().expect("it starts"), screen, theirs }
    }

    /// Reads everything that is shown from now on, and gives all of it at the end.
    fn read_on(&self) -> std::thread::JoinHandle<String> {
        let mut screen = self.screen.try_clone().expect("a descriptor");
        std::thread::spawn(move || {
            let mut all = Vec::new();
            let mut part = [0; 4096];
            // EIO when the last program on it has gone
            while let Ok(count @ 1..) = screen.read(&mut part) {
                all.extend_from_slice(&part[..count]);
            }
            String::from_utf8_lossy(&all).into_owned()
        })
    }

    /// Fills its terminal until not a byte more goes in, once it has begun to write there by a thread of its own.
    fn fill(&self) {
        let tasks = format!("/proc/{}/task", self.child.id());
        wait_until("a thread that writes", || {
            let mut tasks = fs::read_dir(&tasks).expect("our child").map_while(Result::ok);
            tasks
                .any(|task| fs::read_to_string(task.path().join("comm")).is_ok_and(|name| name.trim() == "sinew-words"))
        });
        let path = format!("/proc/self/fd/{}", self.theirs.as_raw_fd());
        let flags = libc::O_NONBLOCK | libc::O_NOCTTY;
        let mut end = fs::OpenOptions::new().write(true).custom_flags(flags).open(path).expect("its own end");
        for size in [1024, 1] {
            while end.write(&vec![b'x'; size]).is_ok() {}
        }
    }

    /// Types on it.
    fn type_in(&mut self, keys: &str) {
        self.screen.write_all(keys.as_bytes()).expect("a terminal");
    }

    fn signal(&self, signal: libc::c_int) {
        // SAFETY: plain system call; the process is our child and has not been waited for.
        assert_eq!(unsafe { libc::kill(self.child.id() as libc::pid_t, signal) }, 0);
    }

    fn finish(&mut self) -> ExitStatus {
        wait_for("its end", || self.child.try_wait().expect("our child"))
    }
}

impl Drop for OnTerminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// `sinew run` with its screen on a terminal, its wire at work.
fn driven(rig: &Rig) -> (OnTerminal, Strike, Client) {
    let mut command = Command::new(sinew());
    command.arg("run").arg(rig.path()).args(["--for", "300"]).env("SINEW_STATE_DIR", rig.file("state"));
    let strike = Strike::of(rig, &mut command);
    let program = OnTerminal::start(&mut command);
    is_there(rig);
    let client = rig.client();
    wait_until("sensors", || client.latest().channels().iter().all(|channel| channel.mode() == Mode::Off));
    client.set_duty("wire", 0.1, LONG).expect("it may be powered");
    wait_until("power", || client.latest().channels()[0].duty == 0.1);
    (program, strike, client)
}

fn is_off(client: &Client) -> bool {
    let last = client.latest();
    last.state() == DriverState::Stopped && last.channels().iter().all(|channel| channel.duty == 0.0)
}

#[test]
fn a_screen_on_a_terminal_nobody_reads_keeps_no_signal_from_outputs_or_end() {
    for signal in [libc::SIGTERM, libc::SIGINT] {
        let rig = Rig::bench(&["wire"], "");
        let (mut program, _, client) = driven(&rig);
        program.fill();
        client.off("wire").expect("it is commanded all the same");
        program.signal(signal);
        wait_until("zero", || is_off(&client));
        assert_eq!(program.finish().code(), Some(0));
    }
}

#[test]
fn a_monitor_on_a_terminal_nobody_reads_ends_when_it_is_asked_to() {
    let rig = Rig::bench(&["wire"], "");
    let (driver, _client) = sinew_tests::Driver::ready(&rig);
    let mut monitor = OnTerminal::start(Command::new(sinew()).args(["monitor", "--rig", &rig.name]));
    monitor.fill();
    monitor.signal(libc::SIGTERM);
    assert_eq!(monitor.finish().code(), Some(0));
    driver.stop();
}

#[test]
fn a_monitor_in_words_draws_nothing_and_does_what_is_typed() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = sinew_tests::Driver::ready(&rig);
    let mut monitor = OnTerminal::start(Command::new(sinew()).args(["monitor", "--plain", "--rig", &rig.name]));
    let shown = monitor.read_on();
    let mode = |channel: usize| client.latest().channels()[channel].mode();
    monitor.type_in("set left 40%\n");
    wait_until("a length", || mode(0) == Mode::Length);
    // held longer than a lease, by renewing it
    let cycle = client.latest().cycle;
    wait_until("three seconds", || client.latest().cycle > cycle + 3 * sinew_tests::RATE_HZ as u64);
    assert_eq!(mode(0), Mode::Length);
    monitor.type_in("set left stroke=30mm\nset lfet 3\nstatus left\nset right 30\n");
    wait_until("the other's length", || mode(1) == Mode::Length);
    // what was refused has not taken the one before it away
    let cycle = client.latest().cycle;
    wait_until("three seconds", || client.latest().cycle > cycle + 3 * sinew_tests::RATE_HZ as u64);
    assert_eq!(mode(0), Mode::Length);
    monitor.type_in("off left\n");
    wait_until("off", || mode(0) == Mode::Off);
    // Ctrl-D: the end, and what is held from there is let go
    monitor.type_in("\x04");
    assert_eq!(monitor.finish().code(), Some(0));
    wait_until("what was held to be let go", || mode(1) != Mode::Length);
    drop(monitor);
    let shown = shown.join().expect("it only reads");
    assert!(!shown.contains('\x1b'), "no cursor is placed, no colour set: {shown:?}");
    for words in [
        "2 channels: 2 off",
        "left: stroke 40.0 %",
        "left: now commanded to a length",
        "refused: left: stroke 30.00 mm is outside 0.00 to",
        "there is no channel lfet; did you mean left?",
        "temperature: ",
        "setpoint: held for",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    driver.stop();
}

#[test]
fn a_terminal_without_a_cursor_gets_the_driver_in_words() {
    let rig = Rig::bench(&["wire"], "");
    // the command has the terminal open for as long as it is there
    let mut program = {
        let mut command = Command::new(sinew());
        command.arg("run").arg(rig.path()).args(["--for", "300"]).env("SINEW_STATE_DIR", rig.file("state"));
        OnTerminal::of_kind("dumb", &mut command)
    };
    let shown = program.read_on();
    is_there(&rig);
    let client = rig.client();
    wait_until("sensors", || client.latest().channels()[0].mode() == Mode::Off);
    program.type_in("help\nset wire duty=0.1\n");
    wait_until("power", || client.latest().channels()[0].duty == 0.1);
    program.type_in("quit\n");
    wait_until("zero", || is_off(&client));
    assert_eq!(program.finish().code(), Some(0));
    drop(program);
    let shown = shown.join().expect("it only reads");
    assert!(!shown.contains('\x1b'), "{shown:?}");
    for words in [
        "type help for the commands",
        "release NAME: ",
        "the end of the driver as well",
        "wire: duty 0.100",
        " cycles at ",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
}

#[test]
fn in_words_a_pipe_commands_and_a_log_has_what_happened_and_when() {
    let mut rig = Rig::bench(&["left", "right"], "");
    rig.add("\n[[simulation.fault]]\nchannel = \"right\"\nkind = \"open_wire\"\nstart_s = 4.0\n");
    let (driver, client) = sinew_tests::Driver::ready(&rig);
    // the end of what is typed is not the end of what is told
    let monitor = |more: &[&str]| {
        let mut command = Command::new(sinew());
        command.args(["monitor", "--plain", "--rig", &rig.name]).args(more);
        command
    };
    let mut log = sinew_tests::Process::start(&mut monitor(&["--every", "0.5"]));
    let mut typed = sinew_tests::Process::start_to_be_told(&mut monitor(&[]));
    // only what changes from then on is told
    log.wait_for_word("type help");
    typed.wait_for_word("type help");
    typed.tell("set left 50%");
    wait_until("a length", || client.latest().channels()[0].mode() == Mode::Length);
    log.wait_for_word("right: fault, open wire: ");
    log.wait_for_word("1 fault\n");
    typed.tell("stop");
    driver.stopped();
    let typed = typed.finish().expect(0);
    assert!(typed.stdout.contains("the driver stops") && typed.stderr.contains("the driver has stopped"), "{typed:?}");
    let log = log.finish().expect(0).stdout;
    assert!(log.matches("channels: ").count() > 2, "how things are, again and again: {log}");
    for line in log.lines() {
        let stamp = line.split_once(" s: ").and_then(|(stamp, _)| stamp.parse::<f64>().ok());
        assert!(stamp.is_some(), "{line}");
    }
    assert!(log.contains(" s: left: now commanded to a length\n"), "{log}");
}

#[test]
fn a_recorder_and_a_benchmark_on_a_terminal_nobody_reads_end_when_they_are_asked_to() {
    let rig = Rig::bench(&["wire"], "");
    let (driver, client) = sinew_tests::Driver::ready(&rig);
    let file = rig.file("session.mcap");
    let mut recorder = OnTerminal::start(Command::new(sinew()).arg("record").arg(&file).args(["--rig", &rig.name]));
    wait_until("a recording", || file.exists());
    recorder.fill();
    let cycle = client.latest().cycle;
    wait_until("cycles", || client.latest().cycle > cycle + 600);
    recorder.signal(libc::SIGTERM);
    assert_eq!(recorder.finish().code(), Some(0));
    sinew_tests::run(["recording".as_ref(), "doctor".as_ref(), file.as_os_str()]).expect(0);
    driver.stop();

    let mut bench = OnTerminal::start(Command::new(sinew()).args(["bench", "loop", "--channels", "1", "--for", "5"]));
    let name = format!("bench-{}", bench.child.id());
    bench.fill();
    // Its parts are measured first, without a driver, and a bare timer loop.
    let is_driver = |client: &Client| client.info().simulated != 0 && client.latest().cycle > 0;
    let client = wait_for("its loop", || Client::connect(&name).ok().filter(is_driver));
    bench.signal(libc::SIGINT);
    wait_until("zero", || is_off(&client));
    assert_eq!(bench.finish().code(), Some(0));
}

#[test]
fn a_thread_that_panics_touches_no_terminal_before_outputs_are_zero() {
    if !can_strike() {
        return;
    }
    for thread in [Thread::Loop, Thread::Desk, Thread::Main] {
        let rig = Rig::bench(&["wire"], "");
        let (mut program, strike, client) = driven(&rig);
        program.fill();
        strike.strike(thread, "panic");
        wait_until("zero", || is_off(&client));
        assert_eq!(program.finish().code(), Some(1), "{thread:?}");
    }
}

#[test]
fn a_screen_whose_keys_nobody_reads_any_more_ends_and_its_driver_with_it() {
    if !can_strike() {
        return;
    }
    for how in ["panic", "end"] {
        let rig = Rig::bench(&["wire"], "");
        let (mut program, strike, client) = driven(&rig);
        let shown = program.read_on();
        strike.strike(Thread::Keys, how);
        wait_until("zero", || is_off(&client));
        assert_eq!(program.finish().code(), Some(1), "{how}");
        // The last who has it open.
        drop(program);
        let shown = shown.join().expect("it only reads");
        assert!(shown.contains("error: the thread that reads the keys has died"), "{how}: {shown}");
    }
}

#[test]
fn every_thread_is_struck_by_a_test() {
    let struck: BTreeSet<&str> = STRUCK.iter().chain(&[Thread::Keys]).map(|thread| thread.row().name).collect();
    assert_eq!(struck, TABLE.iter().map(|row| row.name).collect());
}
