//! A driver as a service: what it tells the service manager, to a socket of the test's own; and the unit file.

use std::fs;
use std::os::unix::net::UnixDatagram;
use std::process::Command;
use std::time::{Duration, Instant};

use sinew_tests::{Driver, PATIENCE, Process, Rig, checkout, sinew, wait_until};

/// How long the manager's watchdog waits.
const WATCHDOG: Duration = Duration::from_millis(400);

/// The manager's end.
struct Manager(UnixDatagram);

impl Manager {
    fn of(rig: &Rig, command: &mut Command) -> Manager {
        let path = rig.file("notify");
        let socket = UnixDatagram::bind(&path).expect("the folder is writable");
        command.env("NOTIFY_SOCKET", path).env("WATCHDOG_USEC", WATCHDOG.as_micros().to_string());
        Manager(socket)
    }

    /// The next words within this time, if any come.
    fn hears(&self, within: Duration) -> Option<String> {
        self.0.set_read_timeout(Some(within)).expect("a socket takes a timeout");
        let mut words = [0; 4096];
        let count = self.0.recv(&mut words).ok()?;
        Some(String::from_utf8_lossy(&words[..count]).into_owned())
    }

    /// The next words of which a line is this.
    #[track_caller]
    fn waits_for(&self, line: &str) -> String {
        let end = Instant::now() + PATIENCE;
        loop {
            let words = self.hears(PATIENCE).unwrap_or_else(|| panic!("no {line} comes"));
            if words.lines().any(|said| said == line) {
                return words;
            }
            assert!(Instant::now() < end, "no {line} comes");
        }
    }
}

/// The number of cycles in a status.
fn cycles(words: &str) -> u64 {
    let status =
        words.lines().find_map(|line| line.strip_prefix("STATUS=")).unwrap_or_else(|| panic!("no status: {words}"));
    let (before, _) = status.split_once(" cycles").unwrap_or_else(|| panic!("no cycles: {status}"));
    before.rsplit(' ').next().and_then(|count| count.parse().ok()).unwrap_or_else(|| panic!("no number: {status}"))
}

/// The thread of this name of a process.
fn thread(pid: u32, name: &str) -> Option<libc::pid_t> {
    fs::read_dir(format!("/proc/{pid}/task")).expect("our child").flatten().find_map(|task| {
        let comm = fs::read_to_string(task.path().join("comm")).ok()?;
        (comm.trim_end() == name).then(|| task.file_name().to_str()?.parse().ok())?
    })
}

/// A thread that stands still until this is dropped, while the others of its process go on.
struct Held(libc::pid_t);

impl Held {
    fn hold(thread: libc::pid_t) -> Held {
        // SAFETY: plain system calls on a thread of our own child; no pointer is handed over but that of a status of this function's own.
        unsafe {
            let none = std::ptr::null_mut::<libc::c_void>();
            assert_eq!(libc::ptrace(libc::PTRACE_SEIZE, thread, none, none), 0, "{}", std::io::Error::last_os_error());
            assert_eq!(
                libc::ptrace(libc::PTRACE_INTERRUPT, thread, none, none),
                0,
                "{}",
                std::io::Error::last_os_error()
            );
            wait_until("the thread to stand still", || {
                let mut status = 0;
                let seen = libc::waitpid(thread, &mut status, libc::__WALL | libc::WNOHANG);
                assert!(seen >= 0, "{}", std::io::Error::last_os_error());
                seen == thread
            });
        }
        Held(thread)
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        // SAFETY: as above.
        unsafe {
            let none = std::ptr::null_mut::<libc::c_void>();
            libc::ptrace(libc::PTRACE_DETACH, self.0, none, none);
        }
    }
}

