//! Driver and clients in processes of their own, and what happens when they are killed.
//!
//! The other processes are this test program again, started for the one test [`another_process`] with its role in the environment.

use crate::common::*;
use sinew_ipc::*;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command as Program, Stdio};
use std::time::Duration;

const ROLE: &str = "SINEW_IPC_TEST_ROLE";

/// A process with a role; killed when dropped.
struct Process {
    child: Child,
    lines: std::sync::mpsc::Receiver<String>,
}

impl Process {
    fn start(role: &str, rig: &str) -> Process {
        let mut child = Program::new(std::env::current_exe().unwrap())
            .args(["processes::another_process", "--exact", "--nocapture"])
            .env(ROLE, role)
            .env("SINEW_IPC_TEST_RIG", rig)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let (send, lines) = std::sync::mpsc::channel();
        std::thread::spawn(move || out.lines().map_while(Result::ok).try_for_each(|line| send.send(line)));
        Process { child, lines }
    }

    fn ready(role: &str, rig: &str) -> Process {
        let process = Process::start(role, rig);
        process.expect("ready");
        process
    }

    /// Waits for a line it prints.
    fn expect(&self, line: &str) {
        loop {
            match self.lines.recv_timeout(PATIENCE) {
                // The test harness has written "test another_process ... " before it.
                Ok(text) if text.ends_with(line) => return,
                Ok(_) => {}
                Err(e) => panic!("never said {line:?}: {e}"),
            }
        }
    }

    fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Lets it go on, and waits until it has ended by itself.
    fn finish(mut self) {
        drop(self.child.stdin.take());
        assert!(self.child.wait().unwrap().success());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn say(line: &str) {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}").unwrap();
    out.flush().unwrap();
}

/// Returns when the parent closes our standard input.
fn wait_for_parent() {
    let _ = std::io::stdin().lock().read_line(&mut String::new());
}

/// What the other processes do.
#[test]
fn another_process() {
    let (Ok(role), Ok(rig)) = (std::env::var(ROLE), std::env::var("SINEW_IPC_TEST_RIG")) else { return };
    match role.as_str() {
        "driver" => {
            let _driver = Driver::start(&rig, 18, 500.0);
            say("ready");
            wait_for_parent();
        }
        // Connected by every means there is, and busy with all of them.
        "client" => {
            let client = patient(&rig);
            let mut stream = client.stream().unwrap();
            let mut said = false;
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    wait_for_parent();
                    std::process::exit(0);
                });
                loop {
                    for i in 0..18 {
                        client.set_stroke(&format!("c{i}"), 0.5, Duration::ZERO).unwrap();
                        client.with_latest(|s| assert_whole(s.cycle, s.missed, s.channels()));
                    }
                    if let Some(c) = stream.next_within(PATIENCE).unwrap() {
                        assert_whole(c.header.cycle, c.header.missed, c.channels);
                    }
                    if !said {
                        say("ready");
                        said = true;
                    }
                }
            });
        }
        // Dies with a command on its way.
        "asker" => {
            let patient = ClientOptions { answer: Duration::from_secs(600), ..ClientOptions::default() };
            let client = Client::connect_with(&rig, patient).unwrap();
            say("ready");
            let _ = client.set_stroke("c0", 0.25, Duration::ZERO);
        }
        // Takes as many places as it can be given at once, and never leaves them properly.
        "crowd" => {
            let clients: Vec<_> = (0..20).map(|_| patient(&rig)).collect();
            let _streams: Vec<_> = clients.iter().map(|c| c.stream().unwrap()).collect();
            let _waiters: Vec<_> = clients.iter().map(|c| c.waiter().unwrap()).collect();
            say("ready");
            wait_for_parent();
        }
        "reader" => {
            let client = patient(&rig);
            let mut stream = client.stream().unwrap();
            let mut last = 0;
            while stream.received() < 300 {
                let Some(c) = stream.next_within(PATIENCE).unwrap() else { panic!("nothing came") };
                assert_whole(c.header.cycle, c.header.missed, c.channels);
                assert!(last == 0 || c.header.cycle == last + 1 + c.lost);
                last = c.header.cycle;
                if last.is_multiple_of(10) {
                    client.with_latest(|s| assert_whole(s.cycle, s.missed, s.channels()));
                    assert_eq!(client.set_stroke("c3", 0.125, Duration::ZERO).unwrap().value, 0.125);
                }
            }
            say("ready");
        }
        other => panic!("no such role: {other}"),
    }
}

