//! Where the doors are, and whose door one may trust.
//!
//! A driver's door is `RIG.sock` in the gate's folder: `$SINEW_GATE_DIR`, else `/run/sinew`. A door in a folder anybody may write to
//! could be anybody's, so both sides are strict: the folder must belong to the driver's user (or root) and be closed to writers, and
//! nobody else may be able to put another folder in its place.

use super::peer::Peer;
use crate::{Error, check_rig_name};
use rustix::fs::{Access, AtFlags, CWD, accessat};
use rustix::net::{self, AddressFamily, SocketAddrUnix, SocketFlags, SocketType};
use std::fs::{self, DirBuilder, Metadata, Permissions};
use std::io::{self, ErrorKind};
use std::os::fd::OwnedFd;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

const ENDING: &str = ".sock";
/// Visitors that may wait for the porter.
const WAITING: i32 = 128;

/// The folder of the doors.
pub fn gate_dir() -> PathBuf {
    match std::env::var_os("SINEW_GATE_DIR") {
        Some(path) if !path.is_empty() => path.into(),
        _ => "/run/sinew".into(),
    }
}

fn wrong(path: &Path, reason: impl ToString) -> Error {
    Error::Gate { path: path.into(), reason: reason.to_string() }
}

fn socket() -> io::Result<OwnedFd> {
    let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
    Ok(net::socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None)?)
}

