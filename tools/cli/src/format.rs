//! What kind of recording a file is, by its name.

use std::path::Path;

/// What a file is by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `.csv` or `.csv.gz`.
    Csv,
    /// `.parquet`.
    Parquet,
    /// `.mcap`.
    Session,
}

impl Format {
    /// By the end of the name.
    pub fn of(path: &Path) -> Option<Format> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        let ends = |end: &str| name.len() > end.len() && name.ends_with(end);
        match () {
            _ if ends(".csv") || ends(".csv.gz") => Some(Format::Csv),
            _ if ends(".parquet") => Some(Format::Parquet),
            _ if ends(".mcap") => Some(Format::Session),
            _ => None,
        }
    }
}