/// Names of what a rig has left in shared memory and in the runtime folder.
fn leftovers(run: &str) -> Vec<String> {
    let mut found = Vec::new();
    for dir in [std::path::PathBuf::from("/dev/shm"), runtime_dir().unwrap()] {
        let names = std::fs::read_dir(dir).unwrap().flatten().filter_map(|e| e.file_name().into_string().ok());
        found.extend(names.filter(|name| name.contains(run)));
    }
    found
}

/// The name of the run a rig's driver is in: from its lock file.
fn run_of(rig: &str) -> String {
    let text = std::fs::read_to_string(runtime_dir().unwrap().join(format!("{rig}.lock"))).unwrap();
    text.lines().find_map(|l| l.strip_prefix("run ")).unwrap().trim().to_string()
}

#[test]
fn twenty_programs_at_once() {
    let rig = rig("twenty");
    let _driver = Process::ready("driver", &rig);
    let readers: Vec<_> = (0..20).map(|_| Process::start("reader", &rig)).collect();
    for reader in readers {
        reader.finish();
    }
}

#[test]
fn a_killed_driver_is_noticed_and_leaves_nothing_in_the_way() {
    let rig = rig("kill9");
    let mut driver = Process::ready("driver", &rig);
    let pid = driver.child.id();
    assert_eq!(RigLock::acquire(&rig).unwrap_err(), Error::AlreadyRunning { rig: rig.clone(), pid });
    let client = patient(&rig);
    assert_eq!(client.info().pid, pid);
    assert!(client.wait(PATIENCE).unwrap());
    assert!(client.is_alive());
    let run = run_of(&rig);
    assert!(!leftovers(&run).is_empty());

    driver.kill();
    let gone = Error::DriverGone { rig: rig.clone(), pid, stopped: false };
    assert!(!client.is_alive());
    assert_eq!(client.health(), DriverHealth::Died);
    client.with_latest(|s| assert_whole(s.cycle, s.missed, s.channels()));
    assert_eq!(client.set_stroke("c0", 0.5, Duration::ZERO), Err(gone.clone()));
    assert!(!Client::discover().unwrap().contains(&rig));

    let next = Process::ready("driver", &rig);
    assert!(!client.is_alive());
    let fresh = patient(&rig);
    assert_eq!(fresh.info().pid, next.child.id());
    assert!(fresh.set_stroke("c0", 0.5, Duration::ZERO).is_ok());
    // The dead run's files go with its last user.
    drop(client);
    assert_eq!(leftovers(&run), Vec::<String>::new());
    let run = run_of(&rig);
    drop(fresh);
    next.finish();
    assert_eq!(leftovers(&run), Vec::<String>::new());
    assert!(!runtime_dir().unwrap().join(format!("{rig}.lock")).exists());
}

#[test]
fn a_driver_killed_again_and_again_starts_every_time() {
    let rig = rig("again");
    let mut runs = Vec::new();
    for _ in 0..10 {
        let mut driver = Process::ready("driver", &rig);
        runs.push(run_of(&rig));
        driver.kill();
    }
    Process::ready("driver", &rig).finish();
    for run in runs {
        assert_eq!(leftovers(&run), Vec::<String>::new());
    }
}

