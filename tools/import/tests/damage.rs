//! No bytes make the importer panic, and every refusal has a place and a remedy.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use sinew_import::{confirm, guess, mapping, read_bytes};
use sinew_rig::{FileFormat, Mapping};

/// Reads bytes all the way to the mapping.
fn through(bytes: &[u8]) {
    match read_bytes(bytes, &FileFormat::default()) {
        Ok(table) => {
            assert!(table.columns.iter().all(|column| column.values.len() == table.len()), "columns of one length");
            assert!(table.columns.iter().all(|column| column.values.iter().all(|v| !v.is_infinite())));
            let understood = guess(&table, None, None);
            let _ = confirm("x", &table, &understood);
            let text = mapping("x", &table, &understood);
            let again = Mapping::parse(&text, "map.toml").unwrap_or_else(|e| panic!("{e}\n{text}"));
            assert_eq!(again, understood.mapping);
        }
        Err(error) => {
            assert!(!error.message.is_empty() && !error.hint.is_empty() && !error.to_string().contains('\n'), "{error}")
        }
    }
}

fn files() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/files");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("files").flatten().map(|entry| entry.path()).collect();
    files.sort();
    files
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a file")
}

/// What text tables are made of, and what is no text.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    let pieces = [
        ",",
        ";",
        "\t",
        "|",
        " ",
        "\n",
        "\r\n",
        "\r",
        "\"",
        "\"\"",
        "#",
        "%",
        "1",
        "0,5",
        "0.5",
        "1.234,5",
        "-",
        "NaN",
        "Zeit [s]",
        "t",
        "pos_mm",
        "duty",
        "12:00:01",
        "2024-03-12",
        "12.03.2024",
        "(°C)",
        "[",
        ")",
        "MATLAB",
        "Delta_X",
        "LabVIEW Measurement",
        "Y_Unit_Label",
        "dt = 1",
        "時間",
        "µ",
        "1e999",
    ];
    prop_oneof![
        20 => prop::sample::select(pieces.to_vec()).prop_map(|text| text.as_bytes().to_vec()),
        1 => prop::collection::vec(any::<u8>(), 0..8),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn arbitrary_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        through(&bytes);
    }

    #[test]
    fn arbitrary_tables_do_not_panic(pieces in prop::collection::vec(piece(), 0..120)) {
        through(&pieces.concat());
    }

    #[test]
    fn arbitrary_binaries_do_not_panic(
        kind in prop::sample::select(vec![&b"TDSm"[..], b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", b"\x1f\x8b\x08\x00", b"MATLAB 5.0 MAT-file"]),
        rest in prop::collection::vec(prop_oneof![3 => Just(0u8), 1 => any::<u8>()], 0..600),
    ) {
        let mut bytes = [kind, &rest].concat();
        if kind.starts_with(b"MATLAB") && bytes.len() > 128 {
            bytes[124..128].copy_from_slice(b"\x00\x01IM");
        }
        through(&bytes);
    }

    #[test]
    fn damaged_files_do_not_panic(
        file in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 1u8..), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let files = files();
        let mut bytes = bytes(&files[file.index(files.len())]);
        for (place, flip) in flips {
            let place = place.index(bytes.len());
            bytes[place] ^= flip;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        through(&bytes);
    }
}
