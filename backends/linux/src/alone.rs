//! Who may write to a file. Whether anybody but this user (and root) may is the only thing by which it can be known that nobody else has used an
//! output; and a lock of somebody who may not is no driver's.
//!
//! The kernel keeps no note of who wrote to a file of sysfs last. So a file that a group may write to is only this user's where he is its
//! only member, as `/etc/passwd` and `/etc/group` have it; a group that is not in there may be anybody's.

use std::fs::{self, File, Metadata};
use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::fs::{major, minor};
use rustix::io::Errno;
use rustix::process::{Pid, geteuid, test_kill_process};

/// Root, and its group.
const ROOT: u32 = 0;

/// Who else may write to a file, in words; `None` where nobody may.
pub(crate) fn others(path: &Path) -> Option<String> {
    let found = match fs::metadata(path) {
        Ok(found) => found,
        Err(error) => return Some(format!("it cannot be told who ({error})")),
    };
    let text = |path: &str| fs::read_to_string(path).unwrap_or_default();
    let own = geteuid().as_raw();
    others_of(found.mode(), found.uid(), found.gid(), own, &text("/etc/passwd"), &text("/etc/group"))
}

fn others_of(mode: u32, owner: u32, group: u32, own: u32, accounts: &str, groups: &str) -> Option<String> {
    if owner != own && owner != ROOT {
        return Some(format!("user {owner}"));
    }
    if mode & 0o002 != 0 {
        return Some("everybody".into());
    }
    if mode & 0o020 == 0 {
        return None;
    }
    // NAME:PASSWORD:UID:GID:…
    let account = |line: &'_ str| {
        let mut fields = line.split(':');
        let (name, user, group) = (fields.next()?, fields.nth(1)?, fields.next()?);
        Some((name.to_string(), user.parse::<u32>().ok()?, group.parse::<u32>().ok()?))
    };
    let accounts: Vec<(String, u32, u32)> = accounts.lines().filter_map(account).collect();
    let is_ours = |user: u32| user == own || user == ROOT;
    // NAME:PASSWORD:GID:MEMBER,MEMBER
    let line = groups.lines().find(|line| line.split(':').nth(2) == Some(&group.to_string()));
    let Some(line) = line else { return Some(format!("group {group}")) };
    let name = line.split(':').next().unwrap_or_default();
    let members = line.split(':').nth(3).unwrap_or_default().split(',').map(str::trim).filter(|name| !name.is_empty());
    let user = |name: &str| accounts.iter().find(|(known, ..)| known == name).map(|(_, user, _)| *user);
    let is_alone = members.map(user).all(|user| user.is_some_and(is_ours))
        && accounts.iter().filter(|(.., first)| *first == group).all(|(_, user, _)| is_ours(*user));
    (!is_alone).then(|| format!("group {name}"))
}

/// Whether a file is locked by nobody but processes that may not write to it. To lock a file of sysfs it is enough to read it, which everybody
/// may.
pub(crate) fn is_locked_by_strangers(file: &File) -> bool {
    let Ok(found) = file.metadata() else { return false };
    let holders = holders(&found);
    !holders.is_empty()
        && holders.into_iter().all(|pid| match fs::read_to_string(format!("/proc/{pid}/status")) {
            Ok(status) => !may_write(&status, &found),
            // One that has died after it had given the lock to a child is no guard, which has none; one that is hidden may be.
            Err(_) => Pid::from_raw(pid).is_some_and(|pid| test_kill_process(pid) == Err(Errno::SRCH)),
        })
}

/// The processes that have locked a file. The kernel gives `/proc/locks` out in pieces and finds its place again by counting, so that a lock
/// is passed over where one before it ends between two pieces: whoever is in one of several readings counts.
fn holders(file: &Metadata) -> Vec<i32> {
    const READINGS: usize = 3;
    let mut found: Vec<i32> = Vec::new();
    for _ in 0..READINGS {
        // Its pieces are a page each where so much is asked for at once; `fs::read_to_string` asks for 32 bytes first.
        let mut locks = String::with_capacity(1 << 16);
        let read = File::open("/proc/locks").and_then(|mut file| file.read_to_string(&mut locks));
        if read.is_ok() {
            found.extend(holders_in(&locks, file));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// By lines of `/proc/locks`: `1: FLOCK  ADVISORY  WRITE PID MAJOR:MINOR:INODE START END`.
fn holders_in<'a>(locks: &'a str, file: &Metadata) -> impl Iterator<Item = i32> + 'a {
    let place = format!("{:02x}:{:02x}:{}", major(file.dev()), minor(file.dev()), file.ino());
    locks.lines().filter_map(move |line| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let pid = fields.iter().position(|field| *field == place)?.checked_sub(1)?;
        fields[pid].parse().ok()
    })
}

