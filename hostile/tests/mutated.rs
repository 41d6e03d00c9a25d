//! A few thousand damaged files of every format, the same ones on every run. The fuzzer goes further: `fuzz/README.md`.

use sinew_hostile::{Mutator, seed};
use sinew_recording::session::Compression;

const CSV_WORDS: [&[u8]; 14] = [
    b",",
    b"\n",
    b"\r\n",
    b";",
    b"\"",
    b"nan",
    b"inf",
    b"-",
    b"1e309",
    b"time_s",
    b"duty",
    b"\xef\xbb\xbf",
    b"\0",
    b"0.1",
];

#[test]
fn damaged_csv_is_read_or_refused() {
    let mut mutator = Mutator::new(1);
    let good = [b"\x01", seed::CSV].concat();
    for _ in 0..3000 {
        sinew_hostile::csv(&mutator.damage(&good, &CSV_WORDS));
    }
}

const RIG: &[u8] = include_bytes!("../../examples/hexapod.toml");
const RIG_WORDS: [&[u8]; 16] = [
    b"=",
    b"\n",
    b"[",
    b"]]",
    b"\"",
    b"#",
    b"nan",
    b"inf",
    b"-1",
    b"1e400",
    b"[[channel]]\n",
    b"[[joint]]\n",
    b"[simulation]\n",
    b"{ }",
    b"name = \"x\"\n",
    b"\xc2\xb5",
];

#[test]
fn a_damaged_rig_file_is_read_or_refused() {
    let mut mutator = Mutator::new(2);
    sinew_hostile::rig(RIG);
    for _ in 0..1500 {
        sinew_hostile::rig(&mutator.damage(RIG, &RIG_WORDS));
    }
}

#[test]
fn a_damaged_session_is_read_mended_or_refused() {
    let mut mutator = Mutator::new(3);
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        for (choice, driver) in [(2, true), (3, true), (3, false), (7, false)] {
            let good = [&[choice], &seed::session(compression, driver)[..]].concat();
            sinew_hostile::mcap(&good);
            for _ in 0..250 {
                sinew_hostile::mcap(&mutator.damage(&good, &[]));
            }
        }
    }
}
