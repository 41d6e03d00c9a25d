//! Shared memory that one process writes and the kernel keeps everybody else from writing.
#![allow(unsafe_code)]

use rustix::fs::{
    MemfdFlags, Mode, SealFlags, fchmod, fcntl_add_seals, fcntl_get_seals, fstat, ftruncate, memfd_create,
};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64};

/// What has to hold before a reader may trust the memory not to vanish under him.
const SEALS: SealFlags = SealFlags::SHRINK.union(SealFlags::GROW).union(SealFlags::FUTURE_WRITE);

/// A mapping, seen as words that may change at any time.
struct Map {
    start: NonNull<AtomicU64>,
    words: usize,
}

// SAFETY: it is only ever looked at as atomics, which threads may share.
unsafe impl Send for Map {}
// SAFETY: as above.
unsafe impl Sync for Map {}

impl Map {
    fn new(memory: BorrowedFd, words: usize, how: ProtFlags) -> io::Result<Map> {
        // SAFETY: a new mapping at a place of the kernel's choosing disturbs nothing. Its size is that of the memory, which is
        // sealed against shrinking before anybody else can have it, so that no access can be beyond its end.
        let start = unsafe { mmap(std::ptr::null_mut(), words * size_of::<u64>(), how, MapFlags::SHARED, memory, 0) }?;
        let start = NonNull::new(start.cast()).ok_or_else(|| io::Error::other("mapped at zero"))?;
        Ok(Map { start, words })
    }

    fn words(&self) -> &[AtomicU64] {
        // SAFETY: the mapping has this many words and lives as long as `self`; pages are aligned; whoever writes does so through
        // atomics; relaxed and acquiring loads of 64 bits are allowed on memory that may only be read.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.words) }
    }

    fn half(&self, word: usize) -> &AtomicU32 {
        let word = &self.words()[word];
        // SAFETY: inside the word, aligned for it, and living as long as `self`. That word is never looked at as a whole.
        unsafe { AtomicU32::from_ptr(word.as_ptr().cast()) }
    }
}

impl Drop for Map {
    fn drop(&mut self) {
        // SAFETY: mapped by `new` with this size, and nothing that borrows from it outlives it.
        let _ = unsafe { munmap(self.start.as_ptr().cast(), self.words * size_of::<u64>()) };
    }
}

/// The writer's side: the only mapping that can ever be written through.
pub(crate) struct Written {
    map: Map,
    /// The same memory, opened for reading only.
    read_only: OwnedFd,
}

impl Written {
    /// New memory of so many words, all zero, sealed.
    pub fn new(words: usize) -> io::Result<Written> {
        let memory = memfd_create("sinew-board", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
        ftruncate(&memory, (words * size_of::<u64>()) as u64)?;
        let map = Map::new(memory.as_fd(), words, ProtFlags::READ | ProtFlags::WRITE)?;
        fcntl_add_seals(&memory, SEALS | SealFlags::SEAL)?;
        // The seals are what counts, and keep root out as well; these two only make others fail earlier.
        fchmod(&memory, Mode::from_raw_mode(0o444))?;
        let read_only = File::open(format!("/proc/self/fd/{}", memory.as_raw_fd()))?.into();
        Ok(Written { map, read_only })
    }

    /// All of it.
    pub fn words(&self) -> &[AtomicU64] {
        self.map.words()
    }

    /// The first half of a word.
    pub fn half(&self, word: usize) -> &AtomicU32 {
        self.map.half(word)
    }

    /// To be handed out.
    pub fn read_only(&self) -> BorrowedFd<'_> {
        self.read_only.as_fd()
    }
}

/// A reader's side.
pub(crate) struct Read {
    map: Map,
}

impl Read {
    /// Maps memory that somebody handed over, if it is sealed as it has to be: what could still be shrunk would kill its reader.
    pub fn new(memory: OwnedFd) -> io::Result<Read> {
        let seals = fcntl_get_seals(&memory)?;
        if !seals.contains(SEALS) {
            return Err(io::Error::other("the memory it handed over is not sealed"));
        }
        let words = usize::try_from(fstat(&memory)?.st_size).unwrap_or(0) / size_of::<u64>();
        Ok(Read { map: Map::new(memory.as_fd(), words, ProtFlags::READ)? })
    }

