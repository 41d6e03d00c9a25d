//! One run of a driver, and how others find it: the rig's lock file, the run's own folder, and sweeping up after the dead.
//!
//! In the runtime folder (`$SINEW_RUNTIME_DIR`, else `$XDG_RUNTIME_DIR/sinew`, else `/run/user/UID/sinew`, else
//! `/tmp/sinew-UID`, with a random end where somebody else has taken that name) stand
//!
//! - `RIG.lock`: held exclusively by the running driver, and read by clients: its process id, protocol and run;
//! - `RUN/`: everything iceoryx2 keeps in files for this run, the rig file's text (`RUN/rig.toml`), and `RUN/users`, held shared
//!   by the driver and by each client.
//!
//! Each run has a name of its own, which is also in the name of all its shared memory (`/dev/shm/sinew_RUN_…`). So nothing
//! that a killed driver left can be in the way of the next one: that one uses other names. `RUN/users` holds the run's key, which is in
//! the names of its services, so that nobody else knows what their files will be called. A run whose `users` nobody
//! holds any more is swept away by whoever comes next. The kernel releases the locks however a process ends.

use crate::error::Error;
use crate::messages::PROTOCOL;
use crate::names::check_rig_name;
use crate::ours::{self, open};
use crate::sys::{self, Lock};
use std::collections::hash_map::RandomState;
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::hash::{BuildHasher, Hasher};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest runtime folder: a Unix socket's path has 107 bytes, of which a run's name, iceoryx2's prefix, id and suffix take 74.
const MAX_RUNTIME_DIR: usize = 33;
/// Letters of a run's name, and of its key.
const RUN_LETTERS: usize = 10;
const KEY_LETTERS: usize = 16;
/// Where Linux keeps shared memory.
const SHARED_MEMORY: &str = "/dev/shm";
/// Size of what stands in a lock file: always written whole, so that a reader never sees half of it.
const RECORD_BYTES: usize = 128;
/// What every run's folder has, and what it is called before it has it.
const USERS: &str = "users";
const NEW: &str = ".sinew-new-";
/// The rig file's text in a run's folder.
const RIG_TEXT: &str = "rig.toml";
/// Longest rig file a client reads, bytes.
const MAX_RIG_TEXT: u64 = 4 << 20;

/// The runtime folder, created when it is not there.
///
/// # Errors
/// [`Error::RuntimeDir`] when it is somebody else's, open to others, or its path is too long.
pub fn runtime_dir() -> Result<PathBuf, Error> {
    let path = match std::env::var_os("SINEW_RUNTIME_DIR") {
        Some(path) if !path.is_empty() => PathBuf::from(path),
        _ => match default_runtime_dir() {
            Some(path) => path,
            None => {
                let wrong = |reason| Error::RuntimeDir { path: "/tmp".into(), reason };
                return ours::own_folder_among(Path::new("/tmp"), "sinew", 0o022).map_err(wrong);
            }
        },
    };
    let wrong = |reason: String| Error::RuntimeDir { path: path.clone(), reason };
    if !path.is_absolute() {
        return Err(wrong("it is not an absolute path".into()));
    }
    if path.as_os_str().len() > MAX_RUNTIME_DIR {
        return Err(wrong(format!(
            "its path is longer than the {MAX_RUNTIME_DIR} bytes a socket's name leaves for it"
        )));
    }
    ours::own_folder(&path, 0o022).map_err(wrong)?;
    Ok(path)
}

/// This user's own among those that a login makes; `None` where there is none.
fn default_runtime_dir() -> Option<PathBuf> {
    let user = sys::user_id();
    let mine = |p: &Path| fs::metadata(p).is_ok_and(|m| m.is_dir() && m.uid() == user);
    let candidates = [std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from), Some(format!("/run/user/{user}").into())];
    candidates
        .into_iter()
        .flatten()
        .filter(|p| p.is_absolute() && mine(p))
        .map(|p| p.join("sinew"))
        .find(|p| p.as_os_str().len() <= MAX_RUNTIME_DIR)
}

fn lock_path(dir: &Path, rig: &str) -> PathBuf {
    dir.join(format!("{rig}.lock"))
}

