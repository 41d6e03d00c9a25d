//! A few thousand damaged files of every format, the same ones on every run. `examples/long.rs` tries millions, the fuzzer looks
//! for the worst: `fuzz/README.md`.

use sinew_hostile::{Format, damaged};

#[test]
fn damaged_csv_is_read_or_refused() {
    damaged(Format::Csv, 1, 3000);
}

#[test]
fn a_damaged_rig_file_is_read_or_refused() {
    damaged(Format::Rig, 2, 1500);
}

#[test]
fn a_damaged_session_is_read_mended_or_refused() {
    damaged(Format::Mcap, 3, 3000);
}
