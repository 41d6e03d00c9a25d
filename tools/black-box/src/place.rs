//! The files' folder, their names, and how many are kept.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use sinew_recording::{Part, Utc};

use crate::error::Error;

/// The folder of what sinew keeps for this user: `$SINEW_STATE_DIR`, else `$XDG_STATE_HOME/sinew`, else `~/.local/state/sinew`; `None` where
/// none of the three is set.
pub fn state_folder() -> Option<PathBuf> {
    state_folder_by(|name| std::env::var_os(name))
}

/// The folder of this user's black boxes: `black-box` in his [state folder](state_folder).
///
/// # Errors
/// [`Error::NoPlace`] where there is none.
pub fn folder() -> Result<PathBuf, Error> {
    state_folder().map(|path| path.join("black-box")).ok_or(Error::NoPlace)
}

fn state_folder_by(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    // The standard says: a path that is not absolute is as good as none.
    let absolute = |name: &str| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let own = variable("SINEW_STATE_DIR").filter(|path| !path.is_empty()).map(PathBuf::from);
    own.or_else(|| absolute("XDG_STATE_HOME").map(|path| path.join("sinew")))
        .or_else(|| absolute("HOME").map(|path| path.join(".local/state/sinew")))
}

/// The black boxes of one rig in a folder.
#[derive(Debug, Clone)]
pub struct Place {
    folder: PathBuf,
    rig: String,
    keep: usize,
}

impl Place {
    /// Of a rig of this name; the newest `keep` stay.
    pub fn new(folder: impl Into<PathBuf>, rig: &str, keep: usize) -> Place {
        Place { folder: folder.into(), rig: rig.into(), keep: keep.max(1) }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Makes the folder if it is not there.
    ///
    /// # Errors
    /// [`Error::Folder`].
    pub fn prepare(&self) -> Result<(), Error> {
        fs::create_dir_all(&self.folder).map_err(|reason| Error::Folder { path: self.folder.clone(), reason })
    }

    /// The path for a fault of this time, channel and flag.
    pub(crate) fn path(&self, at: Utc, channel: &str, flag: &str) -> PathBuf {
        self.folder.join(format!("{}-{}-{channel}-{flag}.mcap", self.rig, at.fine_stamp()))
    }

    /// Removes all but the newest ones, and what a driver left that was killed while it wrote; `newest` is the one just written. Only
    /// what bears this rig's name and a time behind it is touched.
    ///
    /// The order is that in which they were written, which a file beside them keeps: by the times in their names a clock that is behind would
    /// make the newest the oldest.
    pub(crate) fn tidy(&self, newest: &Path) -> io::Result<()> {
        let mut whole = Vec::new();
        for entry in fs::read_dir(&self.folder)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            match name.strip_prefix('.') {
                Some(hidden) if self.is_ours(hidden) && is_left_behind(hidden) => fs::remove_file(entry.path())?,
                None if self.is_ours(&name) && name.ends_with(".mcap") => whole.push(name),
                _ => {}
            }
        }
        let mut written = self.order();
        written.extend(newest.file_name().map(|name| name.to_string_lossy().into_owned()));
        // Those of before there was an order come first, by time.
        whole.sort_by_cached_key(|name| (written.iter().rposition(|one| one == name), name.clone()));
        let (old, kept) = whole.split_at(whole.len().saturating_sub(self.keep));
        // First, so that an interruption leaves too much and not too little.
        self.keep_order(kept)?;
        for name in old {
            fs::remove_file(self.folder.join(name))?;
        }
        Ok(())
    }

    fn order_path(&self) -> PathBuf {
        self.folder.join(format!(".{}.order", self.rig))
    }

    /// Names in the order in which they were written, as far as that is known.
    fn order(&self) -> Vec<String> {
        let text = fs::read_to_string(self.order_path()).unwrap_or_default();
        text.lines().filter(|name| self.is_ours(name)).map(str::to_string).collect()
    }

    fn keep_order(&self, names: &[String]) -> io::Result<()> {
        let (part, mut file) = Part::create(&self.order_path())?;
        file.write_all((names.join("\n") + "\n").as_bytes())?;
        part.publish(&file)
    }

