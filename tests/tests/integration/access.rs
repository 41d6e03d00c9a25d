//! Other users: who is in the command group commands, who is in the read group looks, everybody else is told why not; and whatever
//! any of them does, the driver goes on.
//!
//! The users are numbers without accounts (the kernel asks for no more); the last test makes real ones. Both need root, and say
//! so where they are skipped.

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use serde_json::Value;
use sinew_tests::{Finished, Process, Resources, Rig, check_report, sinew, wait_for, wait_until};
use std::collections::HashSet;
use std::fs::{self, Permissions};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::{FileExt, PermissionsExt, chown};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A user without an account, with one group besides his own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct User {
    pub id: u32,
    pub group: u32,
}

const COMMANDERS: u32 = 64_290;
const READERS: u32 = 64_291;
pub(super) const DRIVER: User = User { id: 64_201, group: 64_299 };
pub(super) const COMMANDER: User = User { id: 64_202, group: COMMANDERS };
pub(super) const READER: User = User { id: 64_203, group: READERS };
pub(super) const STRANGER: User = User { id: 64_204, group: 64_298 };

/// Whether this test can be other users; says so when not.
pub(super) fn can_be_others() -> bool {
    let root = fs::metadata("/proc/self").is_ok_and(|meta| std::os::unix::fs::MetadataExt::uid(&meta) == 0);
    let able = root && Command::new("setpriv").arg("--version").output().is_ok();
    if !able {
        eprintln!("skipped: being another user takes root and setpriv");
    }
    able
}

/// The programs, where everybody may run them.
pub(super) fn programs() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::Builder::new().prefix("sinew-bin-").tempdir().expect("a temporary folder");
        let (robot, intruder) = (env!("CARGO_BIN_EXE_sinew-test-robot"), env!("CARGO_BIN_EXE_sinew-test-intruder"));
        let programs =
            [("sinew", sinew()), ("sinew-test-robot", robot.as_ref()), ("sinew-test-intruder", intruder.as_ref())];
        for (name, program) in programs {
            let copy = folder.path().join(name);
            fs::copy(program, &copy).expect("room for a copy");
            open_to_all(&copy);
        }
        open_to_all(folder.path());
        folder
    });
    folder.path()
}

fn open_to_all(path: &Path) {
    fs::set_permissions(path, Permissions::from_mode(0o755)).expect("ours");
}

/// A rig whose driver runs as a user of its own, with a gate.
pub(super) struct Bench {
    pub rig: Rig,
    folder: TempDir,
}

impl Bench {
    pub fn new(access: &str) -> Bench {
        let rig = Rig::bench(&["left", "right"], &format!("\n[access]\n{access}\n"));
        open_to_all(rig.path().parent().expect("in a folder"));
        let bench = Bench { rig, folder: tempfile::Builder::new().prefix("sg-").tempdir().expect("a folder") };
        open_to_all(bench.folder.path());
        fs::create_dir(bench.gate()).expect("ours");
        open_to_all(&bench.gate());
        chown(bench.gate(), Some(DRIVER.id), Some(DRIVER.group)).expect("root");
        for user in [DRIVER, COMMANDER, READER, STRANGER] {
            let own = bench.own_folder(user);
            fs::create_dir(&own).expect("ours");
            fs::set_permissions(&own, Permissions::from_mode(0o700)).expect("ours");
            chown(&own, Some(user.id), Some(user.group)).expect("root");
        }
        bench
    }

    pub fn gate(&self) -> PathBuf {
        self.folder.path().join("gate")
    }

    pub fn door(&self) -> String {
        format!("{}/{}.sock", self.gate().display(), self.rig.name)
    }

    pub fn own_folder(&self, user: User) -> PathBuf {
        self.folder.path().join(format!("u{}", user.id))
    }

    /// A program run by a user, whose runtime folder is his own.
    pub fn by(&self, user: User, program: &str) -> Command {
        let mut command = Command::new("setpriv");
        command.arg(format!("--reuid={}", user.id)).arg("--regid=64300").arg(format!("--groups={}", user.group));
        command.arg(programs().join(program)).current_dir(self.own_folder(user));
        command.env("SINEW_RUNTIME_DIR", self.own_folder(user)).env("SINEW_GATE_DIR", self.gate());
        command.env("SINEW_STATE_DIR", self.own_folder(user));
        command
    }

