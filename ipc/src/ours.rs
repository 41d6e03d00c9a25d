//! What is this user's: which folders may be taken for our own, and what may be removed: files and folders that bear a run's name and
//! belong to this user, and nothing else, however they came there.
//!
//! Everything is reached from an open folder and without following links, so that nobody can put another file in the place of one that was
//! looked at.

use std::collections::hash_map::RandomState;
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::hash::{BuildHasher, Hasher};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{AtFlags, CWD, Dir, FileType, Mode, OFlags, openat, statat, unlinkat};

use crate::sys;

/// Folders deeper in a run's than that are none of iceoryx2's.
const DEEPEST: u32 = 4;

/// Opens a file to read and write, made if that is asked for: an ordinary file of this user's, and no link to one.
///
/// # Errors
/// [`io::ErrorKind::NotFound`] where it is not there, and one that says so where it is something else.
pub(crate) fn open(path: &Path, create: bool) -> io::Result<File> {
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32;
    let mut options = OpenOptions::new();
    let file =
        options.read(true).write(true).create(create).truncate(false).mode(0o600).custom_flags(flags).open(path)?;
    let found = file.metadata()?;
    if !found.is_file() || found.uid() != sys::user_id() {
        return Err(io::Error::other("there is something there that is not this user's file"));
    }
    Ok(file)
}

/// Makes a folder of this user's, if it is not there. Where anybody may write (`/tmp`, `/dev/shm`) somebody may have put something there
/// before: only what is ours is taken, and only if others have none of the rights `closed`.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn own_folder(path: &Path, closed: u32) -> Result<(), String> {
    match DirBuilder::new().mode(0o700).create(path) {
        Err(e) if e.kind() != io::ErrorKind::AlreadyExists => return Err(e.to_string()),
        _ => {}
    }
    let found = fs::symlink_metadata(path).map_err(|e| e.to_string())?;
    if !found.is_dir() {
        return Err("it is not a folder".into());
    }
    if found.uid() != sys::user_id() {
        return Err(format!("it belongs to user {}, not to {}", found.uid(), sys::user_id()));
    }
    match found.mode() & closed {
        0 => Ok(()),
        open if open & 0o022 != 0 => Err("others may write to it".into()),
        _ => Err("others may look into it".into()),
    }
}

/// A folder of this user's in one where anybody may make some (`/tmp`, `/dev/shm`): `NAME-UID`, made if it is not there. Where somebody else
/// has that name, it is the first of this user's whose names begin so, or a new one with an end that nobody can know before.
///
/// # Errors
/// What is wrong with this user's own, in words.
pub fn own_folder_among(shared: &Path, name: &str, closed: u32) -> Result<PathBuf, String> {
    let name = format!("{name}-{}", sys::user_id());
    let path = shared.join(&name);
    let wrong = match own_folder(&path, closed) {
        Ok(()) => return Ok(path),
        Err(reason) => format!("{}: {reason}", path.display()),
    };
    let is_ours = |path: &Path| fs::symlink_metadata(path).is_ok_and(|found| found.uid() == sys::user_id());
    if is_ours(&path) || fs::symlink_metadata(&path).is_err() {
        return Err(wrong);
    }
    let begins = format!("{name}-");
    // Whoever makes one looks again, so that two that come at once agree.
    for _ in 0..8 {
        let all = fs::read_dir(shared).into_iter().flatten().flatten();
        let named = all.filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&begins)));
        let own = named.map(|entry| entry.path()).filter(|path| is_ours(path) && own_folder(path, closed).is_ok());
        if let Some(first) = own.min() {
            return Ok(first);
        }
        let end = RandomState::new().build_hasher().finish() & 0xff_ffff;
        let _ = own_folder(&shared.join(format!("{begins}{end:06x}")), closed);
    }
    Err(wrong)
}

/// The ordinary files of this user's in a folder whose names begin like this.
pub(crate) fn files(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let all = fs::read_dir(folder).into_iter().flatten().flatten();
    let named = all.filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(prefix)));
    let own =
        |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|found| found.is_file() && found.uid() == sys::user_id());
    named.map(|entry| entry.path()).filter(own).collect()
}

/// Removes a run's folder as far as it is the run's: files that bear `prefix` or one of `names`, and the folders that are empty then.
/// What else lies in there stays, and its folder with it.
pub(crate) fn remove_folder(folder: &Path, prefix: &str, names: &[&str]) {
    let Ok(opened) = openat(CWD, folder, OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC, Mode::empty()) else {
        return;
    };
    clear(&opened, prefix, names, DEEPEST);
    drop(opened);
    // Fails where anything is left.
    let _ = fs::remove_dir(folder);
}