    fn is_ours(&self, name: &str) -> bool {
        let stamp = name.strip_prefix(&self.rig).and_then(|rest| rest.strip_prefix('-')).map(str::as_bytes);
        const FORM: &[u8] = b"00000000T000000.000Z-";
        stamp.and_then(|stamp| stamp.get(..FORM.len())).is_some_and(|stamp| {
            stamp
                .iter()
                .zip(FORM)
                .all(|(found, form)| if *form == b'0' { found.is_ascii_digit() } else { found == form })
        })
    }
}

/// Whether a file that was being written (`NAME.PID-COUNT.part`) has nobody to write it any more.
fn is_left_behind(hidden: &str) -> bool {
    let pid =
        hidden.strip_suffix(".part").and_then(|rest| rest.rsplit_once('.')).and_then(|(_, who)| who.split_once('-'));
    pid.and_then(|(pid, _)| pid.parse::<u32>().ok()).is_some_and(|pid| !Path::new(&format!("/proc/{pid}")).exists())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    #[test]
    fn the_newest_stay_and_nothing_else_is_touched() {
        let folder = tempfile::tempdir().unwrap();
        let place = Place::new(folder.path(), "bench", 3);
        let others =
            ["bench-2-20260801T153012.345Z-wire-open_wire.mcap", "bench-notes.mcap", "bench-2026.txt", ".bench"];
        let dead = ".bench-20260801T153012.345Z-wire-open_wire.mcap.4194305-0.part".to_string();
        let alive = format!(".bench-20260801T153012.345Z-wire-open_wire.mcap.{}-0.part", std::process::id());
        for name in others.into_iter().chain([dead.as_str(), alive.as_str()]) {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let write = |unix_s: u64| {
            let path = place.path(Utc::of_unix_ns(unix_s * 1_000_000_000), "wire", "open_wire");
            fs::write(&path, "").unwrap();
            path
        };
        // Written before there was an order.
        let before: Vec<PathBuf> = (0..8).map(|second| write(1_785_598_212 + 7 * second)).collect();
        place.tidy(&before[7]).unwrap();
        let left = names(folder.path());
        assert!(left.contains(&".bench.order".to_string()), "{left:?}");
        for name in others.into_iter().chain([alive.as_str()]) {
            assert!(left.iter().any(|there| there == name), "{name} is gone: {left:?}");
        }
        assert!(!left.contains(&dead), "{left:?}");
        let boxes: Vec<&String> = left.iter().filter(|name| place.is_ours(name)).collect();
        assert_eq!(boxes.len(), 3, "{left:?}");
        assert!(boxes[2].contains("20260801T153101"), "{boxes:?}");
        // The clock falls back by ten years: what is written now is the newest all the same.
        let behind: Vec<PathBuf> = (0..2)
            .map(|second| {
                let path = write(1_470_000_000 + second);
                place.tidy(&path).unwrap();
                path
            })
            .collect();
        let boxes: Vec<String> = names(folder.path()).into_iter().filter(|name| place.is_ours(name)).collect();
        assert_eq!(boxes.len(), 3, "{boxes:?}");
        assert!(behind.iter().all(|path| path.exists()), "{boxes:?}");
        assert!(boxes[2].contains("20260801T153101"), "{boxes:?}");
    }

    #[test]
    fn the_folder_is_the_first_that_is_set() {
        let by = |set: &[(&str, &str)]| {
            let set: Vec<(String, OsString)> = set.iter().map(|(name, to)| (name.to_string(), to.into())).collect();
            state_folder_by(|name| set.iter().find(|(known, _)| known == name).map(|(_, to)| to.clone()))
        };
        let found = |set: &[(&str, &str)]| by(set).unwrap().display().to_string();
        let home = ("HOME", "/home/x");
        assert_eq!(found(&[home]), "/home/x/.local/state/sinew");
        assert_eq!(found(&[home, ("XDG_STATE_HOME", "/s")]), "/s/sinew");
        assert_eq!(found(&[home, ("XDG_STATE_HOME", "s")]), "/home/x/.local/state/sinew");
        assert_eq!(found(&[home, ("SINEW_STATE_DIR", "/d"), ("XDG_STATE_HOME", "/s")]), "/d");
        assert_eq!(by(&[]), None);
    }
}