#[test]
fn a_service_manager_is_told_that_the_loop_runs_goes_on_and_stops_and_nothing_of_one_that_hangs() {
    let rig = Rig::bench(&["left"], "");
    let mut command = rig.command(&["--for", "300"]);
    let manager = Manager::of(&rig, &mut command);
    let driver = Process::start(&mut command);
    let first = manager.hears(PATIENCE).expect("a word");
    assert!(first.lines().any(|line| line == "READY=1"), "the first word: {first}");
    assert!(cycles(&first) >= 3, "ready before the loop ran: {first}");
    manager.waits_for("WATCHDOG=1");
    manager.waits_for("WATCHDOG=1");

    {
        let _held = Held::hold(thread(driver.pid(), "sinew-loop").expect("a loop"));
        // what was on its way, and the cycles since the last word
        let is_vouched = |words: &str| words.contains("WATCHDOG=1");
        let end = Instant::now() + WATCHDOG;
        while Instant::now() < end {
            let _ = manager.hears(Duration::from_millis(10));
        }
        let (end, mut heard) = (Instant::now() + 8 * WATCHDOG, Vec::new());
        while Instant::now() < end {
            heard.extend(manager.hears(Duration::from_millis(50)));
        }
        assert!(!heard.iter().any(|words| is_vouched(words)), "a loop that hangs is vouched for: {heard:?}");
        // the rest of the process goes on, and says so
        assert!(heard.iter().any(|words| words.starts_with("STATUS=")), "{heard:?}");
    }
    manager.waits_for("WATCHDOG=1");

    driver.signal(libc::SIGTERM);
    let last = manager.waits_for("STOPPING=1");
    assert!(last.contains("stopping"), "{last}");
    assert!(manager.hears(Duration::from_millis(100)).is_none(), "nothing after it");
    driver.finish().expect(0);
}

#[test]
fn a_driver_that_does_not_come_up_is_never_ready() {
    let rig = Rig::bench(&["left"], "");
    let first = Driver::start(&rig);
    let mut command = rig.command(&[]);
    let manager = Manager::of(&rig, &mut command);
    let second = Process::start(&mut command).finish();
    assert_ne!(second.code, Some(0), "two drivers of one rig: {second:?}");
    assert_eq!(manager.hears(Duration::from_millis(10)), None);
    first.stop();
}

#[test]
fn nobody_is_told_anything_where_nobody_asks() {
    let rig = Rig::bench(&["left"], "");
    let mut command = rig.command(&["--for", "300"]);
    command.env_remove("NOTIFY_SOCKET").env("WATCHDOG_USEC", "100000");
    let driver = Process::start(&mut command);
    wait_until("a loop", || thread(driver.pid(), "sinew-loop").is_some());
    let client = rig.client();
    wait_until("cycles", || client.latest().cycle > 100);
    assert_eq!(thread(driver.pid(), "sinew-herald"), None);
    driver.signal(libc::SIGTERM);
    driver.finish().expect(0);
}

/// The unit file of the examples.
fn unit() -> String {
    fs::read_to_string(checkout().join("examples/systemd/sinew@.service")).expect("it is in the checkout")
}

#[test]
fn the_page_shows_the_unit_file_as_it_is() {
    let page = fs::read_to_string(checkout().join("docs/access.md")).expect("it is in the checkout");
    let shown = page.split("```ini\n").nth(1).and_then(|rest| rest.split("```").next());
    assert_eq!(shown, Some(unit().as_str()), "docs/access.md shows another unit than examples/systemd/sinew@.service");
}

#[test]
fn systemd_takes_the_unit_file() {
    let rig = Rig::bench(&["left"], "");
    let binary = sinew().to_str().expect("a plain path");
    let unit = unit().replace("ExecStart=sinew ", &format!("ExecStart={binary} "));
    assert!(unit.contains(binary));
    let path = rig.file("sinew@.service");
    fs::write(&path, unit).expect("the folder is writable");
    let Ok(verified) = Command::new("systemd-analyze").arg("verify").arg(&path).output() else {
        return eprintln!("skipped: there is no systemd-analyze here");
    };
    let said = String::from_utf8_lossy(&verified.stderr);
    // of other units on this machine it may complain, too
    let complaints: Vec<&str> = said.lines().filter(|line| line.contains("sinew")).collect();
    assert!(verified.status.success() && complaints.is_empty(), "{said}");
}