    #[track_caller]
    pub fn ask(&self, user: User, args: &[&str]) -> Finished {
        Process::start(self.by(user, "sinew").args(args)).finish()
    }

    #[track_caller]
    pub fn status(&self) -> Value {
        self.ask(READER, &["status", "--json", "--rig", &self.rig.name]).expect(0).json()
    }

    pub fn robot(&self, user: User, task: &[&str]) -> Process {
        Process::start(self.by(user, "sinew-test-robot").arg(&self.rig.name).args(task))
    }

    pub fn intruder(&self, user: User, task: &[&str]) -> Process {
        Process::start(self.by(user, "sinew-test-intruder").args(task))
    }

    fn report(&self) -> PathBuf {
        self.own_folder(DRIVER).join("report.json")
    }

    /// Its driver, running and with its sensors proved.
    #[track_caller]
    pub fn drive(&self) -> Process {
        let mut command = self.by(DRIVER, "sinew");
        command.arg("run").arg(self.rig.path()).args(["--no-monitor", "--for", "300", "--report"]).arg(self.report());
        let mut driver = Process::start(&mut command);
        wait_until("the driver, seen by a reader", || {
            if let Some(status) = driver.ended() {
                panic!("the driver ended with {status}: {}{}", driver.stdout(), driver.stderr());
            }
            let seen = self.ask(READER, &["status", "--json", "--rig", &self.rig.name]);
            seen.code == Some(0)
                && seen.json()["pid"] == driver.pid()
                && channels(&seen.json()).iter().all(|c| c["mode"] != "waiting")
        });
        driver
    }

    /// Stops it; its report.
    #[track_caller]
    pub fn stop(&self, driver: Process) -> Value {
        driver.signal(libc::SIGTERM);
        driver.finish().expect(0);
        let text = fs::read_to_string(self.report()).expect("a report");
        let report: Value = serde_json::from_str(&text).expect("JSON");
        check_report(&report);
        report
    }
}

fn channels(status: &Value) -> &Vec<Value> {
    status["channel"].as_array().expect("channels")
}

pub(super) fn both_groups() -> String {
    format!("command_group = \"{COMMANDERS}\"\nread_group = \"{READERS}\"")
}

#[test]
fn members_command_readers_look_and_strangers_are_told_why_not() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new(&both_groups());
    let driver = bench.drive();
    let name = bench.rig.name.clone();

    // A reader: looks in every way there is, commands in none. He finds the only driver there is by himself.
    let status = bench.ask(READER, &["status", "--json"]).expect(0).json();
    assert_eq!((status["rig"].as_str(), status["pid"].as_u64()), (Some(name.as_str()), Some(driver.pid().into())));
    assert!(bench.ask(READER, &["monitor", "--for", "3"]).expect(0).stdout.lines().count() >= 1);
    let session = bench.own_folder(READER).join("seen.mcap");
    bench.ask(READER, &["record", "--for", "1", session.to_str().expect("UTF-8")]).expect(0);
    let rows = bench.ask(READER, &["recording", "info", session.to_str().expect("UTF-8"), "--json"]).expect(0).json();
    assert!(rows.to_string().contains(&name), "{rows:#}");
    for command in [&["set", "left", "stroke=30%"][..], &["set", "left", "off"], &["reset", "left"], &["stop"]] {
        let refused = bench.ask(READER, command).expect(1);
        assert_eq!(refused.stdout, "");
        let why = format!("taken from members of group {COMMANDERS} alone");
        assert!(refused.stderr.contains(&why), "{command:?}: {}", refused.stderr);
        let remedy = format!("ask to be added to group {COMMANDERS} (`sudo usermod -aG {COMMANDERS} $USER`)");
        assert!(refused.stderr.contains(&remedy), "{command:?}: {}", refused.stderr);
    }
    // (On a machine that stands still for a quarter of a second a channel is off by `cycle_overrun`.)
    let still = |channel: &Value| channel["mode"] == "off" || channel["fault"] == "cycle_overrun";
    assert!(channels(&bench.status()).iter().all(still), "nothing he asked for came about");

    // A stranger: nothing, and he is told what would help.
    for command in [&["status"][..], &["set", "left", "stroke=30%"], &["monitor", "--for", "1"]] {
        let refused = bench.ask(STRANGER, &[command, &["--rig", &name]].concat()).expect(1);
        let why = format!("belongs to user {}, and this user may neither look nor command", DRIVER.id);
        assert!(refused.stderr.contains(&why) && refused.stderr.contains("usermod -aG"), "{}", refused.stderr);
    }

    // A member of the group: looks and commands.
    bench.ask(COMMANDER, &["set", "left", "stroke=30%", "--hold", "60"]).expect(0);
    assert_eq!(channels(&bench.status())[0]["mode"], "length");
    let refused = bench.ask(COMMANDER, &["set", "left", "stroke=30mm"]).expect(2);
    for word in ["left: stroke 30.00 mm is outside 0.00 to ", "the nearest is stroke="] {
        assert!(refused.stderr.contains(word), "judged and told like everybody's: {refused:?}");
    }
    bench.ask(COMMANDER, &["set", "left", "off", "right", "stroke=30%"]).expect(0);
    assert_eq!(
        (&channels(&bench.status())[0]["mode"], &channels(&bench.status())[1]["mode"]),
        (&"off".into(), &"length".into())
    );
    bench.ask(COMMANDER, &["set", "right", "off"]).expect(0);
    // Every cycle, and what was acknowledged is in force.
    let said = bench.robot(COMMANDER, &["work", "right", "500"]).finish().expect(0).stdout;
    let numbers: Vec<u64> = said.split_whitespace().skip(1).map(|word| word.parse().expect("a number")).collect();
    assert_eq!((numbers[0], numbers[2]), (500, 10), "{said}");
    println!("through the gate: {} cycles lost", numbers[1]);

    // He may stop it, and whoever was looking is told.
    let mut reader = bench.robot(READER, &["stream"]);
    reader.wait_for_word("streaming");
    bench.ask(COMMANDER, &["stop"]).expect(0);
    driver.finish().expect(0);
    let ended = reader.finish().expect(3);
    assert!(ended.stderr.contains("has stopped"), "{}", ended.stderr);
    assert!(!Path::new(&bench.door()).exists(), "the door is taken away");
}

