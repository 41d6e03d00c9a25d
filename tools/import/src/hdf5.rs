//! HDF5: MATLAB's files of version 7.3, and those of other programs.

use hdf5_reader::error::Error as Trouble;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};

use crate::arrays::{Array, Contents, table};
use crate::bytes::{Bytes, Kind};
use crate::contain::contained;
use crate::error::Error;
use crate::table::Table;

/// How deep groups may stand within groups.
const DEEPEST: usize = 8;
/// Most datasets that are looked at.
const MOST: usize = 10_000;
/// Most bytes of a dataset.
const MOST_BYTES: usize = 1 << 30;

/// Reads a file; of MATLAB's, objects of classes are told and passed over.
pub(crate) fn hdf5(bytes: &[u8]) -> Result<Table, Error> {
    let matlab = bytes.starts_with(b"MATLAB");
    let damaged = |why: String| {
        let hint = match matlab {
            true => "in MATLAB: S = load('FILE.mat'); save('FILE-v7.mat', '-struct', 'S', '-v7')",
            false => {
                "write its columns as CSV, in Python: pandas.DataFrame({k: numpy.ravel(v) for k, v in h5py.File(FILE).items()}).to_csv(OUT)"
            }
        };
        Error::new(format!("cannot be read as HDF5: {}", why.replace('\n', " ")), hint)
    };
    let mut contents = Contents::default();
    let read = contained(|| {
        let options = OpenOptions::default().with_max_read_bytes(MOST_BYTES).with_max_chunk_bytes(MOST_BYTES);
        let file = Hdf5File::from_bytes_with_options(bytes, options)?;
        let mut left = MOST;
        group(&file.root_group()?, "", &mut contents, 0, &mut left)
    });
    match read {
        Some(Ok(())) => table(contents, if matlab { "MATLAB 7.3" } else { "HDF5" }),
        Some(Err(error)) => Err(damaged(error.to_string())),
        None => Err(damaged("it is damaged".into())),
    }
}

/// Takes in what is in a group.
fn group(from: &Group, path: &str, contents: &mut Contents, depth: usize, left: &mut usize) -> Result<(), Trouble> {
    let (groups, datasets) = from.members()?;
    let full = |name: &str| if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
    for dataset in datasets {
        if *left == 0 {
            return Ok(());
        }
        *left -= 1;
        let name = full(dataset.name().rsplit('/').next().unwrap_or_default());
        match array(&dataset, &name) {
            Some(array) => contents.arrays.push(array),
            None => contents.notes.push(format!("{name} is no table of numbers: passed over")),
        }
    }
    for inner in groups {
        let name = inner.name().rsplit('/').next().unwrap_or_default().to_string();
        // what MATLAB keeps of objects, cells and texts
        if !name.starts_with('#') && depth < DEEPEST {
            group(&inner, &full(&name), contents, depth + 1, left)?;
        }
    }
    Ok(())
}

/// A dataset of at most two dimensions as an array. HDF5 has rows first and MATLAB columns, so that what MATLAB calls a row stands
/// here as a column: n × 1 and 1 × n are vectors either way.
fn array(dataset: &Dataset, name: &str) -> Option<Array> {
    let kind = match dataset.dtype() {
        Datatype::FloatingPoint { size: 4, .. } => Kind::F32,
        Datatype::FloatingPoint { size: 8, .. } => Kind::F64,
        Datatype::FixedPoint { size, signed, .. } => match (size, signed) {
            (1, true) => Kind::I8,
            (1, false) => Kind::U8,
            (2, true) => Kind::I16,
            (2, false) => Kind::U16,
            (4, true) => Kind::I32,
            (4, false) => Kind::U32,
            (8, true) => Kind::I64,
            (8, false) => Kind::U64,
            _ => return None,
        },
        _ => return None,
    };
    let shape: Vec<usize> = dataset.shape().iter().map(|n| usize::try_from(*n).ok()).collect::<Option<_>>()?;
    let (slow, fast) = match shape[..] {
        [] => (1, 1),
        [n] => (1, n),
        [slow, fast] => (slow, fast),
        _ => return None,
    };
    let bytes = dataset.read_native_bytes().ok()?;
    let mut rest = Bytes { rest: &bytes, big: cfg!(target_endian = "big") };
    let values: Vec<f64> = (0..slow.checked_mul(fast)?).map(|_| rest.number(kind)).collect::<Option<_>>()?;
    // texts of MATLAB's are numbers of their letters
    let class = dataset.attribute("MATLAB_class").ok().and_then(|class| class.read_string().ok());
    if class.is_some_and(|class| matches!(class.as_str(), "char" | "cell")) {
        return None;
    }
    // rows in a file of another program: the longer side is the time
    if slow > fast && fast > 1 {
        let columns = (0..fast).flat_map(|k| (0..slow).map(move |row| (row, k)));
        let values = columns.map(|(row, k)| values[row * fast + k]).collect();
        return Some(Array { name: name.into(), rows: slow, columns: fast, values });
    }
    Some(Array {
        name: name.into(),
        rows: if slow == 1 { 1 } else { fast },
        columns: if slow == 1 { fast } else { slow },
        values,
    })
}
