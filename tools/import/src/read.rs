//! Which kind of file it is, by its first bytes, and the reader for that.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use sinew_rig::FileFormat;

use crate::error::Error;
use crate::table::Table;
#[cfg(feature = "formats")]
use crate::{hdf5::hdf5, sheet::sheet};
use crate::{mat, tdms, text};

/// Most bytes of a file, and of what a compressed one is unpacked to.
pub const MAX_BYTES: u64 = 1 << 30;

/// Reads a file of any kind that is known, as far as `given` does not say how it is written.
///
/// # Errors
/// A file that cannot be read or has no table in it; a kind that is not read, with a sentence that says how to export it.
pub fn read(path: &Path, given: &FileFormat) -> Result<Table, Error> {
    let name = path.display().to_string();
    let unreadable = |e: std::io::Error| {
        Error::new(format!("cannot be read: {e}"), "check the path and that you may read it").of(&name)
    };
    if path.is_dir() {
        let rosbag = path.join("metadata.yaml").is_file();
        let (what, hint) = match rosbag {
            true => ("is the folder of a rosbag2", ROSBAG2),
            false => ("is a folder", "name the file"),
        };
        return Err(Error::new(what, hint).of(&name));
    }
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    read_bytes(&bytes, given).map_err(|error| error.of(&name))
}

/// The same of bytes; the error has no file.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], given: &FileFormat) -> Result<Table, Error> {
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Error::new("is larger than 1 GiB", "cut it into shorter files, or keep every n-th row"));
    }
    if bytes.is_empty() {
        return Err(Error::new("is empty", "record again, or check that the export has finished"));
    }
    if bytes.starts_with(&[0x1f, 0x8b]) {
        let mut unpacked = Vec::new();
        MultiGzDecoder::new(bytes).take(MAX_BYTES + 1).read_to_end(&mut unpacked).map_err(|e| {
            Error::new(format!("has damaged compressed data: {e}"), "copy it again from where it came, as binary")
        })?;
        if unpacked.starts_with(&[0x1f, 0x8b]) {
            return Err(Error::new("is compressed twice", "unpack it with gunzip first"));
        }
        return read_bytes(&unpacked, given);
    }
    if let Some((what, hint)) = other(bytes) {
        return Err(Error::new(what, hint));
    }
    match bytes {
        _ if bytes.starts_with(HDF5) || bytes.get(512..).is_some_and(|rest| rest.starts_with(HDF5)) => hdf5(bytes),
        _ if mat::is_version_5(bytes) => mat::version_5(bytes),
        _ if mat::is_version_4(bytes) => mat::version_4(bytes),
        [b'T', b'D', b'S', b'm', ..] => tdms::tdms(bytes, given),
        [b'P', b'K', 3, 4, ..] | [0xd0, 0xcf, 0x11, 0xe0, ..] => sheet(bytes, given),
        _ => text::text(bytes, given),
    }
}

/// How HDF5 begins, after 512 bytes of MATLAB's own in its files.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

#[cfg(not(feature = "formats"))]
fn hdf5(bytes: &[u8]) -> Result<Table, Error> {
    let hint = match bytes.starts_with(b"MATLAB") {
        true => {
            "in MATLAB: save('FILE-v7.mat', '-v7'); or take a release's package, or compile with the feature formats"
        }
        false => "write the columns as CSV; or take a release's package, or compile with the feature formats",
    };
    Err(Error::new("is HDF5, whose reader this program was compiled without", hint))
}

#[cfg(not(feature = "formats"))]
fn sheet(_: &[u8], _: &FileFormat) -> Result<Table, Error> {
    let what = "is a spreadsheet, for which this program was compiled without a reader";
    Err(Error::new(what, "save it as CSV; or take a release's package, or compile with the feature formats"))
}

const ROSBAG2: &str =
    "it has messages, not columns: play it and write a topic as a table, `ros2 topic echo --csv /TOPIC > FILE.csv`";

/// Kinds of file that are known and not read: what each is, and the way out.
fn other(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    let begins = |start: &[u8]| bytes.starts_with(start);
    Some(match () {
        _ if begins(b"SQLite format 3\0") => ("is an SQLite database, as a rosbag2 in .db3 is", ROSBAG2),
        _ if begins(b"#ROSBAG V") => {
            ("is a rosbag of ROS 1", "write a topic as a table: `rostopic echo -b FILE.bag -p /TOPIC > FILE.csv`")
        }
        _ if begins(b"\x89MCAP0\r\n") => (
            "is an MCAP file",
            "a session of sinew's is taken by every command as it is; of a rosbag2 write a topic as a table: `ros2 topic echo --csv /TOPIC > FILE.csv`",
        ),
        _ if begins(b"PAR1") => ("is a Parquet file", "in Python: pandas.read_parquet(FILE).to_csv(OUT, index=False)"),
        _ if begins(b"ARROW1") || begins(b"FEA1") => {
            ("is an Arrow file", "in Python: pandas.read_feather(FILE).to_csv(OUT, index=False)")
        }
        _ if begins(b"\x93NUMPY") => (
            "is a NumPy array without names of columns",
            "in Python: numpy.savetxt('FILE.csv', numpy.load(FILE), delimiter=',', header='t_s,duty,position_mm', comments='')",
        ),
        _ if begins(b"TDSh") => ("is the index of a TDMS file", "name the .tdms file beside it"),
        _ if begins(b"MDF     ") => {
            ("is an MDF measurement file", "in Python: asammdf.MDF(FILE).to_dataframe().to_csv(OUT)")
        }
        _ if begins(b"%PDF") => ("is a PDF", "export the table as CSV or .xlsx from the program that wrote it"),
        _ if begins(b"\x89PNG") || begins(b"\xff\xd8\xff") => ("is a picture", "export the numbers as CSV"),
        _ if begins(b"7z\xbc\xaf") || begins(b"Rar!") => ("is an archive", "unpack it and name the file in it"),
        _ => return None,
    })
}