/// Only root and `users` can have put a file of this path there, or can put another one in its place.
fn is_kept(dir: &Path, users: [u32; 2], own: u32) -> Result<(), String> {
    let mut must_be_trusted = false;
    // From the root downwards: whoever may write to a folder says what is in it; in one with the sticky bit (such as /tmp) the
    // first comer does, and then only root and we ourselves are good enough.
    for folder in dir.ancestors().collect::<Vec<_>>().into_iter().rev() {
        let meta = fs::symlink_metadata(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        if meta.is_symlink() {
            return Err(format!("{} is a link; name the folder itself", folder.display()));
        }
        if !meta.is_dir() {
            return Err(format!("{} is not a folder", folder.display()));
        }
        let owner = meta.uid();
        if owner != 0 && owner != own && (must_be_trusted || !users.contains(&owner)) {
            return Err(format!("{} belongs to user {owner}", folder.display()));
        }
        let open = meta.mode() & 0o022 != 0;
        if open && (folder == dir || meta.mode() & 0o1000 == 0) {
            return Err(format!("others may write to {}", folder.display()));
        }
        must_be_trusted = open;
    }
    Ok(())
}

/// A driver's door. Taken away when dropped.
#[derive(Debug)]
pub(crate) struct Door {
    path: PathBuf,
    made: Metadata,
    pub socket: OwnedFd,
}

impl Door {
    /// Opens the door of a rig.
    ///
    /// # Errors
    /// [`Error::Gate`].
    pub fn open(rig: &str) -> Result<Door, Error> {
        check_rig_name(rig)?;
        Door::open_in(&gate_dir(), rig)
    }

    pub fn open_in(dir: &Path, rig: &str) -> Result<Door, Error> {
        let own = crate::sys::user_id();
        absolute(dir)?;
        match DirBuilder::new().mode(0o755).create(dir) {
            // Whatever the umask says: others are to find the door.
            Ok(()) => fs::set_permissions(dir, Permissions::from_mode(0o755)).map_err(|e| wrong(dir, e))?,
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(wrong(dir, e)),
        }
        is_kept(dir, [own; 2], own).map_err(|reason| wrong(dir, reason))?;
        let path = door_path(dir, rig);
        let address = SocketAddrUnix::new(&path).map_err(|_| wrong(&path, "its path is too long for a socket"))?;
        let socket = socket().map_err(|e| wrong(&path, e))?;
        match knock(&path) {
            Knocked::In(_) | Knocked::Busy => {
                return Err(wrong(&path, "another driver for a rig of this name stands there"));
            }
            // A killed driver's.
            Knocked::NobodyThere => drop(fs::remove_file(&path)),
            Knocked::Failed(e) if e.kind() == ErrorKind::NotFound => {}
            Knocked::Failed(e) => return Err(wrong(&path, e)),
        }
        net::bind(&socket, &address).map_err(|e| wrong(&path, io::Error::from(e)))?;
        let made = fs::symlink_metadata(&path).map_err(|e| wrong(&path, e))?;
        let door = Door { path: path.clone(), made, socket };
        // Everybody may knock; who comes in is the porter's business, and who does not is told why.
        fs::set_permissions(&path, Permissions::from_mode(0o666)).map_err(|e| wrong(&path, e))?;
        net::listen(&door.socket, WAITING).map_err(|e| wrong(&path, io::Error::from(e)))?;
        Ok(door)
    }
}

impl Drop for Door {
    fn drop(&mut self) {
        // Not when somebody has put another one there.
        let ours = |found: Metadata| (found.dev(), found.ino()) == (self.made.dev(), self.made.ino());
        if fs::symlink_metadata(&self.path).is_ok_and(ours) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn absolute(dir: &Path) -> Result<(), Error> {
    if dir.is_absolute() { Ok(()) } else { Err(wrong(dir, "it is not an absolute path")) }
}

/// What this user's driver would find where the door of a rig is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Doorway {
    /// Its folder is there, and kept as it has to be.
    Free,
    /// Its folder would be made.
    ToBeMade,
    /// The driver of this process stands there.
    Taken(u32),
}

/// Whether a driver of this user could open the door of a rig, and where; nothing is changed.
///
/// # Errors
/// [`Error::Gate`], as the driver would end with; [`Error::RigName`].
pub fn survey(rig: &str) -> Result<(PathBuf, Doorway), Error> {
    check_rig_name(rig)?;
    let dir = gate_dir();
    survey_in(&dir, rig).map(|found| (door_path(&dir, rig), found))
}

fn survey_in(dir: &Path, rig: &str) -> Result<Doorway, Error> {
    let own = crate::sys::user_id();
    absolute(dir)?;
    let path = door_path(dir, rig);
    SocketAddrUnix::new(&path).map_err(|_| wrong(&path, "its path is too long for a socket"))?;
    if let Ok(Found::Driver(_, peer)) = find(dir, rig) {
        return Ok(Doorway::Taken(peer.pid));
    }
    let (kept, doorway) = match dir.parent() {
        Some(above) if !dir.exists() => {
            // In a folder with the sticky bit, which is open to all, one's own is kept as well.
            (is_kept_above(above, own), Doorway::ToBeMade)
        }
        _ => (is_kept(dir, [own; 2], own), Doorway::Free),
    };
    kept.map_err(|reason| wrong(dir, reason))?;
    let place = if doorway == Doorway::ToBeMade { dir.parent().unwrap_or(dir) } else { dir };
    let effective = (Access::WRITE_OK | Access::EXEC_OK, AtFlags::EACCESS);
    accessat(CWD, place, effective.0, effective.1)
        .map_err(|e| wrong(dir, format!("this user may not write to {}: {e}", place.display())))?;
    Ok(doorway)
}

/// A folder that a new one is to be made in: open to others only where the sticky bit protects what is in it.
fn is_kept_above(above: &Path, own: u32) -> Result<(), String> {
    match is_kept(above, [own; 2], own) {
        Err(reason) => {
            let sticky = fs::symlink_metadata(above).is_ok_and(|meta| meta.is_dir() && meta.mode() & 0o1000 != 0);
            let beyond = above.parent().map_or(Ok(()), |beyond| is_kept_above(beyond, own));
            if sticky { beyond } else { Err(reason) }
        }
        Ok(()) => Ok(()),
    }
}

fn door_path(dir: &Path, rig: &str) -> PathBuf {
    dir.join(format!("{rig}{ENDING}"))
}

/// What comes of knocking.
enum Knocked {
    In(OwnedFd),
    /// Too many knock at once.
    Busy,
    /// A killed driver's door.
    NobodyThere,
    Failed(io::Error),
}

fn knock(path: &Path) -> Knocked {
    let attempt = || -> io::Result<OwnedFd> {
        let socket = socket()?;
        net::connect(&socket, &SocketAddrUnix::new(path)?)?;
        Ok(socket)
    };
    match attempt() {
        Ok(socket) => Knocked::In(socket),
        Err(e) if e.kind() == ErrorKind::WouldBlock => Knocked::Busy,
        Err(e) if e.kind() == ErrorKind::ConnectionRefused => Knocked::NobodyThere,
        Err(e) => Knocked::Failed(e),
    }
}

/// What is found at a rig's door.
pub(crate) enum Found {
    /// A driver, with its user and process.
    Driver(OwnedFd, Peer),
    /// One that has many knocking; worth another attempt.
    Busy,
    /// Nobody.
    Nobody,
}

/// Knocks at the door of a rig, and makes sure whose it is.
///
/// # Errors
/// [`Error::Gate`] for a door that could be anybody's.
pub(crate) fn find(dir: &Path, rig: &str) -> Result<Found, Error> {
    let path = door_path(dir, rig);
    let socket = match knock(&path) {
        Knocked::In(socket) => socket,
        Knocked::Busy => return Ok(Found::Busy),
        Knocked::NobodyThere => return Ok(Found::Nobody),
        Knocked::Failed(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(Found::Nobody);
        }
        Knocked::Failed(e) => return Err(wrong(&path, e)),
    };
    let driver = Peer::of(&socket).map_err(|e| wrong(&path, e))?;
    let own = crate::sys::user_id();
    is_kept(dir, [driver.user; 2], own).map_err(|reason| {
        wrong(&path, format!("it could be anybody's door (that of user {}): {reason}", driver.user))
    })?;
    Ok(Found::Driver(socket, driver))
}

/// Names of the rigs at whose doors somebody stands, sorted.
pub(crate) fn open_doors() -> Vec<String> {
    let dir = gate_dir();
    let mut rigs: Vec<String> = fs::read_dir(&dir)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| Some(entry.file_name().to_str()?.strip_suffix(ENDING)?.to_string()))
        .filter(|rig| check_rig_name(rig).is_ok() && matches!(find(&dir, rig), Ok(Found::Driver(..))))
        .collect();
    rigs.sort();
    rigs
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    fn folder() -> TempDir {
        let dir = tempfile::Builder::new().prefix("sinew-gate-").tempdir().unwrap();
        fs::set_permissions(dir.path(), Permissions::from_mode(0o755)).unwrap();
        dir
    }

    #[test]
    fn one_door_per_rig_and_a_dead_ones_is_replaced() {
        let dir = folder();
        let door = Door::open_in(dir.path(), "bench").unwrap();
        assert!(matches!(find(dir.path(), "bench"), Ok(Found::Driver(_, peer)) if peer.pid == std::process::id()));
        assert_eq!(survey_in(dir.path(), "bench"), Ok(Doorway::Taken(std::process::id())));
        let second = Door::open_in(dir.path(), "bench").unwrap_err();
        assert!(second.to_string().contains("another driver"), "{second}");
        let path = door.path.clone();
        drop(door);
        assert!(!path.exists());
        // What a killed one leaves: the socket closes, the file stays.
        let dead = socket().unwrap();
        net::bind(&dead, &SocketAddrUnix::new(&path).unwrap()).unwrap();
        net::listen(&dead, 1).unwrap();
        drop(dead);
        assert!(path.exists());
        assert!(matches!(find(dir.path(), "bench"), Ok(Found::Nobody)));
        assert_eq!(survey_in(dir.path(), "bench"), Ok(Doorway::Free), "a dead one's is in nobody's way");
        let next = Door::open_in(dir.path(), "bench").unwrap();
        assert!(matches!(find(dir.path(), "bench"), Ok(Found::Driver(..))));
        drop(next);
        assert!(!path.exists());
        assert!(matches!(find(dir.path(), "bench"), Ok(Found::Nobody)));
    }

    #[test]
    fn a_door_that_could_be_anybodys_is_none() {
        let dir = folder();
        for (mode, trusted) in [(0o755, true), (0o777, false), (0o1777, false), (0o775, false), (0o711, true)] {
            fs::set_permissions(dir.path(), Permissions::from_mode(0o755)).unwrap();
            let inner = dir.path().join("gate");
            fs::create_dir_all(&inner).unwrap();
            fs::set_permissions(&inner, Permissions::from_mode(mode)).unwrap();
            // What is foretold is what happens.
            let foretold = survey_in(&inner, "bench");
            let found = Door::open_in(&inner, "bench");
            assert_eq!(foretold.map(drop), found.as_ref().map(drop).map_err(Clone::clone), "{mode:o}");
            assert_eq!(found.is_ok(), trusted, "{mode:o}: {found:?}");
            if let Err(error) = found {
                assert!(error.to_string().contains("others may write to"), "{error}");
            }
            drop(fs::remove_dir_all(&inner));
        }
        assert_eq!(survey_in(&dir.path().join("gate"), "bench"), Ok(Doorway::ToBeMade));
        assert!(!dir.path().join("gate").exists(), "looking changes nothing");
        assert!(survey_in(Path::new("relative"), "bench").is_err());
        assert!(survey_in(&dir.path().join("no/where"), "bench").is_err());
        // Its parent: somebody else could put another folder in its place.
        let inner = dir.path().join("gate");
        let door = Door::open_in(&inner, "bench").unwrap();
        fs::set_permissions(dir.path(), Permissions::from_mode(0o777)).unwrap();
        let error = find(&inner, "bench").map(drop).unwrap_err().to_string();
        assert!(error.contains("could be anybody's door"), "{error}");
        fs::set_permissions(dir.path(), Permissions::from_mode(0o1777)).unwrap();
        assert!(find(&inner, "bench").is_ok(), "in a sticky folder what is ours stays ours");
        let link = dir.path().join("link");
        std::os::unix::fs::symlink(&inner, &link).unwrap();
        assert!(find(&link, "bench").is_err());
        drop(door);
        assert!(matches!(Door::open_in(Path::new("relative"), "bench"), Err(Error::Gate { .. })));
        assert!(matches!(Door::open_in(&dir.path().join("x".repeat(100)), "bench"), Err(Error::Gate { .. })));
    }
}
