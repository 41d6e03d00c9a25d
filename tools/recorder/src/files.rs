//! The files of a recording: opened without replacing existing ones, synced to the disk, and numbered.

use std::fs::{self, File, OpenOptions};
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

/// The first of a recording's further files that is there already. What cannot be listed is not found.
pub(crate) fn later_part(path: &Path) -> Option<PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let number = |name: &str| {
        let digits = name.strip_prefix(&stem)?.strip_prefix('-')?;
        digits.split('.').next()?.parse::<u32>().ok().filter(|number| *number > 0)
    };
    let names = fs::read_dir(folder(path)).ok()?.flatten().map(|entry| entry.file_name());
    let numbers = names.filter_map(|name| {
        let number = number(&name.to_string_lossy())?;
        (part_path(path, number).file_name() == Some(&*name)).then_some(number)
    });
    numbers.min().map(|number| part_path(path, number))
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
    // some file systems do not support that for folders
    let _ = File::open(folder(path)).and_then(|folder| folder.sync_all());
    Ok(())
}

/// The folder a file lies in.
pub(crate) fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
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
    fn later_parts_are_found_and_nothing_else_is_taken_for_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.v2.mcap");
        for other in ["walk.v2.mcap", "walk.v2-1.mcap", "walk.v2-0000.mcap", "walk.v2-0003.csv", "walk-0002.mcap"] {
            fs::write(folder.path().join(other), "").unwrap();
        }
        assert_eq!(later_part(&path), None);
        for number in [12_345, 17] {
            fs::write(part_path(&path, number), "").unwrap();
        }
        assert_eq!(later_part(&path), Some(folder.path().join("walk.v2-0017.mcap")));
        assert_eq!(later_part(&folder.path().join("no/such.mcap")), None);
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
