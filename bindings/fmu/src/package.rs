//! The file itself: a zip archive of the description, the rig file and the library for this kind of machine (FMI 3.0, chapter 2.5).

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use sha2::{Digest, Sha256};
use sinew_rig::Rig;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::description::{MODEL_IDENTIFIER, description};

/// The rig file inside an FMU.
pub const RIG: &str = "rig.toml";
/// The name of the channel inside an FMU.
pub const CHANNEL: &str = "channel.txt";

/// What an FMU of this channel of this rig file is told apart by.
pub fn token(rig: &str, channel: &str) -> String {
    let digest = Sha256::new().chain_update(rig).chain_update([0]).chain_update(channel).finalize();
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What FMI calls this machine.
pub fn platform() -> String {
    let machine = match std::env::consts::ARCH {
        "powerpc64" => "ppc64",
        other => other,
    };
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    format!("{machine}-{system}")
}

/// Writes the FMU of a channel, with `library` as what a simulator on this kind of machine loads. Nothing is left where it fails.
///
/// # Errors
/// A wire that cannot be at rest; a library that cannot be read; a file that cannot be written.
pub fn write(rig: &Rig, channel: usize, library: &Path, output: &Path) -> io::Result<()> {
    let name = &rig.channels[channel].name;
    let described =
        description(rig, channel, &token(rig.text(), name)).map_err(|refusal| io::Error::other(refusal.0))?;
    let library = std::fs::read(library)
        .map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", library.display())))?;
    let ending = std::env::consts::DLL_EXTENSION;
    let files: [(String, &[u8]); 4] = [
        ("modelDescription.xml".into(), described.as_bytes()),
        (format!("resources/{RIG}"), rig.text().as_bytes()),
        (format!("resources/{CHANNEL}"), name.as_bytes()),
        (format!("binaries/{}/{MODEL_IDENTIFIER}.{ending}", platform()), &library),
    ];
    let part = output.with_extension(format!("{}.part", std::process::id()));
    let written = pack(&part, &files).and_then(|()| std::fs::rename(&part, output));
    if written.is_err() {
        let _ = std::fs::remove_file(&part);
    }
    written
}

fn pack(path: &Path, files: &[(String, &[u8])]) -> io::Result<()> {
    let mut archive = ZipWriter::new(BufWriter::new(File::create(path)?));
    // a simulator unpacks it before anything else: what little packing would save is not worth a crate
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).unix_permissions(0o644);
    for (name, bytes) in files {
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    archive.finish()?.flush()
}