#[test]
fn members_of_a_stop_group_look_and_stop_and_command_nothing_else() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new(&format!("command_group = \"{COMMANDERS}\"\nstop_group = \"{READERS}\""));
    let driver = bench.drive();
    bench.ask(READER, &["status"]).expect(0);
    for command in [&["set", "left", "stroke=30%"][..], &["set", "left", "off"], &["reset", "left"]] {
        let refused = bench.ask(READER, command).expect(1);
        let why = format!("taken from members of group {COMMANDERS} alone");
        assert!(refused.stderr.contains(&why), "{command:?}: {}", refused.stderr);
    }
    let refused = bench.ask(STRANGER, &["stop", "--rig", &bench.rig.name]).expect(1);
    assert!(refused.stderr.contains("may neither look nor command"), "{}", refused.stderr);
    bench.ask(READER, &["stop"]).expect(0);
    let ended = driver.finish().expect(0);
    println!("{}", ended.stderr);
}

#[test]
fn without_access_nobody_else_comes_in_and_everyone_means_looking() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new("read_group = \"everyone\"");
    let driver = bench.drive();
    let name = &bench.rig.name;
    bench.ask(STRANGER, &["status", "--rig", name]).expect(0);
    let refused = bench.ask(STRANGER, &["set", "left", "stroke=30%", "--rig", name]).expect(1);
    assert!(refused.stderr.contains("from the driver's own user alone"), "{}", refused.stderr);
    assert!(refused.stderr.contains("command_group"), "{}", refused.stderr);
    let own = bench.ask(DRIVER, &["set", "left", "stroke=30%", "--rig", name]);
    own.expect(0);
    let report = bench.stop(driver);
    assert_eq!(report["ended"], "stopped");

    let closed = Bench::new("");
    let mut command = closed.by(DRIVER, "sinew");
    let mut driver = Process::start(command.arg("run").arg(closed.rig.path()).args(["--no-monitor", "--for", "120"]));
    wait_until("the driver, seen by its own user", || {
        assert!(driver.ended().is_none(), "{}", driver.stderr());
        closed.ask(DRIVER, &["status", "--rig", &closed.rig.name]).code == Some(0)
    });
    assert!(!Path::new(&closed.door()).exists());
    let none = closed.ask(STRANGER, &["status", "--rig", &closed.rig.name]).expect(1);
    assert!(none.stderr.contains("no driver for rig"), "{}", none.stderr);
    driver.signal(libc::SIGTERM);
    driver.finish().expect(0);
}