/// Whether a process of this `/proc/PID/status` may write to a file, or is this user's or root's.
fn may_write(status: &str, file: &Metadata) -> bool {
    let numbers = |key: &str| -> Vec<u32> {
        let line = status.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_default();
        line.split_whitespace().filter_map(|number| number.parse().ok()).collect()
    };
    let (users, groups) = (numbers("Uid:"), [numbers("Gid:"), numbers("Groups:")].concat());
    let is_theirs = |user: &u32| [ROOT, geteuid().as_raw(), file.uid()].contains(user);
    // What cannot be read may be anybody's.
    users.is_empty()
        || users.iter().any(is_theirs)
        || (file.mode() & 0o020 != 0 && groups.contains(&file.gid()))
        || file.mode() & 0o002 != 0
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACCOUNTS: &str =
        "root:x:0:0:root:/root:/bin/sh\nrobot:x:1001:1001::/:\nanna:x:1002:1002::/:\nben:x:1003:50::/:\n";
    const GROUPS: &str =
        "root:x:0:\npwm:x:40:robot\nshared:x:41:robot,anna\nfirst:x:50:robot\nempty:x:51:\nrobot:x:1001:\n";

    #[test]
    fn a_lock_counts_whose_holder_may_write() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("duty_cycle");
        fs::write(&path, "0").unwrap();
        let (file, found) = (File::open(&path).unwrap(), fs::metadata(&path).unwrap());
        assert!(!is_locked_by_strangers(&file), "nobody has");
        let other = File::open(&path).unwrap();
        rustix::fs::flock(&other, rustix::fs::FlockOperation::LockExclusive).unwrap();
        assert!(!is_locked_by_strangers(&file), "we have");
        assert_eq!(holders(&found), [std::process::id() as i32]);

        let status = |user: u32, groups: &str| {
            format!("Name:\tx\nUid:\t{user}\t{user}\t{user}\t{user}\nGid:\t7\t7\t7\t7\nGroups:\t{groups}\n")
        };
        let stranger = found.uid().max(geteuid().as_raw()) + 1000;
        assert!(!may_write(&status(stranger, "8 9"), &found));
        assert!(
            may_write(&status(found.uid(), ""), &found)
                && may_write(&status(ROOT, ""), &found)
                && may_write("", &found)
        );
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(&path, fs::Permissions::from_mode(0o664)).unwrap();
        let found = fs::metadata(&path).unwrap();
        assert!(may_write(&status(stranger, &format!("8 {} 9", found.gid())), &found));
        assert!(!may_write(&status(stranger, &format!("8 {}", found.gid() + 1)), &found));
    }

    /// A lock that somebody took through a descriptor for reading.
    #[test]
    fn a_stranger_who_may_only_read_locks_nobody_out() {
        use std::os::unix::fs::PermissionsExt;
        if geteuid().as_raw() != ROOT {
            eprintln!("skipped: being another user takes root");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        let path = folder.path().join("duty_cycle");
        fs::write(&path, "0").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
        let file = File::open(&path).unwrap();
        let locked = |user: u32| {
            let mut command = std::process::Command::new("setpriv");
            command.args([&format!("--reuid={user}"), "--regid=64300", "--clear-groups", "flock", "-x", "--no-fork"]);
            let Ok(mut holder) = command.arg(&path).args(["sleep", "30"]).spawn() else {
                eprintln!("skipped: no setpriv here");
                return None;
            };
            let found = fs::metadata(&path).unwrap();
            while holders(&found).is_empty() {
                assert!(holder.try_wait().unwrap().is_none(), "it locks");
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
            let by_strangers = is_locked_by_strangers(&file);
            holder.kill().unwrap();
            holder.wait().unwrap();
            Some(by_strangers)
        };
        let Some(by_strangers) = locked(64_204) else { return };
        assert!(by_strangers, "who may not write is no driver");
        assert_eq!(locked(ROOT), Some(false), "who may write is one");
    }

    /// The kernel's list has hundreds of others', which come and go.
    #[test]
    fn a_lock_is_seen_among_others_that_end() {
        use std::sync::atomic::{AtomicBool, Ordering};
        let folder = tempfile::tempdir().unwrap();
        let open = |name: &str| File::create(folder.path().join(name)).unwrap();
        let lock = |file: &File| rustix::fs::flock(file, rustix::fs::FlockOperation::LockExclusive).unwrap();
        let ours = open("duty_cycle");
        lock(&ours);
        let found = ours.metadata().unwrap();
        let is_over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !is_over.load(Ordering::Relaxed) {
                    let others: Vec<File> = (0..100).map(|k| open(&format!("other{k}"))).collect();
                    others.iter().for_each(lock);
                }
            });
            let missed = (0..3000).filter(|_| holders(&found) != [std::process::id() as i32]).count();
            is_over.store(true, Ordering::Relaxed);
            assert_eq!(missed, 0, "of 3000");
        });
    }

    #[test]
    fn a_file_is_ours_where_nobody_else_may_write_to_it() {
        let who = |mode, owner, group| others_of(mode, owner, group, 1001, ACCOUNTS, GROUPS);
        for (mode, owner, group) in
            [(0o644, 0, 0), (0o644, 1001, 41), (0o664, 0, 40), (0o664, 0, 51), (0o660, 1001, 1001), (0o664, 0, 0)]
        {
            assert_eq!(who(mode, owner, group), None, "{mode:o} {owner} {group}");
        }
        for (mode, owner, group, says) in [
            (0o646, 0, 0, "everybody"),
            (0o644, 1002, 0, "user 1002"),
            (0o664, 0, 41, "group shared"),
            (0o664, 0, 50, "group first"),
            (0o664, 0, 77, "group 77"),
        ] {
            assert_eq!(who(mode, owner, group).as_deref(), Some(says), "{mode:o} {owner} {group}");
        }
        let stranger = GROUPS.replace("robot", "robot,nobody_known");
        assert!(others_of(0o664, 0, 40, 1001, ACCOUNTS, &stranger).is_some());
    }
}