#[test]
fn killed_clients_disturb_nobody() {
    let rig = rig("clients");
    let _driver = Driver::start(&rig, 18, 500.0);
    let steady = patient(&rig);
    let mut stream = steady.stream().unwrap();
    for _ in 0..8 {
        let mut victims: Vec<_> = (0..2).map(|_| Process::ready("client", &rig)).collect();
        for victim in &mut victims {
            victim.kill();
        }
        assert!(steady.set_stroke("c1", 0.5, Duration::ZERO).is_ok());
        assert!(steady.wait(PATIENCE).unwrap());
        while let Some(c) = stream.next().unwrap() {
            assert_whole(c.header.cycle, c.header.missed, c.channels);
        }
    }
    assert!(stream.received() > 0 && steady.is_alive());
}

#[test]
fn the_places_of_killed_clients_can_be_taken_again() {
    let rig = rig("places");
    let _driver = Driver::start(&rig, 2, 200.0);
    // 200 clients in all that read streams, where 64 fit at a time: with 40 alive no more than 24 of the dead have theirs yet.
    for _ in 0..10 {
        Process::ready("crowd", &rig).kill();
        until("the dead make room", || {
            let mut live = Vec::new();
            while live.len() < 40 {
                let client =
                    Client::connect_with(&rig, ClientOptions { connect: Duration::ZERO, ..Default::default() });
                match client.and_then(|client| Ok((client.stream()?, client))) {
                    Ok(reader) => live.push(reader),
                    Err(_) => return false,
                }
            }
            true
        });
    }
}

/// The marks that its nodes leave in a run's folder.
fn marks(nodes: &Path) -> BTreeSet<PathBuf> {
    let files = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
    };
    files(nodes).into_iter().flat_map(|path| files(&path).into_iter().chain([path])).collect()
}

#[test]
fn a_client_killed_while_it_writes_a_mark_of_itself_leaves_nothing() {
    let rig = rig("unfinished");
    let _driver = Driver::start(&rig, 18, 500.0);
    let nodes = runtime_dir().unwrap().join(run_of(&rig)).join("nodes");
    let before = marks(&nodes);
    assert!(!before.is_empty());
    for which in [".service_tag", ".port_tag"] {
        let mut victim = Process::ready("client", &rig);
        let theirs: Vec<PathBuf> = marks(&nodes).difference(&before).cloned().collect();
        let mark = theirs.iter().find(|path| path.to_string_lossy().ends_with(which)).expect(which);
        // As it is before it is finished: still writable.
        fs::set_permissions(mark, fs::Permissions::from_mode(0o600)).unwrap();
        victim.kill();
        until(&format!("nothing is left of it ({which})"), || marks(&nodes) == before);
    }
}

#[test]
fn a_client_killed_while_it_makes_its_shared_memory_holds_nobody_up() {
    let rig = rig("halfmade");
    let driver = Driver::start(&rig, 18, 500.0);
    let run = run_of(&rig);
    let connections = || -> BTreeSet<PathBuf> {
        of_ports(&run).into_iter().filter(|path| path.extension().is_some_and(|end| end == "connection")).collect()
    };
    let nodes = runtime_dir().unwrap().join(&run).join("nodes");
    let (before, ours) = (marks(&nodes), connections());
    let mut victim = Process::ready("client", &rig);
    let theirs: Vec<PathBuf> = connections().difference(&ours).cloned().collect();
    assert!(!theirs.is_empty());
    victim.kill();
    // As they are between their making and their first page.
    for path in theirs {
        let _ = fs::remove_file(&path);
        fs::File::create(&path).unwrap();
    }
    until("nothing is left of it", || marks(&nodes) == before && connections() == ours);
    let client = patient(&rig);
    client.set_stroke("c0", 0.5, Duration::ZERO).unwrap();
    drop(client);
    drop(driver);
}

