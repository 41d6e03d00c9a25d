//! The system calls of this crate: the user's number, and file locks.
//!
//! The locks are open-file-description locks (`F_OFD_SETLK`): like those of `flock` they belong to the open file, work between
//! threads as between processes and are released by the kernel however the process ends; unlike those they can be
//! *asked for* without being taken, so that a client which looks whether a driver is alive never gets in its way.
#![allow(unsafe_code)]

use std::fs::File;
use std::io;
use std::os::fd::AsRawFd;

/// The effective user id.
pub fn user_id() -> u32 {
    // SAFETY: the call has no arguments and cannot fail.
    unsafe { libc::geteuid() }
}

/// Bytes left for shared memory; `None` where the system does not say.
pub fn shared_memory_left() -> Option<usize> {
    // SAFETY: statvfs is plain data for which all zeros are valid.
    let mut stat: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: the path is a C string, `stat` a valid place; the call writes nothing else.
    let done = unsafe { libc::statvfs(c"/dev/shm".as_ptr(), &mut stat) };
    (done == 0).then(|| (stat.f_bavail as usize).saturating_mul(stat.f_frsize as usize))
}

/// Kind of a lock: any number of readers, or one writer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lock {
    /// Held by any number at a time.
    Shared,
    /// Held by one alone.
    Exclusive,
}

fn record(lock: Lock) -> libc::flock {
    // SAFETY: flock is plain data for which all zeros are valid (whole file, pid 0 as these locks demand).
    let mut record: libc::flock = unsafe { std::mem::zeroed() };
    record.l_type = match lock {
        Lock::Shared => libc::F_RDLCK,
        Lock::Exclusive => libc::F_WRLCK,
    } as libc::c_short;
    record.l_whence = libc::SEEK_SET as libc::c_short;
    record
}

fn control(file: &File, command: libc::c_int, record: &mut libc::flock) -> io::Result<()> {
    loop {
        // SAFETY: the descriptor is open for as long as `file` is borrowed, `record` is a valid flock.
        if unsafe { libc::fcntl(file.as_raw_fd(), command, record as *mut libc::flock) } == 0 {
            return Ok(());
        }
        let error = io::Error::last_os_error();
        if error.kind() != io::ErrorKind::Interrupted {
            return Err(error);
        }
    }
}

/// Takes the lock if it is free. It is held until `file` is closed.
pub fn try_lock(file: &File, lock: Lock) -> io::Result<bool> {
    match control(file, libc::F_OFD_SETLK, &mut record(lock)) {
        Ok(()) => Ok(true),
        Err(e) if matches!(e.raw_os_error(), Some(libc::EAGAIN | libc::EACCES)) => Ok(false),
        Err(e) => Err(e),
    }
}

/// Takes the lock, waiting for it. For the few lines that create or sweep.
pub fn lock(file: &File, lock: Lock) -> io::Result<()> {
    control(file, libc::F_OFD_SETLKW, &mut record(lock))
}

/// Whether somebody else holds this file alone.
pub fn is_locked(file: &File) -> io::Result<bool> {
    // What would keep a reader out is a writer's.
    let mut record = record(Lock::Shared);
    control(file, libc::F_OFD_GETLK, &mut record)?;
    Ok(record.l_type != libc::F_UNLCK as libc::c_short)
}
