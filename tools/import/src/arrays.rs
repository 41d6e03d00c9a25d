//! Files of named arrays, as MATLAB's and HDF5 are: the ones of one length are the columns.

use crate::error::Error;
use crate::table::{Column, Table, name_all};

/// A numeric array of the file, column by column.
pub(crate) struct Array {
    pub name: String,
    pub rows: usize,
    pub columns: usize,
    pub values: Vec<f64>,
}

/// What a file has.
#[derive(Default)]
pub(crate) struct Contents {
    pub arrays: Vec<Array>,
    pub notes: Vec<String>,
    /// Objects of classes, whose contents are not documented.
    pub objects: Vec<String>,
}

/// The arrays as columns: vectors of one length, matrices column by column.
pub(crate) fn table(contents: Contents, kind: &str) -> Result<Table, Error> {
    let Contents { arrays, mut notes, objects } = contents;
    let length_of = |array: &Array| if array.rows == 1 { array.columns } else { array.rows };
    let count_of = |array: &Array| if array.rows == 1 { 1 } else { array.columns };
    // the length that most columns have, the longer one of two
    let mut lengths: Vec<(usize, usize)> = Vec::new();
    for array in arrays.iter().filter(|array| length_of(array) > 2) {
        let length = length_of(array);
        match lengths.iter_mut().find(|(_, l)| *l == length) {
            Some((count, _)) => *count += count_of(array),
            None => lengths.push((count_of(array), length)),
        }
    }
    let Some((_, length)) = lengths.into_iter().max() else {
        let hint = if objects.is_empty() {
            "save the samples as vectors of one length: save('FILE.mat', 't', 'duty', 'position', '-v7')"
        } else {
            "its tables, timeseries and datetimes are MATLAB's own objects: in MATLAB, writetable(T, 'FILE.csv'), or save vectors such as T.t"
        };
        return Err(Error::new("has no vectors of samples in it", hint));
    };
    for object in objects {
        notes.push(format!("{object} is an object of MATLAB's: passed over"));
    }
    let (mut columns, mut rate_hz) = (Vec::new(), None);
    for array in arrays {
        if length_of(&array) == length && array.rows * array.columns > 0 {
            let several = count_of(&array) > 1;
            for (k, values) in array.values.chunks_exact(length).enumerate() {
                let name = if several { format!("{}({})", array.name, k + 1) } else { array.name.clone() };
                let values = values.iter().map(|v| if v.is_finite() { *v } else { f64::NAN }).collect();
                columns.push(Column { name, unit: None, values, clock: false });
            }
        } else if let [value] = array.values[..] {
            let own = array.name.rsplit('.').next().unwrap_or_default().to_lowercase();
            match own.as_str() {
                "fs" | "rate" | "rate_hz" | "samplerate" | "sample_rate" | "fsample" if value > 0.0 => {
                    rate_hz = Some((value, format!("{} = {value}", array.name)));
                }
                "dt" | "ts" | "sampletime" if value > 0.0 => {
                    rate_hz = Some((1.0 / value, format!("{} = {value}", array.name)))
                }
                _ => {}
            }
        } else {
            notes.push(format!("{} has {} values and not {length}: passed over", array.name, array.values.len()));
        }
    }
    name_all(&mut columns);
    Ok(Table { kind: kind.into(), columns, format: Default::default(), rate_hz, notes, lines: Vec::new() })
}
