//! As many damaged files of a format as one likes, the same ones for the same seed.

use sinew_recording::session::Compression;

use crate::{Mutator, command, csv, firmware, gate, line, mcap, rig, scan, seed, visit};

/// A format with a reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Recordings as CSV.
    Csv,
    /// Recordings of many channels, MCAP.
    Mcap,
    /// Rig files.
    Rig,
    /// What comes over the line to a front-end.
    Line,
    /// What a front-end's firmware is sent, and how time passes for it.
    Firmware,
    /// What clients ask for, and what the converter shows.
    Command,
    /// What visitors do at the gate.
    Gate,
    /// What a driver shows to a visitor.
    Visit,
    /// What Linux says of a converter, and its scans.
    Scan,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 9] = [
        Format::Csv,
        Format::Mcap,
        Format::Rig,
        Format::Line,
        Format::Firmware,
        Format::Command,
        Format::Gate,
        Format::Visit,
        Format::Scan,
    ];

    /// Its name, that of its fuzzing target.
    pub const fn name(self) -> &'static str {
        match self {
            Format::Csv => "csv",
            Format::Mcap => "mcap",
            Format::Rig => "rig",
            Format::Line => "line",
            Format::Firmware => "firmware",
            Format::Command => "command",
            Format::Gate => "gate",
            Format::Visit => "visit",
            Format::Scan => "scan",
        }
    }

    /// The good files that are damaged, as its reader's function takes them.
    fn good(self) -> Vec<Vec<u8>> {
        match self {
            Format::Csv => vec![[b"\x01", seed::CSV].concat()],
            Format::Line => seed::lines(),
            Format::Firmware => seed::firmware(),
            Format::Command => seed::commands(),
            Format::Gate => seed::visitors(),
            Format::Visit => seed::drivers(),
            Format::Scan => seed::scans(),
            Format::Rig => vec![HEXAPOD.to_vec(), seed::RIG.to_vec()],
            Format::Mcap => [Compression::None, Compression::Lz4, Compression::Zstd]
                .into_iter()
                .flat_map(|compression| {
                    let session = move |driver| seed::session(compression, driver);
                    [(2, true), (3, true), (3, false), (7, false)]
                        .map(|(choice, driver)| [&[choice], &session(driver)[..]].concat())
                })
                .collect(),
        }
    }

    /// What is strewn in.
    const fn words(self) -> &'static [&'static [u8]] {
        match self {
            Format::Csv => &CSV_WORDS,
            Format::Rig => &RIG_WORDS,
            Format::Scan => &SCAN_WORDS,
            Format::Mcap | Format::Line | Format::Firmware | Format::Command | Format::Gate | Format::Visit => &[],
        }
    }

    fn read(self, bytes: &[u8]) {
        match self {
            Format::Csv => csv(bytes),
            Format::Mcap => mcap(bytes),
            Format::Rig => rig(bytes),
            Format::Line => line(bytes),
            Format::Firmware => firmware(bytes),
            Format::Command => command(bytes),
            Format::Gate => gate(bytes),
            Format::Visit => visit(bytes),
            Format::Scan => scan(bytes),
        }
    }
}

/// Gives a format's reader the good files, then so many damaged ones.
///
/// # Panics
/// Where it breaks a promise.
pub fn damaged(format: Format, seed: u64, files: u64) {
    let good = format.good();
    good.iter().for_each(|file| format.read(file));
    let mut mutator = Mutator::new(seed);
    for (_, file) in (0..files).zip(good.iter().cycle()) {
        format.read(&mutator.damage(file, format.words()));
    }
}

const HEXAPOD: &[u8] = include_bytes!("../../../examples/hexapod.toml");

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

const SCAN_WORDS: [&[u8]; 12] =
    [b"le:", b"be:", b"s", b"u", b"16", b"/", b"64", b">>", b"X4", b"\n", b"4294967295", b"\xc2\xb5"];

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
