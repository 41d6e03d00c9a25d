//! Shared by `identify` and `diagnose`: reading the rig and its recordings, protecting files from being overwritten, showing
//! the progress.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use sinew_diagnosis::{Error, MOST_SAMPLES, Settings};
use sinew_recording::{Options, Recording};
use sinew_report::Source;
use sinew_rig::Rig;

use super::simulate::recording_failure;
use super::{choose_channel, load_rig_with, rig_failure};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// A rig, the channel meant, and what was recorded on it.
pub struct Input {
    /// The rig file.
    pub rig: Rig,
    /// Index of the channel.
    pub channel: usize,
    /// What is fitted.
    pub recordings: Vec<Recording>,
    /// What is only judged by.
    pub held_out: Vec<Recording>,
}

impl Input {
    /// Reads everything, and refuses one and the same recording twice: it would count double, or judge itself.
    pub fn read(args: &args::Fitting, holdout: &[PathBuf]) -> Result<Input, Failure> {
        let rig = load_rig_with(Some(&args.rig), &args.laws)?;
        let name = choose_channel(&rig, args.channel.as_deref())?.name.clone();
        let channel = rig.channels.iter().position(|c| c.name == name).unwrap_or(0);
        let options = Options {
            ignore_columns: args.ignore_columns,
            columns: Some(&rig.recording.columns),
            model: Some(&rig.channels[channel].model),
            max_rows: MOST_SAMPLES,
            channel: Some(&name),
        };
        let (recordings, held_out) = read_all(&args.recordings, holdout, &options)?;
        Ok(Input { rig, channel, recordings, held_out })
    }

    /// Name of the channel.
    pub fn channel_name(&self) -> &str {
        &self.rig.channels[self.channel].name
    }
}

/// Reads what is fitted and what is only judged by, of one channel; refuses one and the same recording twice.
pub fn read_all(
    fitted: &[PathBuf],
    holdout: &[PathBuf],
    options: &Options<'_>,
) -> Result<(Vec<Recording>, Vec<Recording>), Failure> {
    let mut all: Vec<Recording> = Vec::new();
    for path in fitted.iter().chain(holdout) {
        let recording = sinew_recording::read(path, options).map_err(recording_failure)?;
        if let Some(twin) = all.iter().find(|other| other.has_the_samples_of(&recording)) {
            let hint = match all.len() >= fitted.len() {
                true => "hold out a recording that is not fitted; without --holdout, blocks of each are kept back",
                false => "give every recording once",
            };
            let message = format!("{}: is the same recording as {}", path.display(), twin.name());
            return Err(Failure::input(message).hint(hint));
        }
        all.push(recording);
    }
    let held_out = all.split_off(fitted.len());
    Ok((all, held_out))
}

/// The files an answer is made from, by what is in them: what is said of the rig, and these recordings.
pub fn sources<'a>(
    args: &'a args::Fitting,
    recordings: impl Iterator<Item = &'a PathBuf>,
) -> Result<Vec<Source>, Failure> {
    let rig = std::iter::once(&args.rig).chain(&args.laws.catalogue);
    rig.chain(recordings).map(|path| source(path)).collect()
}

fn source(path: &Path) -> Result<Source, Failure> {
    let bytes = std::fs::read(path).map_err(|error| {
        Failure::input(format!("{}: cannot be read again: {error}", path.display()))
            .hint("leave it where it is meanwhile")
    })?;
    Ok(Source { path: path.display().to_string(), sha256: sha256(&bytes) })
}

/// SHA-256 in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Refuses to write where a file of the input lies.
pub fn spare_inputs<'a>(
    output: &Path,
    args: &'a args::Fitting,
    recordings: impl Iterator<Item = &'a PathBuf>,
) -> Outcome {
    let Ok(output_there) = output.canonicalize() else { return Ok(()) };
    let mut inputs = std::iter::once(&args.rig).chain(recordings);
    match inputs.find(|input| input.canonicalize().is_ok_and(|input| input == output_there)) {
        Some(input) => Err(Failure::input(format!("{}: would overwrite {}", output.display(), input.display()))
            .hint("write somewhere else: what goes in is not to be overwritten")),
        None => Ok(()),
    }
}

/// Runs a piece of work with the settings asked for and a line on the terminal that says how far it is.
pub fn work<T>(args: &args::Fitting, work: impl FnOnce(&Settings<'_>) -> Result<T, Error>) -> Result<T, Failure> {
    let progress = Progress::new();
    let tell = |stage: &str, share: f64| progress.tell(stage, share);
    let settings =
        Settings { seed: args.seed, jobs: args.jobs.map_or(0, usize::from), thorough: false, progress: &tell };
    let done = work(&settings);
    progress.clear();
    done.map_err(|error| diagnosis_failure(&error))
}

/// Why there is no answer, with the remedy.
pub fn diagnosis_failure(error: &Error) -> Failure {
    match error {
        Error::Rig(error) => rig_failure(error),
        _ if error.is_bad_input() => Failure::input(error.message()).hint(error.hint()),
        _ => Failure::own(error.message()).hint(error.hint()),
    }
}

/// Whether stdout shows colours.
pub fn has_colour() -> bool {
    let wanted = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    wanted && io::stdout().is_terminal() && std::env::var_os("TERM").is_some_and(|term| term != "dumb")
}

/// Columns of the terminal on stdout; a hundred where it is none.
pub fn width() -> usize {
    const WIDTH: usize = 100;
    match io::stdout().is_terminal() {
        true => terminal_size::terminal_size_of(io::stdout()).map_or(WIDTH, |(columns, _)| usize::from(columns.0)),
        false => WIDTH,
    }
}

/// The command as typed, for a shell to take again.
pub fn command() -> String {
    let name = || Some("sinew".to_string());
    let words = std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy()));
    name().into_iter().chain(words).collect::<Vec<_>>().join(" ")
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Says each warning on stderr.
pub fn warn(warnings: &[String]) {
    for warning in warnings {
        output::note(format_args!("warning: {warning}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("run-1.csv"), "run-1.csv");
        assert_eq!(quoted("my run.csv"), "'my run.csv'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }
}
