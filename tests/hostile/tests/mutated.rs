//! A few thousand damaged inputs of every format, the same ones on every run. `examples/long.rs` tries millions, the fuzzer looks
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

#[test]
fn a_damaged_line_gives_frames_or_nothing() {
    damaged(Format::Line, 4, 20_000);
}

#[test]
fn no_frames_make_a_front_end_heat_beyond_its_limits_or_without_a_driver() {
    damaged(Format::Firmware, 5, 10_000);
}

#[test]
fn no_requests_and_no_samples_make_the_loop_heat_a_wire_beyond_its_limits() {
    damaged(Format::Command, 6, 1500);
}

#[test]
fn no_visitors_keep_the_gate_from_serving_another() {
    damaged(Format::Gate, 7, 3000);
}

#[test]
fn no_driver_at_a_gate_makes_its_client_panic_or_hang() {
    damaged(Format::Visit, 8, 3000);
}

#[test]
fn a_damaged_scan_format_means_what_it_says_or_nothing() {
    damaged(Format::Scan, 9, 20_000);
}
