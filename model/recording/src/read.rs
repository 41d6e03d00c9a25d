//! Reading a recording: which format a file is in, by its name and its first bytes, and the reader for that.

use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use crate::columns::Columns;
use crate::error::{Error, What};
use crate::options::Options;
use crate::recording::Recording;
use crate::rows;
use crate::session::Session;
use crate::table::{BUFFER_BYTES, Reader};

/// Whether a file of this name is to be gzipped.
pub(crate) fn is_gz(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"))
}

/// Whether a file of this name is to be a session.
pub(crate) fn is_mcap(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap"))
}

/// Reads a `.csv`, a `.csv.gz`, or one channel of a session (`.mcap`), see [`crate::rows`].
///
/// # Errors
/// Whatever is wrong first, with file, line, column and remedy.
pub fn read(path: impl AsRef<Path>, options: &Options<'_>) -> Result<Recording, Error> {
    let path = path.as_ref();
    let name = path.to_string_lossy();
    let unreadable = |e: io::Error| Error::new(&name, What::Unreadable { reason: e.to_string() });
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Err(unreadable(ErrorKind::IsADirectory.into()));
    }
    let mut file = BufReader::with_capacity(BUFFER_BYTES, file);
    // the first bytes of a file arrive together, only a pipe may split them
    let start = file.fill_buf().map_err(unreadable)?;
    let compressed = start.starts_with(&[0x1f, 0x8b]);
    if is_mcap(path) || start.starts_with(&[0x89, b'M', b'C', b'A', b'P']) {
        return rows::recording(&Session::open(path)?, options);
    }
    match (start.is_empty(), is_gz(path), compressed) {
        (true, ..) => Err(Error::new(&name, What::Empty)),
        (_, true, false) => Err(Error::new(&name, What::NotGzip)),
        (_, false, true) => Err(Error::new(&name, What::UnexpectedGzip)),
        (_, true, true) => Reader::new(MultiGzDecoder::new(file), &name, options, true).recording(),
        (_, false, false) => Reader::new(file, &name, options, false).recording(),
    }
}

/// Reads CSV text from anything; `name` is what messages call it.
///
/// # Errors
/// As [`read`].
pub fn read_from(from: impl Read, name: &str, options: &Options<'_>) -> Result<Recording, Error> {
    Reader::new(from, name, options, false).recording()
}

