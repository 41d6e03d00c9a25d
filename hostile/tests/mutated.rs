//! A few thousand damaged files of every format, the same ones on every run. The fuzzer goes further: `fuzz/README.md`.

use sinew_hostile::Mutator;

const CSV: &[u8] =
    b"\x01time_s,duty,supply_v,position_m,v1_v\n0,0,6,0.001,0.1\n0.1,0.5,5.9,,0.11\n0.2,1,nan,0.002,0.12\n\
    0.3,0.25,6.01,-0.0005,1e-3\n0.5,0,6,0.001,\n";
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
    sinew_hostile::csv(CSV);
    for _ in 0..3000 {
        sinew_hostile::csv(&mutator.damage(CSV, &CSV_WORDS));
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
