//! A few words that outlive the process: a mapped file in a file system that is memory, so that the real-time loop writes them
//! without a system call, and finds them however its process ended.
//!
//! Two copies are written in turn, each with a number and a checksum: a process that is killed in the middle of one leaves the other
//! whole. A file is held by one process at a time; the kernel releases it however that one ends.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! # let Some(shm) = sinew_page::is_memory(std::path::Path::new("/dev/shm")).then_some("/dev/shm") else { return Ok(()) };
//! # let folder = tempfile::tempdir_in(shm)?;
//! let path = folder.path().join("notes");
//! let mut page: sinew_page::Page<2> = sinew_page::Page::open(&path)?;
//! assert_eq!(page.read(), None, "nothing was ever written");
//! page.write(&[7, 9]);
//! drop(page); // or killed
//! assert_eq!(sinew_page::Page::<2>::open(&path)?.read(), Some([7, 9]));
//! # Ok::<(), std::io::Error>(())
//! ```
#![deny(unsafe_code)]

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering, fence};

use rustix::fs::{FlockOperation, OFlags, flock, statfs};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use rustix::process::geteuid;

/// `TMPFS_MAGIC` and `RAMFS_MAGIC` of Linux.
const MEMORY_FILE_SYSTEMS: [u64; 2] = [0x0102_1994, 0x8584_58f6];
/// Number and checksum of a copy.
const FRAME: usize = 2;
/// Most words a page has room for, twice.
const ROOM: usize = 64;

/// Whether what is written there stays in memory: nothing is ever written back, so that a store waits for no disk.
pub fn is_memory(folder: &Path) -> bool {
    statfs(folder).is_ok_and(|found| MEMORY_FILE_SYSTEMS.contains(&(found.f_type as u64)))
}

/// `N` words in a file, held by this process alone.
#[derive(Debug)]
pub struct Page<const N: usize> {
    words: NonNull<AtomicU64>,
    /// Number of the copy written last.
    number: u64,
    is_new: bool,
    _file: File,
}

// SAFETY: the mapping belongs to this value alone, and everything in it is atomic.
#[allow(unsafe_code)]
unsafe impl<const N: usize> Send for Page<N> {}

impl<const N: usize> Page<N> {
    const BYTES: usize = {
        assert!(N + FRAME <= ROOM, "a page has room for fewer words");
        2 * ROOM * size_of::<AtomicU64>()
    };

    /// Opens a file, made if there is none, closed to all others.
    ///
    /// # Errors
    /// A file that is not an ordinary one of this user's, that another process holds ([`io::ErrorKind::WouldBlock`]), or that
    /// does not lie in memory.
    pub fn open(path: &Path) -> io::Result<Page<N>> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .custom_flags(OFlags::NOFOLLOW.bits() as i32)
            .open(path)?;
        let found = file.metadata()?;
        if !found.is_file() || found.uid() != geteuid().as_raw() || found.nlink() != 1 {
            return Err(io::Error::other("it is not an ordinary file of this user's"));
        }
        if !path.parent().is_some_and(is_memory) {
            return Err(io::Error::other("it does not lie in memory, and the loop must not wait for a disk"));
        }
        flock(&file, FlockOperation::NonBlockingLockExclusive)?;
        let is_new = found.len() == 0;
        file.set_len(Self::BYTES as u64)?;
        let words = Self::map(&file)?;
        let mut page = Page { words, number: 0, is_new, _file: file };
        page.number = page.newest().map_or(0, |(number, _)| number);
        Ok(page)
    }

    #[allow(unsafe_code)]
    fn map(file: &File) -> io::Result<NonNull<AtomicU64>> {
        let access = ProtFlags::READ | ProtFlags::WRITE;
        // SAFETY: a new mapping, nowhere in particular, of a file that is as long and that nobody else of this user's shortens.
        let start = unsafe { mmap(std::ptr::null_mut(), Self::BYTES, access, MapFlags::SHARED, file, 0) }?;
        NonNull::new(start.cast()).ok_or_else(|| io::Error::other("mapped nowhere"))
    }

    /// The words of one of the two copies.
    #[allow(unsafe_code)]
    fn copy(&self, number: u64) -> &[AtomicU64] {
        let offset = (number % 2) as usize * ROOM;
        // SAFETY: both copies lie within the mapping, which is aligned to a page and lives as long as `self`; zeros are valid.
        unsafe { std::slice::from_raw_parts(self.words.as_ptr().add(offset), N + FRAME) }
    }

    /// Whether there was no such file before.
    pub fn is_new(&self) -> bool {
        self.is_new
    }

    /// What was written last and is whole; `None` where nothing is.
    pub fn read(&self) -> Option<[u64; N]> {
        self.newest().map(|(_, words)| words)
    }

    fn newest(&self) -> Option<(u64, [u64; N])> {
        let whole = |copy: u64| {
            let copy = self.copy(copy);
            let mut words = [0; N];
            for (word, stored) in words.iter_mut().zip(&copy[FRAME..]) {
                *word = stored.load(Ordering::Relaxed);
            }
            let (number, sum) = (copy[0].load(Ordering::Relaxed), copy[1].load(Ordering::Relaxed));
            (number > 0 && sum == checksum(number, &words)).then_some((number, words))
        };
        whole(0).into_iter().chain(whole(1)).max_by_key(|(number, _)| *number)
    }

    /// Writes the words: no system call, no allocation, no wait.
    #[inline]
    pub fn write(&mut self, words: &[u64; N]) {
        self.number += 1;
        let copy = self.copy(self.number);
        // Not whole while it is being written, whatever the order in which the processor does it.
        copy[1].store(0, Ordering::Relaxed);
        fence(Ordering::Release);
        copy[0].store(self.number, Ordering::Relaxed);
        for (stored, word) in copy[FRAME..].iter().zip(words) {
            stored.store(*word, Ordering::Relaxed);
        }
        copy[1].store(checksum(self.number, words), Ordering::Release);
    }
}

