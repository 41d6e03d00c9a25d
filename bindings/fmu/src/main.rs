//! `sinew-fmu`: packs a channel of a rig file as an FMU.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use sinew_fmu::package;
use sinew_rig::Rig;

/// A simulated wire for other simulators: packs a channel of a rig file as an FMU (FMI 3.0, co-simulation).
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "\
Examples:
  sinew-fmu rig.toml -o wire.fmu
  sinew-fmu examples/hexapod.toml --channel front_left_coxa -o coxa.fmu

The FMU runs on machines like this one. docs/fmu.md has its inputs, outputs and parameters."
)]
struct Args {
    /// The rig file.
    #[arg(value_name = "RIG.toml")]
    rig: PathBuf,
    /// Which channel, where the rig has several.
    #[arg(long, value_name = "NAME")]
    channel: Option<String>,
    /// The FMU to write.
    #[arg(short, long, value_name = "FILE.fmu")]
    output: PathBuf,
    /// The compiled library; by default the one beside this program.
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err((message, hint)) => {
            eprintln!("error: {message}\nhint: {hint}");
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args) -> Result<(), (String, String)> {
    let rig = Rig::load(&args.rig)
        .map_err(|error| (error.to_string(), "docs/rig.md has every key with its range and default".to_string()))?;
    let channel =
        rig.chosen(args.channel.as_deref()).map_err(|error| (error.to_string(), error.remedy("--channel")))?;
    let library = args.library.clone().or_else(beside).ok_or_else(|| {
        let what = "the library of this program is not beside it".to_string();
        (what, "build it (`cargo build --release -p sinew-fmu`), or name it with --library".to_string())
    })?;
    package::write(&rig, channel, &library, &args.output).map_err(|error| {
        let hint = "check the folder, its free space and that you may write there";
        (format!("{}: cannot be written: {error}", args.output.display()), hint.to_string())
    })?;
    println!("{}: {} of {}, for {}", args.output.display(), rig.channels[channel].name, rig.name, package::platform());
    Ok(())
}

/// The library as cargo leaves it.
fn beside() -> Option<PathBuf> {
    let name = format!("{}sinew_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let path = std::env::current_exe().ok()?.with_file_name(name);
    path.is_file().then_some(path)
}
