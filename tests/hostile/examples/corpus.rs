//! Writes good files for the fuzzer to begin with: `cargo run -p sinew-hostile --example corpus -- fuzz/corpus`.

use std::path::Path;

use sinew_hostile::seed;
use sinew_recording::session::Compression;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "fuzz/corpus".into());
    let write = |format: &str, name: &str, bytes: &[u8]| {
        let folder = Path::new(&folder).join(format);
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join(name), bytes)
    };
    write("csv", "good", &[b"\x01", seed::CSV].concat())?;
    write("rig", "bench", seed::RIG)?;
    write("rig", "hexapod", sinew_rig::HEXAPOD_TOML.as_bytes())?;
    let scripts = [
        ("line", seed::lines()),
        ("firmware", seed::firmware()),
        ("command", seed::commands()),
        ("gate", seed::visitors()),
        ("visit", seed::drivers()),
        ("scan", seed::scans()),
    ];
    for (format, good) in scripts {
        for (number, bytes) in good.iter().enumerate() {
            write(format, &format!("good-{number}"), bytes)?;
        }
    }
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        for (choice, driver) in [(3u8, true), (3, false), (0, true), (7, false)] {
            let bytes = [&[choice], &seed::session(compression, driver)[..]].concat();
            write("mcap", &format!("{}-{driver}-{choice}", compression.name()), &bytes)?;
        }
    }
    Ok(())
}