/// Name of what iceoryx2 creates for a run.
pub(crate) fn prefix(run: &str) -> String {
    format!("sinew_{run}_")
}

/// The shared memory of a run. In `/dev/shm` anybody may have put a file of that name: only this user's are.
pub(crate) fn shared_memory(run: &str) -> Vec<PathBuf> {
    ours::files(Path::new(SHARED_MEMORY), &prefix(run))
}

/// What stands in a lock file.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Record {
    pid: u32,
    protocol: u32,
    /// The run's name; empty while the driver is starting.
    run: String,
}

impl Record {
    fn write(&self, mut file: &File) -> std::io::Result<()> {
        let run = if self.run.is_empty() { "-" } else { &self.run };
        let text = format!("sinew driver\npid {}\nprotocol {}\nrun {run}\n", self.pid, self.protocol);
        let text = format!("{text:<width$}\n", width = RECORD_BYTES - 1);
        file.seek(SeekFrom::Start(0))?;
        file.write_all(text.as_bytes())?;
        file.set_len(RECORD_BYTES as u64)
    }

    fn read(mut file: &File) -> Option<Record> {
        let mut text = [0; RECORD_BYTES];
        file.seek(SeekFrom::Start(0)).ok()?;
        file.read_exact(&mut text).ok()?;
        let text = std::str::from_utf8(&text).ok()?;
        let field =
            |name: &str| text.lines().find_map(|line| line.strip_prefix(name)).map(|value| value.trim().to_string());
        let run = field("run ")?;
        let run = if run == "-" { String::new() } else { run };
        (run.is_empty() || is_run_name(&run)).then_some(())?;
        Some(Record { pid: field("pid ")?.parse().ok()?, protocol: field("protocol ")?.parse().ok()?, run })
    }
}

fn is_run_name(name: &str) -> bool {
    name.len() == RUN_LETTERS && name.bytes().all(|b| b.is_ascii_digit() || b.is_ascii_lowercase())
}

