//! Whatever goes through a format comes out bit for bit.

use std::fs::File;
use std::path::Path;

use parquet::column::reader::ColumnReader;
use parquet::file::reader::{FileReader, SerializedFileReader};
use proptest::prelude::*;
use sinew_exchange::{Imported, SessionPart, Table, parquet, session};
use sinew_recording::session::{About, Ended, Field, Head, Layout, Session, SessionWriter, WriteOptions};
use sinew_recording::{Column, Options, Recording, read, write};

fn about() -> About {
    About {
        rig: "bench".into(),
        rate_hz: 1000.0,
        software: "sinew test".into(),
        kind: "driver".into(),
        simulated: true,
        started_unix_ns: 1_700_000_000_000_000_000,
        started_monotonic_ns: 5_000_000_000,
        rig_toml: Some("[rig]\nname = \"bench\"\n".into()),
        extra: Default::default(),
    }
}

/// Any finite number there is, among them the awkward ones, and missing samples.
fn sample() -> impl Strategy<Value = f64> {
    let awkward = [0.0, -0.0, f64::MIN_POSITIVE, 5e-324, -5e-324, f64::MAX, f64::NAN, 1.0 / 3.0, 0.1 + 0.2];
    prop_oneof![
        3 => any::<u64>().prop_map(f64::from_bits).prop_filter("infinities are refused", |v| !v.is_infinite()),
        1 => prop::sample::select(awkward.to_vec()),
    ]
}

/// By its bits, one missing sample like the other.
fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| if v.is_nan() { f64::NAN.to_bits() } else { v.to_bits() }).collect()
}

fn same(one: &Recording, other: &Recording) {
    assert_eq!(bits(one.time_s()), bits(other.time_s()));
    let columns = |r: &Recording| r.columns().map(|(column, values)| (column, bits(values))).collect::<Vec<_>>();
    assert_eq!(columns(one), columns(other));
}

/// Columns whose values nothing is required of.
const FREE: [Column; 5] = [Column::V1V, Column::ForceN, Column::PositionM, Column::CurrentA, Column::DisturbanceN];