/// A recording of columns that are numbers already, such as those of a spreadsheet: `header` names them, `line` says in which
/// line of the file a row stands, and NaN is a missing sample. The map of `options` and all checks are those of [`read`].
///
/// # Errors
/// As [`read`]; columns of different lengths.
pub fn read_table(
    name: &str,
    header: &[String],
    columns: &[&[f64]],
    line: impl Fn(usize) -> Option<u64>,
    options: &Options<'_>,
) -> Result<Recording, Error> {
    let rows = columns.first().map_or(0, |column| column.len());
    for (name_of, column) in header.iter().zip(columns) {
        if column.len() != rows {
            let what = What::WrongLength { expected: rows, found: column.len() };
            return Err(Error::new(name, what).in_column(name_of));
        }
    }
    let header = &header[..header.len().min(columns.len())];
    let mut table = Columns::new(name, options, header, None)?;
    (0..rows).try_for_each(|row| {
        table.row(line(row), |cell| match columns[cell][row] {
            infinite if infinite.is_infinite() => Err(What::Infinite { found: infinite.to_string() }),
            value => Ok(value),
        })
    })?;
    table.recording()
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::path::PathBuf;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use proptest::prelude::*;
    use sinew_physics::{DriveKind, Load};

    use super::*;
    use crate::column::Column;
    use crate::error::{Miscount, Needed};
    use crate::table::MAX_LINE_BYTES;
    use crate::testing::model;
    use sinew_rig::ColumnMap;

    fn text(text: &str) -> Result<Recording, Error> {
        let model = model();
        read_from(text.as_bytes(), "lab.csv", &Options { model: Some(&model), ..Options::default() })
    }

    /// The error of `text`, checked to name the file and the given place, and to have a remedy.
    fn wrong(content: &str, line: Option<u64>, column: Option<&str>) -> What {
        let error = text(content).expect_err(content);
        assert_eq!((error.line, error.column.as_deref()), (line, column), "{error}");
        assert!(error.file == "lab.csv" && !error.hint().is_empty() && error.is_bad_input(), "{error}");
        assert!(!error.to_string().contains('\n'), "{error}");
        error.what
    }

    const GOOD: &str = "time_s,duty,position_m\n0,0,0.001\n0.1,0.5,\n0.3,1,nan\n";

    #[test]
    fn a_good_file_is_read() {
        let r = text(GOOD).unwrap();
        assert_eq!(r.time_s(), [0.0, 0.1, 0.3]);
        assert_eq!(r.get(Column::Duty).unwrap(), [0.0, 0.5, 1.0]);
        let position = r.get(Column::PositionM).unwrap();
        assert!(position[0] == 0.001 && position[1].is_nan() && position[2].is_nan());
        assert_eq!(r.get(Column::ForceN), None);
        assert_eq!(r.columns().count(), 2);
    }

    #[test]
    fn marks_blanks_quotes_and_line_ends_do_no_harm() {
        let spoilt =
            format!("\u{feff}{}", GOOD.replace('\n', "\r\n").replace("time_s", "\"time_s\"").replace("0.5", " 0.5 "));
        assert_eq!(text(&spoilt).unwrap().time_s(), text(GOOD).unwrap().time_s());
        assert_eq!(text(&format!("\n{GOOD}\n\n  \n")).unwrap().len(), 3);
        assert_eq!(text(GOOD.trim_end()).unwrap().len(), 3);
    }

    #[test]
    fn too_little_is_refused() {
        assert_eq!(wrong("", None, None), What::Empty);
        assert_eq!(wrong("\n\r\n", None, None), What::Empty);
        assert_eq!(wrong("time_s,duty\n", None, None), What::HeaderOnly);
        assert_eq!(wrong("time_s,duty\n0,0\n1,0\n", None, None), What::TooFewSamples { found: 2, least: 3 });
    }

    #[test]
    fn the_columns_must_be_right() {
        let error = text("t_ms,duty\n0,0\n").unwrap_err();
        assert!(matches!(error.what, What::MissingTimeColumn { .. }));
        assert!(error.hint().contains("time_s = { column = \"t_ms\", scale = 0.001 }"), "{error}");
        assert!(matches!(wrong("duty,force_n\n0,0\n", Some(1), None), What::MissingTimeColumn { .. }));

        let what = wrong("time_s,power_w\n0,0\n", Some(1), None);
        let because = Needed::Drive(DriveKind::Pwm);
        let present = vec!["time_s".to_string(), "power_w".to_string()];
        assert_eq!(what, What::MissingInput { input: Column::Duty, because, present });
        let error = text("time_s,power_w\n0,0\n").unwrap_err();
        assert!(error.hint().contains("kind = \"power\""), "{error}");

        let what = wrong("time_s,duty,positon_m,foo\n0,0,0,0\n", Some(1), Some("positon_m"));
        let nearest = Some("position_m");
        assert_eq!(what, What::UnknownColumn { nearest, others: vec!["foo".to_string()] });
        assert!(text("time_s,duty,foo\n0,0\n").unwrap_err().hint().contains("--ignore-columns"));

        let what = wrong("time_s,duty,duty\n0,0,0\n", Some(1), Some("duty"));
        assert!(matches!(what, What::DuplicateColumn { quantity: "duty", .. }));
        let what = wrong("0,0.5\n1,0.5\n", Some(1), None);
        assert!(matches!(what, What::NoHeader { .. }));
    }

    #[test]
    fn ignored_columns_are_not_even_parsed() {
        let options = Options { ignore_columns: true, ..Options::default() };
        let content = "time_s,note,note,duty\n0,a,b,0\n1,,\u{e4},0\n2,x,inf,0.5\n";
        let r = read_from(content.as_bytes(), "x", &options).unwrap();
        assert_eq!(r.get(Column::Duty).unwrap(), [0.0, 0.0, 0.5]);
    }

    #[test]
    fn cells_must_be_numbers() {
        let what = wrong("time_s,duty\n0,0\n1,0.5x\n2,0\n", Some(3), Some("duty"));
        assert_eq!(what, What::NotANumber { found: "0.5x".into() });
        for bad in ["inf", "-Infinity", "1e999"] {
            let what = wrong(&format!("time_s,duty,force_n\n0,0,0\n1,0,{bad}\n2,0,0\n"), Some(3), Some("force_n"));
            assert_eq!(what, What::Infinite { found: bad.into() });
        }
        let what = wrong("time_s,duty\n0,0\n,0\n2,0\n", Some(3), Some("time_s"));
        assert_eq!(what, What::MissingTime);
        let what = wrong("time_s,duty\n0,0\n1,\n2,0\n", Some(3), Some("duty"));
        assert_eq!(what, What::MissingSample { time_s: 1.0 });
    }

    #[test]
    fn rows_must_be_whole() {
        let what = wrong("time_s,duty,force_n\n0,0,0\n\n1,0\n2,0,0\n", Some(4), None);
        assert_eq!(what, What::FieldCount { expected: 3, found: 2, cause: Miscount::Unknown });
        let what = wrong("time_s,duty,force_n\n0,0,0\n1,0\n", Some(3), None);
        assert_eq!(what, What::FieldCount { expected: 3, found: 2, cause: Miscount::CutOff });
        let what = wrong("time_s,duty\n0,0,\n1,0,\n", Some(2), None);
        assert_eq!(what, What::FieldCount { expected: 2, found: 3, cause: Miscount::TrailingComma });
    }

    #[test]
    fn other_countries_files_are_recognised() {
        assert_eq!(wrong("time_s;duty\n0;0\n", Some(1), None), What::WrongSeparator { found: "semicolons" });
        assert_eq!(wrong("time_s\tduty\n0\t0\n", Some(1), None), What::WrongSeparator { found: "tabs" });
        assert_eq!(wrong("time_s duty\n0 0\n", Some(1), None), What::WrongSeparator { found: "spaces" });
        assert_eq!(wrong("time_s,duty\n0,0;0,5\n", Some(2), None), What::WrongSeparator { found: "semicolons" });
        let what = wrong("time_s,duty\n0,0,0,5\n", Some(2), None);
        assert_eq!(what, What::FieldCount { expected: 2, found: 4, cause: Miscount::DecimalComma });
        let what = wrong("time_s,duty\n0,\"0,5\"\n", Some(2), None);
        assert_eq!(what, What::FieldCount { expected: 2, found: 3, cause: Miscount::DecimalComma });
        let bytes = [b"\xff\xfet\0i\0m\0e\0".as_slice(), b"PK\x03\x04....", b"\x89MCAP0\r\n", b"a\0b"];
        for kind in bytes {
            let error = read_from(kind, "x", &Options::default()).unwrap_err();
            assert!(matches!(error.what, What::NotText { .. }), "{error}");
        }
        let latin = b"time_s,duty,\xb5m\n";
        assert!(matches!(read_from(&latin[..], "x", &Options::default()).unwrap_err().what, What::NotText { .. }));
    }

    #[test]
    fn time_must_increase_and_end() {
        let what = wrong("time_s,duty\n0,0\n1,0\n1,0\n", Some(4), Some("time_s"));
        assert_eq!(what, What::TimeNotIncreasing { previous: 1.0, found: 1.0 });
        let what = wrong("time_s,duty\n0,0\n1,0\n0.5,0\n", Some(4), Some("time_s"));
        assert_eq!(what, What::TimeNotIncreasing { previous: 1.0, found: 0.5 });
        let what = wrong("time_s,duty\n0,0\n1,0\n5e6,0\n", Some(4), Some("time_s"));
        assert!(matches!(what, What::TooLong { .. }));
    }

    #[test]
    fn units_that_cannot_be_meant_are_refused() {
        let what = wrong("time_s,duty\n0,0\n1,50\n2,0\n", Some(3), Some("duty"));
        assert_eq!(what, What::DutyOutOfRange { found: 50.0 });
        assert!(text("time_s,duty\n0,0\n1,50\n").unwrap_err().hint().contains("scale = 0.01"));
        wrong("time_s,duty\n0,-0.1\n", Some(2), Some("duty"));

        let what = wrong("time_s,duty,position_m\n0,0,7\n1,0,3.5\n2,0,7.1\n", Some(4), Some("position_m"));
        assert_eq!(what, What::PositionTooLarge { found: 7.1, wire_m: 0.16 });
        // an encoder's arbitrary zero is not a unit
        assert!(text("time_s,duty,position_m\n0,0,7\n1,0,7.003\n2,0,7.005\n").is_ok());

        let what = wrong("time_s,duty,ambient_c\n0,0,298\n1,0,297.5\n2,0,299\n", Some(3), Some("ambient_c"));
        assert_eq!(what, What::Kelvin { lowest: 297.5 });
        let what = wrong("time_s,duty,temperature_c\n0,0,298\n1,0,350\n2,0,370\n", Some(2), Some("temperature_c"));
        assert_eq!(what, What::Kelvin { lowest: 298.0 });
        assert!(text("time_s,duty,temperature_c\n0,0,20\n1,0,250\n2,0,370\n").is_ok());
        wrong("time_s,duty,temperature_c\n0,0,-300\n", Some(2), Some("temperature_c"));
    }

    #[test]
    fn negative_power_is_refused_only_as_an_input() {
        let content = "time_s,duty,power_w\n0,0,-0.001\n1,0,0\n2,0,1\n";
        assert!(text(content).is_ok());
        let mut model = model();
        model.drive.kind = DriveKind::Power;
        let options = Options { model: Some(&model), ..Options::default() };
        let error = read_from(content.as_bytes(), "x", &options).unwrap_err();
        assert_eq!(error.what, What::NegativePower { found: -0.001 });
    }

    #[test]
    fn foreign_names_are_mapped_and_scaled() {
        let map: ColumnMap = [
            ("time_s", "t", 1e-3, 0.0),
            ("position_m", "Pos", -1e-3, 0.01),
            ("duty", "PWM", 0.01, 0.0),
            ("temperature_c", "temperature_c", 1.0, -273.15),
        ]
        .into_iter()
        .map(|(to, column, scale, offset)| {
            (to.to_string(), sinew_rig::Column { column: column.to_string(), scale, offset })
        })
        .collect();
        let model = model();
        let options = Options { columns: Some(&map), model: Some(&model), ..Options::default() };
        let content = "t,Pos,PWM,temperature_c\n0,1,0,298.15\n100,2,50,300\n200,3,100,301\n";
        let r = read_from(content.as_bytes(), "x", &options).unwrap();
        assert!((r.time_s()[1] - 0.1).abs() < 1e-15);
        assert_eq!(r.get(Column::Duty).unwrap(), [0.0, 0.5, 1.0]);
        assert!((r.get(Column::PositionM).unwrap()[0] - 0.009).abs() < 1e-15);
        assert!((r.get(Column::TemperatureC).unwrap()[0] - 25.0).abs() < 1e-9);
        // our own files go with the same rig
        assert_eq!(read_from(GOOD.as_bytes(), "x", &options).unwrap().len(), 3);
        let both = "time_s,duty,PWM\n0,0,0\n";
        let error = read_from(both.as_bytes(), "x", &options).unwrap_err();
        assert!(matches!(error.what, What::DuplicateColumn { quantity: "duty", .. }), "{error}");
        let content = "t,PWM,Pos,temperature_c\n0,0,0,298\n1,500,0,298\n";
        let error = read_from(content.as_bytes(), "x", &options).unwrap_err();
        assert_eq!((error.line, error.column.as_deref()), (Some(3), Some("PWM")), "{error}");
    }

    #[test]
    fn a_mapped_column_that_is_missing_is_an_error_whatever_else_is_ignored() {
        let map: ColumnMap = [("time_s", "t"), ("position_m", "Pos"), ("duty", "PWM")]
            .into_iter()
            .map(|(to, column)| {
                (to.to_string(), sinew_rig::Column { column: column.to_string(), scale: 1.0, offset: 0.0 })
            })
            .collect();
        for ignore_columns in [false, true] {
            let options = Options { columns: Some(&map), ignore_columns, ..Options::default() };
            let read = |content: &str| read_from(content.as_bytes(), "x", &options);
            for (content, column) in [
                ("t,PWM,Poss\n0,0,0\n1,0,0\n2,0,0\n", "Pos"),
                ("time_s,PWM\n0,0\n1,0\n2,0\n", "Pos"),
                ("Zeit,PWM,Pos\n0,0,0\n1,0,0\n2,0,0\n", "t"),
            ] {
                let error = read(content).unwrap_err();
                assert!(matches!(error.what, What::MissingMapped { .. }), "{error}");
                assert_eq!((error.line, error.column.as_deref()), (Some(1), Some(column)));
            }
            assert!(read("t,PWM,Poss\n").unwrap_err().hint().contains("did you mean \"Poss\"?"));
            // a recording in the contract's own names has nothing that is mapped
            assert_eq!(read("time_s,duty\n0,0\n1,0\n2,0\n").unwrap().len(), 3);
        }
    }

    #[test]
    fn columns_of_numbers_are_read_as_lines_of_text_are() {
        let header = ["time_s".to_string(), "duty".to_string()];
        let options = Options::default();
        let line = |row| Some(row as u64 + 5);
        let (time, duty) = ([0.0, 0.1, 0.2], [0.0, 0.5, f64::NAN]);
        let read = read_table("sheet", &header, &[&time, &duty], line, &options).unwrap();
        assert_eq!((read.len(), read.get(Column::Duty).unwrap()[1]), (3, 0.5));
        let error = read_table("sheet", &header, &[&time, &[0.0, 50.0, 0.0]], line, &options).unwrap_err();
        assert_eq!((error.line, error.what), (Some(6), What::DutyOutOfRange { found: 50.0 }));
        let error = read_table("sheet", &header, &[&time, &[0.0]], line, &options).unwrap_err();
        assert_eq!(error.what, What::WrongLength { expected: 3, found: 1 });
    }

    #[test]
    fn exchanged_names_are_exchanged() {
        let entry = |column: &str| sinew_rig::Column { column: column.to_string(), scale: 1.0, offset: 0.0 };
        let map: ColumnMap =
            [("v1_v".to_string(), entry("v2_v")), ("v2_v".to_string(), entry("v1_v"))].into_iter().collect();
        let options = Options { columns: Some(&map), ..Options::default() };
        let r = read_from("time_s,v1_v,v2_v\n0,1,2\n1,1,2\n2,1,2\n".as_bytes(), "x", &options).unwrap();
        assert_eq!((r.get(Column::V1V).unwrap()[0], r.get(Column::V2V).unwrap()[0]), (2.0, 1.0));
    }

    #[test]
    fn lines_are_counted_whatever_ends_them() {
        for end in ["\n", "\r\n"] {
            for last in ["", end] {
                let content = ["", "time_s,duty", "", "", "0,0", "  ", "1,x"].join(end) + last;
                assert_eq!(wrong(&content, Some(7), Some("duty")), What::NotANumber { found: "x".into() });
            }
        }
        // good lines that arrive together with one that is too long are still counted
        let body = |long: usize| format!("time_s,duty\n0,0\n1,0\n2,0{}\n3,0\n", " ".repeat(long - 3));
        assert!(text(&body(MAX_LINE_BYTES)).is_ok());
        assert_eq!(wrong(&body(MAX_LINE_BYTES + 1), Some(4), None), What::LineTooLong { limit: MAX_LINE_BYTES });
    }

    #[test]
    fn rows_and_lines_have_a_limit() {
        let rows: String = (0..11).map(|i| format!("{i},0\n")).collect();
        let content = format!("time_s,duty\n{rows}");
        let options = Options { max_rows: 10, ..Options::default() };
        let error = read_from(content.as_bytes(), "x", &options).unwrap_err();
        assert_eq!((error.line, error.what), (Some(12), What::TooManyRows { limit: 10 }));
        // memory stays bounded however long the line is: this one never ends
        let endless = "time_s,duty\n".as_bytes().chain(io::repeat(b'7'));
        let error = read_from(endless, "x", &Options::default()).unwrap_err();
        assert_eq!((error.line, error.what), (Some(2), What::LineTooLong { limit: MAX_LINE_BYTES }));
        let error = read_from(io::repeat(0), "x", &Options::default()).unwrap_err();
        assert!(matches!(error.what, What::NotText { .. }), "{error}");
    }

    fn file(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        (folder, path)
    }

    fn gzip(content: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn compression_must_be_what_the_name_says() {
        let what = |name: &str, content: &[u8]| {
            let (_folder, path) = file(name, content);
            let error = read(&path, &Options::default()).unwrap_err();
            assert!(error.file.ends_with(name), "{error}");
            error.what
        };
        let packed = gzip(GOOD.as_bytes());
        assert_eq!(what("a.csv.gz", GOOD.as_bytes()), What::NotGzip);
        assert_eq!(what("a.csv", &packed), What::UnexpectedGzip);
        assert_eq!(what("a.csv.gz", b""), What::Empty);
        assert_eq!(what("a.csv.gz", &gzip(b"")), What::Empty);
        for cut in 2..packed.len() {
            assert_eq!(what("a.csv.gz", &packed[..cut]), What::TruncatedGzip, "cut at {cut}");
        }
        let mut damaged = packed.clone();
        let crc = damaged.len() - 6;
        damaged[crc] ^= 0xff;
        assert!(matches!(what("a.csv.gz", &damaged), What::CorruptGzip { .. }));
        let (_folder, path) = file("two.csv.gz", &[packed, gzip(b"0.4,0,\n")].concat());
        assert_eq!(read(&path, &Options::default()).unwrap().len(), 4, "gzip files may be put end to end");
    }

    #[test]
    fn what_cannot_be_opened_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let error = read(folder.path(), &Options::default()).unwrap_err();
        assert!(matches!(error.what, What::Unreadable { .. }), "{error}");
        let error = read(folder.path().join("none.csv"), &Options::default()).unwrap_err();
        assert!(error.is_bad_input() && error.to_string().contains("none.csv: cannot be read"), "{error}");
    }

    /// A number as labs write them, or rubbish.
    fn cell() -> impl Strategy<Value = String> {
        prop_oneof![
            4 => (-2.0f64..2.0).prop_map(|v| format!("{v}")),
            1 => any::<f64>().prop_map(|v| format!("{v}")),
            1 => Just(String::new()),
            1 => "[0-9.,;\"eE+-]{0,6}",
            1 => "\\PC{0,4}",
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]
        #[test]
        fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), ignore in any::<bool>()) {
            let model = model();
            let options = Options { ignore_columns: ignore, model: Some(&model), ..Options::default() };
            if let Err(error) = read_from(&bytes[..], "x", &options) {
                prop_assert!(!error.to_string().contains('\n') && !error.hint().is_empty());
            }
        }

        #[test]
        fn arbitrary_rows_below_a_good_header_never_panic(
            rows in prop::collection::vec(prop::collection::vec(cell(), 1..6), 0..12),
            imposed in any::<bool>(),
        ) {
            let mut model = model();
            if imposed {
                model.load = Load::ImposedForce;
            }
            let options = Options { model: Some(&model), ..Options::default() };
            let body: String = rows.iter().map(|r| r.join(",") + "\n").collect();
            let content = format!("time_s,duty,force_n,position_m\n{body}");
            match read_from(content.as_bytes(), "x", &options) {
                Ok(r) => {
                    prop_assert!(r.time_s().windows(2).all(|w| w[0] < w[1]));
                    prop_assert!(r.columns().all(|(_, v)| v.iter().all(|x| !x.is_infinite())));
                    prop_assert!(r.inputs_for(&model).unwrap().all(|(i, dt)| dt > 0.0 && i.drive.is_finite()));
                }
                Err(error) => prop_assert!(!error.to_string().contains('\n') && !error.hint().is_empty()),
            }
        }

        #[test]
        fn damaged_gzip_never_panics(place in any::<prop::sample::Index>(), flip in 1u8..) {
            let mut packed = gzip(GOOD.as_bytes());
            let place = place.index(packed.len());
            packed[place] ^= flip;
            let (_folder, path) = file("a.csv.gz", &packed);
            let _ = read(&path, &Options::default());
        }
    }
}
