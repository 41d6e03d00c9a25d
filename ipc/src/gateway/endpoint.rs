//! Where the gateways' sockets are, and which of them may be trusted.
//!
//! A driver's socket is `RIG.sock` in the gateway's folder: `$SINEW_GATE_DIR`, else `/run/sinew`. A socket in a folder anybody may
//! write to could be anybody's, so both sides are strict: the folder must belong to the driver's user (or root) and be closed to writers, and
//! nobody else may be able to put another folder in its place.

use super::peer::Peer;
use crate::error::Error;
use crate::names::check_rig_name;
use rustix::fs::{Access, AtFlags, CWD, accessat};
use rustix::net::{self, AddressFamily, SocketAddrUnix, SocketFlags, SocketType};
use std::fs::{self, DirBuilder, Metadata, Permissions};
use std::io::{self, ErrorKind};
use std::os::fd::OwnedFd;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

const ENDING: &str = ".sock";
/// Connections that may wait to be accepted.
const WAITING: i32 = 128;

/// The folder of the sockets.
pub fn gateway_dir() -> PathBuf {
    match std::env::var_os("SINEW_GATE_DIR") {
        Some(path) if !path.is_empty() => path.into(),
        _ => "/run/sinew".into(),
    }
}

fn wrong(path: &Path, reason: impl ToString) -> Error {
    Error::Gateway { path: path.into(), reason: reason.to_string() }
}

fn socket() -> io::Result<OwnedFd> {
    let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
    Ok(net::socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None)?)
}