fn clear(folder: &impl std::os::fd::AsFd, prefix: &str, names: &[&str], deeper: u32) {
    let Ok(entries) = Dir::read_from(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Ok(text) = name.to_str() else { continue };
        if matches!(text, "." | "..") {
            continue;
        }
        let Ok(found) = statat(folder, name, AtFlags::SYMLINK_NOFOLLOW) else { continue };
        if found.st_uid != sys::user_id() {
            continue;
        }
        match FileType::from_raw_mode(found.st_mode) {
            FileType::Directory if deeper > 0 => {
                let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
                if let Ok(inner) = openat(folder, name, flags, Mode::empty()) {
                    clear(&inner, prefix, &[], deeper - 1);
                }
                // Only folders that iceoryx2 makes; one that is not empty stays.
                if text.starts_with(prefix)
                    || matches!(text, "nodes" | "services")
                    || text.bytes().all(|b| b.is_ascii_digit())
                {
                    let _ = unlinkat(folder, name, AtFlags::REMOVEDIR);
                }
            }
            FileType::RegularFile | FileType::Socket | FileType::Fifo
                if text.starts_with(prefix) || names.contains(&text) =>
            {
                let _ = unlinkat(folder, name, AtFlags::empty());
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn only_what_bears_the_name_goes_and_links_are_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = folder.path().join("elsewhere");
        fs::create_dir(&elsewhere).unwrap();
        fs::write(elsewhere.join("sinew_run_precious"), "").unwrap();
        let run = folder.path().join("run");
        fs::create_dir_all(run.join("nodes/17")).unwrap();
        fs::create_dir_all(run.join("services")).unwrap();
        for ours in
            ["users", "rig.toml", "nodes/17/sinew_run_a.details", "nodes/sinew_run_17.monitor", "services/sinew_run_b"]
        {
            fs::write(run.join(ours), "").unwrap();
        }
        symlink(&elsewhere, run.join("services/sinew_run_link")).unwrap();
        symlink(&elsewhere, run.join("nodes/18")).unwrap();
        remove_folder(&run, "sinew_run_", &["users", "rig.toml"]);
        assert!(elsewhere.join("sinew_run_precious").exists(), "behind a link");
        assert!(run.join("nodes/18").exists() && !run.join("nodes/17").exists() && !run.join("users").exists());

        fs::remove_file(run.join("nodes/18")).unwrap();
        fs::remove_file(run.join("services/sinew_run_link")).unwrap();
        fs::write(run.join("nodes/notes.txt"), "mine").unwrap();
        fs::create_dir_all(run.join("nodes/17")).unwrap();
        fs::write(run.join("nodes/17/users"), "mine too").unwrap();
        remove_folder(&run, "sinew_run_", &["users", "rig.toml"]);
        assert!(run.join("nodes/notes.txt").exists() && run.join("nodes/17/users").exists());
        assert!(!run.join("services").exists());
        fs::remove_file(run.join("nodes/notes.txt")).unwrap();
        fs::remove_file(run.join("nodes/17/users")).unwrap();
        remove_folder(&run, "sinew_run_", &[]);
        assert!(!run.exists());
    }

    #[test]
    fn where_somebody_else_has_the_name_a_folder_has_another_one_and_keeps_it() {
        let shared = tempfile::tempdir().unwrap();
        let plain = own_folder_among(shared.path(), "sinew", 0o077).unwrap();
        assert_eq!(plain, shared.path().join(format!("sinew-{}", sys::user_id())));
        assert_eq!(own_folder_among(shared.path(), "sinew", 0o077).as_ref(), Ok(&plain));
        fs::remove_dir(&plain).unwrap();
        // Our own that is open to others, or a link, is said and not passed over.
        symlink(shared.path(), &plain).unwrap();
        assert!(own_folder_among(shared.path(), "sinew", 0o077).is_err());
        fs::remove_file(&plain).unwrap();
        if sys::user_id() != 0 {
            return;
        }
        for number in 0..50 {
            let taken =
                if number == 0 { plain.clone() } else { PathBuf::from(format!("{}-{number:06}", plain.display())) };
            fs::create_dir(&taken).unwrap();
            std::os::unix::fs::chown(&taken, Some(64_204), None).unwrap();
        }
        let another = own_folder_among(shared.path(), "sinew", 0o077).unwrap();
        assert_ne!(another, plain);
        assert_eq!(fs::symlink_metadata(&another).unwrap().uid(), 0);
        assert_eq!(own_folder_among(shared.path(), "sinew", 0o077), Ok(another));
    }

    #[test]
    fn a_link_and_a_pipe_are_no_files() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        assert_eq!(open(&file, false).unwrap_err().kind(), io::ErrorKind::NotFound);
        open(&file, true).unwrap();
        symlink(&file, &link).unwrap();
        assert!(open(&link, false).is_err());
        let pipe = folder.path().join("pipe");
        rustix::fs::mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        assert!(open(&pipe, false).is_err());
        assert_eq!(files(folder.path(), "f"), [file]);
    }
}