    /// All of it.
    pub fn words(&self) -> &[AtomicU64] {
        self.map.words()
    }

    /// The first half of a word.
    pub fn half(&self, word: usize) -> &AtomicU32 {
        self.map.half(word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::OpenOptions;
    use std::io::Write as _;
    use std::sync::atomic::Ordering;

    /// Every way there is of writing to memory one has the descriptor of. As root, who may open it anew for writing: it is the
    /// seals that keep.
    #[test]
    fn nobody_but_the_writer_can_write() {
        let written = Written::new(1024).unwrap();
        written.words()[7].store(42, Ordering::Relaxed);
        let handed = written.read_only().try_clone_to_owned().unwrap();
        let refused = |what: &str, found: io::Result<()>| {
            let error = found.expect_err(what);
            let code = error.raw_os_error();
            // The latter two where a descriptor is for reading only.
            let refusals = [libc::EPERM, libc::EACCES, libc::EBADF, libc::EINVAL];
            assert!(code.is_some_and(|code| refusals.contains(&code)), "{what}: {error}");
        };
        let both = ProtFlags::READ | ProtFlags::WRITE;
        refused("map it for writing", Map::new(handed.as_fd(), 1024, both).map(drop));
        let read_only = Map::new(handed.as_fd(), 1024, ProtFlags::READ).unwrap();
        // SAFETY: asks for more rights to a mapping of this test's own.
        let more = unsafe { libc::mprotect(read_only.start.as_ptr().cast(), 8192, libc::PROT_READ | libc::PROT_WRITE) };
        refused("raise a mapping's rights", if more == 0 { Ok(()) } else { Err(io::Error::last_os_error()) });
        let mut file = File::from(handed.try_clone().unwrap());
        refused("write to it", file.write_all(b"rubbish"));
        refused("shrink it", file.set_len(8));
        refused("let it grow", file.set_len(1 << 20));
        refused(
            "cut a hole",
            rustix::fs::fallocate(
                &handed,
                rustix::fs::FallocateFlags::PUNCH_HOLE | rustix::fs::FallocateFlags::KEEP_SIZE,
                0,
                4096,
            )
            .map_err(io::Error::from),
        );
        refused("seal it otherwise", fcntl_add_seals(&handed, SealFlags::WRITE).map_err(io::Error::from));
        // Opened anew: root gets it, and can do nothing with it either.
        let path = format!("/proc/self/fd/{}", handed.as_raw_fd());
        match OpenOptions::new().read(true).write(true).open(path) {
            Ok(mut again) => {
                refused("write to it, opened anew", again.write_all(b"rubbish"));
                refused("map it for writing, opened anew", Map::new(again.as_fd(), 1024, both).map(drop));
                refused("shrink it, opened anew", again.set_len(8));
            }
            Err(error) => assert_eq!(error.kind(), io::ErrorKind::PermissionDenied),
        }
        // The writer still can, and a reader sees it.
        let read = Read::new(handed).unwrap();
        assert_eq!(read.words()[7].load(Ordering::Relaxed), 42);
        written.words()[7].store(43, Ordering::Relaxed);
        assert_eq!(read.words()[7].load(Ordering::Relaxed), 43);
        assert_eq!(read.words().len(), 1024);
    }

    #[test]
    fn memory_that_could_vanish_is_not_taken() {
        let memory = memfd_create("test", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING).unwrap();
        ftruncate(&memory, 4096).unwrap();
        assert!(Read::new(memory.try_clone().unwrap()).is_err());
        fcntl_add_seals(&memory, SealFlags::SHRINK | SealFlags::GROW).unwrap();
        assert!(Read::new(memory).is_err());
        assert!(Read::new(File::open("/proc/self/exe").unwrap().into()).is_err());
    }
}