/// Only root and `users` can have put a file of this path there, or can put another one in its place.
fn is_protected(dir: &Path, users: [u32; 2], own: u32) -> Result<(), String> {
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

/// A driver's socket. Taken away when dropped.
#[derive(Debug)]
pub(crate) struct Endpoint {
    path: PathBuf,
    made: Metadata,
    pub socket: OwnedFd,
}

impl Endpoint {
    /// Opens the socket of a rig.
    ///
    /// # Errors
    /// [`Error::Gateway`].
    pub fn open(rig: &str) -> Result<Endpoint, Error> {
        check_rig_name(rig)?;
        Endpoint::open_in(&gateway_dir(), rig)
    }

    pub fn open_in(dir: &Path, rig: &str) -> Result<Endpoint, Error> {
        let own = crate::sys::user_id();
        absolute(dir)?;
        match DirBuilder::new().mode(0o755).create(dir) {
            // Whatever the umask says: others are to find the socket.
            Ok(()) => fs::set_permissions(dir, Permissions::from_mode(0o755)).map_err(|e| wrong(dir, e))?,
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(wrong(dir, e)),
        }
        is_protected(dir, [own; 2], own).map_err(|reason| wrong(dir, reason))?;
        let path = socket_path(dir, rig);
        let address = SocketAddrUnix::new(&path).map_err(|_| wrong(&path, "its path is too long for a socket"))?;
        let socket = socket().map_err(|e| wrong(&path, e))?;
        match connect(&path) {
            Attempt::Connected(_) | Attempt::Busy => {
                return Err(wrong(&path, "another driver for a rig of this name stands there"));
            }
            // A killed driver's.
            Attempt::NobodyListens => drop(fs::remove_file(&path)),
            Attempt::Failed(e) if e.kind() == ErrorKind::NotFound => {}
            Attempt::Failed(e) => return Err(wrong(&path, e)),
        }
        net::bind(&socket, &address).map_err(|e| wrong(&path, io::Error::from(e)))?;
        let made = fs::symlink_metadata(&path).map_err(|e| wrong(&path, e))?;
        let endpoint = Endpoint { path: path.clone(), made, socket };
        // Everybody may connect; the listener decides who is admitted, and says why not to who is not.
        fs::set_permissions(&path, Permissions::from_mode(0o666)).map_err(|e| wrong(&path, e))?;
        net::listen(&endpoint.socket, WAITING).map_err(|e| wrong(&path, io::Error::from(e)))?;
        Ok(endpoint)
    }
}

impl Drop for Endpoint {
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

/// What this user's driver would find where the socket of a rig is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndpointState {
    /// Its folder is there, and kept as it has to be.
    Free,
    /// Its folder would be made.
    ToBeMade,
    /// The driver of this process listens there.
    Taken(u32),
}

/// Whether a driver of this user could open the socket of a rig, and where; nothing is changed.
///
/// # Errors
/// [`Error::Gateway`], as the driver would end with; [`Error::RigName`].
pub fn survey(rig: &str) -> Result<(PathBuf, EndpointState), Error> {
    check_rig_name(rig)?;
    let dir = gateway_dir();
    survey_in(&dir, rig).map(|found| (socket_path(&dir, rig), found))
}

fn survey_in(dir: &Path, rig: &str) -> Result<EndpointState, Error> {
    let own = crate::sys::user_id();
    absolute(dir)?;
    let path = socket_path(dir, rig);
    SocketAddrUnix::new(&path).map_err(|_| wrong(&path, "its path is too long for a socket"))?;
    if let Ok(Found::Driver(_, peer)) = find(dir, rig) {
        return Ok(EndpointState::Taken(peer.pid));
    }
    let (protected, state) = match dir.parent() {
        Some(above) if !dir.exists() => {
            // In a folder with the sticky bit, which is open to all, one's own is kept as well.
            (is_protected_above(above, own), EndpointState::ToBeMade)
        }
        _ => (is_protected(dir, [own; 2], own), EndpointState::Free),
    };
    protected.map_err(|reason| wrong(dir, reason))?;
    let place = if state == EndpointState::ToBeMade { dir.parent().unwrap_or(dir) } else { dir };
    let effective = (Access::WRITE_OK | Access::EXEC_OK, AtFlags::EACCESS);
    accessat(CWD, place, effective.0, effective.1)
        .map_err(|e| wrong(dir, format!("this user may not write to {}: {e}", place.display())))?;
    Ok(state)
}

/// A folder that a new one is to be made in: open to others only where the sticky bit protects what is in it.
fn is_protected_above(above: &Path, own: u32) -> Result<(), String> {
    match is_protected(above, [own; 2], own) {
        Err(reason) => {
            let sticky = fs::symlink_metadata(above).is_ok_and(|meta| meta.is_dir() && meta.mode() & 0o1000 != 0);
            let beyond = above.parent().map_or(Ok(()), |beyond| is_protected_above(beyond, own));
            if sticky { beyond } else { Err(reason) }
        }
        Ok(()) => Ok(()),
    }
}

fn socket_path(dir: &Path, rig: &str) -> PathBuf {
    dir.join(format!("{rig}{ENDING}"))
}

/// What comes of an attempt to connect.
enum Attempt {
    Connected(OwnedFd),
    /// Too many connect at once.
    Busy,
    /// A killed driver's socket.
    NobodyListens,
    Failed(io::Error),
}

fn connect(path: &Path) -> Attempt {
    let attempt = || -> io::Result<OwnedFd> {
        let socket = socket()?;
        net::connect(&socket, &SocketAddrUnix::new(path)?)?;
        Ok(socket)
    };
    match attempt() {
        Ok(socket) => Attempt::Connected(socket),
        Err(e) if e.kind() == ErrorKind::WouldBlock => Attempt::Busy,
        Err(e) if e.kind() == ErrorKind::ConnectionRefused => Attempt::NobodyListens,
        Err(e) => Attempt::Failed(e),
    }
}

/// What is found at a rig's socket.
pub(crate) enum Found {
    /// A driver, with its user and process.
    Driver(OwnedFd, Peer),
    /// One to which many connect at once; worth another attempt.
    Busy,
    /// Nobody.
    Nobody,
}

/// Connects to the socket of a rig, and makes sure whose it is.
///
/// # Errors
/// [`Error::Gateway`] for a socket that could be anybody's.
pub(crate) fn find(dir: &Path, rig: &str) -> Result<Found, Error> {
    let path = socket_path(dir, rig);
    let socket = match connect(&path) {
        Attempt::Connected(socket) => socket,
        Attempt::Busy => return Ok(Found::Busy),
        Attempt::NobodyListens => return Ok(Found::Nobody),
        Attempt::Failed(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Ok(Found::Nobody);
        }
        Attempt::Failed(e) => return Err(wrong(&path, e)),
    };
    let driver = Peer::of(&socket).map_err(|e| wrong(&path, e))?;
    let own = crate::sys::user_id();
    is_protected(dir, [driver.user; 2], own).map_err(|reason| {
        wrong(&path, format!("it could be anybody's door (that of user {}): {reason}", driver.user))
    })?;
    Ok(Found::Driver(socket, driver))
}

/// Names of the rigs at whose sockets a driver listens, sorted.
pub(crate) fn open_endpoints() -> Vec<String> {
    let dir = gateway_dir();
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
        let endpoint = Endpoint::open_in(dir.path(), "bench").unwrap();
        assert!(matches!(find(dir.path(), "bench"), Ok(Found::Driver(_, peer)) if peer.pid == std::process::id()));
        assert_eq!(survey_in(dir.path(), "bench"), Ok(EndpointState::Taken(std::process::id())));
        let second = Endpoint::open_in(dir.path(), "bench").unwrap_err();
        assert!(second.to_string().contains("another driver"), "{second}");
        let path = endpoint.path.clone();
        drop(endpoint);
        assert!(!path.exists());
        // What a killed one leaves: the socket closes, the file stays.
        let dead = socket().unwrap();
        net::bind(&dead, &SocketAddrUnix::new(&path).unwrap()).unwrap();
        net::listen(&dead, 1).unwrap();
        drop(dead);
        assert!(path.exists());
        assert!(matches!(find(dir.path(), "bench"), Ok(Found::Nobody)));
        assert_eq!(survey_in(dir.path(), "bench"), Ok(EndpointState::Free), "a dead one's is in nobody's way");
        let next = Endpoint::open_in(dir.path(), "bench").unwrap();
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
            let found = Endpoint::open_in(&inner, "bench");
            assert_eq!(foretold.map(drop), found.as_ref().map(drop).map_err(Clone::clone), "{mode:o}");
            assert_eq!(found.is_ok(), trusted, "{mode:o}: {found:?}");
            if let Err(error) = found {
                assert!(error.to_string().contains("others may write to"), "{error}");
            }
            drop(fs::remove_dir_all(&inner));
        }
        assert_eq!(survey_in(&dir.path().join("gate"), "bench"), Ok(EndpointState::ToBeMade));
        assert!(!dir.path().join("gate").exists(), "looking changes nothing");
        assert!(survey_in(Path::new("relative"), "bench").is_err());
        assert!(survey_in(&dir.path().join("no/where"), "bench").is_err());
        // Its parent: somebody else could put another folder in its place.
        let inner = dir.path().join("gate");
        let endpoint = Endpoint::open_in(&inner, "bench").unwrap();
        fs::set_permissions(dir.path(), Permissions::from_mode(0o777)).unwrap();
        let error = find(&inner, "bench").map(drop).unwrap_err().to_string();
        assert!(error.contains("could be anybody's door"), "{error}");
        fs::set_permissions(dir.path(), Permissions::from_mode(0o1777)).unwrap();
        assert!(find(&inner, "bench").is_ok(), "in a sticky folder what is ours stays ours");
        let link = dir.path().join("link");
        std::os::unix::fs::symlink(&inner, &link).unwrap();
        assert!(find(&link, "bench").is_err());
        drop(endpoint);
        assert!(matches!(Endpoint::open_in(Path::new("relative"), "bench"), Err(Error::Gateway { .. })));
        assert!(matches!(Endpoint::open_in(&dir.path().join("x".repeat(100)), "bench"), Err(Error::Gateway { .. })));
    }
}
