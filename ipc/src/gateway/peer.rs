//! Who is at the other end of a Unix socket, in the kernel's own words, and the numbers of groups.
#![allow(unsafe_code)]

use std::ffi::CString;
use std::io;
use std::os::fd::{AsFd, AsRawFd};

/// Most groups a process can have (NGROUPS_MAX).
const MAX_GROUPS: usize = 65536;

/// The process at the other end, as it was when it connected (or, of a listening one, when it began to listen).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Peer {
    /// Its number; 0 when it is in another namespace.
    pub pid: u32,
    /// Its effective user.
    pub user: u32,
    /// Its effective group.
    pub group: u32,
    /// Its supplementary groups.
    pub groups: Vec<u32>,
}

impl Peer {
    /// Of a connected socket.
    ///
    /// # Errors
    /// The kernel's; then nothing is known about it, and nothing may be allowed to it.
    pub fn of(socket: impl AsFd) -> io::Result<Peer> {
        let mut who = [libc::ucred { pid: 0, uid: u32::MAX, gid: u32::MAX }];
        if option(&socket, libc::SO_PEERCRED, &mut who)? != 1 {
            return Err(io::Error::other("the kernel does not say who it is"));
        }
        let mut groups = vec![0 as libc::gid_t; 64];
        let found = loop {
            match option(&socket, libc::SO_PEERGROUPS, &mut groups) {
                Err(e) if e.raw_os_error() == Some(libc::ERANGE) && groups.len() < MAX_GROUPS => {
                    groups.resize(MAX_GROUPS, 0)
                }
                // Before Linux 4.13: then only its own group counts.
                Err(e) if e.raw_os_error() == Some(libc::ENOPROTOOPT) => break 0,
                other => break other?,
            }
        };
        groups.truncate(found);
        Ok(Peer { pid: who[0].pid.max(0) as u32, user: who[0].uid, group: who[0].gid, groups })
    }

    /// This process itself.
    pub fn this_process() -> Peer {
        let groups = rustix::process::getgroups().unwrap_or_default();
        Peer {
            pid: std::process::id(),
            user: rustix::process::geteuid().as_raw(),
            group: rustix::process::getegid().as_raw(),
            groups: groups.into_iter().map(|group| group.as_raw()).collect(),
        }
    }

    /// Whether it has this group.
    pub fn is_in(&self, group: u32) -> bool {
        self.group == group || self.groups.contains(&group)
    }
}

/// Plain integers the kernel may write over.
trait Plain: Copy {}
impl Plain for libc::ucred {}
impl Plain for libc::gid_t {}

/// Reads an option of a socket; how many of `places` it filled.
fn option<T: Plain>(socket: &impl AsFd, option: libc::c_int, places: &mut [T]) -> io::Result<usize> {
    let mut bytes = size_of_val(places) as libc::socklen_t;
    // SAFETY: the descriptor is open for as long as `socket` is borrowed; the kernel writes at most `bytes` bytes into `places`,
    // and any bits are a valid `T`.
    let done = unsafe {
        libc::getsockopt(socket.as_fd().as_raw_fd(), libc::SOL_SOCKET, option, places.as_mut_ptr().cast(), &mut bytes)
    };
    if done == 0 { Ok((bytes as usize / size_of::<T>()).min(places.len())) } else { Err(io::Error::last_os_error()) }
}

/// The number of the group of this name, if there is one.
pub(crate) fn group_id(name: &str) -> Option<u32> {
    let name = CString::new(name).ok()?;
    let mut text = vec![0 as libc::c_char; 1024];
    loop {
        // SAFETY: group is plain data and pointers, for which zeros are valid.
        let mut group: libc::group = unsafe { std::mem::zeroed() };
        let mut found = std::ptr::null_mut();
        // SAFETY: all places are valid during the call, and `text` is as long as it says.
        let error = unsafe { libc::getgrnam_r(name.as_ptr(), &mut group, text.as_mut_ptr(), text.len(), &mut found) };
        if error == libc::ERANGE && text.len() < 16 << 20 {
            text.resize(text.len() * 4, 0);
            continue;
        }
        return (error == 0 && !found.is_null()).then_some(group.gr_gid);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixStream;

    #[test]
    fn the_kernel_knows_who_we_are() {
        let (a, _b) = UnixStream::pair().unwrap();
        let peer = Peer::of(&a).unwrap();
        assert_eq!((peer.pid, peer.user), (std::process::id(), crate::sys::user_id()));
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let groups = status.lines().find_map(|line| line.strip_prefix("Groups:")).unwrap();
        let mut groups: Vec<u32> = groups.split_whitespace().map(|id| id.parse().unwrap()).collect();
        let mut found = peer.groups.clone();
        groups.sort();
        found.sort();
        assert_eq!(found, groups);
        assert!(Peer::of(std::io::stdin()).is_err() || cfg!(miri));
    }

    #[test]
    fn groups_are_found_by_name() {
        assert_eq!(group_id("root"), Some(0));
        assert_eq!(group_id("no-such-group-here"), None);
        assert_eq!(group_id("ro\0ot"), None);
    }
}