#[test]
fn the_kernel_keeps_a_reader_from_writing_and_from_everything_else() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new(&both_groups());
    let driver = bench.drive();
    for user in [READER, COMMANDER] {
        let tried = bench.intruder(user, &["glass", &bench.door()]).finish().expect(0).stdout;
        assert!(tried.lines().count() > 8 && !tried.contains("SUCCEEDED"), "{tried}");
        println!("{tried}");
    }
    // The driver's own folder, its memory, its process.
    let lock = bench.own_folder(DRIVER).join(format!("{}.lock", bench.rig.name));
    let lock = fs::read_to_string(lock).expect("root may read it");
    let run = lock.lines().find_map(|line| line.strip_prefix("run ")).expect("its run").trim();
    let shared = fs::read_dir("/dev/shm").expect("Linux").flatten();
    let mut targets: Vec<String> = shared
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&format!("sinew_{run}_")))
        .map(|entry| entry.path().display().to_string())
        .collect();
    assert!(targets.len() >= 3, "{targets:?}");
    targets.push(bench.own_folder(DRIVER).display().to_string());
    targets.extend(["mem", "fd", "environ"].map(|file| format!("/proc/{}/{file}", driver.pid())));
    for user in [READER, COMMANDER, STRANGER] {
        let paths: Vec<&str> = targets.iter().map(String::as_str).collect();
        let tried = bench.intruder(user, &[&["files"], &paths[..]].concat()).finish().expect(0).stdout;
        assert!(tried.lines().count() >= 2 * targets.len(), "{tried}");
    }
    bench.stop(driver);
}

#[test]
fn rubbish_at_the_door_costs_the_others_nothing() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new(&both_groups());
    let driver = bench.drive();
    bench.ask(COMMANDER, &["set", "left", "stroke=20%", "--hold", "100"]).expect(0);
    let door = bench.door();
    let mut intruders: Vec<Process> = [(READER, "1"), (READER, "2"), (STRANGER, "3")]
        .map(|(user, seed)| bench.intruder(user, &["rubbish", &door, "2", seed]))
        .into();
    let said = bench.robot(COMMANDER, &["work", "right", "500"]).finish().expect(0).stdout;
    assert!(said.starts_with("worked 500"), "{said}");
    for intruder in &mut intruders {
        wait_until("the intruder to end", || intruder.ended().is_some());
    }
    let said: Vec<String> = intruders.into_iter().map(|intruder| intruder.finish().expect(0).stdout).collect();
    println!("doors, messages, shut: {said:?}");
    let status = bench.status();
    assert_eq!(channels(&status)[0]["mode"], "length", "the setpoint of who may command is in force: {status:#}");
    // One who may command and sends anything: each is judged, none is more than a command.
    bench.intruder(COMMANDER, &["rubbish", &door, "1", "4"]).finish().expect(0);
    bench.ask(COMMANDER, &["set", "left", "stroke=20%"]).expect(0);
    let report = bench.stop(driver);
    assert_eq!(report["unpublished"], 0, "{report:#}");
}

/// As many visitors as there may be, of one user and of all; the next ones are told so, those inside go on, and when they have gone nothing is
/// left of them.
/// What a driver has of the machine once its open files have been as many for a second.
fn settled(driver: &Process) -> Resources {
    let (mut seen, mut since) = (driver.resources(), Instant::now());
    wait_until("the driver's files to stay as many", || {
        let now = driver.resources();
        if now.open_files != seen.open_files {
            (seen, since) = (now, Instant::now());
        }
        since.elapsed() > Duration::from_secs(1)
    });
    seen
}

