//! What is said while a recording goes on.

use std::fmt;
use std::io;
use std::path::PathBuf;

use sinew_recording::session::size;

/// Something to know about a recording that goes on all the same.
#[derive(Debug)]
#[non_exhaustive]
pub enum Warning {
    /// The disk has less than twice what is to stay free ([`crate::Options::keep_free_bytes`]). Said once.
    LowSpace {
        /// The file being written.
        path: PathBuf,
        /// Free, bytes.
        free: u64,
        /// What is to stay free, bytes.
        floor: u64,
        /// How long it lasts as the free space falls at present, s; `None` = it does not fall, or that is not known yet.
        lasts_s: Option<f64>,
    },
    /// How much is free cannot be found out, so none is kept free.
    SpaceUnknown {
        /// The file being written.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
        /// What was to stay free, bytes.
        floor: u64,
    },
    /// An older file was to be removed, but it is not the one that was written: it stays.
    NotOurs {
        /// The file.
        path: PathBuf,
    },
    /// An older file could not be removed: it stays.
    NotRemoved {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::LowSpace { path, free, floor, lasts_s } => {
                let (path, free, floor) = (path.display(), size(*free), size(*floor));
                write!(f, "{path}: {free} are free on its disk, and the recording ends when it is less than {floor}")?;
                match lasts_s {
                    Some(seconds) => write!(f, ": in about {} at the present rate", time(*seconds)),
                    None => Ok(()),
                }
            }
            Warning::SpaceUnknown { path, reason, floor } => {
                let (path, floor) = (path.display(), size(*floor));
                write!(f, "{path}: how much is free on its disk is not known ({reason}), so {floor} are not kept free")
            }
            Warning::NotOurs { path } => {
                write!(f, "{}: is not the file that was recorded there; it is left alone", path.display())
            }
            Warning::NotRemoved { path, reason } => {
                write!(f, "{}: cannot be removed: {reason}; it is kept", path.display())
            }
        }
    }
}

/// Seconds for a person.
fn time(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} s"),
        ..7200.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.0} h", seconds / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_space_is_said_with_the_time_it_lasts() {
        let low = |lasts_s| Warning::LowSpace { path: "a.mcap".into(), free: 400_000_000, floor: 256_000_000, lasts_s };
        let text = low(Some(1500.0)).to_string();
        for word in ["a.mcap: 400.0 MB are free", "less than 256.0 MB", "about 25 min"] {
            assert!(text.contains(word), "{text}");
        }
        assert!(!low(None).to_string().contains("about"));
        assert_eq!((time(119.0), time(3.0 * 3600.0)), ("119 s".into(), "3 h".into()));
    }
}
