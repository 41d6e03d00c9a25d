//! Errors of recording.

use std::fmt;
use std::io;
use std::path::PathBuf;

use sinew_threads::Thread;

use sinew_recording::session::size;

/// Every way a recording can fail.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// There is a file of that name already.
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A size or time after which to begin a new file that is too small for one.
    TooSmall {
        /// What.
        what: &'static str,
        /// As given, bytes or s.
        found: f64,
        /// The least that will do.
        least: f64,
    },
    /// Fewer files are to be kept than two.
    TooFewKept {
        /// As given.
        found: u32,
    },
    /// Less is to be kept than two files may have.
    TooLittleKept {
        /// As given, bytes.
        found: u64,
        /// The least that will do, bytes.
        least: u64,
    },
    /// Older files are to be removed, but there is only one, however long it becomes.
    OneFile,
    /// Less is free on the disk than is to stay free.
    Floor {
        /// The file that was being written, or was to be.
        path: PathBuf,
        /// Free, bytes.
        free: u64,
        /// What is to stay free, bytes.
        floor: u64,
    },
    /// The connection to the driver failed.
    Driver(sinew_ipc::Error),
    /// A file could not be written.
    File(sinew_recording::Error),
    /// A thread could not be started.
    Thread(io::Error),
    /// A thread has died.
    Died(Thread),
}

impl Error {
    /// What a person can do about it.
    pub fn remedy(&self) -> String {
        match self {
            Error::Exists { .. } => "choose another name, or --force to replace it".into(),
            Error::TooSmall { least, .. } => format!("give at least {least}"),
            Error::TooFewKept { .. } => "keep at least 2: the one being written and the one before it".into(),
            Error::TooLittleKept { least, .. } => format!("keep at least {}, or make files smaller", size(*least)),
            Error::OneFile => "say when a new file begins: --max-size 1GB or --max-time 10min".into(),
            Error::Floor { .. } => {
                "make room there or record to another disk; --keep-size bounds what a recording takes, --keep-free 100MB lets it \
                 have more, --keep-free 0 all"
                    .into()
            }
            Error::Driver(error) => error.remedy(),
            Error::File(error) => error.hint(),
            Error::Died(Thread::Writer) => "`sinew recording recover FILE.mcap` brings back what is in it; please report this".into(),
            Error::Died(_) => "record anew, and please report this".into(),
            Error::Thread(_) => "check the limits on threads and memory (`ulimit -a`)".into(),
        }
    }

    /// Whether this is the caller's mistake and not a failure of the machine or the driver.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Error::Exists { .. } | Error::TooSmall { .. } => true,
            Error::TooFewKept { .. } | Error::TooLittleKept { .. } | Error::OneFile => true,
            Error::Driver(error) => error.is_bad_input(),
            Error::File(error) => error.is_bad_input(),
            Error::Floor { .. } | Error::Thread(_) | Error::Died(_) => false,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Exists { path } => write!(f, "{}: is there already", path.display()),
            Error::TooSmall { what, found, .. } => write!(f, "a {what} of {found} is too small for a file"),
            Error::TooFewKept { found } => write!(f, "a recording of which {found} files are kept loses all it has"),
            Error::TooLittleKept { found, least } => {
                write!(f, "{} to keep are less than two files may have, {}", size(*found), size(*least))
            }
            Error::OneFile => f.write_str("a recording of which only the last files are kept is one file"),
            Error::Floor { path, free, floor } => {
                let (path, free, floor) = (path.display(), size(*free), size(*floor));
                write!(f, "{path}: {free} are free on its disk, less than the {floor} that stay free")
            }
            Error::Driver(error) => error.fmt(f),
            Error::File(error) => f.write_str(&error.message()),
            Error::Thread(error) => write!(f, "a thread failed: {error}"),
            Error::Died(thread) => write!(f, "the thread that {} has died", thread.row().does),
        }
    }
}

impl std::error::Error for Error {}

impl From<sinew_ipc::Error> for Error {
    fn from(error: sinew_ipc::Error) -> Error {
        Error::Driver(error)
    }
}

impl From<sinew_recording::Error> for Error {
    fn from(error: sinew_recording::Error) -> Error {
        Error::File(error)
    }
}