/// A name no other run has had lately; the folder of that name, created first, makes sure of it.
fn run_name(attempt: u64) -> String {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    let mut seed = (since.as_nanos() as u64) ^ (u64::from(std::process::id()) << 40) ^ attempt.rotate_left(57);
    // Mixed (splitmix64), so that neighbours in time and number share no beginning.
    seed = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    seed = (seed ^ (seed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    seed ^= seed >> 31;
    let letters = b"0123456789abcdefghijklmnopqrstuvwxyz";
    (0..RUN_LETTERS)
        .map(|_| {
            let letter = letters[(seed % 36) as usize];
            seed /= 36;
            letter as char
        })
        .collect()
}

/// The exclusive hold on a rig's name: at most one driver has it. Released when dropped, and by the kernel when the
/// process ends in any other way.
#[derive(Debug)]
pub struct RigLock {
    rig: String,
    dir: PathBuf,
    run: String,
    key: String,
    file: File,
    users: Option<File>,
}

impl RigLock {
    /// Takes hold of a rig name, and sweeps up what earlier runs have left.
    ///
    /// # Errors
    /// [`Error::AlreadyRunning`] with the other driver's process id, [`Error::RigName`], [`Error::RuntimeDir`].
    pub fn acquire(rig: &str) -> Result<RigLock, Error> {
        RigLock::acquire_in(&runtime_dir()?, rig, PROTOCOL)
    }

    pub(crate) fn acquire_in(dir: &Path, rig: &str, protocol: u32) -> Result<RigLock, Error> {
        check_rig_name(rig)?;
        let path = lock_path(dir, rig);
        let failed = |e: std::io::Error| Error::RuntimeDir { path: path.clone(), reason: e.to_string() };
        // Nobody sweeps meanwhile.
        let sweep = Sweep::begin(dir)?;
        let file = loop {
            let file = open(&path, true).map_err(failed)?;
            // Shared as long as the file may be a dead driver's: a client that looks at this moment must not take him for alive, and map
            // what he left.
            if !sys::try_lock(&file, Lock::Shared).map_err(failed)? {
                let pid = Record::read(&file).map_or(0, |record| record.pid);
                return Err(Error::AlreadyRunning { rig: rig.into(), pid });
            }
            // The one before may have removed the file between our opening and locking it: then ours is not the rig's any more.
            if !is_the_file_at(&file, &path) {
                continue;
            }
            if file.metadata().map_err(failed)?.len() == 0 {
                match sys::try_lock(&file, Lock::Exclusive).map_err(failed)? {
                    true => break file,
                    false => return Err(Error::AlreadyRunning { rig: rig.into(), pid: 0 }),
                }
            }
            // A dead driver's, and its clients may still be watching: to them a lock on this very file would mean that he is back. They
            // keep the old one, we take a new one.
            if Record::read(&file).is_none() {
                let reason = "it is not a lock of sinew's, and is left alone; move it away".into();
                return Err(Error::RuntimeDir { path, reason });
            }
            fs::remove_file(&path).map_err(failed)?;
        };
        Record { pid: std::process::id(), protocol, run: String::new() }.write(&file).map_err(failed)?;
        sweep.all();
        let (run, key, users) = create_run(dir)?;
        drop(sweep);
        Ok(RigLock { rig: rig.into(), dir: dir.into(), run, key, file, users: Some(users) })
    }

    /// Name of the rig.
    pub fn rig(&self) -> &str {
        &self.rig
    }

    /// Leaves the rig file's text in the run's folder, for clients to read ([`crate::Client::rig_text`]): a recording carries it.
    /// Before the services are created, so that no client comes too early.
    ///
    /// # Errors
    /// [`Error::RuntimeDir`].
    pub fn leave_rig_text(&self, text: &str) -> Result<(), Error> {
        let path = self.run_dir().join(RIG_TEXT);
        fs::write(&path, text).map_err(|e| Error::RuntimeDir { path, reason: e.to_string() })
    }

    /// Takes every right of other users to the shared memory of this run away. iceoryx2 0.10 gives them one: to its counter of nodes, the
    /// first thing it makes, and it only. Before its first client comes.
    ///
    /// # Errors
    /// [`Error::RuntimeDir`].
    pub(crate) fn close_to_others(&self) -> Result<(), Error> {
        for path in shared_memory(&self.run) {
            replace_by_own(&path).map_err(|e| Error::RuntimeDir { path, reason: e.to_string() })?;
        }
        Ok(())
    }

    pub(crate) fn run_dir(&self) -> PathBuf {
        self.dir.join(&self.run)
    }

    pub(crate) fn run(&self) -> &str {
        &self.run
    }

    pub(crate) fn key(&self) -> &str {
        &self.key
    }

    /// Tells clients that the services of this run can be opened.
    pub(crate) fn publish(&self, protocol: u32) -> Result<(), Error> {
        Record { pid: std::process::id(), protocol, run: self.run.clone() }
            .write(&self.file)
            .map_err(|e| Error::RuntimeDir { path: lock_path(&self.dir, &self.rig), reason: e.to_string() })
    }
}

/// Puts a copy that nobody else can open in the place of a file that others could. Rights that are taken away close no file that is open:
/// what somebody has opened meanwhile is nobody's now.
fn replace_by_own(path: &Path) -> io::Result<()> {
    if fs::symlink_metadata(path)?.mode() & 0o077 == 0 {
        return Ok(());
    }
    let content = fs::read(path)?;
    let mut copy = path.as_os_str().to_owned();
    copy.push(".own");
    OpenOptions::new().write(true).create_new(true).mode(0o600).open(&copy)?.write_all(&content)?;
    fs::rename(&copy, path)
}

impl Drop for RigLock {
    fn drop(&mut self) {
        // Removed while it is still locked: who opens it later finds a new one, who has it open notices (see `acquire_in`).
        // Should somebody have removed it before, the one that is there now is another driver's.
        let path = lock_path(&self.dir, &self.rig);
        if is_the_file_at(&self.file, &path) {
            let _ = fs::remove_file(path);
        }
        self.users = None;
        match Sweep::begin(&self.dir) {
            Ok(sweep) => sweep.run(&self.run),
            // Somebody has removed the runtime folder, and with it every way to find this run.
            Err(_) if !self.dir.exists() => remove_shared_memory(&self.run),
            Err(_) => {}
        }
    }
}

fn remove_shared_memory(run: &str) {
    for path in shared_memory(run) {
        let _ = fs::remove_file(path);
    }
}

fn is_the_file_at(file: &File, path: &Path) -> bool {
    match (file.metadata(), fs::metadata(path)) {
        (Ok(a), Ok(b)) => a.ino() == b.ino() && a.dev() == b.dev(),
        _ => false,
    }
}

/// A new run's folder and its key, with `users` held. Only while nobody sweeps: see [`Sweep`].
fn create_run(dir: &Path) -> Result<(String, String, File), Error> {
    let key = format!("{:0KEY_LETTERS$x}", RandomState::new().build_hasher().finish());
    let mut attempt = 0;
    loop {
        let run = run_name(attempt);
        match make_run(dir, &run, &key) {
            Err(e) if e.kind() == ErrorKind::AlreadyExists && attempt < 100 => attempt += 1,
            Err(e) => return Err(Error::RuntimeDir { path: dir.join(&run), reason: e.to_string() }),
            Ok(users) => return Ok((run, key, users)),
        }
    }
}

/// Makes the folder of a run of this name, whole from the first moment: one without `users` is somebody else's.
fn make_run(dir: &Path, run: &str, key: &str) -> std::io::Result<File> {
    let new = dir.join(format!("{NEW}{run}"));
    DirBuilder::new().mode(0o700).create(&new)?;
    let mut users = open(&new.join(USERS), true)?;
    users.write_all(key.as_bytes())?;
    sys::try_lock(&users, Lock::Shared)?;
    rename_to_new(&new, &dir.join(run)).inspect_err(|_| ours::remove_folder(&new, &prefix(run), &[USERS]))?;
    Ok(users)
}

/// The right to create and to remove runs, one process at a time.
struct Sweep {
    dir: PathBuf,
    _lock: File,
}

impl Sweep {
    fn begin(dir: &Path) -> Result<Sweep, Error> {
        let path = dir.join(".sweep");
        let failed = |e: std::io::Error| Error::RuntimeDir { path: path.clone(), reason: e.to_string() };
        let file = open(&path, true).map_err(failed)?;
        sys::lock(&file, Lock::Exclusive).map_err(failed)?;
        Ok(Sweep { dir: dir.into(), _lock: file })
    }

    /// Removes every run nobody uses and every lock file nobody holds. What cannot be removed is left for the next time.
    fn all(&self) {
        for entry in fs::read_dir(&self.dir).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let Some(name) = name.to_str() else { continue };
            if is_run_name(name) {
                self.run(name);
            } else if let Some(run) = name.strip_prefix(NEW).filter(|run| is_run_name(run)) {
                // Killed before it was whole.
                ours::remove_folder(&entry.path(), &prefix(run), &[USERS]);
            } else if name.ends_with(".lock") {
                let Ok(file) = open(&entry.path(), false) else { continue };
                let is_dead = matches!(sys::try_lock(&file, Lock::Shared), Ok(true)) && Record::read(&file).is_some();
                if is_dead && is_the_file_at(&file, &entry.path()) {
                    let _ = fs::remove_file(entry.path());
                }
            }
        }
    }

    /// Removes a run if nobody uses it.
    fn run(&self, run: &str) {
        let dir = self.dir.join(run);
        // Held until everything is gone.
        let _users = match open(&dir.join(USERS), false) {
            Ok(users) if matches!(sys::try_lock(&users, Lock::Exclusive), Ok(true)) => Some(users),
            // Somebody has removed the whole folder: nobody can find the rest any more.
            Err(e) if e.kind() == ErrorKind::NotFound && !dir.exists() => None,
            // Used; or a folder without it, which is none of ours, whatever its name.
            _ => return,
        };
        // Shared memory first: the folder is what it will be found by the next time, should this be interrupted.
        remove_shared_memory(run);
        ours::remove_folder(&dir, &prefix(run), &[USERS, RIG_TEXT]);
    }
}

/// Renames a folder, unless something of the new name is there already.
fn rename_to_new(from: &Path, to: &Path) -> std::io::Result<()> {
    let flags = rustix::fs::RenameFlags::NOREPLACE;
    rustix::fs::renameat_with(rustix::fs::CWD, from, rustix::fs::CWD, to, flags).map_err(std::io::Error::from)
}

/// A client's hold on a run: keeps its files from being swept away, and tells whether the driver lives.
#[derive(Debug)]
pub(crate) struct Attachment {
    rig: String,
    dir: PathBuf,
    pub(crate) run: String,
    pub(crate) key: String,
    pub(crate) pid: u32,
    lock: File,
    users: Option<File>,
}

impl Attachment {
    /// Finds the rig's driver. Waits for one that is just starting until `patience` is over.
    pub(crate) fn find(rig: &str, patience: Duration) -> Result<Attachment, Error> {
        check_rig_name(rig)?;
        let dir = runtime_dir()?;
        let started = Instant::now();
        let mut starting = 0;
        loop {
            match Attachment::try_find(&dir, rig, &mut starting)? {
                Some(found) => return Ok(found),
                None if started.elapsed() < patience => std::thread::sleep(Duration::from_millis(2)),
                None => return Err(Error::Starting { rig: rig.into(), pid: starting }),
            }
        }
    }

    /// `None` while it is starting.
    fn try_find(dir: &Path, rig: &str, starting: &mut u32) -> Result<Option<Attachment>, Error> {
        let path = lock_path(dir, rig);
        let not_running = || Error::NotRunning { rig: rig.into(), running: known(dir) };
        let failed = |e: std::io::Error| Error::RuntimeDir { path: path.clone(), reason: e.to_string() };
        let lock = match open(&path, false) {
            Ok(file) => file,
            Err(e) if e.kind() == ErrorKind::NotFound => return Err(not_running()),
            Err(e) => return Err(failed(e)),
        };
        if !sys::is_locked(&lock).map_err(failed)? {
            return Err(not_running());
        }
        let Some(record) = Record::read(&lock) else { return Ok(None) };
        if record.protocol != PROTOCOL {
            return Err(Error::Protocol { rig: rig.into(), found: record.protocol, expected: PROTOCOL });
        }
        *starting = record.pid;
        if record.run.is_empty() {
            return Ok(None);
        }
        let Ok(mut users) = open(&dir.join(&record.run).join(USERS), false) else { return Ok(None) };
        let mut key = [0; KEY_LETTERS];
        users.read_exact(&mut key).map_err(failed)?;
        if !sys::try_lock(&users, Lock::Shared).map_err(failed)? || !sys::is_locked(&lock).map_err(failed)? {
            // Swept, or its driver ended this instant: look again from the start.
            return Ok(None);
        }
        Ok(Some(Attachment {
            rig: rig.into(),
            dir: dir.into(),
            run: record.run,
            key: String::from_utf8_lossy(&key).into_owned(),
            pid: record.pid,
            lock,
            users: Some(users),
        }))
    }

    pub(crate) fn rig(&self) -> &str {
        &self.rig
    }

    pub(crate) fn run_dir(&self) -> PathBuf {
        self.dir.join(&self.run)
    }

    /// The rig file's text as the driver left it; `None` where it left none.
    pub(crate) fn rig_text(&self) -> Result<Option<String>, Error> {
        let path = self.run_dir().join(RIG_TEXT);
        let failed = |e: std::io::Error| Error::RuntimeDir { path: path.clone(), reason: e.to_string() };
        let file = match File::open(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            opened => opened.map_err(failed)?,
        };
        let mut text = String::new();
        file.take(MAX_RIG_TEXT).read_to_string(&mut text).map_err(failed)?;
        Ok(Some(text))
    }

    /// Whether the driver of this run still holds the rig.
    pub(crate) fn driver_lives(&self) -> bool {
        sys::is_locked(&self.lock).unwrap_or(false)
    }
}

impl Drop for Attachment {
    fn drop(&mut self) {
        self.users = None;
        // The last to leave a run whose driver is gone takes its files along.
        if !self.driver_lives()
            && let Ok(sweep) = Sweep::begin(&self.dir)
        {
            sweep.run(&self.run);
        }
    }
}

/// Names of the rigs a driver is running for, sorted: the own user's, and other users' that have a gateway.
///
/// # Errors
/// [`Error::RuntimeDir`].
pub fn running() -> Result<Vec<String>, Error> {
    runtime_dir().map(|dir| known(&dir)).or_else(|error| match crate::gateway::open_endpoints() {
        none if none.is_empty() => Err(error),
        others => Ok(others),
    })
}

fn known(dir: &Path) -> Vec<String> {
    let mut rigs = running_in(dir);
    rigs.extend(crate::gateway::open_endpoints());
    rigs.sort();
    rigs.dedup();
    rigs
}

fn running_in(dir: &Path) -> Vec<String> {
    let mut rigs: Vec<String> = fs::read_dir(dir)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name().to_str()?.strip_suffix(".lock")?.to_string();
            let file = open(&entry.path(), false).ok()?;
            sys::is_locked(&file).ok()?.then_some(name)
        })
        .collect();
    rigs.sort();
    rigs
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Scratch(PathBuf);
    impl Scratch {
        fn new(name: &str) -> Scratch {
            let path = std::env::temp_dir().join(format!("sinew-run-{}-{name}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Scratch(path)
        }
        fn entries(&self) -> Vec<String> {
            let mut names: Vec<String> =
                fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
            names.sort();
            names
        }
    }
    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn rig_names() {
        for good in ["hexapod", "a", "left.arm-2_B", &"x".repeat(48), ".."] {
            assert!(check_rig_name(good).is_ok(), "{good}");
        }
        for bad in ["", "a b", "a/b", "ä", "x\n", &"x".repeat(49), "a\0"] {
            assert_eq!(check_rig_name(bad), Err(Error::RigName { name: bad.to_string() }));
        }
    }

    #[test]
    fn one_driver_per_rig_and_the_second_learns_whose_it_is() {
        let dir = Scratch::new("one");
        let first = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
        let second = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap_err();
        assert_eq!(second, Error::AlreadyRunning { rig: "bench".into(), pid: std::process::id() });
        let other = RigLock::acquire_in(&dir.0, "other", PROTOCOL).unwrap();
        assert_eq!(running_in(&dir.0), ["bench", "other"]);
        assert_ne!(first.run(), other.run());
        drop(first);
        assert_eq!(running_in(&dir.0), ["other"]);
        drop(RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap());
        drop(other);
        assert_eq!(dir.entries(), [".sweep"]);
    }

    #[test]
    fn a_driver_whose_lock_file_was_removed_leaves_the_next_ones_alone() {
        let dir = Scratch::new("removed");
        let first = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
        fs::remove_file(lock_path(&dir.0, "bench")).unwrap();
        let second = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
        drop(first);
        assert_eq!(running_in(&dir.0), ["bench"], "it could not be stopped any more");
        drop(second);
        assert_eq!(dir.entries(), [".sweep"]);
    }

    #[test]
    fn of_many_that_start_at_once_exactly_one_wins_each_time() {
        let dir = Scratch::new("many");
        for _ in 0..20 {
            let winners: Vec<RigLock> = std::thread::scope(|scope| {
                let starts: Vec<_> =
                    (0..8).map(|_| scope.spawn(|| RigLock::acquire_in(&dir.0, "bench", PROTOCOL))).collect();
                starts.into_iter().filter_map(|t| t.join().unwrap().ok()).collect()
            });
            assert_eq!(winners.len(), 1);
        }
    }

    #[test]
    fn what_a_killed_driver_left_is_swept_but_not_what_a_client_still_uses() {
        let dir = Scratch::new("swept");
        let killed = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
        killed.publish(PROTOCOL).unwrap();
        let mut pid = 0;
        let client = Attachment::try_find(&dir.0, "bench", &mut pid).unwrap().unwrap();
        assert!(client.driver_lives());
        let run = killed.run().to_string();
        kill(killed);
        assert!(!client.driver_lives());
        let next = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
        assert!(dir.entries().contains(&run), "a client still uses it");
        assert!(!client.driver_lives(), "the next driver is not the one this client knew");
        drop(client);
        assert!(!dir.entries().contains(&run), "the last user takes it along");
        drop(next);
        assert_eq!(dir.entries(), [".sweep"]);
    }

    #[test]
    fn a_dead_driver_is_never_taken_for_a_living_one_while_others_clear_up_after_him() {
        let dir = Scratch::new("dead");
        for round in 0..300 {
            let dead = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
            dead.publish(PROTOCOL).unwrap();
            let run = dead.run().to_string();
            kill(dead);
            std::thread::scope(|scope| {
                // The next one of this rig, or of another one, which sweeps in passing.
                let rig = ["bench", "other"][round % 2];
                let next = scope.spawn(|| RigLock::acquire_in(&dir.0, rig, PROTOCOL).unwrap());
                while !next.is_finished() {
                    if let Ok(Some(found)) = Attachment::try_find(&dir.0, "bench", &mut 0) {
                        panic!("round {round}: found run {}, and {run} was the dead one", found.run);
                    }
                }
                next.join().unwrap();
            });
        }
    }

    /// What the kernel does when it is killed: the descriptors close, nothing is removed.
    fn kill(driver: RigLock) {
        let RigLock { ref file, ref users, .. } = driver;
        let (file, users) = (file.try_clone().unwrap(), users.as_ref().unwrap().try_clone().unwrap());
        std::mem::forget(driver);
        unlock(file);
        unlock(users);
    }

    #[allow(unsafe_code)]
    fn unlock(file: File) {
        use std::os::fd::AsRawFd;
        // SAFETY: flock is plain data for which zeros are valid.
        let mut record: libc::flock = unsafe { std::mem::zeroed() };
        record.l_type = libc::F_UNLCK as libc::c_short;
        // SAFETY: descriptor and record are valid during the call.
        assert_eq!(unsafe { libc::fcntl(file.as_raw_fd(), libc::F_OFD_SETLK, &mut record) }, 0);
    }

    #[test]
    fn what_is_not_ours_stays_whatever_its_name_and_what_is_half_made_goes() {
        let dir = Scratch::new("stray");
        fs::create_dir(dir.0.join("0123456789")).unwrap();
        fs::create_dir(dir.0.join("abcdefghij")).unwrap();
        fs::write(dir.0.join("abcdefghij/thesis.tex"), "years of work").unwrap();
        fs::write(dir.0.join("ghost.lock"), "nonsense").unwrap();
        fs::write(dir.0.join("notes.txt"), "not ours").unwrap();
        // Killed right after it was made, and before it got its name.
        fs::create_dir(dir.0.join(".sinew-new-0123456789")).unwrap();
        fs::write(dir.0.join(".sinew-new-0123456789/users"), "").unwrap();
        let lock = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
        // And one of a dead driver into whose folder somebody has put something.
        let run = lock.run_dir();
        fs::write(run.join("notes.txt"), "not ours either").unwrap();
        drop(lock);
        let mut left = dir.entries();
        left.retain(|name| !run.ends_with(name));
        assert_eq!(left, [".sweep", "0123456789", "abcdefghij", "ghost.lock", "notes.txt"]);
        assert!(dir.0.join("abcdefghij/thesis.tex").exists() && run.join("notes.txt").exists());
        assert!(!run.join("users").exists());
        let error = RigLock::acquire_in(&dir.0, "ghost", PROTOCOL).unwrap_err().to_string();
        assert!(error.contains("move it away") && dir.0.join("ghost.lock").exists(), "{error}");
    }

    #[test]
    fn a_starting_driver_and_another_protocol_are_told_apart() {
        let dir = Scratch::new("proto");
        let mut pid = 0;
        assert!(matches!(Attachment::try_find(&dir.0, "bench", &mut pid), Err(Error::NotRunning { .. })));
        let lock = RigLock::acquire_in(&dir.0, "bench", PROTOCOL + 1).unwrap();
        assert_eq!(
            Attachment::try_find(&dir.0, "bench", &mut pid).unwrap_err(),
            Error::Protocol { rig: "bench".into(), found: PROTOCOL + 1, expected: PROTOCOL }
        );
        drop(lock);
        let lock = RigLock::acquire_in(&dir.0, "bench", PROTOCOL).unwrap();
        assert!(Attachment::try_find(&dir.0, "bench", &mut pid).unwrap().is_none());
        assert_eq!(pid, std::process::id());
        lock.publish(PROTOCOL).unwrap();
        assert!(Attachment::try_find(&dir.0, "bench", &mut pid).unwrap().is_some());
    }
}