#[test]
fn as_many_visitors_as_promised_and_not_one_more() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new(&format!("command_group = \"{COMMANDERS}\"\nread_group = \"everyone\""));
    let driver = bench.drive();
    // The ways in open with the first who takes them, and stay.
    bench.ask(COMMANDER, &["set", "left", "off", "--rig", &bench.rig.name]).expect(0);
    bench.ask(DRIVER, &["set", "right", "off", "--rig", &bench.rig.name]).expect(0);
    let before = settled(&driver);
    let crowded = |mut crowd: Process| {
        crowd.wait_for_word("crowded");
        crowd
    };
    for round in 0..2 {
        // Readers look; commanders look, sleep and command.
        let crowds: Vec<Process> = (0..4).map(|_| bench.robot(READER, &["crowd", "64"])).collect();
        let mut crowds: Vec<Process> = crowds.into_iter().map(crowded).collect();
        let own = bench.ask(READER, &["status", "--rig", &bench.rig.name]).expect(1);
        assert!(own.stderr.contains("serves 256 clients through its gate at once"), "round {round}: {}", own.stderr);
        assert!(own.stderr.contains("end programs that are not needed"), "{}", own.stderr);
        crowds.push(crowded(bench.robot(COMMANDER, &["crowd", "128", "left"])));
        for user in [COMMANDER, STRANGER] {
            let full = bench.ask(user, &["status", "--rig", &bench.rig.name]).expect(1);
            assert!(full.stderr.contains("serves 384 clients through its gate at once"), "{}", full.stderr);
        }
        println!("{} files open with 384 visitors, {} with none", driver.resources().open_files, before.open_files);
        // The driver's own user comes another way.
        bench.ask(DRIVER, &["set", "right", "stroke=20%", "--rig", &bench.rig.name]).expect(0);
        assert!(crowds.iter_mut().all(|crowd| crowd.ended().is_none()), "those inside go on");
        crowds.into_iter().for_each(Process::kill);
        wait_until("their seats to be free", || driver.resources().open_files <= before.open_files);
        bench.ask(READER, &["status", "--rig", &bench.rig.name]).expect(0);
    }
    let after = driver.resources();
    assert!(after.memory_bytes < before.memory_bytes + (16 << 20), "{before:?} {after:?}");
    let report = bench.stop(driver);
    assert_eq!(report["unpublished"], 0, "{report:#}");
}

#[test]
fn a_killed_drivers_door_is_replaced_and_a_squatters_is_not_trusted() {
    if !can_be_others() {
        return;
    }
    let bench = Bench::new(&both_groups());
    for _ in 0..3 {
        let driver = bench.drive();
        let mut reader = bench.robot(READER, &["stream"]);
        reader.wait_for_word("streaming");
        driver.kill();
        let ended = reader.finish().expect(3);
        assert!(ended.stderr.contains("has died"), "{}", ended.stderr);
        let none = bench.ask(READER, &["status", "--rig", &bench.rig.name]).expect(1);
        assert!(none.stderr.contains("no driver for rig"), "{}", none.stderr);
    }
    bench.stop(bench.drive());

    // A folder anybody may write to: neither does a driver open a door there, nor does a client go through one.
    fs::set_permissions(bench.gate(), Permissions::from_mode(0o1777)).expect("ours");
    let mut command = bench.by(DRIVER, "sinew");
    let refused = Process::start(command.arg("run").arg(bench.rig.path()).args(["--no-monitor", "--for", "5"]));
    let refused = refused.finish().expect(1);
    assert!(refused.stderr.contains("others may write to"), "{}", refused.stderr);
    let mut squatter = bench.intruder(STRANGER, &["squat", bench.gate().to_str().expect("UTF-8"), &bench.rig.name]);
    squatter.wait_for_word("squatting");
    let refused = bench.ask(COMMANDER, &["set", "left", "stroke=30%", "--rig", &bench.rig.name]).expect(1);
    assert!(refused.stderr.contains("could be anybody's door"), "{}", refused.stderr);
    squatter.kill();
}

