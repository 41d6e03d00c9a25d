//! The files of a recording: opened without replacing existing ones, synced to the disk, and numbered.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// The name of a recording's file by its number: `walk.mcap`, `walk-0001.mcap`, `walk-0002.mcap`, …
pub fn part_path(path: &Path, part: u32) -> PathBuf {
    if part == 0 {
        return path.to_path_buf();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = match path.extension() {
        Some(extension) => format!("{stem}-{part:04}.{}", extension.to_string_lossy()),
        None => format!("{stem}-{part:04}"),
    };
    path.with_file_name(name)
}

/// Opens a new file; one that is there is only replaced with `overwrite`.
pub(crate) fn create(path: &Path, overwrite: bool) -> Result<File, Error> {
    let mut options = OpenOptions::new();
    options.write(true).read(true);
    if overwrite {
        options.create(true).truncate(true)
    } else {
        options.create_new(true)
    };
    options.open(path).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => Error::Exists { path: path.to_path_buf() },
        _ => unwritable(path, &error),
    })
}

/// Brings a file and its name to the disk.
pub(crate) fn keep(path: &Path, file: &File) -> io::Result<()> {
    file.sync_all()?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // some file systems do not support that for folders
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

pub(crate) fn unwritable(path: &Path, error: &io::Error) -> Error {
    Error::File(sinew_recording::Error {
        file: path.to_string_lossy().into_owned(),
        line: None,
        column: None,
        what: sinew_recording::What::Unwritable { reason: error.to_string() },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_numbered_before_the_ending() {
        assert_eq!(part_path(Path::new("a/walk.mcap"), 0), Path::new("a/walk.mcap"));
        assert_eq!(part_path(Path::new("a/walk.mcap"), 1), Path::new("a/walk-0001.mcap"));
        assert_eq!(part_path(Path::new("walk.v2.mcap"), 12345), Path::new("walk.v2-12345.mcap"));
        assert_eq!(part_path(Path::new("walk"), 2), Path::new("walk-0002"));
    }

    #[test]
    fn what_is_there_stays_unless_told_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        std::fs::write(&path, "precious").unwrap();
        assert!(matches!(create(&path, false), Err(Error::Exists { .. })));
        assert_eq!(std::fs::read(&path).unwrap(), b"precious");
        drop(create(&path, true).unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), b"");
    }
}
