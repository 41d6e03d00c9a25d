//! Files of sysfs: numbers in and out of files that stay open, without allocation.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str;

use rustix::io::Errno;

use crate::Error;

/// The longest number a file of sysfs holds, with room to spare: bytes.
const LONGEST: usize = 48;

/// An attribute that stays open. sysfs makes its content anew for each read at offset 0, and takes each write as a whole.
#[derive(Debug)]
pub(crate) struct Attribute {
    file: File,
    path: PathBuf,
}

impl Attribute {
    pub fn to_write(path: PathBuf) -> Result<Attribute, Error> {
        let opened = OpenOptions::new().read(true).write(true).open(&path);
        let file = opened.map_err(|error| Error::file(&path, "open to write", error))?;
        Ok(Attribute { file, path })
    }

    pub fn to_read(path: PathBuf) -> Result<Attribute, Error> {
        let file = File::open(&path).map_err(|error| Error::file(&path, "open to read", error))?;
        Ok(Attribute { file, path })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn file(&self) -> &File {
        &self.file
    }

    /// Writes a whole number.
    pub fn write(&self, value: u64) -> Result<(), Errno> {
        let mut text = [0u8; LONGEST];
        let mut rest = &mut text[..];
        // Formatting an integer into a slice allocates nothing, and there is room for any.
        let _ = write!(rest, "{value}");
        let used = LONGEST - rest.len();
        let written = rustix::io::pwrite(&self.file, &text[..used], 0)?;
        if written == used { Ok(()) } else { Err(Errno::IO) }
    }

    /// Reads a number, whole or with a fraction.
    pub fn read(&self) -> Result<f64, Errno> {
        let mut text = [0u8; LONGEST];
        let count = rustix::io::pread(&self.file, &mut text[..], 0)?;
        let text = str::from_utf8(&text[..count]).map_err(|_| Errno::INVAL)?;
        text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or(Errno::INVAL)
    }
}

/// The text of a small file, trimmed.
pub(crate) fn text(path: &Path) -> Result<String, Error> {
    let text = fs::read_to_string(path).map_err(|error| Error::file(path, "read", error))?;
    Ok(text.trim().to_string())
}

/// The number in a small file.
pub(crate) fn number<T: str::FromStr>(path: &Path) -> Result<T, Error> {
    let found = text(path)?;
    found.parse().map_err(|_| Error::Content { path: path.into(), found, expected: "a number" })
}

/// Writes a small file as a whole, as `echo` does.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    let opened = OpenOptions::new().write(true).open(path);
    let written = opened.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| Error::file(path, format!("write {text}"), error))
}

/// The names in a folder, sorted; none where there is no folder.
pub(crate) fn names(path: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(path) else { return Vec::new() };
    let mut names: Vec<String> = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable_by_key(|name| (name.trim_end_matches(|c: char| c.is_ascii_digit()).to_string(), digits(name)));
    names
}

/// The number at the end of a name, so that `pwmchip10` comes after `pwmchip9`.
fn digits(name: &str) -> u64 {
    name[name.trim_end_matches(|c: char| c.is_ascii_digit()).len()..].parse().unwrap_or(0)
}