fn recording() -> impl Strategy<Value = Recording> {
    let steps = prop::collection::vec(1e-9..1e3f64, 3..40);
    (steps, prop::sample::subsequence(FREE.to_vec(), 1..=5), -1e6..2e9f64).prop_flat_map(|(steps, columns, start)| {
        let mut time_s = start;
        let times: Vec<f64> = steps
            .iter()
            .map(|step| {
                time_s = (time_s + step).max(time_s.next_up());
                time_s
            })
            .collect();
        let rows = times.len();
        prop::collection::vec(prop::collection::vec(sample(), rows), columns.len()).prop_map(move |values| {
            let mut recording = Recording::new("any", times.clone()).unwrap();
            for (column, values) in columns.iter().zip(values) {
                recording.set(*column, values).unwrap();
            }
            recording
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn csv_to_a_session_and_back(original in recording(), gz in any::<bool>()) {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let name = if gz { "a.csv.gz" } else { "a.csv" };
        write(at(name), &original).unwrap();
        let foreign = read(at(name), &Options::default()).unwrap();
        same(&original, &foreign);

        let imported = Imported::new(foreign, "the wire", about()).unwrap();
        prop_assert_eq!(session(&imported, &at("b.mcap")).unwrap(), original.len() as u64);
        let back = read(at("b.mcap"), &Options::default()).unwrap();
        same(&original, &back);
        write(at("c.csv"), &back).unwrap();
        same(&original, &read(at("c.csv"), &Options::default()).unwrap());
        if !gz {
            prop_assert_eq!(std::fs::read(at("a.csv")).unwrap(), std::fs::read(at("c.csv")).unwrap());
        }
    }

    #[test]
    fn a_session_to_parquet(
        channels in 1usize..4,
        floats in 1usize..6,
        pairs in 0usize..3,
        rows in prop::collection::vec((1u64..50, prop::collection::vec(any::<u64>(), 24)), 0..60),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let fields = (0..floats).map(|i| Field::f64(&format!("x{i}"), "m"))
            .chain((0..2 * pairs).map(|i| Field::u32(&format!("n{i}")))).collect();
        let layout = Layout::new((0..channels).map(|i| format!("Wire {i}")).collect(), fields).unwrap();
        let options = WriteOptions::new("a.mcap");
        let mut writer = SessionWriter::create(File::create(at("a.mcap")).unwrap(), &about(), &layout, options).unwrap();
        let (mut cycle, mut expected) = (0, Vec::new());
        for (step, words) in &rows {
            cycle += step;
            let bytes: Vec<u8> = words.iter().cycle().flat_map(|w| w.to_le_bytes()).take(layout.bytes()).collect();
            let head = Head { cycle, monotonic_ns: 5_000_000_000 + cycle * 1_000_000, missed: cycle / 7 };
            writer.cycle(&head, &bytes).unwrap();
            expected.push((head, bytes));
        }
        writer.finish(Ended::Complete).unwrap();
        let original = Session::open(at("a.mcap")).unwrap();
        let written = parquet(&SessionPart::whole(&original), &[], &at("a.parquet")).unwrap();
        prop_assert_eq!(written, rows.len() as u64);
        prop_assert_eq!(columns(&at("a.parquet")), expected_columns(&layout, &expected));
        // and what came out of it is a session again, the same
        session(&SessionPart::whole(&original), &at("b.mcap")).unwrap();
        let again = Session::open(at("b.mcap")).unwrap();
        let mut seen = Vec::new();
        SessionPart::whole(&again).each(&mut |cycle| { seen.push((cycle.head, cycle.bytes.to_vec())); Ok(()) }).unwrap();
        prop_assert_eq!(seen, expected);
        prop_assert_eq!(again.about(), original.about());
    }
}

/// The columns of a Parquet file by name, every value by its bits.
fn columns(path: &Path) -> Vec<(String, Vec<u64>)> {
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let mut columns: Vec<(String, Vec<u64>)> =
        schema.columns().iter().map(|column| (column.name().to_string(), Vec::new())).collect();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).unwrap();
        let rows = group.metadata().num_rows() as usize;
        for (index, (_, values)) in columns.iter_mut().enumerate() {
            match group.get_column_reader(index).unwrap() {
                ColumnReader::DoubleColumnReader(mut column) => {
                    let mut read = Vec::new();
                    column.read_records(rows, None, None, &mut read).unwrap();
                    values.extend(read.iter().map(|v| v.to_bits()));
                }
                ColumnReader::Int32ColumnReader(mut column) => {
                    let mut read = Vec::new();
                    column.read_records(rows, None, None, &mut read).unwrap();
                    values.extend(read.iter().map(|v| u64::from(*v as u32)));
                }
                ColumnReader::Int64ColumnReader(mut column) => {
                    let mut read = Vec::new();
                    column.read_records(rows, None, None, &mut read).unwrap();
                    values.extend(read.iter().map(|v| *v as u64));
                }
                _ => panic!("a column of another type"),
            }
        }
    }
    columns
}

fn expected_columns(layout: &Layout, cycles: &[(Head, Vec<u8>)]) -> Vec<(String, Vec<u64>)> {
    let head = |name: &str, of: fn(&Head) -> u64| (name.to_string(), cycles.iter().map(|(head, _)| of(head)).collect());
    let mut columns: Vec<(String, Vec<u64>)> = vec![
        head("cycle", |h| h.cycle),
        head("monotonic_ns", |h| h.monotonic_ns),
        head("missed", |h| h.missed),
        head("time_s", |h| ((h.monotonic_ns - 5_000_000_000) as f64 * 1e-9).to_bits()),
    ];
    let mut offset = 0;
    for channel in &layout.channels {
        for field in &layout.fields {
            let width = if field.name.starts_with('x') { 8 } else { 4 };
            let value = |bytes: &Vec<u8>| {
                let mut word = [0; 8];
                word[..width].copy_from_slice(&bytes[offset..offset + width]);
                u64::from_le_bytes(word)
            };
            columns.push((format!("{channel}.{}", field.name), cycles.iter().map(|(_, bytes)| value(bytes)).collect()));
            offset += width;
        }
    }
    columns
}

#[test]
fn parquet_says_where_it_comes_from_and_of_which_channels() {
    let folder = tempfile::tempdir().unwrap();
    let mut recording = Recording::new("x", vec![0.0, 0.5, 1.0]).unwrap();
    recording.set(Column::ForceN, vec![1.0, f64::NAN, -0.0]).unwrap();
    let imported = Imported::new(recording, "wire", about()).unwrap();
    let path = folder.path().join("x.parquet");
    parquet(&imported, &[0], &path).unwrap();
    let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
    let said = reader.metadata().file_metadata().key_value_metadata().unwrap().clone();
    let of = |key: &str| said.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.clone()).unwrap();
    assert_eq!(of("rig.toml"), "[rig]\nname = \"bench\"\n");
    let sinew: serde_json::Value = serde_json::from_str(&of("sinew")).unwrap();
    assert_eq!((sinew["kind"].as_str(), sinew["rate_hz"].as_f64()), (Some("import"), Some(2.0)));
    assert_eq!(
        (sinew["fields"][1]["name"].as_str(), sinew["fields"][1]["unit"].as_str()),
        (Some("force_n"), Some("N"))
    );
}

#[test]
fn a_session_too_large_for_one_group_has_several_and_no_row_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let layout = Layout::new(vec!["w".into()], (0..500).map(|i| Field::f64(&format!("x{i}"), "")).collect()).unwrap();
    let path = folder.path().join("a.mcap");
    let mut writer =
        SessionWriter::create(File::create(&path).unwrap(), &about(), &layout, WriteOptions::new("a.mcap")).unwrap();
    let rows = sinew_exchange::GROUP_BYTES / 4000 + 7;
    for cycle in 1..=rows as u64 {
        let head = Head { cycle, monotonic_ns: 5_000_000_000 + cycle, missed: 0 };
        writer.cycle(&head, &cycle.to_le_bytes().repeat(500)).unwrap();
    }
    writer.finish(Ended::Complete).unwrap();
    let out = folder.path().join("a.parquet");
    parquet(&SessionPart::whole(&Session::open(&path).unwrap()), &[], &out).unwrap();
    let reader = SerializedFileReader::new(File::open(&out).unwrap()).unwrap();
    assert!(reader.num_row_groups() >= 2);
    let last = columns(&out).pop().unwrap();
    assert_eq!(last.1, (1..=rows as u64).collect::<Vec<u64>>());
}