/// Those of a run's files that belong to its clients and its driver, not to the run itself.
fn of_ports(run: &str) -> BTreeSet<PathBuf> {
    let folders = [PathBuf::from("/dev/shm"), runtime_dir().unwrap().join(run)];
    let all = folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap().flatten()).map(|entry| entry.path());
    let is_one =
        |end: &std::ffi::OsStr| ["data", "connection", "event", "event_mgmt"].contains(&end.to_string_lossy().as_ref());
    all.filter(|path| path.to_string_lossy().contains(run) && path.extension().is_some_and(is_one)).collect()
}

#[test]
fn clients_killed_at_any_moment_of_their_start_leave_no_shared_memory() {
    let rig = rig("starting");
    let _driver = Driver::start(&rig, 18, 500.0);
    let run = run_of(&rig);
    let nodes = runtime_dir().unwrap().join(&run).join("nodes");
    let before = of_ports(&run);
    assert!(!before.is_empty());
    let count = || fs::read_dir(&nodes).unwrap().count();
    for kill in 0..100 {
        let known = count();
        let mut victim = Process::start("client", &rig);
        // The clearing of those before may hide its coming: then it is killed later.
        for _ in 0..200 {
            if count() > known {
                break;
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        std::thread::sleep(Duration::from_micros(kill * 37 % 100 * 40));
        victim.kill();
    }
    until("nothing is left of them", || of_ports(&run) == before);
    assert!(patient(&rig).set_stroke("c0", 0.5, Duration::ZERO).is_ok());
}

#[test]
fn a_connection_that_died_before_its_ends_took_it_goes() {
    let rig = rig("endless");
    let _driver = Driver::start(&rig, 18, 500.0);
    let run = run_of(&rig);
    let client = patient(&rig);
    client.set_stroke("c0", 0.5, Duration::ZERO).unwrap();
    let before = of_ports(&run);
    let model = before.iter().find(|path| path.extension().is_some_and(|end| end == "connection")).unwrap();
    let parts: Vec<&str> = model.to_str().unwrap().split('_').collect();
    let [start, _, hash, _, port] = parts[..] else { panic!("{model:?}") };
    let left = PathBuf::from(format!("{start}_{run}_{hash}_123456_{port}"));
    fs::copy(model, &left).unwrap();
    until("it is gone", || !left.exists());
    assert_eq!(of_ports(&run), before);
    assert!(client.set_stroke("c0", 0.7, Duration::ZERO).is_ok());
}

#[test]
fn a_client_that_dies_before_its_reply_is_nobodys_loss() {
    let rig = rig("noreply");
    let mut server = Server::create(RigLock::acquire(&rig).unwrap(), &info(&rig, 1, 1000.0)).unwrap();
    for _ in 0..3 {
        let mut asker = Process::ready("asker", &rig);
        let mut request = None;
        until("the command arrives", || {
            request = server.commands.receive();
            request.is_some()
        });
        asker.kill();
        let request = request.unwrap();
        let replies = request.commands().iter().map(decide).collect();
        request.reply(replies);
    }
    let client = patient(&rig);
    std::thread::scope(|scope| {
        let asking = scope.spawn(|| client.set_stroke("c0", 0.75, Duration::ZERO));
        until("the command arrives", || server.commands.serve(decide) > 0);
        assert_eq!(asking.join().unwrap().unwrap().value, 0.75);
    });
}

#[test]
fn of_many_drivers_that_start_at_once_one_runs() {
    let rig = rig("race");
    for _ in 0..3 {
        let servers: Vec<_> = std::thread::scope(|scope| {
            let starts: Vec<_> = (0..6)
                .map(|_| scope.spawn(|| Server::create(RigLock::acquire(&rig)?, &info(&rig, 1, 100.0))))
                .collect();
            starts.into_iter().map(|t| t.join().unwrap()).collect()
        });
        let refused = servers.iter().filter(|s| matches!(s, Err(Error::AlreadyRunning { .. }))).count();
        assert_eq!(refused, 5);
        assert!(Client::connect(&rig).is_ok());
    }
}