/// What programs of the driver's own user can do to it: they may write to its shared memory, and break it as surely as by a kill. What is
/// left then is what is left after a kill: nothing that is in the way of the next one.
#[test]
fn the_own_user_can_break_a_driver_and_the_next_one_starts_as_if_nothing_had_been() {
    let rig = Rig::bench(&["left", "right"], "");
    let mut random = SmallRng::seed_from_u64(6);
    let mut ends = Vec::new();
    for kind in ["blackboard", "connection", "data", "dynamic", "cut off"] {
        let (mut driver, client) = sinew_tests::Driver::ready(&rig);
        // This process must not map what it is going to spoil; another one has a connection meanwhile.
        drop(client);
        let mut reader =
            Process::start(Command::new(env!("CARGO_BIN_EXE_sinew-test-robot")).args([&rig.name, "stream"]));
        reader.wait_for_word("streaming");
        // The driver tells which of the shared memory is its: it has it mapped.
        let maps = fs::read_to_string(format!("/proc/{}/maps", driver.pid())).expect("our child");
        let own: HashSet<&str> = maps
            .lines()
            .filter_map(|line| line.split_whitespace().last())
            .filter(|path| path.starts_with("/dev/shm/sinew_"))
            .collect();
        let chosen: Vec<&str> = own.iter().copied().filter(|path| kind == "cut off" || path.contains(kind)).collect();
        let mut spoiled = 0;
        for path in &chosen {
            let memory = match fs::OpenOptions::new().write(true).open(path) {
                // what was the client's that has just gone
                Err(gone) if gone.kind() == std::io::ErrorKind::NotFound => continue,
                opened => opened.expect("our own"),
            };
            spoiled += 1;
            let length = memory.metadata().expect("our own").len();
            if kind == "cut off" {
                memory.set_len(0).expect("our own");
            }
            for _ in 0..if kind == "cut off" { 0 } else { 2000 } {
                let mut rubbish = [0; 64];
                random.fill(&mut rubbish[..]);
                let at = random.random_range(0..length.saturating_sub(64).max(1));
                memory.write_at(&rubbish, at).expect("our own");
            }
        }
        assert!(spoiled > 0, "{kind}: {own:?}");
        // It goes on, ends in order, or dies.
        std::thread::sleep(Duration::from_millis(300));
        ends.push((kind, driver.process.ended()));
        driver.process.kill();
        reader.kill();
        // Nothing has to be cleaned up.
        sinew_tests::Driver::ready(&rig).0.stop();
        let left: Vec<&&str> = own.iter().filter(|path| Path::new(path).exists()).collect();
        assert!(left.is_empty(), "{kind}: {left:?}");
    }
    println!("driver after rubbish in its own memory: {ends:?}");
}

/// The sockets a process has open, by the numbers the kernel gives them.
fn sockets_of(pid: u32) -> HashSet<String> {
    let links = fs::read_dir(format!("/proc/{pid}/fd")).expect("our child").flatten();
    links
        .filter_map(|entry| fs::read_link(entry.path()).ok())
        .filter_map(|link| Some(link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_string()))
        .collect()
}

/// Its sockets of the network: table, local address and state.
fn network_of(pid: u32) -> Vec<String> {
    let own = sockets_of(pid);
    let mut found = Vec::new();
    for table in ["tcp", "tcp6", "udp", "udp6", "udplite", "udplite6", "raw", "raw6"] {
        for line in fs::read_to_string(format!("/proc/{pid}/net/{table}")).unwrap_or_default().lines().skip(1) {
            let fields: Vec<&str> = line.split_whitespace().collect();
            if own.contains(fields[9]) {
                found.push(format!("{table} {} {}", fields[1], fields[3]));
            }
        }
    }
    found
}

#[test]
fn nothing_is_reachable_from_the_network_unless_asked_for_and_then_where_it_was_asked_for_alone() {
    let rig = Rig::bench(&["left"], "");
    let (driver, client) = sinew_tests::Driver::ready(&rig);
    let _stream = client.stream().expect("a stream");
    assert_eq!(network_of(driver.pid()), Vec::<String>::new());
    let any = ["--listen", "127.0.0.1:0"];
    for (what, more) in [(&["scope"][..], &[][..]), (&["bridge", "prometheus"], &any), (&["bridge", "foxglove"], &any)]
    {
        let mut asked_for = Process::start(Command::new(sinew()).args(what).args(more).args(["--rig", &rig.name]));
        asked_for.wait_for_word("://");
        let pid = asked_for.pid();
        let listening = wait_for("its port", || Some(network_of(pid)).filter(|found| !found.is_empty()));
        // 0100007F is 127.0.0.1, 0A is listening.
        assert!(
            listening.iter().all(|socket| socket.starts_with("tcp 0100007F:") && socket.ends_with(" 0A")),
            "{what:?}: {listening:?}"
        );
        assert_eq!(network_of(driver.pid()), Vec::<String>::new(), "the driver itself still has none");
        asked_for.kill();
    }
    // the scope where it was told to listen, besides, and nowhere else: a socket on loopback and one there
    let mut on_the_network = Command::new(sinew());
    on_the_network
        .args(["scope", "--lan", "127.0.0.2:0", "--rig", &rig.name])
        .env("SINEW_STATE_DIR", rig.file("state"));
    let mut on_the_network = Process::start(&mut on_the_network);
    on_the_network.wait_for_word("certificate ");
    let mut listening = network_of(on_the_network.pid());
    listening.sort_unstable();
    let [own, asked_for] = listening.as_slice() else { panic!("{listening:?}") };
    assert!(own.starts_with("tcp 0100007F:") && own.ends_with(" 0A"), "{listening:?}");
    assert!(asked_for.starts_with("tcp 0200007F:") && asked_for.ends_with(" 0A"), "{listening:?}");
    // which shows nothing in the clear, whatever is asked for
    let port = u16::from_str_radix(&asked_for["tcp 0200007F:".len()..][..4], 16).expect("a port");
    for path in ["/", "/figures", "/live"] {
        let mut line = TcpStream::connect(("127.0.0.2", port)).expect("it listens");
        write!(line, "GET {path} HTTP/1.1\r\nHost: 127.0.0.2:{port}\r\n\r\n").expect("it takes a request");
        let mut said = String::new();
        line.read_to_string(&mut said).expect("it answers");
        assert!(said.starts_with("HTTP/1.1 307") && said.contains(&format!("https://127.0.0.2:{port}/")), "{said}");
        assert!(!said.contains(&rig.name) && !said.contains("left"), "{said}");
    }
    assert_eq!(network_of(driver.pid()), Vec::<String>::new(), "the driver itself still has none");
    on_the_network.kill();
    driver.stop();
}