impl<const N: usize> Drop for Page<N> {
    #[allow(unsafe_code)]
    fn drop(&mut self) {
        // SAFETY: mapped by `open`, and nothing refers to it any more. What was written stays in the file.
        let _ = unsafe { munmap(self.words.as_ptr().cast(), Self::BYTES) };
    }
}

/// Multiply and rotate, word by word, never 0: every single bit changes half of it.
#[inline]
fn checksum(number: u64, words: &[u64]) -> u64 {
    let mix = |sum: u64, word: u64| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    words.iter().fold(mix(0x5139_3365_7749_7265, number), |sum, word| mix(sum, *word)) | 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SHM: &str = "/dev/shm";

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir_in(SHM).unwrap()
    }

    #[test]
    fn the_last_words_stay_and_one_process_holds_them_at_a_time() {
        let folder = folder();
        let path = folder.path().join("words");
        let mut page = Page::<3>::open(&path).unwrap();
        assert!(page.is_new() && page.read().is_none());
        for number in 1..100 {
            page.write(&[number, 2 * number, 0]);
            assert_eq!(page.read(), Some([number, 2 * number, 0]));
        }
        assert_eq!(Page::<3>::open(&path).unwrap_err().kind(), io::ErrorKind::WouldBlock);
        drop(page);
        let mut page = Page::<3>::open(&path).unwrap();
        assert!(!page.is_new());
        assert_eq!(page.read(), Some([99, 198, 0]));
        page.write(&[1, 1, 1]);
        assert_eq!(page.read(), Some([1, 1, 1]), "newer, though it starts from a file");
    }

    #[test]
    fn what_is_not_ours_or_not_memory_is_refused() {
        let folder = folder();
        let target = folder.path().join("target");
        std::fs::write(&target, "precious").unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&target, &link).unwrap();
        assert!(Page::<1>::open(&link).is_err(), "a link");
        std::fs::hard_link(&target, folder.path().join("second")).unwrap();
        assert!(Page::<1>::open(&target).is_err(), "a file of two names");
        assert_eq!(std::fs::read_to_string(&target).unwrap(), "precious");
        if !is_memory(Path::new("/")) {
            assert!(!is_memory(Path::new("/proc/self")));
        }
    }

    proptest! {
        /// Killed after any store, and with any bit changed: the words before, those of the last write, or none; never others.
        #[test]
        fn half_a_write_and_a_damaged_one_are_not_read(
            words in prop::array::uniform4(any::<u64>()), cut in 0usize..6, bit in 0usize..(6 * 64), damage in any::<bool>(),
        ) {
            let folder = folder();
            let path = folder.path().join("words");
            let mut page = Page::<4>::open(&path).unwrap();
            page.write(&[1, 2, 3, 4]);
            page.write(&[5, 6, 7, 8]);
            // The third write, up to a store.
            let stores = [(1, 0), (0, 3), (2, words[0]), (3, words[1]), (4, words[2]), (5, words[3])];
            for (place, value) in &stores[..cut] {
                page.copy(3)[*place].store(*value, Ordering::Relaxed);
            }
            if cut > 0 {
                prop_assert_eq!(page.read(), Some([5, 6, 7, 8]));
            }
            if damage {
                page.copy(2)[bit / 64].fetch_xor(1 << (bit % 64), Ordering::Relaxed);
                let read = page.read();
                prop_assert!(read.is_none() || read == Some([1, 2, 3, 4]), "{read:?}");
            }
        }
    }
}
