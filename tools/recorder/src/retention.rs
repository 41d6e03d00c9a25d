//! Which files of a recording stay: the oldest go when there are too many, or when they are too large together.
//!
//! Only what this recording has written and completed itself is ever removed, in the order of its numbers, whatever the clock says.
//! Before that it is looked at: what was put in its place, a link, or a file of another length is not ours, and stays.

use std::collections::VecDeque;
use std::fs::{self, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::options::Options;
use crate::warning::Warning;

/// The files of a recording that are complete and still there, oldest first.
#[derive(Debug)]
pub(crate) struct Kept {
    most_files: Option<u64>,
    most_bytes: Option<u64>,
    files: VecDeque<Whole>,
    bytes: u64,
}

/// A file that is complete, and by what it is known again.
#[derive(Debug)]
pub(crate) struct Whole {
    pub(crate) path: PathBuf,
    pub(crate) bytes: u64,
    pub(crate) cycles: u64,
    device: u64,
    inode: u64,
}

impl Kept {
    /// None yet.
    pub(crate) fn new(options: &Options) -> Kept {
        Kept {
            most_files: options.keep_files.map(u64::from),
            most_bytes: options.keep_bytes,
            files: VecDeque::new(),
            bytes: 0,
        }
    }

    /// The newest one, complete as of now.
    pub(crate) fn add(&mut self, path: &Path, there: &Metadata, cycles: u64) {
        self.bytes += there.len();
        let (device, inode) = (there.dev(), there.ino());
        self.files.push_back(Whole { path: path.into(), bytes: there.len(), cycles, device, inode });
    }

    /// Takes the oldest one out if, with one more being written that has so many bytes, it is too much.
    pub(crate) fn surplus(&mut self, being_written: u64) -> Option<Whole> {
        let too_many = self.most_files.is_some_and(|most| self.files.len() as u64 + 1 > most);
        let too_large = self.most_bytes.is_some_and(|most| self.bytes + being_written > most);
        if !too_many && !too_large {
            return None;
        }
        let oldest = self.files.pop_front()?;
        self.bytes -= oldest.bytes;
        Some(oldest)
    }
}

impl Whole {
    /// Removes it; false when it is not there any more.
    ///
    /// # Errors
    /// [`Warning::NotOurs`], [`Warning::NotRemoved`]; then it stays.
    pub(crate) fn remove(&self) -> Result<bool, Warning> {
        let removed = fs::symlink_metadata(&self.path).and_then(|there| match self.is(&there) {
            true => fs::remove_file(&self.path).map(|()| true),
            false => Ok(false),
        });
        match removed {
            Ok(true) => Ok(true),
            Ok(false) => Err(Warning::NotOurs { path: self.path.clone() }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
            Err(reason) => Err(Warning::NotRemoved { path: self.path.clone(), reason }),
        }
    }

    fn is(&self, there: &Metadata) -> bool {
        there.is_file() && (there.dev(), there.ino(), there.len()) == (self.device, self.inode, self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(keep_files: Option<u32>, keep_bytes: Option<u64>) -> Kept {
        Kept::new(&Options { keep_files, keep_bytes, ..Options::new("a.mcap") })
    }

    /// Adds files of these sizes.
    fn fill(kept: &mut Kept, folder: &Path, sizes: &[usize]) -> Vec<PathBuf> {
        let paths = sizes.iter().enumerate().map(|(number, size)| {
            let path = folder.join(format!("{number}.mcap"));
            fs::write(&path, vec![b'x'; *size]).unwrap();
            kept.add(&path, &fs::metadata(&path).unwrap(), 7);
            path
        });
        paths.collect()
    }

    #[test]
    fn the_oldest_go_first_by_number_and_by_size() {
        let folder = tempfile::tempdir().unwrap();
        let mut by_number = kept(Some(3), None);
        let paths = fill(&mut by_number, folder.path(), &[10, 10, 10, 10]);
        assert_eq!(by_number.surplus(1_000_000).unwrap().path, paths[0]);
        assert_eq!(by_number.surplus(0).unwrap().path, paths[1]);
        assert!(by_number.surplus(u64::MAX).is_none(), "two and the one being written");

        let mut by_size = kept(None, Some(100));
        let paths = fill(&mut by_size, folder.path(), &[50, 20, 20]);
        assert!(by_size.surplus(10).is_none());
        assert_eq!(by_size.surplus(11).unwrap().path, paths[0]);
        assert!(by_size.surplus(60).is_none());
        assert_eq!(by_size.surplus(61).unwrap().path, paths[1]);
        assert_eq!(by_size.surplus(81).unwrap().path, paths[2]);
        assert!(by_size.surplus(1000).is_none(), "the one being written is never removed");

        let mut all = kept(None, None);
        fill(&mut all, folder.path(), &[50; 20]);
        assert!(all.surplus(1 << 60).is_none());
    }

    #[test]
    fn only_what_was_written_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let mut files = kept(Some(2), None);
        let paths = fill(&mut files, folder.path(), &[10; 6]);
        let precious = folder.path().join("precious");
        fs::write(&precious, "precious..").unwrap();
        // replaced, moved away behind a link, longer, a folder, gone
        fs::rename(&precious, &paths[1]).unwrap();
        fs::rename(&paths[2], &precious).unwrap();
        std::os::unix::fs::symlink(&precious, &paths[2]).unwrap();
        fs::write(&paths[3], "it was written on").unwrap();
        fs::remove_file(&paths[4]).unwrap();
        fs::create_dir(&paths[4]).unwrap();
        fs::remove_file(&paths[5]).unwrap();
        let mut found = Vec::new();
        while let Some(old) = files.files.pop_front() {
            found.push(old.remove());
        }
        assert!(matches!(found[0], Ok(true)) && !paths[0].exists());
        for (number, found) in found.iter().enumerate().take(5).skip(1) {
            assert!(matches!(found, Err(Warning::NotOurs { path }) if *path == paths[number]), "{found:?}");
        }
        assert!(matches!(found[5], Ok(false)), "{:?}", found[5]);
        assert_eq!(fs::read(&paths[1]).unwrap(), b"precious..");
        assert!(fs::symlink_metadata(&paths[2]).unwrap().is_symlink() && precious.exists() && paths[4].is_dir());
        assert_eq!(fs::read(&paths[3]).unwrap(), b"it was written on");
    }
}