/// With accounts and groups of this machine, as on a real bench. Asked for by `SINEW_TEST_ACCOUNTS=1`, since it changes
/// /etc/passwd and /etc/group for its time.
#[test]
fn real_accounts_and_a_group_by_name() {
    if std::env::var_os("SINEW_TEST_ACCOUNTS").is_none() || !can_be_others() {
        eprintln!("skipped: makes accounts, asked for by SINEW_TEST_ACCOUNTS=1");
        return;
    }
    let tag = std::process::id();
    let (group, robot, guest) = (format!("sinewg{tag}"), format!("sinewr{tag}"), format!("sinewv{tag}"));
    struct Accounts(Vec<[String; 2]>);
    impl Accounts {
        fn make(&mut self, program: &str, args: &[&str], undo: &str) {
            let done = Command::new(program).args(args).status().unwrap_or_else(|e| panic!("{program}: {e}"));
            assert!(done.success(), "{program} {args:?}");
            self.0.push([undo.into(), args.last().expect("a name").to_string()]);
        }
    }
    impl Drop for Accounts {
        fn drop(&mut self) {
            for [program, name] in self.0.iter().rev() {
                let _ = Command::new(program).arg(name).status();
            }
        }
    }
    let mut accounts = Accounts(Vec::new());
    accounts.make("groupadd", &[&group], "groupdel");
    accounts.make("useradd", &["-M", "-G", &group, &robot], "userdel");
    accounts.make("useradd", &["-M", &guest], "userdel");

    let bench = Bench::new(&format!("command_group = \"{group}\"\nread_group = \"everyone\""));
    let driver = bench.drive();
    let as_account = |account: &str, args: &[&str]| {
        let mut command = Command::new("runuser");
        command.args(["-u", account, "--"]).arg(programs().join("sinew")).args(args).current_dir("/");
        command.env("SINEW_GATE_DIR", bench.gate()).env_remove("SINEW_RUNTIME_DIR").env_remove("XDG_RUNTIME_DIR");
        let finished = Process::start(&mut command).finish();
        let id = Command::new("id").args(["-u", account]).output().expect("coreutils").stdout;
        let _ = fs::remove_dir_all(format!("/tmp/sinew-{}", String::from_utf8_lossy(&id).trim()));
        finished
    };
    as_account(&robot, &["set", "left", "stroke=30%", "--hold", "60"]).expect(0);
    assert_eq!(channels(&bench.status())[0]["mode"], "length");
    as_account(&guest, &["status"]).expect(0);
    let refused = as_account(&guest, &["set", "left", "off"]).expect(1);
    assert!(refused.stderr.contains(&format!("from members of group {group} alone")), "{}", refused.stderr);
    assert!(refused.stderr.contains(&format!("usermod -aG {group} $USER")), "{}", refused.stderr);
    bench.stop(driver);
}
