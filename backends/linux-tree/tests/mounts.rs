//! No tree stays mounted: not with open files, not when its process is terminated, not for long when it is killed.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use sinew_linux_tree::{Scans, Tree};
use sinew_rig::Rig;
use tempfile::TempDir;

/// Where waiting becomes a failure.
const PATIENCE: Duration = Duration::from_secs(60);

fn is_mounted(folder: &Path) -> bool {
    let folder = folder.to_str().expect("a plain name");
    let table = fs::read_to_string("/proc/self/mounts").expect("Linux has one");
    table.lines().any(|line| line.split(' ').nth(1) == Some(folder))
}

/// `None`, with a word about it, where there is no FUSE.
fn tree(folder: &TempDir) -> Option<Tree> {
    match Tree::mount(&Rig::hexapod(), Scans::OnPhase, folder.path()) {
        Ok(tree) => Some(tree),
        Err(error) => {
            eprintln!("skipped: no FUSE here ({error})");
            None
        }
    }
}

fn wait(what: &str, is_so: impl Fn() -> bool) {
    let since = Instant::now();
    while !is_so() {
        assert!(since.elapsed() < PATIENCE, "waited {PATIENCE:?} in vain for: {what}");
        thread::sleep(Duration::from_millis(2));
    }
}

/// A tree in a process of its own.
struct Process(Child);

impl Process {
    fn start(folder: &TempDir) -> Process {
        let rig = folder.path().with_extension("toml");
        fs::write(&rig, Rig::hexapod().to_toml()).expect("a file");
        let mut command = Command::new(env!("CARGO_BIN_EXE_sinew-linux-tree"));
        let child = command.args([&rig, folder.path()]).stderr(Stdio::null()).spawn().expect("it starts");
        let process = Process(child);
        wait("the tree", || folder.path().join("sys/class/pwm").is_dir());
        fs::remove_file(rig).expect("it was there");
        process
    }

    fn end(&mut self, signal: Signal) {
        kill_process(Pid::from_child(&self.0), signal).expect("it is ours");
        self.0.wait().expect("it is ours");
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_tree_that_is_dropped_goes_with_files_still_open() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(tree) = tree(&folder) else { return };
    let file = File::open(folder.path().join("sys/class/pwm/pwmchip0/npwm")).expect("it is there");
    assert!(is_mounted(folder.path()));
    drop(tree);
    assert!(!is_mounted(folder.path()));
    drop(file);
    folder.close().expect("nothing is in the way");
}

#[test]
fn a_tree_whose_process_is_killed_goes_with_the_next_one() {
    let [killed, next] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let Some(first) = tree(&next) else { return };
    drop(first);
    let mut process = Process::start(&killed);
    let file = File::open(killed.path().join("sys/class/pwm/pwmchip0/npwm")).expect("it is there");
    let lives = tree(&next).expect("there was one before");
    assert!(is_mounted(killed.path()), "a tree that lives is left alone");
    drop(lives);
    process.end(Signal::KILL);
    // Perhaps another test's tree has cleared it away already.
    let _tree = tree(&next).expect("there was one before");
    assert!(!is_mounted(killed.path()));
    drop(file);
    killed.close().expect("nothing is in the way");
}

#[test]
fn a_tree_whose_process_is_told_to_end_goes_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    if tree(&folder).is_none() {
        return;
    }
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        Process::start(&folder).end(signal);
        assert!(!is_mounted(folder.path()), "{signal:?}");
    }
}
