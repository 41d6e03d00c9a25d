//! Results to stdout, everything else to stderr.

use std::fmt;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue};
use serde::Serialize;
use sinew_rig::nearest;

use crate::failure::{Failure, Outcome};
use crate::log::{self, Stream};

/// Prints to stdout. A reader that has gone away (`| head`) has what it wanted.
pub fn print(text: impl fmt::Display) -> Outcome {
    try_print(text).map(|_| ())
}

/// Prints to stdout; false when its reader has gone away.
pub fn try_print(text: impl fmt::Display) -> Result<bool, Failure> {
    match log::put(Stream::Out, text.to_string().as_bytes()) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(Failure::own(format!("stdout: {error}"))),
    }
}

/// Prints a line to stderr, unless errors alone are wanted there. Where nobody listens any more (a terminal that is gone) nothing is lost: the
/// commands go on.
pub fn note(text: impl fmt::Display) {
    if !log::is_quiet() {
        error(text);
    }
}

/// Prints an error to stderr, whatever else is wanted there.
pub fn error(text: impl fmt::Display) {
    log::say(format!("{text}\n").as_bytes());
}

/// So many of a thing: "1 channel", "18 channels".
pub fn counted(count: usize, thing: &str) -> String {
    if count == 1 { format!("1 {thing}") } else { format!("{count} {thing}s") }
}

/// Prints a value as JSON to stdout; numbers that are not finite become `null`.
pub fn print_json(value: &impl Serialize) -> Outcome {
    print(format_args!("{}\n", json(value)?))
}

/// A value as indented JSON.
pub fn json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(|error| Failure::own(format!("JSON: {error}")))
}

/// Finds out before the work, not after it, that a file to be written has no place.
pub fn has_place(path: &Path) -> Outcome {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    match (path.is_dir(), folder.is_dir()) {
        (true, _) => Err(Failure::input(format!("{}: is a folder", path.display())).hint("name a file")),
        (_, false) => Err(Failure::input(format!("{}: there is no folder {}", path.display(), folder.display()))
            .hint(format!("mkdir -p {}", folder.display()))),
        _ => Ok(()),
    }
}

/// Finds out before the work, not after it, that a folder to be written to has no place.
pub fn can_become_folder(out: &Path) -> Outcome {
    let there = out.ancestors().map(|path| if path.as_os_str().is_empty() { Path::new(".") } else { path });
    let Some(nearest) = there.into_iter().find(|path| path.exists()) else { return Ok(()) };
    if !nearest.is_dir() {
        return Err(Failure::input(format!("{}: is a file, not a folder", nearest.display()))
            .hint("choose another --out, or move that file away"));
    }
    tempfile_in(nearest).map_err(|error| {
        Failure::input(format!("{}: cannot be written to: {error}", nearest.display()))
            .hint("choose an --out where you may write")
    })
}

/// Finds out before the work that a folder for what `--keep` keeps is there already, or has no place.
pub fn can_keep_in(folder: &Path) -> Outcome {
    if folder.exists() {
        return Err(Failure::input(format!("{}: is there already", folder.display()))
            .hint("choose another --keep: nothing is overwritten"));
    }
    can_become_folder(folder)
}

/// Makes a file and takes it away again: permissions say less than trying.
fn tempfile_in(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!(".sinew.{}.part", std::process::id()));
    std::fs::write(&path, "").and_then(|()| std::fs::remove_file(&path))
}

/// Writes a file whole or not at all, by way of one beside it.
pub fn write_file(path: &Path, text: impl AsRef<[u8]>) -> Outcome {
    let failed = |error: io::Error| {
        Failure::own(format!("{}: cannot be written: {error}", path.display()))
            .hint("check the folder, its free space and that you may write there")
    };
    // a pipe or a device takes the text directly
    if path.metadata().is_ok_and(|there| !there.is_file()) {
        return std::fs::write(path, text).map_err(failed);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let part = path.with_file_name(format!(".{name}.{}.part", std::process::id()));
    std::fs::write(&part, text).and_then(|()| std::fs::rename(&part, path)).map_err(|error| {
        let _ = std::fs::remove_file(&part);
        failed(error)
    })
}

/// What clap has to say: help and version on stdout with exit code 0, bad use on stderr with exit code 2.
pub fn usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let typed = std::env::args().nth(1).unwrap_or_default();
    let unknown =
        [ContextKind::InvalidSubcommand, ContextKind::InvalidArg].into_iter().find_map(|kind| error.get(kind));
    if let Some(ContextValue::String(word)) = unknown
        && let Some(feature) = crate::args::left_out(&typed, word)
    {
        let failure = match cfg!(target_os = "linux") {
            true => Failure::left_out(format_args!("`{word}`"), feature),
            false => {
                Failure::input(format_args!("`{word}` drives a rig, or talks to what does, which is for Linux alone"))
                    .hint("what works on recordings is there: `sinew --help` shows it")
            }
        };
        self::error(failure);
        return ExitCode::from(2);
    }
    // the styled text of clap, but with its last line in the form every hint has here
    let styled = error.render();
    let text = match io::IsTerminal::is_terminal(&io::stderr()) && std::env::var_os("NO_COLOR").is_none() {
        true => styled.ansi().to_string(),
        false => styled.to_string(),
    };
    let plain = styled.to_string();
    match plain.trim_end().ends_with("try '--help'.") {
        true => {
            let body = text.trim_end().rsplit_once('\n').map_or("", |(body, _)| body).trim_end();
            let program = <crate::args::Cli as clap::CommandFactory>::command();
            let known = program.find_subcommand(&typed);
            let command = known.map(|known| format!(" {}", known.get_name())).unwrap_or_default();
            // clap knows words that begin alike, and no slips of the fingers
            let meant = match (error.get(ContextKind::InvalidSubcommand), error.get(ContextKind::SuggestedSubcommand)) {
                (Some(ContextValue::String(word)), None) => {
                    nearest(word, known.unwrap_or(&program).get_subcommands().map(clap::Command::get_name))
                }
                _ => None,
            };
            let meant = meant.map(|meant| format!("did you mean `sinew{command} {meant}`? ")).unwrap_or_default();
            self::error(format_args!(
                "{body}\nhint: {meant}`sinew{command} --help` shows what there is, with examples"
            ));
        }
        false => self::error(text.trim_end()),
    }
    ExitCode::from(2)
}
